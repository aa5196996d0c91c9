"""Holes of a part: their table, their positions, their labels in the views, their fits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.parts.sheets.description import POSITION, FitLine, Label, Table, Vector
from mbcdm_cad.parts.sheets.words import mm
from mbcdm_cad.parts.threads import thread

THROUGH = "through"
# Place of a hole for a screw or a key, plus or minus: half the play of a screw in its hole (ISO 273, fine).
FREE_POSITION_MM = 0.1
COLUMNS = ("Hole", "No.", "%%c", "Thread", "Depth", "Fit", "Counterbore", "From")


@dataclass(frozen=True)
class Holes:
    """Equal holes, drilled from one face. ``depth`` is in mm or ``THROUGH``.

    ``diameter`` is the nominal one; of a thread its major diameter, the table then says the tap drill; with ``insert``
    that of the hole that the insert is set into.
    ``counterbore``: diameter, depth, fit, at the face ``from_face``. ``places``: where they start, in the part's
    coordinates; ``what`` says what they are for.
    """

    letter: str
    diameter: float
    depth: float | str
    places: tuple[Vector, ...]
    from_face: str
    what: str
    threaded: bool = False
    insert: InsertSpec | None = None
    fit: str = ""
    counterbore: tuple[float, float, str] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """A for a single hole, A1, A2 ... for several."""
        if len(self.places) == 1:
            return (self.letter,)
        return tuple(f"{self.letter}{n}" for n in range(1, len(self.places) + 1))

    def row(self) -> tuple[str, ...]:
        """The line of the table of holes."""
        drill, name = self.diameter, ""
        if self.threaded:
            screw = thread(self.diameter)
            drill, name = screw.tap_drill_mm, screw.name
            if not isinstance(self.depth, str):
                name += f" x {mm(screw.full_thread_mm(self.depth), 1)}"
        elif self.insert is not None:
            name = f"insert {self.insert.name}"
        deeper = ""
        if self.counterbore is not None:
            diameter, depth, fit = self.counterbore
            deeper = f"%%c{mm(diameter)}{' ' + fit if fit else ''} x {mm(depth)}"
        depth_text = self.depth if isinstance(self.depth, str) else mm(self.depth)
        return (self.letter, str(len(self.places)), mm(drill, 3), name, depth_text, self.fit, deeper, self.from_face)

    def data(self) -> dict[str, Any]:
        """The same as plain data, with the places; lengths in mm."""
        screw = thread(self.diameter) if self.threaded else None
        bore = self.counterbore
        return {
            "hole": self.letter,
            "count": len(self.places),
            "diameter_mm": self.diameter,
            "thread": screw.name if screw else None,
            "insert": self.insert.name if self.insert else None,
            "tap_drill_mm": screw.tap_drill_mm if screw else None,
            "depth": self.depth,
            "fit": self.fit or None,
            "counterbore": None if bore is None else {"diameter_mm": bore[0], "depth_mm": bore[1], "fit": bore[2]},
            "from": self.from_face,
            "for": self.what,
            "places_mm": [list(place) for place in self.places],
        }

    def fit_lines(self) -> tuple[FitLine, ...]:
        """Its toleranced diameters."""
        lines = []
        if self.fit:
            lines.append(FitLine(round(self.diameter, 6), self.fit, f"{self.letter}, {self.what}"))
        if self.counterbore is not None and self.counterbore[2]:
            lines.append(FitLine(round(self.counterbore[0], 6), self.counterbore[2], f"{self.letter}, {self.what}"))
        return tuple(lines)

    @property
    def reach(self) -> float:
        """Radius of the hole as drawn, mm."""
        return max(self.diameter, self.counterbore[0] if self.counterbore else 0.0) / 2


def outside_bore(places: tuple[Vector, ...], reach_mm: float, bore_mm: float) -> tuple[Vector, ...]:
    """``places``, or none if the bore of radius ``bore_mm`` includes holes that reach ``reach_mm`` from its axis."""
    return places if reach_mm > bore_mm else ()


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
