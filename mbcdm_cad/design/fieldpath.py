"""The place of a field in a file: its path, its form in messages, its line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

FieldPath = tuple[str | int, ...]


def dotted(path: FieldPath) -> str:
    """``('cables', 0, 'step')`` as ``cables[0].step``, the form used in messages."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if len(part) <= 40 else part[:37] + "..."
            text += ("." if text else "") + (name if name.isprintable() else repr(name))
    return text


def nearest_line(lines: Mapping[FieldPath, int], path: FieldPath) -> int:
    """Line of the field, or of the nearest block above it in the file."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


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
