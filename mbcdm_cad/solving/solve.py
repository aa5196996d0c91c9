"""Find the nearest design that passes every check, or the requirements that exclude it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, exp, log
from typing import Any

import numpy as np

from mbcdm_cad.design.sized import Freedom
from mbcdm_cad.design.yamltree import leaves
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.conflict import Conflict, conflict
from mbcdm_cad.solving.question import ASKED, CHOICE, PIN, WISH, Fixed, Out, Point, Question, Setting, Times, round_to
from mbcdm_cad.solving.repair import creeps, repair, stuck, taken_back, towards_aims, written_out
from mbcdm_cad.solving.trials import SpentError, Trials, choices, cost, outcome, setting_of

# Trials of the guided search and of the evolution after it: numbers, not times, so that the result is reproducible.
DIRECTED, EVOLVED = 140, 96
# All searches end by these numbers: that for a design, and all of it, with its changes reduced or the conflict found.
MOST_FOR_A_DESIGN, MOST_IN_ALL = 500, 1000
# Number of values tried before the search for a range that has an aim and no rule.
GRID = 9


@dataclass(frozen=True)
class Change:
    """One changed field: its value before (None: not in the file), its value now, and why it was free to change."""

    field: str
    before: Any
    after: Any
    note: str


@dataclass(frozen=True)
class Solution:
    """Result of a search. ``data`` is the content of the passing file; None if there is a ``conflict`` instead."""

    question: Question = field(repr=False)
    data: Mapping[str, Any] | None
    changes: tuple[Change, ...]
    trials: int
    conflict: Conflict | None = None


def solve(question: Question, told: Callable[[str, int], None] | None = None, jobs: int | None = None) -> Solution:
    """Search for the nearest passing design. ``told`` is called with the present stage and the number of trials."""
    stage = ["searching"]
    hears = told or (lambda name, count: None)
    trials = Trials(question, jobs, lambda count: hears(stage[0], count), MOST_FOR_A_DESIGN)
    point = _found(trials)
    trials.most = MOST_IN_ALL
    while _passes(trials, point):
        stage[0] = "reducing the changes"
        data = question.as_written(_nearest(trials, point))
        if passes_as_written(question, data):
            return Solution(question, data, tuple(_changes(question, data)), trials.count)
        if trials.from_files:
            break
        trials.begin_at_files()
        point = _found(trials)
    stage[0] = "looking for requirements that exclude each other"
    found = conflict(trials, point)
    return Solution(question, None, (), trials.count, found)


def _passes(trials: Trials, point: Point) -> bool:
    """Whether a point is known to pass before the trials are spent."""
    try:
        return trials(point).passes
    except SpentError:
        return False


def _found(trials: Trials) -> Point:
    """A passing point, or the best that was found before the trials were spent."""
    try:
        return _searched(trials)
    except SpentError:
        return trials.nearest


def _searched(trials: Trials) -> Point:
    starts = list(_starts(trials.question))
    for start, found in zip(starts, trials.many(starts), strict=True):
        if found.passes:
            return start
    start = starts[-1] if trials.question.complete else trials.best(starts)
    point = repair(trials, start, DIRECTED)
    if not trials(point).passes and not creeps(trials(start), trials(point)) and not stuck(trials, point):
        point = trials.best([point, repair(trials, evolve(trials, point, EVOLVED), DIRECTED // 4)])
    return point


def _starts(question: Question) -> Iterator[Point]:
    """The file itself, then without its pins (a complete one also without choices and wishes), then over its ranges."""
    yield {}
    if question.complete:
        for last in (PIN, CHOICE, WISH, ASKED):
            yield {name: Out() for name, kind in sorted(question.releases.items()) if kind <= last}
    else:
        yield from ({name: Out()} for name in sorted(question.releases))
        yield {name: Out() for name in sorted(question.releases)}
    for name in sorted(question.unruled):
        if question.ranges[name].aim:
            found = question.ranges[name]
            for k in range(GRID):
                share = (k + 0.5) / GRID
                spread = found.low * (found.high / found.low) ** share if found.low > 0.0 else None
                value = spread if spread is not None else found.low + share * (found.high - found.low)
                yield {name: setting_of(found.within(round_to(value)))}


def _nearest(trials: Trials, point: Point) -> Point:
    """A passing point with as few changes as are found before the trials are spent."""
    try:
        fixed = written_out(trials, point)
        if not trials(fixed).passes:  # some rules use a stated value, so that stating it can change others
            fixed = repair(trials, fixed, DIRECTED // 4)
            fixed = written_out(trials, fixed) if trials(fixed).passes else point
        return taken_back(trials, towards_aims(trials, fixed))
    except SpentError:
        return point


def _changes(question: Question, data: Mapping[str, Any]) -> Iterator[Change]:
    """The differences between the file and the solution, field by field."""
    before, after = dict(leaves(question.data)), dict(leaves(data))
    for name in dict.fromkeys([*before, *after]):
        was, now = before.get(name), after.get(name)
        if name in question.ranges:
            found = question.ranges[name]
            yield Change(
                name, found.words(), now, "a range" + (f", as near to {found.aim} as possible" if found.aim else "")
            )
        elif was != now:
            kind = question.releases.get(name, WISH) if name in before else 0
            yield Change(name, was, now, _NOTES[kind])


_NOTES = {
    0: "was left to its rule",
    PIN: "was a pin",
    CHOICE: "was the choice of the reference design",
    WISH: "was the value of the reference design",
    ASKED: "was the value of the reference design",
}


def passes_as_written(question: Question, data: Mapping[str, Any]) -> bool:
    """Whether a file with this content passes every check."""
    return outcome(replace(question, data=dict(data), ranges={}), {}).passes


SEED = 20
# Trials in one generation.
POPULATION = 24
# Share of a variable's interval that means "keep the value of the rule", because few fields of a solution change.
STILL = 0.5


def evolve(trials: Trials, start: Point, most: int) -> Point:
    """The best point that at most about ``most`` trials find; stops after the first generation with a passing trial."""
    from scipy.optimize import differential_evolution  # its import takes longer than all checks of a design

    held = dict(start)
    trials.begin_at(start)
    free = (f for f in trials.question.open_fields(start) if not f.only_named and (f.is_choice or f.low < f.high))
    variables = [_variable(trials, freedom) for freedom in free]
    variables += [_along_range(trials, field) for field in sorted(trials.question.unruled)]
    if not variables:
        return start
    rng = np.random.default_rng(SEED)
    first = rng.uniform(0.0, 1.0, (POPULATION, len(variables)))
    first[0] = _STAYS
    found: list[Point] = [start]

    def point_of(x: Floats) -> Point:
        settings = {name: setting for (name, of), u in zip(variables, x, strict=True) if (setting := of(float(u)))}
        return {**held, **settings}

    def generation(_: Callable[..., Any], members: Any) -> Sequence[float]:
        points = [point_of(np.asarray(member)) for member in members]
        outcomes = trials.many(points)
        found.append(trials.best([found[-1], *points]))
        return [o.violation or 1e-3 * cost(trials.question, p) for p, o in zip(points, outcomes, strict=True)]

    differential_evolution(
        lambda x: 0.0,
        [(0.0, 1.0)] * len(variables),
        init=first,
        maxiter=max(ceil(most / POPULATION) - 1, 1),
        popsize=1,
        tol=0.0,
        atol=0.0,
        mutation=(0.4, 0.9),
        recombination=0.6,
        seed=SEED,
        polish=False,
        updating="deferred",
        workers=generation,
        callback=lambda *_, **__: trials(found[-1]).passes,
    )
    return found[-1]


_STAYS = 0.5 * STILL
Variable = tuple[str, Callable[[float], Setting | None]]


def _variable(trials: Trials, freedom: Freedom) -> Variable:
    """A field as a variable from 0 to 1: the value of its rule below ``STILL``, its other values above."""
    names = choices(trials.question, freedom) if freedom.is_choice else []

    def setting(u: float) -> Setting | None:
        if u < STILL:
            return None
        share = (u - STILL) / (1.0 - STILL)
        if names:
            return Fixed(names[min(int(share * len(names)), len(names) - 1)])
        low, high = log(freedom.low), log(freedom.high)
        return Times(round_to(exp(low + share * (high - low))))

    return freedom.field, setting


def _along_range(trials: Trials, field: str) -> Variable:
    found = trials.question.ranges[field]
    return field, lambda u: setting_of(found.within(round_to(found.low + u * (found.high - found.low))))
