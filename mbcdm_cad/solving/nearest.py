"""Reduce the changes of a passing design, one by one, as far as it still passes."""

from __future__ import annotations

from itertools import pairwise

from mbcdm_cad.design.fieldpath import value_at
from mbcdm_cad.errors import InputError
from mbcdm_cad.solving.question import Fixed, Out, Point, Times
from mbcdm_cad.solving.repair import repair
from mbcdm_cad.solving.trials import Trials, cost, setting_of

BISECTIONS = 5
AIM_STEPS = 7
# Beyond the value that the rules alone reach: step as a share of the rest, trials to repair it, how many of them at
# once, number of steps.
FURTHER, TRIALS_FOR_AN_AIM, TRIALS_AT_ONCE, AIM_REPAIRS = 0.05, 60, 20, 4


def written_out(trials: Trials, point: Point) -> Point:
    """The point with numbers in place of factors and ranges, as the file will state them."""
    found = trials.question.as_written(point)
    moved = [field for field, setting in point.items() if isinstance(setting, Times)]
    moved += [field for field in trials.question.ranges if field not in point]
    return {**point, **{field: setting_of(value_at(found, field)) for field in moved}}


def taken_back(trials: Trials, point: Point) -> Point:
    """The nearest passing point between a passing point and the values of file and rules."""
    trials.begin_at(point)
    now = _released_less(trials, point)
    for field in sorted(now, key=lambda name: (-cost(trials.question, {name: now[name]}), name)):
        if field in trials.question.ranges or isinstance(now[field], Out):
            continue
        without = {name: setting for name, setting in now.items() if name != field}
        if trials(without).passes:
            now = without
    for field in sorted(now):
        now = _halved(trials, now, field)
    return now


def _released_less(trials: Trials, point: Point) -> Point:
    """Put removed fields back: all of one kind, else each half of them, down to single fields."""
    for kind in sorted({trials.question.releases.get(field, 0) for field in point}, reverse=True):
        fields = [
            f for f, s in sorted(point.items()) if isinstance(s, Out) and trials.question.releases.get(f, 0) == kind
        ]
        point = _put_back(trials, point, fields)
        # Fields that belong together, such as a modulus and its area, are put back together or not at all.
        for block in dict.fromkeys(field.partition(".")[0] for field in fields):
            left = [field for field in fields if field in point and field.startswith(f"{block}.")]
            point = _pairs_put_back(trials, point, left)
    return point


def _pairs_put_back(trials: Trials, point: Point, fields: list[str]) -> Point:
    for first, second in pairwise(fields):
        if first in point and second in point:
            without = {name: setting for name, setting in point.items() if name not in (first, second)}
            point = without if trials(without).passes else point
    return point


def _put_back(trials: Trials, point: Point, fields: list[str]) -> Point:
    if not fields:
        return point
    without = {name: setting for name, setting in point.items() if name not in fields}
    if trials(without).passes:
        return without
    if len(fields) > 1:
        half = len(fields) // 2
        point = _put_back(trials, point, fields[:half])
        point = _put_back(trials, point, fields[half:])
    return point


def _halved(trials: Trials, point: Point, field: str) -> Point:
    """Move a number back towards its value before the search, by bisection, as far as the design still passes."""
    setting = point[field]
    if not isinstance(setting, Fixed) or isinstance(setting.value, str | bool | tuple):
        return point
    home = _home(trials, point, field)
    if not isinstance(home, int | float):
        return point
    passing, failing, best = float(setting.value), float(home), point
    for _ in range(BISECTIONS):
        middle = float(f"{0.5 * (passing + failing):.4g}")
        trial = {**point, field: Fixed(middle)}
        if middle in (passing, failing):
            break
        if trials(trial).passes:
            passing, best = middle, trial
        else:
            failing = middle
    return best


def _home(trials: Trials, point: Point, field: str) -> object:
    """Value of a field that the search does not change: its rule's value within its range, or the range's middle.

    None if it has none, or if the file states an aim for the range.
    """
    if field in trials.question.unruled:
        return None if trials.question.ranges[field].aim else trials.question.middle(field)
    if field in trials.question.ranges and trials.question.ranges[field].aim:
        return None
    without = {name: setting for name, setting in point.items() if name != field}
    try:
        return value_at(trials.question.as_written(without), field) or _sized(trials, without, field)
    except InputError:
        return None


def _sized(trials: Trials, point: Point, field: str) -> object:
    sized = trials.question.resolve(*trials.question.trial(point)).sized
    return next((value.value for value in sized if value.field == field), None)


def towards_aims(trials: Trials, point: Point) -> Point:
    """Move ranges towards their aim (min or max): by bisection, then in small steps if a repair makes them pass."""
    for field, found in trials.question.ranges.items():
        if not found.aim:
            continue
        end = found.low if found.aim == "min" else found.high
        trials.begin_at(point)
        point = _bisected(trials, point, field, end)
        for _ in range(AIM_REPAIRS):
            near = {**point, field: Fixed(_between(_number(point, field), end, FURTHER))}
            trial = dict(repair(trials, near, TRIALS_FOR_AN_AIM, TRIALS_AT_ONCE))
            trial = dict(written_out(trials, trial)) if trials(trial).passes else trial
            if trial.get(field) != near[field] or not trials.confirmed(trial):
                break
            point = _bisected(trials, trial, field, end)
    return point


def _bisected(trials: Trials, point: Point, field: str, end: float) -> Point:
    """A passing point with a field as near to ``end`` as possible while no other field changes."""
    passing, failing = _number(point, field), end
    for _ in range(AIM_STEPS):
        middle = _between(passing, failing, 0.5)
        if middle in (passing, failing):
            break
        trial = {**point, field: Fixed(middle)}
        if trials.confirmed(trial):
            passing, point = middle, trial
        else:
            failing = middle
    return point


def _number(point: Point, field: str) -> float:
    setting = point[field]
    assert isinstance(setting, Fixed), "values are written out by now"
    return float(setting.value)


def _between(near: float, far: float, share: float) -> float:
    """Value at this share of the interval between two values; on a logarithmic scale if both are positive."""
    by_ratio = near > 0.0 and far > 0.0
    return float(f"{near * (far / near) ** share if by_ratio else near + share * (far - near):.4g}")
