"""Sheet of the whole drive: three views, the envelope, a number beside each part, the list of parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbcdm_cad.parts.item import Item
from mbcdm_cad.parts.sheets.description import Label, Linear, Sheet, Table, Vector, View, X, Y, Z, minus

Box = tuple[Vector, Vector]


def _placed_box(item: Item, box: Box) -> Box:
    """Box of an item at its place, from the corners of its part's own box."""
    low, high = box
    corners = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    points = item.location.apply(corners)
    return _vector(points.min(axis=0)), _vector(points.max(axis=0))


def _vector(values: Sequence[float]) -> Vector:
    x, y, z = (float(v) for v in values)
    return x, y, z


def assembly_sheet(
    name: str, items: Sequence[Item], boxes: Mapping[str, Box], envelope: Box, names: Mapping[str, str]
) -> Sheet:
    """Views from the front, the left and above. ``boxes``: each part's box in its own frame; ``envelope``: that of the
    whole; ``names``: what to order, by part, where a standard says it.

    Parts are numbered in the order of the bill; a number points to the part's first instance."""
    parts: dict[str, list[Item]] = {}
    for item in items:
        parts.setdefault(item.part, []).append(item)
    (left, back, low), (right, front, high) = envelope
    rows, labels = [], []
    for number, (part, instances) in enumerate(parts.items(), 1):
        first = instances[0]
        kind = first.material.name if first.kind == "made" else names.get(part, "bought")
        rows.append((str(number), part, str(len(instances)), kind))
        a, b = _placed_box(first, boxes[part])
        middle = _vector([(p + q) / 2 for p, q in zip(a, b, strict=True)])
        labels.append(Label("front", middle, str(number), clear_mm=3.0, leader=True))
    middle_x = (left + right) / 2
    return Sheet(
        part=name,
        title="Assembly",
        paper="A2",
        views=(
            View("front", minus(X), Z, axes=(((middle_x, 0.0, low), (middle_x, 0.0, high)),)),
            View("left", Y, Z, column=1),
            View("top", minus(X), minus(Y), row=-1),
        ),
        dimensions=(
            Linear("front", (right, front, low), (left, front, low), right - left, "below"),
            Linear("front", (right, front, low), (right, front, high), high - low, "left"),
            Linear("left", (middle_x, back, low), (middle_x, front, low), front - back, "below"),
        ),
        labels=tuple(labels),
        tables=(Table("Parts", ("No.", "Part", "Pieces", "Material or standard"), tuple(rows)),),
        notes=(
            "Drum centred. Cables are not drawn; their lengths stand in the report.",
            "Order of assembly: see the report.",
        ),
    )
