"""The report page: whole in itself, with everything that the result holds, and figures that a person reads."""

import re
from base64 import b64decode
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from io import BytesIO

import matplotlib.image
import numpy as np
import pytest

from mbcdm_cad.loop.page import report_page
from mbcdm_cad.loop.pictures import AFTER, BEFORE, orders_chart, scatter_png, time_charts
from mbcdm_cad.loop.readable import Value, readable, share_text
from mbcdm_cad.loop.result import VERDICTS, CandidateRow, Errors, LoopResult, Named, Traces, result_text
from mbcdm_cad.measurement.run import Run, VettingNote, half_sweeps
from tests.effects_page import page as effects_page
from tests.support.reference import ROOT

TIME = np.linspace(0.0, 60.0, 3000)
DRUM = 0.4 * np.sin(TIME)
NAMED = Named(
    "once_per_rev",
    "eccentric pulley",
    "guide",
    (),
    {"eccentricity_m": Value(8.6e-6, 8.4e-6, 8.8e-6)},
    {"eccentricity_m": 8.6e-6, "amplitude_rad": 1.4e-4},
    ("eccentric encoder",),
    "runout of <the guide>",
    "turn the encoder by 90 degrees",
    "the pitch circle runs out",
    9.6e-5,
    {"x_m": 1.0, "y_m": 2.0},
)
RESULT = LoopResult(
    "explained",
    (NAMED,),
    (),
    None,
    Errors(Value(9.65e-5, 9.3e-5, 1e-4), Value(4.9e-6, 4.2e-6, 5.6e-6), 2.07e-4, 1.42e-5, 4.4e-6, 0.99, "half sweep 3"),
    (CandidateRow("ripple (line in angle)", 5e-6, 1e-7, "given back"),),
    (),
    ("no temperature",),
    ("dial gauge",),
    {"drum": 1.0, "guide": 6.0, "input": 9.0},
    (
        Traces(
            TIME,
            DRUM,
            np.sign(np.cos(TIME)),
            1e-4 * np.cos(6 * DRUM),
            4e-6 * np.sin(50.0 * TIME),
            (TIME > 20.0) & (TIME < 30.0),
            half_sweeps(DRUM) > 0,
            np.linspace(20.0, 4000.0, 500),
            np.full(500, 1e-6),
            np.full(500, 1e-7),
        ),
    ),
)
RUN = Run(TIME, np.stack([9.0 * DRUM, 9.0 * DRUM]), DRUM, source="a<b>.csv", sha256="5" * 64)
DESIGN = {"name": "mbcdm", "file": "mbcdm.yaml", "sha256": "6" * 64}


NOTES = [VettingNote("gaps", "doubt", "2 gaps"), VettingNote("sweeps", "fact", "12 half sweeps")]
JUDGED = (RUN, NOTES, ["3 broken rows"])


@cache
def whole_page() -> str:
    return report_page(RESULT, DESIGN, [JUDGED]).decode()


def words_of(result: LoopResult) -> str:
    """The page without pictures, which take most of the time."""
    return report_page(replace(result, traces=()), DESIGN, []).decode()


class _Links(HTMLParser):
    """Everything that a browser would fetch, and the balance of the tags."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.fetched += [str(value) for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, (tag, self.getpos())


def test_the_page_needs_no_other_file_and_holds_what_the_result_holds() -> None:
    page = whole_page()
    links = _Links()
    links.feed(page)
    outside = [link for link in links.fetched if not link.startswith(("#", "data:,"))]
    assert links.open == [] and len(outside) == 2, outside
    assert all(link.startswith("data:image/png;base64,") for link in outside)
    assert all(f'id="{link[1:]}"' in page for link in links.fetched if link.startswith("#"))
    for words in (
        "8.6 µm",
        "8.4 µm to 8.8 µm",
        "140 µrad",
        "96.5 µrad",
        "99%",
        "ripple (line in angle)",
        "given back",
        "no temperature",
        "Look at: runout of",
        "2 gaps",
        "12 half sweeps",
        "3 broken rows",
        "half sweep 3",
        "5" * 64,
        "6" * 64,
        "Looks the same: eccentric encoder",
        "Measured against predicted, over time",
        "Transmission error over output angle",
        "What is left over output angle and load",
        "Orders of what is left",
    ):
        assert words in page, words


def test_names_from_files_cannot_write_into_the_page() -> None:
    page = whole_page()
    assert "a&lt;b&gt;.csv" in page and "<the guide>" not in page and "a<b>" not in page


@pytest.mark.parametrize("verdict", ["none", "explained", "partly_explained", "not_testable"])
def test_every_verdict_has_a_page_and_a_text(verdict: str) -> None:
    lacking = verdict in ("explained", "partly_explained")
    result = replace(RESULT, verdict=verdict, effects=(NAMED,) if lacking else ())
    page, text = words_of(result), result_text(result)
    assert ("runout of" in page) == lacking and ("runout of" in text) == lacking
    assert text.startswith(result.sentence)


def test_a_set_says_that_the_data_cannot_tell() -> None:
    other = replace(NAMED, stage="drum", separate_by="a longer travel")
    result = replace(RESULT, effects=(), one_of=((NAMED, other),))
    page = words_of(result)
    assert "One of these 2; the data cannot tell which" in page and "once_per_rev drum" in page
    assert "To tell them apart: turn the encoder by 90 degrees; or: a longer travel." in page
    assert "one of these; the data cannot show which" in result_text(result)


def test_doubts_stand_right_below_the_finding() -> None:
    page = whole_page()
    places = [page.index(words) for words in ("<h1>", "a&lt;b&gt;.csv: 2 gaps", "What to do next")]
    assert places == sorted(places), places
    lines = result_text(RESULT, ["doubt: 2 gaps"]).splitlines()
    assert lines[:3] == [RESULT.sentence, "verdict: Explained", "doubt: 2 gaps"], lines[:3]
    assert "Doubts" not in words_of(RESULT)


def test_a_run_that_lacks_nothing_asks_for_nothing() -> None:
    page = words_of(replace(RESULT, verdict="none", effects=(), next_steps=()))
    assert "Nothing: the drive does what its design file says" in page


def test_what_was_left_out_gets_no_error_that_nobody_took() -> None:
    left_out = CandidateRow("lash (play at the output)", 4.9e-6, 2e-7, "too small to name")
    result = replace(RESULT, small=(left_out,))
    (line,) = (line for line in result_text(result).splitlines() if line.startswith("lash"))
    assert line.split("(play at the output)")[1].split() == ["0.2", "too", "small", "to", "name"], line
    row = words_of(result).split("lash (play at the output)")[1].split("</tr>")[0]
    assert "4.9" not in row and "0.2 µrad" in row, row


def test_the_first_half_sweep_is_left_out_of_the_plots_over_angle() -> None:
    trace = RESULT.traces[0]
    first = np.flatnonzero(half_sweeps(trace.output_rad) == 0)
    changed = trace.residual_before_rad.copy()
    changed[first] += 5e-5
    assert scatter_png(replace(trace, residual_before_rad=changed)) == scatter_png(trace)
    assert time_charts(replace(trace, residual_before_rad=changed)) != time_charts(trace)


def test_of_a_run_too_short_to_spare_one_no_half_sweep_is_left_out() -> None:
    whole = replace(RESULT.traces[0], used=np.ones(TIME.size))
    changed = whole.residual_before_rad.copy()
    changed[half_sweeps(whole.output_rad) == 0] += 5e-5
    assert scatter_png(replace(whole, residual_before_rad=changed)) != scatter_png(whole)


def test_no_line_is_drawn_over_a_pause_in_logging() -> None:
    trace = RESULT.traces[0]
    time = trace.time_s + 20.0 * (np.arange(trace.time_s.size) >= 1500)
    for chart in time_charts(replace(trace, time_s=time)).values():
        for line in chart["lines"]:
            gaps = [k for k, value in enumerate(line["y"]) if value is None]
            assert gaps == [1500], (chart["title"], line["label"], gaps)


def test_charts_hold_the_signals_in_readable_units() -> None:
    trace = RESULT.traces[0]
    charts = time_charts(trace)
    measured, predicted = charts["output"]["lines"]
    assert measured["y"] == pytest.approx(1e3 * trace.output_rad, rel=1e-4, abs=1e-4)
    assert np.subtract(measured["y"], predicted["y"]) == pytest.approx(1e3 * trace.residual_before_rad, abs=0.02)
    assert charts["residual"]["y"]["unit"] == "µrad"
    assert charts["residual"]["lines"][0]["y"] == pytest.approx(1e6 * trace.residual_before_rad, rel=1e-4)
    held = [band for band in charts["residual"]["bands"] if band["kind"] == "held"]
    assert [(band["from"], band["to"]) for band in held] == [pytest.approx((20.0, 30.0), abs=0.05)]


def test_chart_of_orders_marks_what_turns_in_the_chain() -> None:
    chart = orders_chart(RESULT.traces[0], RESULT.chain_orders)
    assert {mark["label"]: mark["at"] for mark in chart["marks"]} == RESULT.chain_orders
    assert chart["x"]["from"] < min(RESULT.chain_orders.values()), "a mark lies outside the axis"
    assert chart["lines"][0]["y"] == pytest.approx([1.0] * 500) and chart["lines"][1]["y"] == pytest.approx([0.1] * 500)


@pytest.mark.parametrize(("share", "said"), [(1.0, "100%"), (0.9965, "over 99%"), (0.9899, "99%"), (0.0, "0%")])
def test_what_is_not_quite_the_whole_is_not_called_so(share: float, said: str) -> None:
    assert share_text(share) == said


def test_pictures_are_the_same_every_time_and_show_before_and_after() -> None:
    first = whole_page()
    pictures = [b64decode(data) for data in re.findall(r"base64,([A-Za-z0-9+/=]+)", first)]
    assert pictures[1] == scatter_png(RESULT.traces[0])
    pixels = np.asarray(matplotlib.image.imread(BytesIO(pictures[1])))[:, :, :3]
    for colour in (BEFORE, AFTER):
        wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
        assert (np.abs(pixels - wanted).max(axis=2) < 0.02).sum() > 200, colour


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("eccentricity_m", [8.6e-6, -1e-6], ("eccentricity", ["8.6 um", "-1 um"])),
        ("play_rad", [0.031], ("play", ["31 mrad"])),
        ("phase_rad", [np.pi / 2], ("phase", ["90 deg"])),
        ("torque_Nm", [0.02], ("torque", ["20 mN m"])),
        ("compliance_rad_Nm", [4.2e-4], ("compliance", ["420 urad/(N m)"])),
        ("share", [0.031], ("share", ["3.1 %"])),
        ("cycles_per_output_rev", [684.0], ("cycles per output rev", ["684"])),
        ("delay_s", [float("nan"), 0.004], ("delay", ["nan ms", "4 ms"])),
    ],
)
def test_figures_come_in_units_that_a_person_reads(name: str, values: list[float], said: object) -> None:
    assert readable(name, values) == said


def test_the_page_of_effects_is_that_of_the_library() -> None:
    assert (ROOT / "docs/loop-effects.md").read_text("utf-8") == effects_page(), "make docs"


def test_every_verdict_is_there() -> None:
    page = (ROOT / "docs/how-to/close-the-loop.md").read_text("utf-8")
    assert [v for v in VERDICTS if f"| `{v}` |" not in page] == []
