"""The page in a real browser: no errors, no network, and controls that work as labelled."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.page import report_page
from mbcdm_cad.loop.readable import Value
from mbcdm_cad.loop.result import Errors, LoopResult, Traces
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.optimising.result import optimum_page
from mbcdm_cad.report.comparison import compared
from mbcdm_cad.report.page.stage import comparison_page
from tests.support.optimum import optimum
from tests.support.reference import REFERENCE

LARGEST_BYTES = 5_000_000
Open = Callable[..., Any]  # see conftest.Opened


def test_is_silent_and_asks_for_nothing_but_itself(shared: Any, built: Path) -> None:
    one = shared
    assert one.problems == []
    foreign = [url for url in one.requests if not url.startswith(("file:", "data:"))]
    assert foreign == []
    assert len([url for url in one.requests if url.startswith("file:")]) == 1, one.requests
    assert (built / "report.html").stat().st_size < LARGEST_BYTES


def test_every_item_of_the_bill_is_in_the_picture_and_in_the_list(shared: Any, report: dict[str, Any]) -> None:
    one = shared
    drawn = set(one.value("v.entries.map(e => e.name)"))
    listed = set(one.page.eval_on_selector_all("[data-pick]", "nodes => nodes.map(n => n.dataset.pick)"))
    assert drawn == listed == set(report["items"])


@pytest.mark.parametrize("angle", [-35.0, 12.5, 35.0])
def test_slider_turns_each_body_by_its_ratio(shared: Any, report: dict[str, Any], angle: float) -> None:
    one = shared
    one.set_slider("angle", angle)
    turned = one.value(
        "Object.fromEntries([...v.bodies].map(([name, b]) => {"
        " const q = new THREE.Quaternion().setFromRotationMatrix(b.node.matrix);"
        " const sine = b.axis.x * q.x + b.axis.y * q.y + b.axis.z * q.z;"
        " return [name, 2 * Math.atan2(sine, q.w) * 180 / Math.PI]; }))"
    )
    first = report["analysis"]["shaft_turns"][0]
    ratio = {"fixed": 0.0, "drum": 1.0, "guide": first["guide_deg"] / first["drum_deg"]}
    for name, found in turned.items():
        wanted = ratio.get(name, first["input_deg"] / first["drum_deg"]) * angle
        assert abs((found - wanted + 180.0) % 360.0 - 180.0) < 1e-3, (name, found, wanted)
    shown = one.page.text_content("[data-body-angle=guide]")
    assert shown == f"{ratio['guide'] * angle:.1f}°".replace("-", "−")


def test_cables_wind_with_the_drum_and_keep_their_length(shared: Any, report: dict[str, Any]) -> None:
    one = shared
    for angle in (-35.0, -17.3, 0.0, 35.0):
        one.set_slider("angle", angle)
        lengths = one.value(
            "Object.fromEntries(v.tubes.map(t => { const c = t.centre; let s = 0;"
            " for (let k = 3; k < c.length; k += 3) s += Math.hypot(c[k]-c[k-3], c[k+1]-c[k-2], c[k+2]-c[k-1]);"
            " return [t.cable.name, s]; }))"
        )
        for name, length in report["cable_lengths_mm"].items():
            # chords are shorter than the curve by up to 0.1 %
            assert 0.998 * length < lengths[name] < 1.001 * length, (name, angle, lengths[name], length)


def test_picking_tells_part_material_mass_and_file(used: Any, report: dict[str, Any]) -> None:
    one = used
    one.page.click("[data-view=front]")
    one.settle()
    place = one.value(
        "(() => { const e = v.entry('drum'), p = e.mesh.geometry.getAttribute('position'), i = e.mesh.geometry.index;"
        " const w = new THREE.Vector3(); v.scene.updateMatrixWorld(); let best = null;"
        " for (let k = 0; k < i.count; k += 3) {"
        "  w.set(0,0,0); for (let j = 0; j < 3; j++) w.add(new THREE.Vector3().fromBufferAttribute(p, i.getX(k+j)));"
        "  w.divideScalar(3).applyMatrix4(e.mesh.matrixWorld).project(v.camera);"
        "  if (v.at(w.x, w.y) === e) { best = [w.x, w.y]; break; } }"
        " const r = v.canvas.getBoundingClientRect();"
        " return [r.left + (best[0] + 1) / 2 * r.width, r.top + (1 - best[1]) / 2 * r.height]; })()"
    )
    one.page.mouse.click(*place)
    assert one.page.text_content("#fact-name") == "drum"
    assert report["bill_of_materials"][1]["material"] in one.page.text_content("#fact-material")
    mass = float(one.page.text_content("#fact-mass").split()[0])
    assert abs(mass - report["items"]["drum"]["mass_g"]) < 0.01
    addresses = one.page.eval_on_selector_all("#fact-files a", "nodes => nodes.map(n => n.getAttribute('href'))")
    assert "parts/drum.step" in addresses


def test_links_lead_to_files_that_are_there(shared: Any, built: Path) -> None:
    one = shared
    addresses = one.page.eval_on_selector_all(
        "a[href]:not([href^='#'])", "nodes => nodes.map(n => n.getAttribute('href'))"
    )
    assert addresses
    assert [a for a in addresses if not (built / a).is_file()] == []
    inside = one.page.eval_on_selector_all("a[href^='#']", "nodes => nodes.map(n => n.getAttribute('href').slice(1))")
    assert [i for i in inside if one.page.query_selector(f"[id='{i}']") is None] == []


@pytest.mark.slow
def test_section_cuts_and_closes_what_it_cuts(used: Any) -> None:
    one = used
    one.value("v.look('right')")
    one.settle()
    middle = "v.at(0, 0)?.name ?? null"
    outside = one.value(middle)
    before = one.page.locator("#stage canvas").screenshot()
    one.page.check("input[name=cut-axis][value=x]", force=True)
    one.set_slider("cut", 0)
    one.settle()
    assert one.page.locator("#stage canvas").screenshot() != before, "the cut does not show"
    caps = one.value("v.section.caps.filter(c => c.face.visible).map(c => c.entry.name)")
    assert {"frame", "drum", "guide"} <= set(caps), caps
    assert one.value(middle) != outside or outside is None
    assert one.value("v.section.hides(new THREE.Vector3(30, 0, 50))") is True
    assert one.value("v.section.hides(new THREE.Vector3(-30, 0, 50))") is False
    one.page.check("input[name=cut-axis][value='']", force=True)
    assert one.value("v.section.group.visible") is False


@pytest.mark.slow
def test_taking_apart_leaves_the_base_and_no_two_parts_in_one_place(used: Any) -> None:
    one = used
    one.set_slider("explode", 100)
    one.settle()
    offsets = one.value("Object.fromEntries([...v.offsets].map(([n, o]) => [n, o.length()]))")
    assert offsets["frame"] == 0.0
    moved = [name for name, far in offsets.items() if far > 5.0]
    assert len(moved) > 0.8 * len(offsets), sorted(set(offsets) - set(moved))
    assert one.value("v.tubes.length && v.entries.filter(e => e.tube).every(e => !e.node.visible)") is True


@pytest.mark.slow
def test_hiding_by_list_and_steps_of_assembly(used: Any, report: dict[str, Any]) -> None:
    one = used
    one.page.eval_on_selector("[data-show=drum]", "box => { box.closest('details').open = true; }")
    one.page.uncheck("[data-show=drum]")
    assert one.value("v.entry('drum').node.visible") is False
    one.page.click("#show-all")
    assert one.value("v.entries.every(e => e.shown)") is True
    first = next(k for k, items in enumerate(report["assembly_items"]) if items)
    one.page.click(f"[data-show-step='{first}']")
    assert set(one.value("v.entries.filter(e => e.shown).map(e => e.name)")) == set(report["assembly_items"][first])


def test_choosing_a_field_shows_what_it_rests_on(shared: Any, report: dict[str, Any]) -> None:
    one = shared
    field = "transmission.centre_distance_mm"
    one.page.click(f"[data-field-pick='{field}']")
    near = set(one.page.eval_on_selector_all("#graph g.near", "nodes => nodes.map(n => n.dataset.field)"))
    entry = next(entry for entry in report["fields"] if entry["field"] == field)
    assert {field, *entry["rests_on"]} <= near, set(entry["rests_on"]) - near
    rests_on_it = {other["field"] for other in report["fields"] if field in other["rests_on"]}
    assert rests_on_it and rests_on_it <= near, rests_on_it - near
    assert one.page.text_content("#graph-shown").startswith(f"{field} depends on ")
    one.page.focus("[data-field-pick='rope.type']")
    one.page.keyboard.press("Enter")
    assert one.page.get_attribute("#graph g.picked", "data-field") == "rope.type"
    one.page.click("[data-field-pick='rope.type']")
    assert one.page.query_selector("#graph.some") is None


@pytest.mark.slow
def test_steps_of_assembly_get_their_pictures(used: Any, report: dict[str, Any], artefacts: Path) -> None:
    used.page.evaluate("() => document.getElementById('assembly').scrollIntoView()")
    used.wait_for("document.documentElement.dataset.pictured === 'yes'")
    joined = [items for items in report["assembly_items"] if items]
    pictures = used.page.locator("#assembly li img")
    assert pictures.count() == len(joined)
    addresses = pictures.evaluate_all("all => all.map(image => image.src)")
    assert len(set(addresses)) == len(joined), "two steps look the same"
    assert min(len(address) for address in addresses) > 4000, "a step shows nothing"
    assert joined[0][0].replace("_", " ") in pictures.first.get_attribute("alt")
    assert used.value("v.entries.every(e => e.shown)") is True
    used.page.locator("#assembly").screenshot(path=artefacts / "page-steps.png")
    assert used.problems == []


@pytest.mark.slow
def test_checks_are_sorted_and_filtered(used: Any, report: dict[str, Any]) -> None:
    one = used
    rank = {"fail": 0, "warn": 1, "pass": 2}
    order = one.page.eval_on_selector_all("#checks tbody tr", "rows => rows.map(r => r.dataset.status)")
    assert len(order) == len(report["checks"])
    assert [rank[s] for s in order] == sorted(rank[s] for s in order)
    one.page.fill("#check-words", "fleet")
    shown = one.page.eval_on_selector_all("#checks tbody tr:not([hidden])", "rows => rows.map(r => r.id)")
    assert shown and "check-fleet_angle" in shown and len(shown) < len(order)


@pytest.mark.slow
def test_works_by_keyboard(used: Any) -> None:
    one = used
    one.page.focus("#canvas")
    before = one.value("v.camera.position.toArray()")
    one.page.keyboard.press("ArrowLeft")
    assert one.value("v.camera.position.toArray()") != before
    one.page.keyboard.press("]")
    assert one.value("v.angle") == 1.0
    one.page.focus("#angle")
    one.page.keyboard.press("End")
    assert one.value("v.angle") == one.value("v.data.half_travel_deg")
    one.page.eval_on_selector("[data-pick=guide]", "node => { node.closest('details').open = true; }")
    one.page.focus("[data-pick=guide]")
    one.page.keyboard.press("Enter")
    assert one.page.text_content("#fact-name") == "guide"


def test_tables_have_headers_and_controls_have_names(shared: Any) -> None:
    one = shared
    bare = one.page.eval_on_selector_all(
        "table", "all => all.filter(t => !t.querySelector('thead th[scope=col]')).length"
    )
    assert bare == 0
    nameless = one.page.evaluate(
        "() => [...document.querySelectorAll('button, input, canvas, [role=img]')].filter(n => !(n.ariaLabel ||"
        " n.textContent.trim() || n.closest('label') || document.querySelector(`label[for='${n.id}']`)))"
        ".map(n => n.outerHTML.slice(0, 90))"
    )
    assert nameless == []
    levels = one.page.eval_on_selector_all("h1, h2, h3", "all => all.map(h => Number(h.tagName[1]))")
    assert levels[0] == 1 and levels.count(1) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("width", "scheme"),
    [
        (1280, "light"),
        (390, "dark"),
        *(pytest.param(*p, marks=pytest.mark.slow) for p in ((1280, "dark"), (390, "light"))),
    ],
)
def test_fits_the_width(opened: Open, artefacts: Path, width: int, scheme: str) -> None:
    one = opened(width, 900, scheme)
    one.settle()
    one.page.screenshot(path=artefacts / f"page-{width}-{scheme}.png")
    assert one.page.evaluate("() => document.documentElement.scrollWidth") <= width
    assert one.problems == []


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
