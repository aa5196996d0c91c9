"""Find which requirements exclude each other, and how far each must change, by relaxing one at a time.

If a design passes after one requirement alone is relaxed, this requirement belongs to every set of requirements that
exclude each other. If no design passes after all other requirements are dropped, the requirements found in this way are
such a set, and a smallest one. If no single requirement is enough, the one that brings the design nearest to a pass is
relaxed first, and the search is repeated for the others.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import log
from typing import Any

from mbcdm_cad.design.yamltree import leaves
from mbcdm_cad.errors import InputError
from mbcdm_cad.solving.question import ASIDE, Fixed, Out, Point, Question, round_to
from mbcdm_cad.solving.repair import repair, stuck
from mbcdm_cad.solving.trials import SpentError, TrialResult, Trials, messages

# Factors by which a requirement is relaxed, in both directions.
SHARES = (1.05, 1.15, 1.4, 2.0, 4.0, 12.0)
BISECTIONS = 4
# Trials to make a design pass at one value of a requirement, and how many values of one requirement are repaired.
TRIALS, VALUES = 40, 2
# Trials after which no further requirement is relaxed: once one is known that is enough, and in all.
ENOUGH_KNOWN, MOST = 80, 200
# Largest number of requirements that are relaxed one after the other.
MOST_GIVING = 3


@dataclass(frozen=True)
class Give:
    """How far one requirement must change; ``after`` None: it is left out, and its rule gives the value.

    ``moves`` are the other changes with which the design then passes, by field.
    """

    field: str
    before: Any
    after: Any
    moves: dict[str, Any]


@dataclass(frozen=True)
class Conflict:
    """Why no design passes.

    ``first``: requirements that were relaxed first, one after the other; then any one of ``either`` is enough.
    ``exclude``: the smallest set of requirements that no design was found to meet together; ``proved``: a failing check
    is moved by nothing that is free, and no design passes even when all others are dropped, so that they exclude each
    other. ``nearest``: the checks that fail on the nearest design.
    ``not_tried``: requirements that were left when the trials were spent.
    """

    exclude: tuple[str, ...]
    either: tuple[Give, ...]
    first: tuple[Give, ...]
    nearest: tuple[tuple[str, str], ...]
    proved: bool
    not_tried: tuple[str, ...] = ()


def conflict(trials: Trials, miss: Point) -> Conflict:
    """The conflict of a question whose best point is ``miss``."""
    question, first = trials.question, list[Give]()
    nearest = tuple(messages(question, miss))
    left = list(_requirements(question))
    spent = 0
    with suppress(SpentError):
        for _ in range(MOST_GIVING):
            fixed = stuck(trials, {}) if trials({}).failing else frozenset[str]()
            before = trials.count
            found: list[Give | Miss | None] = []
            enough: list[Give] = []
            # Those first whose limit a failing check has: its source names them.
            sources = " ".join(trials.checks[name].source for name, _ in trials(miss).failing if name in trials.checks)
            left = sorted(_requirements(trials.question), key=lambda name: name not in sources)
            with suppress(SpentError):
                while left and spent + trials.count - before < (ENOUGH_KNOWN if enough else MOST):
                    found.append(_given_way(trials, left[0], miss, fixed))
                    left.pop(0)
                    enough = [way for way in found if isinstance(way, Give)]
            spent += trials.count - before
            if enough:
                exclude = tuple(sorted(way.field for way in enough))
                # One alone belongs to several sets, each with another partner: no set is found then.
                # What a search does not find may exist, unless a failing check is moved by nothing that is free.
                proved = len(exclude) > 1 and not left and bool(fixed) and _rest_is_idle(trials, exclude, miss)
                ways = tuple(sorted(enough, key=_size))
                return Conflict(exclude, ways, tuple(first), nearest, proved, tuple(left))
            least = min((way for way in found if isinstance(way, tuple)), default=None, key=lambda way: way[:2])
            if left or least is None or least[0] >= trials(miss).violation:
                break
            _, name, value, miss = least
            first.append(Give(name, _shown(trials.question, name), value, {}))
            trials = _on(trials, name, value)
            miss = {field: setting for field, setting in miss.items() if field != name}
    return Conflict((), (), tuple(first), nearest, proved=False, not_tried=tuple(left))


def _size(way: Give) -> tuple[float, str]:
    """Small changes first; requirements left out last."""
    if isinstance(way.after, int | float) and isinstance(way.before, int | float) and way.after * way.before > 0:
        return abs(log(way.after / way.before)), way.field
    return 10.0, way.field


def _on(trials: Trials, name: str, value: Any) -> Trials:
    """The same question with one requirement set to ``value``, or left out."""
    question = trials.question.relaxed({name: Out() if value is None else Fixed(value)})
    return Trials(question, trials.jobs, trials.told, trials.most - trials.count)


def _requirements(question: Question) -> Iterator[str]:
    """The requirements of the file: fields that the search may not change, without those that only describe it."""
    for name, value in leaves(question.data):
        listed = isinstance(value, list) and not all(isinstance(item, int | float) for item in value)
        if (
            name.split(".")[0] not in ASIDE
            and name not in question.releases
            and not isinstance(value, bool)
            and not listed
        ):
            yield name
    yield from question.ranges


def _shown(question: Question, name: str) -> Any:
    found = question.ranges.get(name)
    return dict(leaves(question.data)).get(name) if found is None else found.words()


Miss = tuple[float, str, Any, Point]


def _given_way(trials: Trials, name: str, miss: Point, fixed: frozenset[str]) -> Give | Miss | None:
    """The change of one requirement with which a design passes; if none is found, (violation, name, value, point).

    None if no value of the requirement lowers the violation, or if one of the ``fixed`` checks, which no move changes,
    misses by the same amount.
    """
    before, (starts, outcomes) = trials({}), _tried(trials, name)
    order = sorted(range(len(starts)), key=lambda k: (round(outcomes[k].violation, 9), k))
    best: Point | None = None
    for k in order[:VALUES]:
        still = dict(outcomes[k].failing)
        if outcomes[k].violation >= before.violation or any(
            still.get(check) == dict(before.failing)[check] for check in fixed
        ):
            continue
        start = trials.best([starts[k], {**miss, **starts[k]}])
        found = repair(trials, start, TRIALS)
        if trials.confirmed(found):
            return _as_little(trials, name, found)
        if best is None or trials(found).violation < trials(best).violation:
            best = found
    if best is None:
        return None
    setting = best.get(name)
    value = setting.value if isinstance(setting, Fixed) else None
    return trials(best).violation, name, value, best


def _tried(trials: Trials, name: str) -> tuple[list[Point], list[TrialResult]]:
    """Values of a requirement with their results; those of a sense in which the first two do not help are left out."""
    starts: list[list[Point]] = [[{name: _setting(value)} for value in way] for way in _values(trials.question, name)]
    first = [values if len(values) == 1 else values[1:4:2] for values in starts]
    points = [point for values in first for point in values]
    outcomes, before = trials.many(points), trials({}).violation
    for values, few in zip(starts, first, strict=True):
        rest = [point for point in values if point not in few]
        if rest and min(trials(point).violation for point in few) < before:
            points, outcomes = points + rest, outcomes + trials.many(rest)
    return points, outcomes


def _values(question: Question, name: str) -> Iterator[list[Any]]:
    """Values of a requirement that may be tried, by the sense in which they lie: None for leaving it out."""
    if name in question.ranges:
        found = question.ranges[name]
        yield [round_to(found.low / share) for share in SHARES] if found.low > 0.0 else []
        yield [round_to(found.high * share) for share in SHARES]
        return
    value = dict(leaves(question.data))[name]
    if _has_rule(question, name):
        yield [None]
    if isinstance(value, int | float):
        yield [round_to(value * share) for share in SHARES]
        yield [round_to(value / share) for share in SHARES]
    elif isinstance(value, list):
        yield [tuple(round_to(v * share) for v in value) for share in SHARES]
        yield [tuple(round_to(v / share) for v in value) for share in SHARES]


def _has_rule(question: Question, name: str) -> bool:
    try:
        found = question.resolve(*question.trial({name: Out()}))
    except InputError as error:
        return not any(problem.field == name or problem.missing for problem in error.problems)
    return any(value.field == name for value in found.sized)


def _setting(value: Any) -> Out | Fixed:
    return Out() if value is None else Fixed(value)


def _as_little(trials: Trials, name: str, found: Point) -> Give:
    """Move a passing value back towards the value that the file asks for, by bisection, as far as the design passes."""
    before = _shown(trials.question, name)
    setting = found[name]
    asked = dict(leaves(trials.question.data)).get(name)
    if isinstance(setting, Out) and isinstance(asked, int | float):
        sized = trials.question.resolve(*trials.question.trial(found)).sized
        value = next((item.value for item in sized if item.field == name), None)
        setting = Fixed(value) if isinstance(value, int | float) else Out()
    if isinstance(setting, Fixed) and isinstance(setting.value, int | float):
        end = asked
        if name in trials.question.ranges:
            end = trials.question.ranges[name].within(float(setting.value))
        assert isinstance(end, int | float)
        passing, failing = float(setting.value), float(end)
        for _ in range(BISECTIONS):
            middle = round_to(0.5 * (passing + failing))
            if middle in (passing, failing):
                break
            trial: Point = {**found, name: Fixed(middle)}
            if not trials(trial).passes:
                trial = repair(trials, trial, TRIALS // 2)
            if trials.confirmed(trial):
                passing, found = middle, trial
            else:
                failing = middle
        setting = found[name]
    after = setting.value if isinstance(setting, Fixed) else None
    moves = {field: how.value if isinstance(how, Fixed) else how for field, how in found.items() if field != name}
    return Give(name, before, list(after) if isinstance(after, tuple) else after, moves)


def _rest_is_idle(trials: Trials, exclude: tuple[str, ...], miss: Point) -> bool:
    """Whether no design passes even when all other requirements that have a rule are dropped."""
    others = [name for name in _requirements(trials.question) if name not in exclude]
    dropped = {
        name: Out() for name in others if name not in trials.question.ranges and _has_rule(trials.question, name)
    }
    if not dropped:
        return True
    start = {**{field: how for field, how in miss.items() if field not in dropped}, **dropped}
    try:
        return not trials(repair(trials, start, TRIALS * 2)).passes
    except SpentError:
        return False
