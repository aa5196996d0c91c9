"""What the loop found, as text for a terminal: sentence, errors, effects in metal, candidates, what to do next."""

from __future__ import annotations

from collections.abc import Sequence

from mbcdm_cad.identification.readable import readable, share_text, size_of
from mbcdm_cad.identification.result import LoopResult, Named


def result_text(result: LoopResult, doubts: Sequence[str] = ()) -> str:
    """The finding in one sentence, doubts of the runs right below, then the tables.

    Angles are in the unit that suits the error of the declared model.
    """
    e = result.errors
    size, unit = size_of("_rad", [e.before.value])
    lines = [result.sentence, *doubts, ""]
    lines += [
        f"{'error on held-out data':<24}{'RMS':>10}{'95 % from':>12}{'to':>10}{'peak':>10}  {unit}",
        _error_line("declared model", size, e.before.value, e.before.low, e.before.high, e.peak_before_rad),
        _error_line("with what was found", size, e.after.value, e.after.low, e.after.high, e.peak_after_rad),
        f"{'noise floor':<24}{e.floor_rad / size:>10.3g}",
        f"explained: {share_text(e.explained_share)} of what lies above the floor; held out: {e.held_out}",
    ]
    for named in result.effects:
        lines += ["", *named_lines(named)]
    for group in result.one_of:
        lines += ["", "one of these, the data cannot tell which:"]
        for named in group:
            lines += ["  " + line for line in named_lines(named)]
    candidates = (*result.evidence, *result.small)
    if candidates:
        width = max(len(c.label) for c in candidates)
        lines += ["", f"{'candidate':<{width}}{'held out':>12}{'takes off':>12}  {unit}"]
        # A candidate that was left out was not fitted on what is held out.
        held = [f"{c.held_out_rad / size:.3g}" for c in result.evidence] + [""] * len(result.small)
        lines += [
            f"{c.label:<{width}}{rms:>12}{c.fall_rad / size:>12.3g}  {c.outcome}"
            for c, rms in zip(candidates, held, strict=True)
        ]
    lines += [f"not testable: {words}" for words in result.not_testable]
    lines += [f"next: {words}" for words in result.next_steps]
    return "\n".join(lines)


def named_lines(named: Named) -> list[str]:
    """An effect with its figures, one a line."""
    lines = [f"{named.words} ({named.form}): {named.physics}"]
    for name, value in named.parameters.items():
        word, (middle, low, high) = readable(name, [value.value, value.low, value.high])
        lines.append(f"  {word} {middle} (95 %: {low} to {high})")
    for name, figure in named.physical.items():
        if name not in named.parameters:
            lines.append("  {} {}".format(*_one(name, figure)))
    lines += [f"  looks the same: {words}" for words in named.equivalent]
    return [*lines, f"  look at: {named.where_to_look}"]


def _one(name: str, figure: float) -> tuple[str, str]:
    word, shown = readable(name, [figure])
    return word, shown[0]


def _error_line(word: str, size: float, *errors_rad: float) -> str:
    rms, low, high, peak = (error / size for error in errors_rad)
    return f"{word:<24}{rms:>10.3g}{low:>12.3g}{high:>10.3g}{peak:>10.3g}"
