"""What a search for the best design shall reach, which fields it may set, how long it may take, and its variables.

A variable is what an engine varies; a set of values of all means a point of a question. A field with a rule keeps the
value of its rule in the middle of its variable, so that few fields of a good design differ from their rules, and its
file stays short.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from math import exp, isfinite, log, prod
from typing import Any

import numpy as np

from mbcdm_cad.design.sized import LIGHTEST
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.solving.question import Fixed, Point, Question, Setting, Times, round_to
from mbcdm_cad.solving.trials import choices, setting_of

SENSES = ("min", "max")
MOST_AIMS = 4


@dataclass(frozen=True)
class Aim:
    """One figure to make as small (``min``) or as large (``max``) as possible."""

    figure: str
    sense: str

    def less(self, value: float) -> float:
        """The figure such that less is better."""
        return value if self.sense == "min" else -value

    def __str__(self) -> str:
        """As the command line takes it."""
        return f"{self.figure}:{self.sense}"


@dataclass(frozen=True)
class Keep:
    """One figure that must be at least (``sense`` +1) or at most (-1) a limit."""

    figure: str
    sense: int
    limit: float

    def margin(self, value: float) -> float:
        """Distance from the limit in the figure's unit, positive inside."""
        return self.sense * (value - self.limit)

    def __str__(self) -> str:
        """As the command line takes it."""
        return f"{self.figure}:{'>=' if self.sense > 0 else '<='}{self.limit:g}"


@dataclass(frozen=True)
class Freed:
    """A field that a search may set: to one of ``values``, or to a number from ``low`` to ``high``."""

    field: str
    values: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Wishes:
    """All of a search: 1 to 4 ``aims``, ``keeps``, and ``free`` fields.

    ``only_free``: fields that the file leaves to their rules follow these rules and are not free.
    """

    aims: tuple[Aim, ...]
    keeps: tuple[Keep, ...] = ()
    free: tuple[Freed, ...] = ()
    only_free: bool = False


def wishes_of(
    aims: Sequence[str], keeps: Sequence[str] = (), free: Sequence[str] = (), *, only_free: bool = False
) -> Wishes:
    """Wishes from their texts.

    Such as ``mass_g:min``, ``torque_Nm:>=3``, ``drum.material=pa12,pla`` or ``rope.preload_N=30..90``. Raises
    ``MbcdmError`` for a text that is none, for no aim, more than four, or one figure twice.
    """
    found = []
    for text in aims:
        figure, _, sense = text.partition(":")
        if sense not in SENSES or not figure:
            raise MbcdmError(f"--aim: not an aim (value {text}, limit FIGURE:min or FIGURE:max); write mass_g:min, say")
        found.append(Aim(figure, sense))
    if not 1 <= len(found) <= MOST_AIMS:
        raise MbcdmError(f"--aim: {len(found)} given (limit 1 to {MOST_AIMS}); for example --aim mass_g:min")
    names = [aim.figure for aim in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise MbcdmError(f"--aim: {twice} is given twice; give each figure one aim")
    return Wishes(tuple(found), tuple(_keep(text) for text in keeps), tuple(_freed(text) for text in free), only_free)


def over_tolerances(wishes: Sequence[str]) -> tuple[str, ...]:
    """Texts of aims or keeps with the value that 95 % of the drives reach in place of each figure that has one.

    ``swing_mrad:min`` becomes ``swing_mrad_p95:min``, ``torque_Nm:>=2`` becomes ``torque_Nm_p5:>=2``; see
    :mod:`mbcdm_cad.optimising.spread`.
    """
    from mbcdm_cad.optimising.spread import SPREAD

    found = []
    for text in wishes:
        figure, colon, rest = text.partition(":")
        worse = "_p95" if rest.strip().startswith(("min", "<")) else "_p5"
        found.append(f"{figure}{worse if figure.strip() in SPREAD else ''}{colon}{rest}")
    return tuple(found)


def _number(text: str) -> float | None:
    """The finite number of a text; None for another text."""
    with suppress(ValueError):
        number = float(text)
        return number if isfinite(number) else None
    return None


def _value(text: str) -> Any:
    """A value as in a design file; None for a text that is none."""
    import yaml  # the package's own import brings this file, and should be fast

    with suppress(yaml.YAMLError, ValueError):
        return yaml.safe_load(text)
    return None


def _keep(text: str) -> Keep:
    found = re.fullmatch(r"([^:]+):(>=|<=)(.+)", text.replace(" ", ""))
    limit = _number(found[3]) if found is not None else None
    if found is not None and limit is not None:
        return Keep(found[1], 1 if found[2] == ">=" else -1, limit)
    raise MbcdmError(
        f"--keep: not a figure with a limit (value {text}, limit FIGURE:>=NUMBER or FIGURE:<=NUMBER); write "
        "torque_to_weight_Nm_kg:>=9, say"
    )


def _freed(text: str) -> Freed:
    field, _, given = text.partition("=")
    span = re.fullmatch(r"(\S+)\.\.(\S+)", given)
    if span is not None:
        low, high = map(_number, span.groups())
        if low is not None and high is not None and low < high:
            return Freed(field, (), low, high)
    elif field and given:
        values = tuple(map(_value, given.split(",")))
        if all(isinstance(value, bool | int | float | str) for value in values):
            return Freed(field, values)
    raise MbcdmError(
        f"--free: not a field with values (value {text}, limit FIELD=A,B,... or FIELD=LOW..HIGH); write "
        "drum.material=aluminium-7075,pa12, say"
    )


# Share of a factor's variable, around its middle, that means "as its rule says".
STILL = 0.2
# Fields that differ from their rules in a point of the first generation, on average.
MOVED_AT_FIRST = 2.5
# A number this near to an end of its range, as a share of the range, is that end: the best often lies there.
SNAP = 0.03
# A range is followed by its logarithm if its ends are this far apart.
WIDE = 4.0
# The ratio of the lightest drive may be changed by this factor both ways.
AROUND = 2.5
# Draws for each point of the first generation; where few values are free, some of them are equal.
_DRAWS = 4
# A choice that leaves the field to its rule.
RULE = ""

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Variable:
    """One field: ``options``, of which a point takes one, or a number from ``low`` to ``high`` of which 0 means
    "as its rule says" if ``ruled``."""

    field: str
    options: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 1.0
    ruled: bool = True
    logarithmic: bool = False

    def setting(self, value: Any) -> Setting | None:
        """What a value of the variable does to its field; None: its rule gives it."""
        if self.options:
            return None if value == RULE else setting_of(value)
        u = float(value)
        if self.ruled:
            moved = max(abs(u) - STILL, 0.0) / (1.0 - STILL)
            factor = round_to(exp(moved * log(self.high if u > 0.0 else self.low)))
            return None if factor == 1.0 else Times(factor)
        u = 0.0 if u < SNAP else 1.0 if u > 1.0 - SNAP else u
        if self.logarithmic:
            found = exp(log(self.low) + u * (log(self.high) - log(self.low)))
        else:
            found = self.low + u * (self.high - self.low)
        return Fixed(min(max(round_to(found), self.low), self.high))

    @property
    def start(self) -> Any:
        """The value with which a search begins: the rule, or the middle of a range."""
        if self.options:
            return RULE if RULE in self.options else self.options[0]
        return 0.0 if self.ruled else 0.5

    def drawn(self, rng: np.random.Generator) -> Any:
        """A random value."""
        if self.options:
            return self.options[int(rng.integers(len(self.options)))]
        return float(rng.uniform(-1.0 if self.ruled else 0.0, 1.0))


def variables_of(question: Question, wishes: Wishes) -> tuple[Variable, ...]:
    """The variables of a question: its ranges, the wishes' own, and the fields that the file leaves to their rules.

    Raises ``MbcdmError`` for a field that the layout does not have, and if nothing is free.
    """
    found = dict[str, Variable]()
    for freed in wishes.free:
        name, of = freed.field, question.data["configuration"]
        if question.file.node_at(tuple(name.split("."))) is None:
            raise MbcdmError(f"--free: {name}: {of} has no such field; see mbcdm schema")
        found[name] = Variable(name, freed.values) if freed.values else _between(name, freed.low, freed.high)
    for name, span in question.ranges.items():
        if name not in found:
            found[name] = _between(name, span.low, span.high)
    if not wishes.only_free:
        found |= {v.field: v for v in _open_ratio(question) if not _stated_within(v.field, found)}
        found |= {v.field: v for v in _ruled(question) if not _stated_within(v.field, found)}
    if not found:
        raise MbcdmError(
            f"{question.path}: nothing is free; leave fields out, give them as ranges {{min: 30, max: 60}}, or name "
            "them with --free"
        )
    return tuple(found.values())


def _stated_within(field: str, others: Mapping[str, Variable]) -> bool:
    """Whether a field, a block around it, or a field within it is a variable already."""
    return any(field == o or field.startswith(f"{o}.") or o.startswith(f"{field}.") for o in others)


def _ruled(question: Question) -> Iterator[Variable]:
    for freedom in question.open_fields({}):
        if freedom.only_named:
            continue
        if freedom.is_choice:
            yield Variable(freedom.field, (RULE, *choices(question, freedom)))
        elif freedom.low < freedom.high:
            yield Variable(freedom.field, (), freedom.low, freedom.high)


def _open_ratio(question: Question) -> Iterator[Variable]:
    """The ratio, around that of the lightest drive, where the file leaves it open together with the motor.

    By its rule each point would size whole drives at many ratios to compare them, which the search does itself.
    """
    with suppress(InputError):
        for value in question.resolve(*question.trial({})).sized:
            if value.driver == LIGHTEST:
                yield _between(value.field, value.value / AROUND, value.value * AROUND)


def _between(field: str, low: float, high: float) -> Variable:
    return Variable(field, (), low, high, ruled=False, logarithmic=low > 0.0 and high > WIDE * low)


def point_of(variables: Sequence[Variable], values: Values) -> Point:
    """The point that values of all variables mean."""
    found = {v.field: v.setting(values[v.field]) for v in variables}
    return {field: setting for field, setting in found.items() if setting is not None}


def first_values(variables: Sequence[Variable], count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    """The first generation: the start, the corners if they are few, then points that differ from the start at random.

    Such a point differs in a few ruled fields, and in all others.
    """
    ruled = [v for v in variables if v.ruled and v.start in (0.0, RULE)]
    share = min(0.5, MOVED_AT_FIRST / max(len(ruled), 1))
    start = {v.field: v.start for v in variables}
    found = {tuple(start.values()): start}
    for corner in _corners(variables, start, count // 2):
        found.setdefault(tuple(corner.values()), corner)
    for _ in range(_DRAWS * count):
        if len(found) < count:
            drawn = {v.field: v.drawn(rng) if v not in ruled or rng.random() < share else v.start for v in variables}
            found.setdefault(tuple(drawn.values()), drawn)
    return list(found.values())


def _corners(variables: Sequence[Variable], start: Values, most: int) -> list[dict[str, Any]]:
    """Every combination of the ends of ranges and of choices without a rule, where a front often ends; none if more
    than ``most``."""
    ends = {v.field: v.options or (0.0, 1.0) for v in variables if v.start not in (0.0, RULE)}
    if prod(len(values) for values in ends.values()) > most:
        return []
    return [{**start, **dict(zip(ends, row, strict=True))} for row in product(*ends.values())]
