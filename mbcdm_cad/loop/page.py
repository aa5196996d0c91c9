"""The loop's page for the bench: one HTML file that needs no other file and no network.

The finding stands in plain sentences for a new reader: what is wrong, how certain it is, what to do; no identifiers.
Figures are rounded to the digits that their intervals support.
"""

import math
from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.loop.pictures import bode_png, loop_png, orders_chart, readings_png, scatter_png, time_charts
from mbcdm_cad.loop.readable import Value, probability_text, readable, share_text, size_of
from mbcdm_cad.loop.result import (
    LEAST_ODDS,
    ONLY_RATIO,
    VERDICTS,
    BodePicture,
    CandidateRow,
    LoopResult,
    Named,
    ReadingsPicture,
    Traces,
    ways_apart,
    windows_words,
)
from mbcdm_cad.measurement.run import Run, VettingNote, doubts
from mbcdm_cad.report.page.template import page_environment

# Pages of more runs than this show the plots of the first ones.
MOST_PLOTTED = 6

JudgedRun = tuple[Run, Sequence[VettingNote], Sequence[str]]


def report_page(result: LoopResult, design: dict[str, str] | None, runs: Sequence[JudgedRun]) -> bytes:
    """The page as HTML. ``design``: name, file and sha256, None where only the ratio is known."""
    plots = list(zip(runs, result.traces, strict=True))[:MOST_PLOTTED] if result.traces else []
    drawn = [_plots(judged[0], trace, result.chain_orders) for judged, trace in plots]
    drawn += [_picture(picture) for picture in result.pictures[:MOST_PLOTTED]]
    page = (
        page_environment(("mbcdm_cad.loop", "."))
        .get_template("report.html.j2")
        .render(
            sections=_sections(result, len(drawn)),
            verdict=VERDICTS[result.verdict],
            finding=_micro(finding(result)),
            certainty=_micro(certainty(result)),
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
            next_steps=steps(result),
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
    sizes = [*e.before.three, e.peak_before_rad, *e.after.three, e.peak_after_rad, e.floor_rad]
    shown = [_micro(text) for text in readable("_rad", sizes)[1]]
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
        word, (middle, low, high) = readable(name, value.three)
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
    drawn = {"loop": loop_png(trace, ideal), "scatter": scatter_png(trace)}
    return {
        "source": run.source,
        "over_time": time_charts(trace),
        "images": [{"kind": kind, "data": b64encode(png).decode()} for kind, png in drawn.items()],
        "orders": orders_chart(trace, chain_orders),
    }


def _picture(picture: ReadingsPicture | BodePicture) -> dict[str, Any]:
    if isinstance(picture, BodePicture):
        kind, png = "torque" if picture.over_torque else "inputs", bode_png(picture)
    else:
        kind, png = "readings", readings_png(picture)
    return {"source": picture.source, "images": [{"kind": kind, "data": b64encode(png).decode(), "of": picture}]}


def _micro(text: str) -> str:
    """The sign for micro, which a page can show and a terminal may not."""
    return text.replace(" um", " \N{MICRO SIGN}m").replace(" urad", " \N{MICRO SIGN}rad")


def finding(result: LoopResult) -> str:
    """What is wrong with the drive, in one sentence."""
    after, floor = _angle(result.errors.after.value), _angle(result.errors.floor_rad)
    if result.verdict == "none":
        beside = f" of the drive: with {result.within_class}" if result.within_class else ":"
        return f"Nothing is missing{beside} the design file predicts the output within {after}; the noise is {floor}."
    if result.verdict == "not_testable" and result.helpful:
        return "A load that was not measured explains the error as well as a fault of the drive: log the torque."
    if result.verdict == "not_testable":
        return "These runs say nothing about the drive."
    parts = [described(named) for named in result.effects]
    parts += ["either " + " or ".join(described(named) for named in group) for group in result.one_of]
    left = f"something unknown is left, {_angle(result.unknown.rms_rad)} RMS" if result.unknown else ""
    if not parts:
        helps = [described(one.named) for one in result.helpful]
        likely = f"; what helps looks like this: {' and '.join(helps)}" if helps else ""
        return _sentence((left or "something is missing") + likely)
    return _sentence(" and ".join(parts) + (f"; {left}" if left else ""))


def certainty(result: LoopResult) -> str:
    """How certain the finding is."""
    e = result.errors
    fell = f"On data kept aside the error falls from {_angle(e.before.value)} to {_angle(e.after.value)} RMS"
    floor = f"the noise is {_angle(result.errors.floor_rad)}"
    if result.verdict in ("none", "not_testable"):
        return ""
    if result.verdict == "unknown" or not (result.effects or result.one_of):
        odds = [one.words.removeprefix("odds ") for one in result.helpful if one.odds >= LEAST_ODDS]
        sure = f" It lowers the error with odds of {', '.join(odds)}." if odds else ""
        return f"The error is {_angle(e.before.value)} RMS and {floor}: none of the known causes explains it.{sure}"
    words = [f"{fell}; {floor}."]
    if result.effects:
        known = [probability_text(one.probability) for one in result.effects if one.probability is not None]
        words += (
            [f"That no other known cause is in its place has a probability of {' and of '.join(known)}."]
            if known
            else []
        )
        words += [interval for named in result.effects if (interval := _interval(named))]
    if result.one_of:
        words.append("These runs cannot show which of the causes named with 'or' is present.")
        members = [one for group in result.one_of for one in group]
        known = [probability_text(one.probability) for one in members if one.probability is not None]
        words += [f"In the order of their names they have probabilities of {', '.join(known)}."] if known else []
    return " ".join(words)


def steps(result: LoopResult) -> list[str]:
    """What to do next."""
    found = [_sentence(f"look at: {named.where_to_look}") for named in result.effects]
    for group in result.one_of:
        ways = ways_apart(group)
        unplanned = result.pictures or ONLY_RATIO in result.not_testable
        plan = "" if unplanned else ", or let 'mbcdm loop --next' plan the run"
        found.append(_sentence(f"to find out which it is: {ways}{plan}"))
    found += [_sentence(f"look at: {one.named.where_to_look}") for one in result.helpful]
    if result.unknown is not None:
        found.append(_sentence(result.unknown.repeat))
    return list(dict.fromkeys(found))


def described(named: Named, ranged: bool = False) -> str:
    """One effect as a clause; ``ranged``: with intervals in place of figures."""
    words = {name: rounded(name, value, ranged) for name, value in named.parameters.items()}
    words |= {f"way_{name}": "higher" if value.value > 0.0 else "lower" for name, value in named.parameters.items()}
    words["stage"] = _spoken(named.stage or "")
    words["form"] = _spoken(named.form)
    every = len(named.cables) > 1
    words["cables"] = "all cables" if every else " ".join(_spoken(cable) for cable in named.cables)
    return named.plain.format(**words) if named.plain else f"{_spoken(named.name)} ({named.form})"


def rounded(name: str, value: Value, ranged: bool = False) -> str:
    """A size with its unit, rounded to the digits that its interval supports; ``ranged``: the interval."""
    factor, unit = size_of(name, value.three)
    if math.isinf(value.high):
        if value.low <= 0.0:
            return "a size that these runs leave open"
        return f"at least {value.low / factor:.2g} {unit}".strip()
    half = 0.5 * abs(value.high - value.low) / factor
    ends = sorted((abs(value.low), abs(value.high))) if ranged else [abs(value.value)]
    return f"{' to '.join(_to_place(end / factor, half) for end in ends)} {unit}".strip()


def _to_place(size: float, half: float) -> str:
    if not (math.isfinite(size) and math.isfinite(half)) or half <= 0.0 or 0.0 < size < 1e-3:
        return f"{size:.3g}"
    place = math.floor(math.log10(half))
    return f"{round(size, -place):.{max(0, -place)}f}"


def _interval(named: Named) -> str:
    """The intervals of an effect's figures."""
    told = [value for name, value in named.parameters.items() if f"{{{name}}}" in named.plain]
    if any(math.isinf(value.high) for value in told):
        return "A larger size would do the same in this run, so it may be any."
    return f"With 95 % certainty {described(named, ranged=True)}." if told else ""


def _angle(size_rad: float) -> str:
    factor, unit = size_of("_rad", [size_rad])
    return f"{size_rad / factor:.2g} {unit}" if size_rad < 100.0 * factor else f"{size_rad / factor:.0f} {unit}"


def _spoken(identifier: str) -> str:
    """``input_left`` as "left input", ``cable_4`` as "cable 4"."""
    if identifier.startswith("input_"):
        return f"{identifier.removeprefix('input_')} input"
    return identifier.replace("_", " ")


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:].rstrip(".") + "."
