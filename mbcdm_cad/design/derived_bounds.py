"""A value that a rule gives and that its bounds do not allow: name the requirement that asks for it, not the value.

The user wrote no such value. What can be changed is a requirement that the rule rests on; a value of it that works is
found by trying and stands in the message.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import exp, log
from typing import Any

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.fieldpath import put, value_at
from mbcdm_cad.design.sized import Sizing
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import Problem

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
