"""Explain the values of a design's fields: rule, fields that it reads, driving need; for one field the whole chain.

The report, the page and the graph of dependencies show the same records.
"""

import copy
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.sized import SizedValue, SizingError
from mbcdm_cad.design.yamltree import leaves, take_out, value_at
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.loader import design_file
from mbcdm_cad.report.table import TextReport, filled

# Blocks whose entries have names chosen by the user.
_WITHOUT_RULES = ("catalogue", "as_built", "waivers")
# Least width of a reason beside its value, in characters.
_NARROWEST = 32


@dataclass(frozen=True)
class Explained:
    """One field: its value, and the record of the rule that gives it.

    ``given``: the file states it; ``record`` is then what the rule would give, None if there is no rule.
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


@dataclass(frozen=True)
class Explanation(TextReport):
    """Why fields of a design have their values: one ``field``, or all that have a rule where it is None."""

    loaded: LoadedDesign
    field: str | None
    entries: tuple[Explained, ...]

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm explain`` prints: a table of all fields, or the chain of one; no line longer than ``width``."""
        if self.field is None:
            return "\n".join(table_lines(self.loaded, width))
        return "\n".join(line for long in _chain(self.loaded, self.field) for line in filled(long, width))

    def to_dict(self) -> dict[str, Any] | list[dict[str, Any]]:
        """Plain data: one record for a field, else a list of records."""
        records = [entry.to_dict() for entry in self.entries]
        return records[0] if self.field else records


def explain(loaded: LoadedDesign, field: str | None = None) -> Explanation:
    """Explain one field by its dotted name, or all. Raises ``MbcdmError`` for a name that the design does not have."""
    entries = (explain_field(loaded, field),) if field else explain_all(loaded)
    return Explanation(loaded, field or None, entries)


def explain_all(loaded: LoadedDesign) -> tuple[Explained, ...]:
    """Every field that has a rule: filled fields in the order of the rules, then those that the file states."""
    filled = (Explained(value.field, value.value, False, value) for value in loaded.sized)
    return (*filled, *_stated(loaded))


def _stated(loaded: LoadedDesign) -> Iterator[Explained]:
    """The fields that the file states although a rule would fill them, in the order of the file."""
    data = loaded.given
    whole = _filled(loaded, data)
    sized = {value.field for value in loaded.sized}
    for field, _ in leaves({name: block for name, block in data.items() if name not in _WITHOUT_RULES}):
        record = None if field in sized else _without(loaded, whole, field)
        if record is not None:
            yield Explained(field, value_at(data, field), True, record)


def _filled(loaded: LoadedDesign, data: dict[str, Any]) -> dict[str, Any]:
    """The data with the fields filled that even a complete file may leave out, so that they are computed only once."""
    file = design_file(loaded.drive.configuration)
    try:
        return file.size(copy.deepcopy(data), {}).data if file.sizing else data
    except SizingError:
        return data


def _without(loaded: LoadedDesign, data: dict[str, Any], field: str) -> SizedValue | None:
    """The rule's value of a field that the file, read as ``data``, states; None if no rule gives one."""
    file = design_file(loaded.drive.configuration)
    if not file.sizing:
        return None
    freed = copy.deepcopy(data)
    take_out(freed, field)
    try:
        return file.size(freed, {}).of(field)
    except SizingError:
        return None


def fields_data(loaded: LoadedDesign) -> dict[str, Any]:
    """The report's data of the fields: a record for each field with a rule."""
    return {"fields": [entry.to_dict() for entry in explain_all(loaded)]}


def explain_field(loaded: LoadedDesign, field: str) -> Explained:
    """One field by its dotted name. Raises ``MbcdmError`` for a name that the design does not have."""
    record = next((value for value in loaded.sized if value.field == field), None)
    if record is not None:
        return Explained(field, record.value, False, record)
    whole = loaded.design.model_dump(mode="json")
    value, known = value_at(whole, field), [*(v.field for v in loaded.sized), *(name for name, _ in leaves(whole))]
    if value is None and field not in known:
        absent = _absent_block(loaded, field)
        raise MbcdmError(f"{loaded.path}: {field}: {absent or f'no such field; {did_you_mean(field, known)}'}")
    data = loaded.given
    given = value_at(data, field) is not None
    ruled = given and field.partition(".")[0] not in _WITHOUT_RULES
    return Explained(field, value, given, _without(loaded, data, field) if ruled else None)


def _absent_block(loaded: LoadedDesign, field: str) -> str:
    """What a block with this field that the design leaves out does, and how to add it; empty where there is none."""
    node_at, parts = design_file(loaded.drive.configuration).node_at, tuple(field.split("."))
    for k in range(1, len(parts) if node_at(parts) else 1):
        name, node = ".".join(parts[:k]), node_at(parts[:k])
        if node and value_at(loaded.given, name) is None:
            example = flow(node["examples"][0])
            return f"the design has no block {name}: {node['description']}; add it as {name}: {example}"
    return ""


def table_lines(loaded: LoadedDesign, width: int | None = None) -> Iterator[str]:
    """All fields that have a rule: name, value, driving need; for a stated value also what the rule gives.

    No line is longer than ``width``; on a narrow terminal the reasons stand below the values.
    """
    entries = explain_all(loaded)
    if not entries:
        yield f"{loaded.path}: every field is given, and {loaded.drive.configuration} has no sizing rules"
        return
    wide = max(len(entry.field) for entry in entries)
    value_wide = max(len(_short(entry.value)) for entry in entries)
    for entry in entries:
        assert entry.record is not None
        value = _short(entry.value)
        head, reason = f"{entry.field:<{wide}}  {value:<{value_wide}}  ", _reason(entry, entry.record)
        if width is None:
            yield head + reason
        elif len(head) + _NARROWEST <= width:
            first, *more = textwrap.wrap(reason, width - len(head), break_on_hyphens=False)
            yield head + first
            yield from (" " * len(head) + line for line in more)
        else:
            yield from filled(f"{entry.field}  {value}", width)
            yield from filled(f"    {reason}", width)


def _reason(entry: Explained, rule: SizedValue) -> str:
    rounding = f", rounded {rule.rounding}" if rule.rounding.startswith(("up", "down", "to ")) else ""
    reason = f"{rule.reason}{rounding}"
    return f"given; its rule gives {_short(rule.value)} ({reason})" if entry.given else reason


def _chain(loaded: LoadedDesign, field: str) -> Iterator[str]:
    """One field with its rule, and below it the fields that the rule reads, down to those that the file gives."""
    entry = explain_field(loaded, field)
    yield f"{field} = {_short(entry.value)}"
    if entry.given or entry.record is None:
        default = "  left out, and no rule fills it" if entry.value is None else "  left out; its default"
        yield "  given in the file" if entry.given else default
    if entry.given and entry.record is not None:
        yield f"  its rule gives {_short(entry.record.value)} ({entry.record.reason})"
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
