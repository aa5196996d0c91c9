"""The finding in plain sentences for a new reader: what is wrong, how certain it is, what to do; no identifiers.

Figures are rounded to the digits that their intervals support.
"""

import math

from mbcdm_cad.loop.readable import Value, probability_text, size_of
from mbcdm_cad.loop.result import LEAST_ODDS, ONLY_RATIO, LoopResult, Named, ways_apart


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
    factor, unit = size_of(name, [value.value, value.low, value.high])
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
