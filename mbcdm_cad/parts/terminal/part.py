"""Threaded terminal of a cable: swage with a bore and two flats, stud behind it. Axis Z, the cable comes from -Z."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import cut, turned
from mbcdm_cad.parts.sheets.description import Linear, Sheet, View, X, Y, minus, mm
from mbcdm_cad.parts.sheets.turned import ALONG_Z
from mbcdm_cad.parts.threads import thread
from mbcdm_cad.parts.volume import Ring, rings_mm3, segment_mm2

if TYPE_CHECKING:
    import cadquery as cq


# The end after which the sleeve is drawn; inside the sleeve of another one there may be a socket or cross threads.
SWAGED = "swaged"
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
    spring: float  # height between lug and nut at the preload, of springs; 0 without
    tip: float
    pocket_end: float  # behind the tip; beyond the sector if the wall there would be too thin
    pocket_top: float  # outward; open to the outside if the wall below a land's surface would be too thin
    cut_through: bool  # pockets go through the whole rim instead of leaving a thin floor
    travel: float
    drawn_in: float
    front: bool = False  # pockets are open to the rim's outer face, not to the inner one

    def deeper(self, mm: float) -> float:
        """The y of a point ``mm`` from the terminal's axis, away from the face to which its pockets are open."""
        return self.y_mm - mm if self.front else self.y_mm + mm

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


_END = "end"


@dataclass(frozen=True)
class ThreadedTerminal(MadePart):
    """Terminal along Z, the cable from -Z; ``end``: how the cable ends in its sleeve, an entry of the catalogue."""

    dims: TerminalDims
    end: str = SWAGED

    def solid(self) -> cq.Solid:
        """Its flats at +-y: one slides along the wall of its pocket and keeps the rope from twisting."""
        import cadquery as cq

        dims = self.dims
        c = CHAMFER_MM
        body = turned(
            [
                (0.0, dims.cable_end),
                (dims.bore_radius, dims.cable_end),
                (dims.bore_radius, dims.swage_start),
                (dims.swage_radius - c, dims.swage_start),
                (dims.swage_radius, dims.swage_start + c),
                (dims.swage_radius, dims.swage_end),
                (dims.stud_radius, dims.swage_end),
                (dims.stud_radius, dims.tip - c),
                (dims.stud_radius - c, dims.tip),
                (0.0, dims.tip),
            ],
            "terminal",
        )
        length = dims.swage_end - dims.swage_start
        sides = [
            cq.Solid.makeBox(
                2.0 * dims.swage_radius, dims.swage_radius, length, cq.Vector(-dims.swage_radius, y, dims.swage_start)
            )
            for y in (dims.flat, -dims.flat - dims.swage_radius)
        ]
        return cut(body, sides, "terminal")

    def in_rings(self) -> tuple[Ring, ...]:
        """Swage with its bore, without its flats, and the stud."""
        d = self.dims
        swage, bore = (
            (d.swage_radius, 0.0, d.swage_start, d.swage_end),
            (0.0, d.bore_radius, d.swage_start, d.cable_end),
        )
        return (swage, bore, (d.stud_radius, 0.0, d.swage_end, d.tip))

    def volume_mm3(self) -> float:
        """Swage with its bore and flats, and the stud."""
        d = self.dims
        return rings_mm3(self.in_rings()) - 2 * segment_mm2(d.swage_radius, d.flat) * (d.swage_end - d.swage_start)

    def sheet(self, part: str) -> Sheet:
        """Section along the axis, and the end with the flats."""
        dims = self.dims
        c = CHAMFER_MM
        screw = thread(2 * dims.stud_radius)
        return Sheet(
            part=part,
            title="Cable terminal",
            views=(
                ALONG_Z.view(dims.swage_start, dims.tip, section=True),
                View(_END, minus(X), Y, column=1, title="From the cable"),
            ),
            dimensions=(
                ALONG_Z.diameter(dims.bore_radius, dims.swage_start, "left"),
                ALONG_Z.diameter(dims.swage_radius, dims.swage_start + c, "left"),
                ALONG_Z.thread(dims.stud_radius, dims.tip - c, "right", "-6g"),
                ALONG_Z.length(dims.swage_start, dims.cable_end, "above", (dims.swage_radius - c, dims.bore_radius)),
                ALONG_Z.length(dims.swage_start, dims.swage_end, "below", (dims.swage_radius - c, dims.swage_radius)),
                ALONG_Z.length(dims.swage_start, dims.tip, "below", (dims.swage_radius - c, dims.stud_radius - c)),
                ALONG_Z.chamfer(c, dims.stud_radius, dims.tip, -1.0, "above", count=2),
                Linear(
                    _END,
                    (0.0, -dims.flat, dims.swage_start),
                    (0.0, dims.flat, dims.swage_start),
                    2 * dims.flat,
                    "right",
                    suffix=" over 2 flats",
                ),
            ),
            notes=(
                f"{screw.name}: pitch {mm(screw.pitch_mm)}; rolled, full length of the stud.",
                "Swage sizes after swaging on the cable."
                if self.end == SWAGED
                else f"Sleeve as an outline: its inside is made for a {self.end} end of the cable.",
            ),
        )
