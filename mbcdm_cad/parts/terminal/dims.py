"""Dimensions of a cable's threaded terminal and of its place on the drum."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.2


@dataclass(frozen=True)
class TerminalDims:
    """A terminal by itself, mm; z = 0 where its cable leaves the drum's land before it is tensioned."""

    swage_start: float
    cable_end: float  # bottom of the swage's bore
    swage_end: float
    tip: float
    swage_radius: float
    flat: float  # from the axis to each of the swage's two flats
    stud_radius: float
    bore_radius: float


@dataclass(frozen=True)
class Tensioner:
    """Threaded terminal of one cable on the drum, drum centred.

    ``anchor_rad``: where the cable leaves its land, from +Z towards ``side``; distances s run from there along the
    tangent, n outward along the radius at that point. Swage and tip are in the place that a cable of nominal length
    gives them, bedded in and at its preload: ``drawn_in`` from slack, of a ``travel`` that the drum leaves them.
    """

    cable_name: str
    side: int
    radius_mm: float
    y_mm: float
    anchor_rad: float
    furthest_rad: float  # where it would be if the file did not state its angle
    swage_start: float
    cable_end: float  # bottom of the swage's bore
    swage_end: float
    lug_start: float
    lug_end: float
    nuts_end: float
    tip: float
    pocket_end: float  # behind the tip; beyond the sector if the wall there would be too thin
    pocket_top: float  # outward; open to the outside if the wall below a land's surface would be too thin
    cut_through: bool  # pockets go through the whole rim instead of leaving a thin floor
    travel: float
    drawn_in: float

    @property
    def slack_start(self) -> float:
        """Front of the swage before the cable is tensioned."""
        return self.swage_start - self.drawn_in

    @property
    def last_end(self) -> float:
        """Back of the swage with the terminal drawn in completely."""
        return self.swage_end + self.travel - self.drawn_in

    @property
    def last_tip(self) -> float:
        """End of the stud with the terminal drawn in completely."""
        return self.tip + self.travel - self.drawn_in

    def at(self, s: float, n: float = 0.0) -> tuple[float, float]:
        """(x, z) of the point ``s`` along and ``n`` outward, mm."""
        a = self.anchor_rad
        x = (self.radius_mm + n) * sin(a) + s * cos(a)
        return self.side * x, (self.radius_mm + n) * cos(a) - s * sin(a)
