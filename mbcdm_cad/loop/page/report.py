"""The loop's page for the bench: one HTML file that needs no other file and no network."""

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.loop.page import plain
from mbcdm_cad.loop.page.pictures import bode_png, loop_png, orders_chart, readings_png, scatter_png, time_charts
from mbcdm_cad.loop.readable import readable, share_text
from mbcdm_cad.loop.result import (
    VERDICTS,
    BodePicture,
    CandidateRow,
    LoopResult,
    Named,
    ReadingsPicture,
    Traces,
    windows_words,
)
from mbcdm_cad.measurement.run import Run, VettingNote, doubts
from mbcdm_cad.report.page.template import page_environment

# Pages of more runs than this show the plots of the first ones.
MOST_PLOTTED = 6

# Text below each plot that says what to look for; pictures have a title too.
TIME = (
    "Over time: the output as measured and as the declared model predicts it; below, what is left of it before, and "
    "after what was found was put into the model. Grey was held back before anything was chosen. Yellow is not used: "
    "in the first half sweep the state of the friction is not known."
)
LOOP = (
    "Transmission error over output angle",
    "Output less inputs through the ratio. Where the blue line runs through the dots the model follows the drive.",
)
SCATTER = (
    "What is left over output angle and load",
    "Lines and large dots are means; over angle solid where it rises and dashed where it falls. Flat at zero is right. "
    "A wave in angle looks like something that turns; two levels by direction like friction, lash or delay; a slope "
    "over load like stiffness.",
)
ORDERS = (
    "Orders of the remaining error: amplitude over cycles for a turn of the output. Dotted lines mark one turn of each "
    "shaft; a peak on one of them, or on a multiple, points at that shaft. Grey: too few cycles over this travel."
)

BODE = (
    "Output over inputs, as angles of the output",
    "Gain, phase and coherence over the frequency of the excitation. The peak is the first mode with the inputs held; "
    "a phase that falls in proportion to the frequency beside it is a delay of the bench.",
)

JudgedRun = tuple[Run, Sequence[VettingNote], Sequence[str]]


def report_page(result: LoopResult, design: dict[str, str] | None, runs: Sequence[JudgedRun]) -> bytes:
    """The page as HTML. ``design``: name, file and sha256, None where only the ratio is known."""
    plots = list(zip(runs, result.traces, strict=True))[:MOST_PLOTTED] if result.traces else []
    drawn = [_plots(judged[0], trace, result.chain_orders) for judged, trace in plots]
    drawn += [
        _bode(picture) if isinstance(picture, BodePicture) else _readings(picture)
        for picture in result.pictures[:MOST_PLOTTED]
    ]
    page = (
        page_environment(("mbcdm_cad.loop.page", "."))
        .get_template("report.html.j2")
        .render(
            sections=_sections(result, len(drawn)),
            time_text=TIME,
            orders_text=ORDERS,
            verdict=VERDICTS[result.verdict],
            finding=_micro(plain.finding(result)),
            certainty=_micro(plain.certainty(result)),
            sentence=_micro(result.sentence),
            modes=[mode.words for mode in result.modes],
            doubts=[f"{run.source}: {words}" for run, findings, notes in runs for words in doubts(notes, findings)]
            + [_micro(words) for words in result.doubts],
            helpful=[_effect(one.named) | {"odds": f"{min(one.odds, 9999.0):.0f}"} for one in result.helpful],
            noise=_noise(result),
            windows=[windows_words(one) for one in result.windows],
            errors=_errors(result),
            effects=[_effect(named) for named in result.effects],
            sets=[[_effect(named) for named in group] for group in result.one_of],
            unknown=_micro(result.unknown.sentence()) if result.unknown else "",
            candidates=[_candidate(one, result.small) for one in (*result.evidence, *result.small)],
            not_testable=result.not_testable,
            next_steps=plain.steps(result),
            nothing_lacks=result.verdict == "none",
            design=design,
            runs=[_run(judged) for judged in runs],
            plots=drawn,
        )
    )
    return page.encode()


def _sections(result: LoopResult, plotted: int) -> list[tuple[str, str]]:
    """(place, name) of the sections that the page has."""
    lacking = result.effects or result.one_of or result.unknown or result.helpful
    found = [("finding", "Finding"), ("error", "Error")]
    found += [("lacks", "What the model lacks")] if lacking else []
    found += [(f"run-{k}", "Plots" if plotted == 1 else f"Run {k}") for k in range(1, plotted + 1)]
    found += [("candidates", "Candidates")] if result.evidence or result.small else []
    return [*found, ("runs", "Runs")]


def _noise(result: LoopResult) -> str:
    """The parts of the noise floor in words."""
    noise = result.noise
    if noise is None:
        return ""
    _, (total, white, coloured) = readable("_rad", [noise.total_rad, noise.white_rad, noise.coloured_rad])
    memory = f" with a correlation time of {noise.memory_s:.2g} s" if noise.memory_s else ""
    return _micro(f"{total} RMS, from {noise.source}: {white} from sample to sample, {coloured} slower{memory}")


def _errors(result: LoopResult) -> dict[str, Any]:
    e = result.errors
    _, shown = readable(
        "_rad",
        [
            e.before.value,
            e.before.low,
            e.before.high,
            e.peak_before_rad,
            e.after.value,
            e.after.low,
            e.after.high,
            e.peak_after_rad,
            e.floor_rad,
        ],
    )
    shown = [_micro(text) for text in shown]
    most = max(e.before.value, e.after.value, e.floor_rad, 1e-300)
    return {
        "rows": [
            ("Declared model", *shown[0:4], 100.0 * e.before.value / most),
            ("With what was found", *shown[4:8], 100.0 * e.after.value / most),
            ("Noise floor", shown[8], "", "", "", 100.0 * e.floor_rad / most),
        ],
        "share": share_text(e.explained_share),
        "held_out": e.held_out,
    }


def _effect(named: Named) -> dict[str, Any]:
    figures = []
    for name, value in named.parameters.items():
        word, (middle, low, high) = readable(name, [value.value, value.low, value.high])
        if name in named.meanings:
            word = f"{word}, {named.meanings[name]}"
        figures.append((word, _micro(middle), _micro(f"{low} to {high}")))
    for name, figure in named.physical.items():
        if name not in named.parameters:
            word, (text,) = readable(name, [figure])
            figures.append((word, _micro(text), ""))
    return {"named": named, "figures": figures, "takes_off": _micro(readable("_rad", [named.fall_rad])[1][0])}


def _candidate(one: CandidateRow, small: Sequence[CandidateRow]) -> dict[str, str]:
    _, (held, fall) = readable("_rad", [one.held_out_rad, one.fall_rad])
    return {
        "label": one.label,
        # A candidate that was not fitted has no error on the data held back.
        "held": "" if one in small else _micro(held),
        "fall": _micro(fall) if one.fall_rad else "",
        "outcome": one.outcome,
    }


def _run(judged: JudgedRun) -> dict[str, Any]:
    run, findings, notes = judged
    return {
        "source": run.source,
        "samples": f"{run.time_s.size:,}".replace(",", " "),
        "sha256": run.sha256,
        "doubts": doubts(notes, findings),
        "facts": [str(f) for f in findings if f.level == "fact"],
    }


def _plots(run: Run, trace: Traces, chain_orders: dict[str, float]) -> dict[str, Any]:
    ideal = np.interp(trace.time_s, run.time_s, run.input_rad.mean(axis=0) / chain_orders["input"])
    drawn = ((LOOP, loop_png(trace, ideal)), (SCATTER, scatter_png(trace)))
    return {
        "source": run.source,
        "over_time": time_charts(trace),
        "images": [{"title": title, "text": text, "data": b64encode(png).decode()} for (title, text), png in drawn],
        "orders": orders_chart(trace, chain_orders),
    }


def _readings(picture: ReadingsPicture) -> dict[str, Any]:
    data = b64encode(readings_png(picture)).decode()
    return {"source": picture.source, "images": [{"title": picture.title, "text": picture.words, "data": data}]}


def _bode(picture: BodePicture) -> dict[str, Any]:
    title = "Output over a torque on it, inputs held" if picture.over_torque else BODE[0]
    image = {"title": title, "text": BODE[1], "data": b64encode(bode_png(picture)).decode()}
    return {"source": picture.source, "images": [image]}


def _micro(text: str) -> str:
    """The sign for micro, which a page can show and a terminal may not."""
    return text.replace(" um", " \N{MICRO SIGN}m").replace(" urad", " \N{MICRO SIGN}rad")
