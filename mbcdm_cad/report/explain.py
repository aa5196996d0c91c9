"""Why a design's fields have the values they have: rule, what it rests on, what drives it; for one field the chain."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.configurations.loader import load_tree
from mbcdm_cad.design import yamltree
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.sized import SizedValue
from mbcdm_cad.errors import InputError, MbcdmError, did_you_mean


@dataclass(frozen=True)
class Explained:
    """One field: its value, and the record of the rule that gives it.

    ``given``: the file states it; ``record`` is then what the rule would give, None where there is no rule.
    """

    field: str
    value: Any
    given: bool
    record: SizedValue | None

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        rule = self.record
        return {
            "field": self.field,
            "value": self.value,
            "given": self.given,
            "rule": rule.text if rule else None,
            "rule_value": rule.value if rule else None,
            "driver": rule.driver if rule else None,
            "rests_on": dict(rule.rests_on) if rule else {},
            "rounding": rule.rounding if rule else None,
        }


def explain_all(loaded: LoadedDesign) -> tuple[Explained, ...]:
    """Every field that a rule filled, in the order of the rules."""
    return tuple(Explained(value.field, value.value, False, value) for value in loaded.sized)


def explain_field(loaded: LoadedDesign, field: str) -> Explained:
    """One field by its dotted name. Raises ``MbcdmError`` for a name that the design has not."""
    record = next((value for value in loaded.sized if value.field == field), None)
    if record is not None:
        return Explained(field, record.value, False, record)
    value: Any = loaded.design.model_dump(mode="json")
    for part in field.split("."):
        if not isinstance(value, dict) or part not in value:
            known = [*(sized.field for sized in loaded.sized), *_fields(loaded.design.model_dump(mode="json"))]
            raise MbcdmError(f"{loaded.path}: {field}: no such field; {did_you_mean(field, known)}")
        value = value[part]
    return Explained(field, value, True, without(loaded, field))


def without(loaded: LoadedDesign, field: str) -> SizedValue | None:
    """What the rule gives where the file states the field; None where none does."""
    tree = yamltree.parse(loaded.text, str(loaded.path))
    data = copy.deepcopy(tree.data)
    *blocks, last = field.split(".")
    at = data
    for block in blocks:
        at = at.get(block) if isinstance(at, dict) else None
    if not isinstance(at, dict) or last not in at:
        return None
    del at[last]
    try:
        freed = load_tree(yamltree.Tree(data, tree.lines), loaded.text, loaded.path)
    except InputError:
        return None
    return next((value for value in freed.sized if value.field == field), None)


def _fields(data: dict[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in data.items():
        if isinstance(value, dict):
            yield from _fields(value, f"{prefix}{key}.")
        else:
            yield prefix + key


def table_lines(loaded: LoadedDesign) -> Iterator[str]:
    """All sized fields: name, value, what drives it."""
    rows = [(entry.field, _short(entry.value), entry.record) for entry in explain_all(loaded)]
    if not rows:
        yield f"{loaded.path}: every field is given; leave fields out to have them follow from rules"
        return
    wide = max(len(field) for field, _, _ in rows)
    value_wide = max(len(value) for _, value, _ in rows)
    for field, value, record in rows:
        assert record is not None
        rounding = f", rounded {record.rounding}" if record.rounding.startswith(("up", "down", "to ")) else ""
        yield f"{field:<{wide}}  {value:<{value_wide}}  {record.driver}: {record.text}{rounding}"


def chain_lines(loaded: LoadedDesign, field: str) -> Iterator[str]:
    """One field with its rule, and below it what the rule rests on, down to what the file gives."""
    entry = explain_field(loaded, field)
    yield f"{field} = {_short(entry.value)}"
    if entry.given:
        yield "  given in the file"
        if entry.record is None:
            return
        yield f"  its rule gives {_short(entry.record.value)} ({entry.record.driver}: {entry.record.text})"
    sized = {value.field: value for value in loaded.sized}
    if entry.record is not None:
        yield from _below(entry.record, sized, 1, set())


def _below(record: SizedValue, sized: dict[str, SizedValue], depth: int, shown: set[str]) -> Iterator[str]:
    pad = "  " * depth
    rounding = f"; rounded {record.rounding}" if record.rounding.startswith(("up", "down", "to ")) else ""
    yield f"{pad}rule: {record.text}"
    yield f"{pad}set by: {record.driver}{rounding}"
    for name, value in record.rests_on.items():
        below = sized.get(name)
        note = "" if below else "  (given)"
        again = name in shown
        yield f"{pad}- {name} = {_short(value)}{note}{'  (see above)' if below and again else ''}"
        shown.add(name)
        if below is not None and not again:
            yield from _below(below, sized, depth + 2, shown)


def _short(value: Any) -> str:
    text = flow(value)
    return text if len(text) <= 44 else text[:41] + "..."
