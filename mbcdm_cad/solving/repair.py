"""Guided search: try the remedies of the failing checks, then reduce the changes as far as the design passes."""

from collections.abc import Iterator, Sequence
from itertools import chain, pairwise

from mbcdm_cad.design.sized import Freedom
from mbcdm_cad.design.yamltree import value_at
from mbcdm_cad.errors import InputError
from mbcdm_cad.solving.question import Fixed, Out, Point, Setting, Times, round_to
from mbcdm_cad.solving.trials import (
    NO_FIGURE,
    SLOW,
    TrialResult,
    Trials,
    choices,
    cost,
    entries_of,
    over_limit,
    setting_of,
)

# Size of one step of a number as a share of its value, and of a range as a share of its width.
STEPS = (0.02, 0.08, 0.25, 0.7)
RANGE_STEPS = (0.1, 0.3, 1.0)
# Places of a choice that are tried, counted from the present one in the order of sizes.
SIZES = (-1, 1, 2, 4)
# Failing checks whose remedies are tried, and the moves of one round at most.
FIRST_CHECKS, MOST_MOVES = 6, 90
# Improvements that are also tried together.
TOGETHER = 4
ROUNDS = 12
# Trials after which a round looks whether one of them passes or comes far: the moves that help are among the first.
BATCH = 12
GAIN = 1e-3
# If a check misses by the same amount in at least ENOUGH trials, no free field affects it. SAME: tolerance of the miss.
ENOUGH, SAME = 20, 1e-6


def repair(trials: Trials, start: Point, most: int, at_once: int = MOST_MOVES) -> Point:
    """The best point found by some rounds of changes from ``start``, with at most about ``most`` trials.

    A round ends after a batch of trials of which one passes or comes far. ``at_once``: changes after which it also ends
    if they do not affect some check.
    """
    best, limit = dict(start), trials.count + most
    for _ in range(ROUNDS):
        now = trials(best)
        if now.passes or trials.count >= limit:
            break
        moves = list(_Moves(trials, best, now))[: max(min(MOST_MOVES, limit - trials.count), 4)]
        points = [{**best, field: setting} for field, setting in moves]
        outcomes, far = list[TrialResult](), False
        for first in range(0, len(points), min(BATCH, at_once)):
            outcomes += trials.many(points[first : first + min(BATCH, at_once)])
            far = any(_comes_far(now, outcome) for outcome in outcomes)
            if far or (len(outcomes) >= at_once and _unmoved(now, outcomes)):
                break
        if not far and _unmoved(now, outcomes):
            break
        better = sorted((o.violation, k) for k, o in enumerate(outcomes) if o.violation < now.violation - GAIN)
        if not better:
            break
        joined, fields = dict(best), set[str]()
        combined: list[Point] = [points[better[0][1]]]
        for _, k in better:
            field, setting = moves[k]
            if field not in fields and len(fields) < TOGETHER:
                fields.add(field)
                joined = {**joined, field: setting}
                combined.append(joined)
        if any(outcome.passes for outcome in outcomes):
            combined = [points[k] for k, outcome in enumerate(outcomes) if outcome.passes]
        best = dict(trials.best(combined))
        if creeps(now, trials(best)):
            break
    return best


def _comes_far(before: TrialResult, after: TrialResult) -> bool:
    """Whether fewer checks fail, or the same ones by at most half as much altogether."""
    if after.refused or len(after.failing) > len(before.failing):
        return False
    if before.refused or len(after.failing) < len(before.failing):
        return True
    return sum(over_limit(miss) for _, miss in after.failing) <= 0.5 * sum(
        over_limit(miss) for _, miss in before.failing
    )


def creeps(before: TrialResult, after: TrialResult) -> bool:
    """Whether a round left every check failing, each by less than its share of all rounds nearer to its limit.

    A round tries all moves and the best of them together: as many again do not reach the limits.
    """
    was, now = dict(before.failing), dict(after.failing)
    if after.passes or before.refused or after.refused or was.keys() != now.keys():
        return False
    return all(over_limit(now[name]) > (1.0 - 1.0 / ROUNDS) * over_limit(was[name]) for name in was)


def stuck(trials: Trials, point: Point) -> frozenset[str]:
    """The checks that fail at a point and that no single move from there changes."""
    now = trials(point)
    moves = list(_Moves(trials, point, now))[:MOST_MOVES]
    outcomes = list[TrialResult]()
    for first in range(0, len(moves), BATCH):
        outcomes += trials.many([{**point, field: setting} for field, setting in moves[first : first + BATCH]])
        if len(outcomes) >= ENOUGH and not _unmoved(now, outcomes):
            return frozenset()
    return _unmoved(now, outcomes)


def _unmoved(now: TrialResult, outcomes: Sequence[TrialResult]) -> frozenset[str]:
    """The checks that miss by the same amount in every trial: no free field affects them."""
    others = [dict(outcome.failing) for outcome in outcomes if not outcome.refused]
    if len(others) < ENOUGH:
        return frozenset()
    return frozenset(
        name
        for name, miss in now.failing
        if name not in SLOW and miss < NO_FIGURE and all(abs(other.get(name, 0.0) - miss) < SAME for other in others)
    )


class _Moves:
    """Moves from one point: removal of pins, remedies of failing checks, choices, ranges, all free numbers."""

    def __init__(self, trials: Trials, point: Point, now: TrialResult) -> None:
        self.trials, self.question, self.point, self.now = trials, trials.question, point, now
        self.freedoms = {freedom.field: freedom for freedom in trials.question.open_fields(point)}
        found = trials.begin_at(point)
        self.values = found.design.model_dump() if found is not None else {}

    def __iter__(self) -> Iterator[tuple[str, Setting]]:
        seen = set[tuple[str, Setting]]()
        along = (move for field in sorted(self.question.unruled) for s in (1, -1) for move in self._within(field, s))
        # Removal of one pin of the file; from a complete file :func:`solve` removes them all before.
        pins = () if self.question.complete else self.question.releases
        out = ((field, Out()) for field in pins if field not in self.point)
        for move in chain(out, self._asked_for(), self._sizes(), along, self._free()):
            if move not in seen and self.point.get(move[0]) != move[1]:
                seen.add(move)
                yield move

    def _asked_for(self) -> Iterator[tuple[str, Setting]]:
        """Changes that the remedies of the checks with the largest misses name, in their direction."""
        names = {field: (field, 1) for field in chain(self.freedoms, self.question.ranges)}
        for freedom in self.freedoms.values():
            names |= {alias: (freedom.field, sense) for alias, sense in freedom.mends}
        for check, _ in sorted(self.now.failing, key=lambda item: -item[1])[:FIRST_CHECKS]:
            # A check of a first stage has no place here: its remedies are words of another design.
            for path, sense in self.trials.checks[check].adjust if check in self.trials.checks else ():
                field, way = names.get(path, ("", 0))
                if field in self.question.unruled:
                    yield from self._within(field, way * sense)
                elif field in self.freedoms:
                    yield from self._steps(self.freedoms[field], way * sense)

    def _steps(self, freedom: Freedom, sense: int) -> Iterator[tuple[str, Setting]]:
        """A number some steps up or down; a choice one to three sizes."""
        if freedom.is_choice:
            yield from self._sized(freedom, [sense * size for size in (1, 2, 3)])
            return
        value = value_at(self.values, freedom.field)
        if isinstance(value, int | float) and value < 0:
            sense = -sense  # a factor above one lowers a negative value
        yield from self._stretched(freedom, STEPS, (sense,))

    def _stretched(
        self, freedom: Freedom, steps: Sequence[float], senses: Sequence[int]
    ) -> Iterator[tuple[str, Setting]]:
        setting = self.point.get(freedom.field)
        if isinstance(setting, Fixed):
            return
        factor = setting.factor if isinstance(setting, Times) else 1.0
        for step in steps:
            for sense in senses:
                moved = min(max(factor * (1.0 + step) ** sense, freedom.low), freedom.high)
                yield freedom.field, Times(round_to(moved))

    def _sized(self, freedom: Freedom, sizes: Sequence[int]) -> Iterator[tuple[str, Setting]]:
        """A choice moved by some places in the order of sizes; of words, the first holds if no rule gave one.

        A rope is moved among those of its construction.
        """
        names, now = choices(self.question, freedom), value_at(self.values, freedom.field)
        if now is None and freedom.words:
            now = freedom.words[0]
        if freedom.kind == "ropes":
            names = self._ropes(names).get(self._construction(now), names)
        for size in sizes:
            at = names.index(now) + size if now in names else -1
            if 0 <= at < len(names):
                yield freedom.field, Fixed(names[at])

    def _construction(self, rope: object) -> str:
        entry = entries_of(self.question, "ropes").get(rope) if isinstance(rope, str) else None
        return str((entry or {}).get("construction"))

    def _ropes(self, names: Sequence[str]) -> dict[str, list[str]]:
        """The ropes of each construction, thin before thick."""
        found: dict[str, list[str]] = {}
        for name in names:
            found.setdefault(self._construction(name), []).append(name)
        return found

    def _other_ropes(self, freedom: Freedom) -> Iterator[tuple[str, Setting]]:
        """Of each other construction the rope of the nearest diameter, and the next thinner one."""
        now = value_at(self.values, freedom.field)
        ropes, entries = self._ropes(choices(self.question, freedom)), entries_of(self.question, "ropes")
        if now not in entries:
            return
        wanted = entries[now]["diameter_mm"]
        for kind, names in sorted(ropes.items()):
            if kind != self._construction(now):
                nearest = min(range(len(names)), key=lambda k: abs(entries[names[k]]["diameter_mm"] - wanted))
                yield from ((freedom.field, Fixed(names[k])) for k in (nearest, nearest - 1) if k >= 0)

    def _sizes(self) -> Iterator[tuple[str, Setting]]:
        """Choices some sizes up and down, the nearest of all choices first."""
        for size in SIZES:
            for freedom in self.freedoms.values():
                if freedom.is_choice and not freedom.only_named:
                    yield from self._sized(freedom, [size])
            if size == SIZES[1] and "rope.type" in self.freedoms:
                yield from self._other_ropes(self.freedoms["rope.type"])

    def _within(self, field: str, sense: int) -> Iterator[tuple[str, Setting]]:
        found, setting = self.question.ranges[field], self.point.get(field)
        now = float(setting.value) if isinstance(setting, Fixed) else self.question.middle(field)
        for step in RANGE_STEPS:
            value = round_to(now + sense * step * (found.high - found.low))
            yield field, setting_of(found.within(value))

    def _free(self) -> Iterator[tuple[str, Setting]]:
        """Free numbers up and down, by the two steps of medium size."""
        for freedom in self.freedoms.values():
            if not freedom.is_choice and freedom.low < freedom.high:
                yield from self._stretched(freedom, STEPS[1:3], (1, -1))


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
            for first, second in pairwise(left):
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
        middle = round_to(0.5 * (passing + failing))
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
    return round_to(near * (far / near) ** share if by_ratio else near + share * (far - near))
