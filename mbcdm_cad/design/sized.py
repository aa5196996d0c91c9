"""The values that sizing adds to a design file for fields that it leaves out, each with its reason.

Which of them ``mbcdm solve`` may change, and within which limits. Of a value that its bounds do not allow the
requirement that asks for it is named, not the value, which the user did not write: what can be changed is a requirement
that the rule rests on; a value of it that works is found by trying and stands in the message."""

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp, log
from typing import Any

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.yamltree import Tree, put, value_at
from mbcdm_cad.errors import Problem


def scaled(value: Any, factor: float) -> Any:
    """A number times a factor, to four significant digits: what a file can be written with.

    Of a list, such as the radii of steps, the first value stays and the distances from it are multiplied.
    """
    if isinstance(value, list):
        return [round(value[0] + factor * (item - value[0]), 3) for item in value]
    return float(f"{value * factor:.4g}")


def to_a_size(sizes: Sequence[float], value: float, factor: float) -> float:
    """A number times a factor, to the nearest (by ratio) of the ``sizes`` in which its part is bought."""
    return min(sizes, key=lambda size: abs(log(size / (value * factor))))


def nothing_instead(data: Mapping[str, Any]) -> dict[str, Any]:
    """No fields to add in place of one that is taken out; a name, since it goes to the workers of a cluster."""
    return {}


@dataclass(frozen=True)
class Freedom:
    """One field that follows from a rule, and the range in which a search may change it.

    A number is moved by a factor between ``low`` and ``high``: ``stretch(value, factor)`` is the moved value. A choice
    is one of ``words``, the schema's own first, or of the catalogue's entries of ``kind``, which ``order`` sorts by
    size. ``mends`` names design variables of the checks' remedies that this field stands for, +1 where both rise
    together. ``only_named``: tried only where a failing check names it. ``instead``: the requirements that take the
    field's place where it is taken out of a file, from the file's data.
    """

    field: str
    low: float = 1.0
    high: float = 1.0
    stretch: Callable[[Any, float], Any] = scaled
    kind: str = ""
    order: str = ""
    words: tuple[str, ...] = ()
    mends: tuple[tuple[str, int], ...] = ()
    only_named: bool = False
    instead: Callable[[Mapping[str, Any]], dict[str, Any]] = nothing_instead

    @property
    def is_choice(self) -> bool:
        """Whether the field names something, rather than being a number."""
        return bool(self.kind or self.words)


# What a search makes of the value that a rule finds, by field.
Moved = Mapping[str, Callable[[Any], Any]]

# The driver of a ratio that is that of the lightest drive.
LIGHTEST = "the lightest drive"
# Begins the driver of a field that the design has no use for.
NOT_USED = "not used: "


@dataclass(frozen=True)
class SizedValue:
    """A field that the file leaves out and a rule filled. Values are plain data, in the units of the field's name.

    ``rests_on`` holds the fields that the rule read, with their values; ``driver`` says what set the value: the id of
    the check whose limit it keeps, or the requirement that asks for it.
    """

    field: str
    value: Any
    text: str
    driver: str
    rests_on: Mapping[str, Any]
    rounding: str

    @property
    def reason(self) -> str:
        """What set the value, and by which rule; of a field that is not used only why."""
        return self.driver if self.driver.startswith(NOT_USED) else f"{self.driver}: {self.text}"


@dataclass(frozen=True)
class Sizing:
    """A file's data with every field filled, and a record for each field that a rule filled, in the rules' order.

    ``ends``: how the searches of the rules ended, where they search, and ``refused`` what a drive of them did not bear,
    ``held`` what went up and down; the sizing of a similar design begins there.
    ``raised``: factors on the values of rules with which the design is as stiff, or turns as easily, as its file asks,
    or mass times compliance is least; None before they are sought. ``ratio``: what the lightest of several drives had,
    where file and rules of single fields leave the ratio open.
    """

    data: dict[str, Any]
    values: tuple[SizedValue, ...]
    ends: Mapping[Any, Any] = field(default_factory=dict)
    refused: frozenset[str] = frozenset()
    held: Mapping[str, float] = field(default_factory=dict)
    raised: Mapping[str, float] | None = None
    ratio: float | None = None

    def of(self, name: str) -> SizedValue | None:
        """The record of a field by its dotted name; None where the file gives it."""
        return next((value for value in self.values if value.field == name), None)


class SizingError(Exception):
    """What sizing cannot fill from what the file gives, as broken rules; becomes messages with file and line."""

    def __init__(self, *broken: Broken) -> None:
        super().__init__("; ".join(rule.what for rule in broken))
        self.broken = broken

    def __reduce__(self) -> "tuple[type[SizingError], tuple[Broken, ...]]":
        """Whole across processes, as :class:`~mbcdm_cad.errors.InputError`."""
        return type(self), self.broken


# Blocks with the requirements of a drive, in the order in which a user would rather change them.
REQUIREMENTS = ("loads", "travel", "transmission", "rope")
# Factors on a requirement that are tried both ways, and how close the value in the message is to the border.
FACTORS = (1.2, 2.0, 5.0, 20.0, 100.0)
HALVINGS = 5
Fits = Callable[[Tree], bool]


def blame_requirements(problems: list[Problem], tree: Tree, sizing: Sizing, fits: Fits) -> list[Problem]:
    """The problems, those of derived values told as of the requirement behind them.

    ``fits``: whether a file with other requirements has all values within their bounds.
    """
    return [_told(problem, tree, sizing, fits) for problem in problems]


def _told(problem: Problem, tree: Tree, sizing: Sizing, fits: Fits) -> Problem:
    if sizing.of(problem.field) is None:
        return problem
    asked = dict.fromkeys(_requirements(problem.field, tree, sizing))
    if not asked:
        return problem
    _, bracket, meaning = problem.remedy.partition(" (")
    field, own = next(iter(asked)), f"give {problem.field} a value within its limit{bracket}{meaning}"
    remedy = f"change {' or '.join(asked)}, or {own}"
    # Each trial sizes the whole drive, so that the first requirement that helps is taken.
    works = next(((name, value) for name in asked for value in _works(tree, name, fits)), None)
    if works is not None:
        field, value = works
        way = "raise" if value > value_at(tree.data, field) else "lower"
        remedy = f"{way} {field} to {value:g}, or {own}"
    return replace(
        problem,
        line=tree.line_of(tuple(field.split("."))),
        field=field,
        what=f"leads to {problem.field} of {problem.value}, which is out of bounds",
        value=flow(value_at(tree.data, field)),
        limit=f"{problem.field} {problem.limit}",
        remedy=remedy,
    )


def _requirements(field: str, tree: Tree, sizing: Sizing) -> Iterator[str]:
    """Numbers of the file that a derived value rests on, directly or over other derived values, by their blocks."""
    open_fields, seen, given = [field], {field}, list[str]()
    while open_fields:
        record = sizing.of(open_fields.pop(0))
        for other in record.rests_on if record else ():
            if other in seen:
                continue
            seen.add(other)
            if sizing.of(other) is not None:
                open_fields.append(other)
            elif isinstance(value_at(tree.data, other), int | float):
                given.append(other)
    blocks = {block: place for place, block in enumerate(REQUIREMENTS)}
    yield from sorted((f for f in given if f.partition(".")[0] in blocks), key=lambda f: blocks[f.partition(".")[0]])


def _works(tree: Tree, field: str, fits: Fits) -> Iterator[float]:
    """A value of the field with which the file fits, the nearest upwards first."""
    own = float(value_at(tree.data, field))
    if own <= 0.0:
        return

    def works(factor: float) -> bool:
        return fits(_with(tree, field, _rounded(own * factor)))

    for way in (1.0, -1.0):
        last = 0.0
        for size in map(log, FACTORS):
            if works(exp(way * size)):
                low, high = last, size
                for _ in range(HALVINGS):
                    middle = (low + high) / 2
                    low, high = (low, middle) if works(exp(way * middle)) else (middle, high)
                yield _rounded(own * exp(way * high))
                break
            last = size


def _with(tree: Tree, field: str, value: float) -> Tree:
    data: Any = copy.deepcopy(tree.data)
    put(data, field, value)
    return Tree(data, tree.lines)


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
