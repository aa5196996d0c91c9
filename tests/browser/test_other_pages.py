"""Pages of the loop, of compared and of the best designs: no errors, self-contained, same style, charts respond."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.page.report import report_page
from mbcdm_cad.loop.readable import Value
from mbcdm_cad.loop.result import Errors, LoopResult, Traces
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.optimising.result import optimum_page
from mbcdm_cad.report.comparison import compared
from mbcdm_cad.report.page.stage import comparison_page
from tests.support.optimum import optimum

REFERENCE = Path(__file__).parents[2] / "params" / "mbcdm.yaml"
TIME = np.linspace(0.0, 60.0, 600)
DRUM = 0.4 * np.sin(TIME)
BEFORE_RAD = 1e-4 * np.cos(6 * DRUM)


def loop_page() -> bytes:
    errors = Errors(Value(9e-5, 8e-5, 1e-4), Value(5e-6, 4e-6, 6e-6), 2e-4, 1e-5, 4e-6, 0.99, "half sweep 3")
    orders = np.geomspace(20.0, 4000.0, 200)
    held, used = (TIME > 20.0) & (TIME < 30.0), TIME > 3.0
    after = 1e-6 * np.sin(TIME)
    trace = Traces(TIME, DRUM, None, BEFORE_RAD, after, held, used, orders, 1e-5 / orders, 1e-6 / orders)
    chain = {"drum": 1.0, "guide": 6.0, "input": 9.0}
    result = LoopResult("none", (), (), None, errors, (), (), (), (), chain, (trace,))
    run = Run(TIME, np.stack([9.0 * DRUM, 9.0 * DRUM]), DRUM, source="bench.csv", sha256="5" * 64)
    return report_page(result, None, [(run, [], [])])


def compared_page(report: dict[str, Any]) -> bytes:
    drive = load_design(REFERENCE).drive
    one = compared(drive, report, 0.28)
    pixel = bytes.fromhex("89504e470d0a1a0a")
    return comparison_page([one, one], [drive, drive], [pixel, pixel])


@pytest.fixture
def shown(browser: Any, tmp_path: Path) -> Iterator[Callable[..., tuple[Any, list[str], list[str]]]]:
    """Opens a page offline; gives it with what it complained of and what it asked for."""
    contexts = []

    def show(content: bytes, width: int, scheme: str) -> tuple[Any, list[str], list[str]]:
        path = tmp_path / "page.html"
        path.write_bytes(content)
        contexts.append(
            browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme, offline=True)
        )
        page = contexts[-1].new_page()
        problems: list[str] = []
        asked: list[str] = []
        page.on("console", lambda m: problems.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.on("request", lambda r: asked.append(r.url))
        page.goto(path.as_uri())
        return page, problems, [url for url in asked if not url.startswith(("file:", "data:"))]

    yield show
    for context in contexts:
        context.close()


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_loops_page_answers_to_the_pointer(shown: Any, artefacts: Path, width: int, scheme: str) -> None:
    page, problems, foreign = shown(loop_page(), width, scheme)
    plot = page.locator("#chart-residual-1 .plot")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 60)
    words = plot.locator("output").text_content()
    seconds = float(words.split()[1])
    shown_urad = float(words.split("before: ")[1].split(";")[0].replace("\u2212", "-"))
    wanted = 1e6 * float(np.interp(seconds, TIME, BEFORE_RAD))
    assert abs(shown_urad - wanted) < 0.5, (words, wanted)
    held = page.locator("#chart-residual-1 rect.held")
    assert held.count() == 1 and page.locator("#chart-orders-1 text", has_text="guide").count() == 1
    page.locator("#chart-orders-1 .plot").focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    assert "before: " in page.text_content("#chart-orders-1 output")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
    page.screenshot(path=artefacts / f"loop-{width}-{scheme}.png", full_page=True)
    assert problems == [] and foreign == []


@pytest.mark.slow
def test_page_of_compared_designs_is_silent_and_fits(shown: Any, artefacts: Path, report: dict[str, Any]) -> None:
    page, problems, foreign = shown(compared_page(report), 390, "light")
    page.click("#theme")
    assert page.evaluate("() => document.documentElement.dataset.theme") == "dark"
    assert page.locator("#figures tbody tr").count() > 15
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    page.screenshot(path=artefacts / "compared-390.png", full_page=True)
    assert problems == [] and foreign == []


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_page_of_the_best_designs_links_its_plots(shown: Any, artefacts: Path, width: int, scheme: str) -> None:
    page, problems, foreign = shown(optimum_page(optimum()), width, scheme)
    assert page.locator("#plot circle.design").count() == page.locator("#parallel polyline.design").count() == 3
    assert page.locator("#plot rect.start").count() == 1
    first = page.get_attribute("#chosen-line", "points")
    page.locator("#plot circle.design").nth(2).click()
    assert page.inner_text("#chosen-name") == "Design made-03"
    assert page.get_attribute("#chosen-line", "points") != first
    assert page.inner_text("#chosen-patch").endswith("made-03 <b>&")
    rows = page.locator("#chosen-checks tbody tr")
    assert [rows.nth(k).locator("td").first.inner_text() for k in range(2)] == ["warn", "pass"]
    assert "at its limit" in rows.nth(1).inner_text()
    page.locator("#parallel polyline.design").nth(0).dispatch_event("click")
    assert page.inner_text("#chosen-name") == "Design made-01"
    page.locator("#plot circle.design").nth(1).press("Enter")
    assert page.inner_text("#chosen-name") == "Design made-02"
    drawn = page.evaluate("() => document.getElementById('space').toDataURL()")
    page.locator("#space").press("ArrowLeft")
    assert page.evaluate("() => document.getElementById('space').toDataURL()") != drawn
    page.select_option("#y-axis", "box_x_mm")
    assert "box_x_mm" in page.locator("#plot circle.design").first.get_attribute("aria-label")
    assert "mass_g, g" in page.inner_text("#chosen-figures") and "350" in page.inner_text("#chosen-figures")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
    page.screenshot(path=artefacts / f"optimum-{width}.png", full_page=True)
    assert problems == [] and foreign == []
