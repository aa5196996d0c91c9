"""Holes of a part: their table, their positions, their labels in the views, their fits."""

from __future__ import annotations

from collections.abc import Sequence

from mbcdm_cad.parts.sheets.description import POSITION, Holes, Label, Table, Vector, mm

THROUGH = "through"
# Place of a hole for a screw or a key, plus or minus: half the play of a screw in its hole (ISO 273, fine).
FREE_POSITION_MM = 0.1
COLUMNS = ("Hole", "No.", "%%c", "Thread", "Depth", "Fit", "Counterbore", "From")


def hole_table(groups: Sequence[Holes], title: str = "Holes") -> Table:
    """One line for each group of equal holes."""
    return Table(title, COLUMNS, tuple(group.row() for group in groups))


def position_table(groups: Sequence[Holes], axes: tuple[int, int], title: str) -> Table:
    """One line for each hole; ``axes`` are the two coordinates (0 x, 1 y, 2 z) shown, both within the last column."""
    heads = (*("XYZ"[a] for a in axes), "%%p")
    rows = tuple(
        (name, *(mm(place[a], 3) for a in axes), _tolerance(group, place, axes))
        for group in groups
        for name, place in zip(group.names, group.places, strict=True)
    )
    return Table(title, ("Hole", *heads), rows)


def _tolerance(group: Holes, place: Vector, axes: tuple[int, int]) -> str:
    """Tolerance of both coordinates: close for a hole with a fit, none for the hole from which others are measured."""
    fitted = group.fit or (group.counterbore is not None and group.counterbore[2])
    if fitted and not any(place[a] for a in axes):
        return ""
    return POSITION if fitted else mm(FREE_POSITION_MM)


def hole_labels(groups: Sequence[Holes], view: str) -> tuple[Label, ...]:
    """The name of each hole beside it."""
    return tuple(
        Label(view, place, name, clear_mm=group.reach)
        for group in groups
        for name, place in zip(group.names, group.places, strict=True)
    )


def hole_marks(
    groups: Sequence[Holes], across: Vector, up: Vector, z: float | None = None
) -> tuple[tuple[Vector, Vector], ...]:
    """Centre lines of holes seen from their end: at the height ``z``, or each at that of its hole."""
    marks = []
    for group in groups:
        reach = group.reach + 0.8
        for x, y, own in group.places:
            place = (x, y, own if z is None else z)
            for way in (across, up):
                low, high = (tuple(p + s * reach * q for p, q in zip(place, way, strict=True)) for s in (-1, 1))
                marks.append(((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    return tuple(marks)
