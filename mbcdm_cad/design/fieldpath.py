"""The place of a field in a file: its path, its form in messages, its line."""

from __future__ import annotations

from collections.abc import Mapping

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
