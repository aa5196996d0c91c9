"""Runs sizing rules over many designs at once: the same rules, on columns of values.

Designs that agree on every choice of part and every case of a rule are computed together. Where a rule finds that they
do not agree (:class:`~mbcdm_cad.sizing.arithmetic.Split`), it runs again on each group of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.fieldpath import dotted
from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.sizing.arithmetic import PerDesign, Split, per_design
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Found, Rule

Rows = NDArray[np.intp]


@dataclass(frozen=True)
class Alike:
    """Designs that agree on every choice: their rows, and their data with one column for each number that differs.

    ``refused`` says why no rule can fill a field of these designs; empty where all are filled.
    """

    rows: Rows
    known: KnownFields
    refused: str = ""


def fill_many(
    data: dict[str, Any],
    columns: Mapping[str, Sequence[Any]],
    rules: Sequence[Rule],
    known: Callable[[dict[str, Any]], KnownFields],
) -> Iterator[Alike]:
    """Fill the open fields of many designs: those of ``data`` with the fields of ``columns`` changed, row by row."""
    for rows, own in _by_names(columns):
        laid = known(_taken(data, slice(None)))
        for field, values in own.items():
            laid.put(field, values)
        todo = [(rows, laid, 0)]
        while todo:
            rows, given, start = todo.pop()
            try:
                with np.errstate(all="ignore"):
                    why, start = "", _fill(given, rules, start)
            except _Divided as divided:
                for part in (divided.holds, ~divided.holds):
                    todo.append((rows[part], known(_taken(given.data, part)), divided.rule))
                continue
            except SizingError as error:
                broken = error.broken[0]
                why = f"{dotted(broken.path)}: {broken.what} (value {broken.value})"
            except _NoValueError as error:
                why = str(error)
            yield Alike(rows, given, why)


class _Divided(Exception):  # noqa: N818 - no error: a rule whose designs go two ways
    def __init__(self, rule: int, holds: Any) -> None:
        super().__init__()
        self.rule, self.holds = rule, holds


class _NoValueError(Exception):
    """A rule that finds no value."""


def _fill(given: KnownFields, rules: Sequence[Rule], start: int) -> int:
    for k in range(start, len(rules)):
        rule = rules[k]
        try:
            if given.has(rule.field) or not rule.applies(given):
                continue
            found = rule.value(given)
        except Split as split:
            raise _Divided(k, split.holds) from None
        except (ValueError, ArithmeticError, IndexError) as error:
            raise _NoValueError(f"{rule.field}: no rule can fill it here ({error})") from None
        given.put(rule.field, found.value if isinstance(found, Found) else found)
    return len(rules)


def _by_names(columns: Mapping[str, Sequence[Any]]) -> Iterator[tuple[Rows, dict[str, Any]]]:
    """Rows that agree in every field that is a name, with their columns of numbers."""
    listed = {field: np.asarray(values) for field, values in columns.items()}
    names = {field: values for field, values in listed.items() if values.dtype.kind not in "iuf"}
    n = max((len(values) for values in listed.values()), default=0)
    groups: dict[tuple[str, ...], list[int]] = {}
    for row in range(n):
        groups.setdefault(tuple(str(values[row]) for values in names.values()), []).append(row)
    for key, members in groups.items():
        rows = np.array(members)
        numbers = {field: per_design(values[rows]) for field, values in listed.items() if field not in names}
        yield rows, numbers | dict(zip(names, key, strict=True))


def _taken(node: Any, part: Any) -> Any:
    """A copy of the data with only the rows ``part`` of each column."""
    if isinstance(node, dict):
        return {key: _taken(item, part) for key, item in node.items()}
    if isinstance(node, list):
        return [_taken(item, part) for item in node]
    return node[part] if isinstance(node, PerDesign) else node


def gathered(alike: Iterable[Alike], field: str, n: int) -> NDArray[Any]:
    """A field of all n designs: (n,) of numbers, names or blocks, (n, k) of lists of k numbers.

    NaN or None where a design is refused or has no such field.
    """
    parts = [(group.rows, group.known.peek(field)) for group in alike if not group.refused]
    first = next((value for _, value in parts if value is not None), None)
    if isinstance(first, list) and _is_number(first[0]):
        return np.stack([_spread([(rows, v and v[k]) for rows, v in parts], n) for k in range(len(first))], axis=1)
    if _is_number(first):
        return _spread(parts, n)
    found = np.full(n, None, dtype=object)
    for rows, value in parts:
        for row in rows:
            found[row] = value
    return found


def _spread(parts: Iterable[tuple[Rows, Any]], n: int) -> NDArray[Any]:
    found = np.full(n, np.nan)
    for rows, value in parts:
        found[rows] = np.nan if value is None else value
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, PerDesign | int | float) and not isinstance(value, bool)
