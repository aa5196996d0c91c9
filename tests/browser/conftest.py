"""A browser and the page of the reference design; without Chromium these tests are skipped with a message."""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad.cli import run
from tests.support.reference import REFERENCE

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
# No GPU is needed: the browser draws in software.
FLAGS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox")
READY_MS = 600_000


@dataclass
class Opened:
    """A page on show, and what it complained of or asked the network for."""

    page: Any
    problems: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def value(self, script: str) -> Any:
        """What ``script`` comes to in the page; ``v`` is the 3D view."""
        return self.page.evaluate(f"() => {{ const v = window.drivePage.viewer; return {script}; }}")

    def wait_for(self, seen: str) -> None:
        assert any(self.page.evaluate(seen) or self.page.wait_for_timeout(20) for _ in range(1500)), seen

    def set_slider(self, element: str, value: float) -> None:
        """Move a slider as a user does."""
        self.page.eval_on_selector(
            f"#{element}",
            "(node, value) => { node.value = value; node.dispatchEvent(new Event('input', {bubbles: true})); }",
            value,
        )

    def put_back(self) -> None:
        """The page as it was when it was opened, by its own controls."""
        self.page.evaluate(
            "() => { for (const one of ['#show-all', '[data-view=output]', 'input[name=cut-axis][value=\"\"]'])"
            " document.querySelector(one).click(); }"
        )
        for slider in ("angle", "explode"):
            self.set_slider(slider, 0)
        self.page.fill("#check-words", "")
        self.settle()

    def settle(self) -> None:
        """Wait until what was asked for has been drawn."""
        self.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the reference design's files and its page."""
    out = tmp_path_factory.mktemp("page")
    assert run(["page", str(REFERENCE), "--out", str(out)]) == 0
    return out / "mbcdm"


@pytest.fixture(scope="session")
def report(built: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((built / "report.json").read_text("utf-8"))
    return data


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    if CHROMIUM is None:
        pytest.skip("needs Chromium, which is not installed (Debian: apt-get install chromium)")
    playwright = pytest.importorskip("playwright.sync_api", reason="needs playwright (pip install playwright)")
    with playwright.sync_playwright() as driver:
        yield driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))


def _show(browser: Any, built: Path, width: int, height: int, scheme: str) -> Opened:
    context = browser.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, offline=True, reduced_motion="reduce"
    )
    context.set_default_timeout(READY_MS)
    one = Opened(context.new_page())
    one.page.on("console", lambda m: one.problems.append(m.text) if m.type in ("error", "warning") else None)
    one.page.on("pageerror", lambda error: one.problems.append(str(error)))
    one.page.on("request", lambda r: one.requests.append(r.url))
    one.page.goto((built / "report.html").as_uri())
    one.wait_for("performance.getEntriesByName('first-picture').length")
    return one


@pytest.fixture
def opened(browser: Any, built: Path) -> Iterator[Callable[..., Opened]]:
    """Opens the page offline at a size and colour scheme, as nobody has touched it; closes it after the test."""
    shown = []

    def show(width: int = 1280, height: int = 900, scheme: str = "light") -> Opened:
        shown.append(_show(browser, built, width, height, scheme))
        return shown[-1]

    yield show
    for one in shown:
        one.page.context.close()


@pytest.fixture(scope="session")
def shared(browser: Any, built: Path) -> Iterator[Opened]:
    """A page for all tests that read it or use its controls: drawing it anew takes seconds without a GPU."""
    one = _show(browser, built, 1280, 900, "light")
    yield one
    one.page.context.close()


@pytest.fixture
def used(shared: Opened) -> Opened:
    """The shared page, put back, for tests that turn, hide and take apart."""
    shared.put_back()
    return shared


@pytest.fixture(scope="session")
def artefacts() -> Path:
    """Where screenshots are kept to be looked at: ``MBCDM_SCREENSHOTS``, or out/screenshots."""
    folder = Path(os.environ.get("MBCDM_SCREENSHOTS", Path(__file__).parents[2] / "out" / "screenshots"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder
