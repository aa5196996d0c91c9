"""Requirements given as ranges: ``centre_distance_mm: {min: 30, max: 60}``, or ``min`` for as small as possible.

A file with ranges is not yet a design: ``mbcdm solve`` finds the values; other commands refuse it and name ``solve``.
Also values with a standard deviation: ``{value: 70.0, sigma: 3.0}``."""

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from typing import Any

from mbcdm_cad.design.describe import Node
from mbcdm_cad.design.yamltree import FieldPath, Tree, dotted
from mbcdm_cad.errors import InputError, Problem, shortened

LOW, HIGH = "min", "max"
NodeAt = Callable[[FieldPath], Node | None]


@dataclass(frozen=True)
class Range:
    """A number of the file between ``low`` and ``high``; ``aim``: ``min`` or ``max`` if the file asks for one."""

    field: str
    low: float
    high: float
    aim: str = ""

    def words(self) -> str:
        """``30 to 60``, or the aim alone."""
        return self.aim or f"{self.low:g} to {self.high:g}"

    def within(self, value: float) -> float:
        """The value, or the end of the range that is nearer to it."""
        return min(max(value, self.low), self.high)


def split_ranges(tree: Tree, file: str, node_at: NodeAt) -> tuple[Tree, tuple[Range, ...]]:
    """The tree without its ranges, and the ranges. Raises InputError with all that is wrong with them."""
    data, found, problems = copy.deepcopy(tree.data), list[Range](), list[Problem]()
    for path, value in _ranges(tree.data, (), node_at):
        node = node_at(path) or {}
        wrong = list(_wrong(path, value, node))
        for where, what, shown, limit, remedy in wrong:
            problems.append(Problem(file, tree.line_of(where), dotted(where), what, shown, limit, remedy))
        if not wrong:
            ends, aim = ({}, value) if isinstance(value, str) else (value, "")
            low, high = _bounds(node)
            found.append(Range(dotted(path), float(ends.get(LOW, low)), float(ends.get(HIGH, high)), aim))
        at: Any = data
        for part in path[:-1]:
            at = at[part]
        del at[path[-1]]
    if problems:
        raise InputError(problems)
    return Tree(data, tree.lines), tuple(found)


def refuse_ranges(tree: Tree, file: str, node_at: NodeAt) -> None:
    """Raise InputError if the file contains ranges, which only a search can use.

    Errors of a range itself are reported first, since a search refuses them too.
    """
    problems = [
        Problem(file, tree.line_of(where), dotted(where), what, shown, limit, remedy)
        for path, value in _ranges(tree.data, (), node_at)
        for where, what, shown, limit, remedy in _refused(path, value, node_at(path) or {}, file)
    ]
    if problems:
        raise InputError(problems)


def _refused(path: FieldPath, value: Any, node: Node, file: str) -> list[tuple[FieldPath, str, str, str, str]]:
    shown = value if isinstance(value, str) else ", ".join(f"{key} {end}" for key, end in value.items())
    remedy = f"run 'mbcdm solve {file} --apply FILE', which chooses it, or give a number"
    return list(_wrong(path, value, node)) or [
        (path, "a range, of which a design needs one value", shown, "a number", remedy)
    ]


def _ranges(node: Any, path: FieldPath, node_at: NodeAt) -> Iterator[tuple[FieldPath, Any]]:
    """(field, content) of every number that the file gives as a range; lists contain no ranges."""
    if not isinstance(node, dict):
        return
    for key, value in node.items():
        if isinstance(value, dict) or value in (LOW, HIGH):
            below = (*path, key)
            if _is_range(value) and (node_at(below) or {}).get("type") == "number":
                yield below, value
            else:
                yield from _ranges(value, below, node_at)


def _is_range(value: Any) -> bool:
    if isinstance(value, str):
        return value in (LOW, HIGH)
    return bool(value) and (LOW in value or HIGH in value)


def _bounds(node: Node) -> tuple[float, float]:
    low = next((node[key] for key in ("minimum", "exclusiveMinimum") if key in node), -inf)
    high = next((node[key] for key in ("maximum", "exclusiveMaximum") if key in node), inf)
    return float(low), float(high)


def _wrong(path: FieldPath, value: Any, node: Node) -> Iterator[tuple[FieldPath, str, str, str, str]]:
    """(field, what, value, limit, remedy) of everything wrong with the ends of one range."""
    ends = {} if isinstance(value, str) else value
    low, high = _bounds(node)
    unit = node.get("unit", "-")
    limit = f"{low:g} to {high:g}" + ("" if unit == "-" else f" {unit}")
    for key, end in ends.items():
        if key not in (LOW, HIGH):
            yield (*path, key), "unknown field of a range", "", "min and max", "remove it"
        elif isinstance(end, bool) or not isinstance(end, int | float):
            yield (*path, key), "not a number", shortened(end), limit, "write the bare number"
        elif not low <= end <= high:
            yield (*path, key), "out of bounds", f"{end:g}", limit, "choose a value within the limit"
    least, most = ends.get(LOW), ends.get(HIGH)
    if isinstance(least, int | float) and isinstance(most, int | float) and least > most:
        shown = f"min {least:g}, max {most:g}"
        yield path, "a range upside down", shown, "min up to max", f"write {{min: {most:g}, max: {least:g}}}"
    if -inf in (low, high) or inf in (low, high):
        missing = [key for key, end in ((LOW, low), (HIGH, high)) if abs(end) == inf and key not in ends]
        if missing:
            yield path, "a range without an end", "", "min and max", f"add {' and '.join(missing)}"


VALUE, SIGMA = "value", "sigma"
# A value must stay positive within three sigma, or a normal law does not describe it.
WIDEST_SHARE = 1 / 3


def split_sigmas(
    tree: Tree, file: str, may_carry_sigma: Callable[[FieldPath], bool]
) -> tuple[Tree, dict[FieldPath, float]]:
    """The tree with plain values, and the sigma of each field that gave one. Raises InputError with all problems."""
    splitter = _Splitter(tree, file, may_carry_sigma)
    data = splitter.plain(tree.data, ())
    if splitter.problems:
        raise InputError(sorted(splitter.problems, key=lambda problem: problem.line))
    return Tree(data, tree.lines), splitter.sigmas


class _Splitter:
    def __init__(self, tree: Tree, file: str, may_carry_sigma: Callable[[FieldPath], bool]) -> None:
        self.tree, self.file, self.may_carry_sigma = tree, file, may_carry_sigma
        self.sigmas: dict[FieldPath, float] = {}
        self.problems: list[Problem] = []

    def plain(self, node: Any, path: FieldPath) -> Any:
        if isinstance(node, list):
            return [self.plain(item, (*path, k)) for k, item in enumerate(node)]
        if not isinstance(node, dict):
            return node
        if SIGMA in node or VALUE in node:
            if self.may_carry_sigma(path):
                return self._measured(node, path)
            if set(node) == {VALUE, SIGMA}:
                self._problem(path, "carries a sigma, which nothing here would use", remedy="give the bare value")
                return node
        return {key: self.plain(item, (*path, key)) for key, item in node.items()}

    def _measured(self, node: dict[str, Any], path: FieldPath) -> Any:
        for key in node:
            if key not in (VALUE, SIGMA):
                self._problem((*path, key), "unknown field", limit="value and sigma", remedy="remove it")
        for key in (VALUE, SIGMA):
            if key not in node:
                self._problem(path, f"has no {key}", limit="value and sigma", remedy="write {value: ..., sigma: ...}")
        value, sigma = node.get(VALUE), node.get(SIGMA)
        if SIGMA in node and (isinstance(sigma, bool) or not isinstance(sigma, int | float)):
            where = (*path, SIGMA)
            self._problem(where, "not a number", shortened(sigma), remedy="write one standard deviation in the unit")
        elif isinstance(sigma, int | float) and isinstance(value, int | float) and not isinstance(value, bool):
            widest = WIDEST_SHARE * abs(value)
            if 0.0 <= sigma <= widest:
                self.sigmas[path] = float(sigma)
            else:
                limit = f"0 to {widest:.4g}, a third of the value"
                self._problem((*path, SIGMA), "out of bounds", f"{sigma:g}", limit, "give one standard deviation")
        return value

    def _problem(self, path: FieldPath, what: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        line = self.tree.line_of(path)
        self.problems.append(Problem(self.file, line, dotted(path), what, value, limit, remedy))
