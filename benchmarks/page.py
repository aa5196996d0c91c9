"""Time to open the page of a design in headless Chromium with software GL, and size of the page.

    python benchmarks/page.py out/mbcdm/report.html [runs]

Wall time from the start of loading to the first paint of the tables (limit 1 s) and to the first 3D picture (3 s),
and the processor time of the page's main thread, which depends less on other programs of the machine.
"""

import os
import shutil
import statistics
import sys
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
FIRST = "performance.getEntriesByName('first-picture')"


def opened_s(browser: Browser, url: str) -> tuple[float, float, float]:
    """(tables painted, first picture, processor time of the main thread), s."""
    context = browser.new_context(viewport={"width": 1280, "height": 900}, offline=True)
    page = context.new_page()
    session = context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.goto(url)
    page.wait_for_function(f"{FIRST}.length", timeout=120_000)
    picture = page.evaluate(f"{FIRST}[0].startTime") / 1e3
    paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime") / 1e3
    metrics = {m["name"]: m["value"] for m in session.send("Performance.getMetrics")["metrics"]}
    context.close()
    return paint, picture, metrics["TaskDuration"]


def main() -> None:
    path = Path(sys.argv[1]).resolve()
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("needs Chromium (Debian: apt-get install chromium)")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=FLAGS)
        found = [opened_s(browser, path.as_uri()) for _ in range(runs)]
    print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB; load of the machine {os.getloadavg()[0]:.1f}")
    for name, values in zip(("tables", "first picture", "main thread's own"), zip(*found, strict=True), strict=True):
        print(
            f"{name}: median {statistics.median(values):.2f} s, {min(values):.2f} to {max(values):.2f} of {runs} runs"
        )


if __name__ == "__main__":
    main()
