"""Read and set fields of a design file's data by their dotted names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def value_at(data: Any, field: str) -> Any:
    """Value of a field, None if it is left out."""
    for part in field.split("."):
        if not isinstance(data, dict):
            return None
        data = data.get(part)
    return data


def put(data: dict[str, Any], field: str, value: Any) -> None:
    """Set a field; blocks above it that are missing are created."""
    *blocks, last = field.split(".")
    for block in blocks:
        if not isinstance(data.get(block), dict):
            data[block] = {}
        data = data[block]
    data[last] = value


def take_out(data: dict[str, Any], field: str) -> None:
    """Remove a field and each block above it that becomes empty; nothing happens if the field is left out."""
    *blocks, last = field.split(".")
    above: list[tuple[dict[str, Any], str]] = []
    for block in blocks:
        if not isinstance(data.get(block), dict):
            return
        above.append((data, block))
        data = data[block]
    data.pop(last, None)
    for outer, block in reversed(above):
        if not outer[block]:
            del outer[block]


def leaves(data: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every field that is not a block, with its value; an empty block gives nothing."""
    for key, value in data.items():
        name = f"{above}{key}"
        if isinstance(value, dict):
            yield from leaves(value, f"{name}.")
        else:
            yield name, value
