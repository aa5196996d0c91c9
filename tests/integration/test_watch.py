"""mbcdm watch as a whole program: the served page follows a design file that is saved as different editors do."""

import json
import os
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.reference import REFERENCE

WAIT_S = 600.0

pytestmark = pytest.mark.slow


class Watching:
    """A running watch over a copy of the reference design."""

    def __init__(self, folder: Path) -> None:
        self.design, self.out = folder / "drive.yaml", folder / "out"
        self.design.write_bytes(REFERENCE.read_bytes())
        self.text = self.design.read_text("utf-8")
        self.log = folder / "log"
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-u", "-m", "mbcdm_cad", "watch", str(self.design), "--out", str(self.out)],
                stdout=log,
                stderr=subprocess.STDOUT,
            )
        self.wait(lambda: self.log.read_text().startswith("http"))
        self.address = self.log.read_text().splitlines()[0]

    def wait(self, true: Callable[[], bool]) -> None:
        """Until ``true``; fails with what the program said."""
        end = time.monotonic() + WAIT_S
        while not true():
            assert time.monotonic() < end and self.process.poll() is None, self.log.read_text()
            time.sleep(0.05)

    def state(self) -> dict[str, Any]:
        """What an open page is told."""
        with urllib.request.urlopen(self.address + "events", timeout=600) as answer:
            found: dict[str, Any] = json.loads(answer.readline().removeprefix(b"data: "))
        return found

    def page(self) -> str:
        with urllib.request.urlopen(self.address, timeout=600) as answer:
            text: str = answer.read().decode()
        return text

    def edited(self, old: str, new: str) -> bytes:
        """The text with one value changed."""
        assert self.text.count(old) == 1
        self.text = self.text.replace(old, new)
        return self.text.encode()


@pytest.fixture(scope="module")
def watching(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Watching]:
    running = Watching(tmp_path_factory.mktemp("watch"))
    yield running
    running.process.send_signal(signal.SIGTERM)
    assert running.process.wait(timeout=600) == 0, running.log.read_text()


def test_a_saved_edit_is_checked_drawn_and_built(watching: Watching) -> None:
    watching.wait(lambda: watching.state()["stage"] == "built")
    before = (watching.out / "mbcdm-live/parts/drum.step").read_bytes()
    watching.design.write_bytes(watching.edited("web_thickness_mm: 2.4 ", "web_thickness_mm: 2.1 "))
    watching.wait(lambda: watching.state()["save"] == 2 and watching.state()["stage"] == "built")
    assert (watching.out / "mbcdm-live/parts/drum.step").read_bytes() != before
    report = json.loads((watching.out / "mbcdm/report.json").read_text())
    assert report["design_sha256"][:12] in watching.page() and not report["interference"]["clashes"]


def test_a_broken_file_keeps_the_last_page_and_says_why(watching: Watching) -> None:
    page = watching.page()
    watching.design.write_bytes(watching.text.replace("schema_version: 1", "schema_version: one").encode())
    watching.wait(lambda: watching.state()["stage"] == "broken")
    assert "schema_version" in watching.state()["message"] and watching.page() == page
    watching.design.write_bytes(watching.text.encode())
    watching.wait(lambda: watching.state()["stage"] == "built")


def test_a_failing_check_is_listed_with_its_remedy_and_nothing_is_drawn(watching: Watching) -> None:
    page = watching.page()
    watching.design.write_bytes(watching.text.replace("preload_N: 70.0", "preload_N: 300.0").encode())
    watching.wait(lambda: watching.state()["stage"] == "failing")
    failing = [row for row in watching.state()["findings"] if row["status"] == "fail"]
    assert any("preload" in row["id"] and row["remedy"] for row in failing), failing
    assert watching.page() == page
    watching.design.write_bytes(watching.text.encode())
    watching.wait(lambda: watching.state()["stage"] == "built")


def test_ten_saves_a_second_by_rename_end_in_the_last_one(watching: Watching) -> None:
    saves = watching.state()["save"]
    for k in range(10):
        text = watching.text.replace("web_thickness_mm: 2.1 ", f"web_thickness_mm: {2.15 + k / 100:.2f} ")
        new = watching.design.with_name(".drive.yaml.swp")
        new.write_text(text)
        os.replace(new, watching.design)
        time.sleep(0.1)
    watching.wait(lambda: watching.state()["stage"] == "built" and watching.state()["save"] > saves)
    report = json.loads((watching.out / "mbcdm/report.json").read_text())
    assert report["design_sha256"][:12] in watching.page()
    check = subprocess.run(
        [sys.executable, "-m", "mbcdm_cad", "check", str(watching.design), "--json"], capture_output=True, check=True
    )
    assert json.loads(check.stdout)["design_sha256"] == report["design_sha256"], watching.log.read_text()
