"""Times after a save under `mbcdm watch`, with the page open in headless Chromium with software GL.

    python benchmarks/watch.py [runs]

For two edits of the reference design: wall time from the save to the new checks (limit 0.3 s), to the new STEP file of
a changed pulley (1 s), to the reloaded page with the tables of the new design (3 s), and to its first 3D picture; the
last two by the browser's clock. The smallest time of the runs is that of an idle machine.
"""

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from mbcdm_cad.layouts.loader import load_text

REFERENCE = Path(__file__).parents[1] / "params" / "mbcdm.yaml"
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
# What is edited, how the value reads with a share of its range, and the part whose STEP file is waited for.
EDITS: dict[str, tuple[str, Callable[[float], str], str]] = {
    "radius of the input pulleys": (
        "input_to_guide: 1.5 ",
        lambda share: f"input_to_guide: {1.495 + 0.004 * share:.6f} ",
        "input_pulley_left",
    ),
    "web of the drum": ("web_thickness_mm: 2.0 ", lambda share: f"web_thickness_mm: {2.1 + 0.4 * share:.6f} ", "drum"),
}
WAIT_S = 900.0
POLLING_MS = 100.0
# Between two saves, while the browser still draws the page of the last build with the processor.
PAUSE_S = 5.0
PAINT = "performance.getEntriesByName('first-contentful-paint')"
PICTURE = "performance.getEntriesByName('first-picture')"
NAMES = ("checks", "STEP", "page", "picture")


class Watching:
    """A running `mbcdm watch` over a copy of the reference, and what it says to an open page."""

    def __init__(self, folder: Path) -> None:
        self.design, self.parts = folder / "drive.yaml", folder / "out" / "mbcdm-live" / "parts"
        self.text = REFERENCE.read_text("utf-8")
        self.design.write_text(self.text)
        self.log = folder / "log"
        command = [sys.executable, "-u", "-m", "mbcdm_cad", "watch", str(self.design), "--out", str(folder / "out")]
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        self.wait(lambda: self.log.read_text().startswith("http"))
        self.address = self.log.read_text().splitlines()[0]
        self.states: list[tuple[float, dict[str, object]]] = []
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        with contextlib.suppress(OSError), urllib.request.urlopen(self.address + "events") as answer:
            for line in answer:
                if line.startswith(b"data: "):
                    self.states.append((time.perf_counter(), json.loads(line[6:])))

    def wait(self, true: Callable[[], object]) -> float:
        """When it was first seen to be true."""
        end = time.perf_counter() + WAIT_S
        while not true():
            if time.perf_counter() > end or self.process.poll() is not None:
                sys.exit(self.log.read_text())
            time.sleep(0.005)
        return time.perf_counter()

    def built(self) -> None:
        """Wait for the whole build of the newest save."""
        self.wait(lambda: self.states and self.states[-1][1]["stage"] == "built")


@contextlib.contextmanager
def watching() -> Iterator[Watching]:
    """One that ends with the block."""
    with tempfile.TemporaryDirectory() as folder:
        running = Watching(Path(folder))
        try:
            yield running
        finally:
            running.process.send_signal(signal.SIGTERM)
            running.process.wait(timeout=20)


def measured_s(running: Watching, page: Page, text: str, part: str) -> tuple[float, ...]:
    """Seconds from saving ``text`` to checks, STEP of ``part``, reloaded page and picture."""
    step = running.parts / f"{part}.step"
    before = step.stat().st_mtime_ns
    sha256 = load_text(text, running.design).sha256
    heard = len(running.states)
    start, start_of_epoch = time.perf_counter(), time.time()
    running.design.write_text(text)
    running.wait(lambda: len(running.states) > heard)
    checked, state = running.states[heard]
    if state["stage"] != "drawing":
        sys.exit(running.log.read_text())
    drawn = running.wait(lambda: step.stat().st_mtime_ns != before)
    # Looked for now and then: at each frame, which is what Playwright does, reading the page takes a core of its own.
    page.wait_for_function(
        "sha => document.readyState !== 'loading' && document.body.textContent.includes(sha)",
        arg=sha256[:12],
        polling=POLLING_MS,
    )
    page.wait_for_function(f"{PICTURE}.length", polling=POLLING_MS)
    shown, pictured = page.evaluate(
        f"[{PAINT}[0], {PICTURE}[0]].map(e => (performance.timeOrigin + e.startTime) / 1e3)"
    )
    running.built()
    return checked - start, drawn - start, shown - start_of_epoch, pictured - start_of_epoch


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("needs Chromium (Debian: apt-get install chromium)")
    with watching() as running, sync_playwright() as driver:
        page = driver.chromium.launch(executable_path=chromium, args=FLAGS).new_page()
        page.set_default_timeout(1e3 * WAIT_S)
        running.built()
        page.goto(running.address)
        for what, (old, new, part) in EDITS.items():
            assert running.text.count(old) == 1, old
            found = []
            for _ in range(runs):
                time.sleep(PAUSE_S)
                load = os.getloadavg()[0]
                text = running.text.replace(old, new(random.random()))  # what no run has drawn and cached before
                found.append(measured_s(running, page, text, part))
                row = ", ".join(f"{name} {value:.2f}" for name, value in zip(NAMES, found[-1], strict=True))
                print(f"{what}, {part}: {row} s (load {load:.1f})", flush=True)
            least = ", ".join(
                f"{name} {min(values):.2f}" for name, values in zip(NAMES, zip(*found, strict=True), strict=True)
            )
            print(f"{what}: least of {runs}: {least} s", flush=True)


if __name__ == "__main__":
    main()
