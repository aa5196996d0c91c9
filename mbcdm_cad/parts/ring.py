"""Plain round rings and pins (swaged stops, nuts, pins), axis Z from z = 0, and idlers.

An idler is a stepped pulley that cables pass, smooth, with a bearing in each end; two of its steps may be flanges.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.milled import Point2, cut, cylinder_z, hexagon_z, turned
from mbcdm_cad.parts.part import MadePart, Part, Ring, StandardPart, ring_mm3, rings_mm3
from mbcdm_cad.parts.sheet import FitLine, Label, Sheet, Table, mm3
from mbcdm_cad.parts.sheet_blocks import ALONG_Z, MAIN
from mbcdm_cad.parts.threads import thread

if TYPE_CHECKING:
    import cadquery as cq


_SMALLEST_ISO_NUT_MM = 1.6


@dataclass(frozen=True)
class Sleeve(MadePart):
    """Stop swaged on a cable's end; sizes in mm."""

    bore_radius: float
    radius: float
    length: float

    def solid(self) -> cq.Solid:
        """Sleeve: the stop swaged on a cable's end."""
        bore_radius, radius, length = self.bore_radius, self.radius, self.length
        return turned([(bore_radius, 0.0), (radius, 0.0), (radius, length), (bore_radius, length)], "sleeve")

    def in_rings(self) -> tuple[Ring, ...]:
        """Sleeve."""
        return ((self.radius, self.bore_radius, 0.0, self.length),)

    def volume_mm3(self) -> float:
        """Sleeve."""
        return rings_mm3(self.in_rings())

    def sheet(self, part: str) -> Sheet:
        """Stop, after it is swaged on the cable's end."""
        bore_radius, radius, length = self.bore_radius, self.radius, self.length
        return Sheet(
            part=part,
            title="Cable stop, swaged",
            views=(ALONG_Z.view(0.0, length, section=True),),
            dimensions=(
                ALONG_Z.diameter(bore_radius, 0.0, "left"),
                ALONG_Z.diameter(radius, length, "right", decimals=3),
                ALONG_Z.length(0.0, length, "below", (radius, radius), decimals=3),
            ),
            notes=("Sizes after swaging on the cable; the sleeve before swaging is that of the rope's maker.",),
        )


@dataclass(frozen=True)
class Nut(StandardPart):
    """Hexagon nut; sizes in mm, the thread a plain bore at its diameter."""

    cut_in_sections = False

    across_flats: float
    height: float
    thread: float

    def solid(self) -> cq.Solid:
        """Hexagon nut; the thread is a plain bore at the nominal diameter."""
        across_flats, height, thread = self.across_flats, self.height, self.thread
        return cut(hexagon_z(across_flats, 0.0, height), [cylinder_z(thread / 2, 0, 0, -1.0, height + 1.0)], "nut")

    def in_rings(self) -> tuple[Ring, ...]:
        """As round as a circle that is wider than its flats by a twentieth: of the hexagon's area."""
        return ((1.05 * self.across_flats / 2, self.thread / 2, 0.0, self.height),)

    def volume_mm3(self) -> float:
        """Hexagon nut."""
        across_flats, height, thread = self.across_flats, self.height, self.thread
        return sqrt(3) / 2 * across_flats**2 * height - ring_mm3(thread / 2, 0.0, height)

    @property
    def designation(self) -> str:
        """The standard's name: ISO 4032 from M1.6 on; smaller nuts are those of DIN 934."""
        standard = "ISO 4032" if self.thread >= _SMALLEST_ISO_NUT_MM else "DIN 934"
        return f"{standard} - {thread(self.thread).name}"


@dataclass(frozen=True)
class PlainPin(Part):
    """Pin with chamfered ends; sizes in mm."""

    cut_in_sections = False

    radius: float
    length: float

    def solid(self) -> cq.Solid:
        """Dowel pin with chamfered ends."""
        radius, length = self.radius, self.length
        c = min(0.3, radius / 3)
        return turned(
            [(0.0, 0.0), (radius - c, 0.0), (radius, c), (radius, length - c), (radius - c, length), (0.0, length)],
            "pin",
        )

    def in_rings(self) -> tuple[Ring, ...]:
        """Pin without its chamfers."""
        return ((self.radius, 0.0, 0.0, self.length),)

    def volume_mm3(self) -> float:
        """Pin with chamfered ends."""
        radius, length = self.radius, self.length
        c = min(0.3, radius / 3)
        return ring_mm3(radius, 0.0, length) - 2 * pi * c**2 * (radius - c / 3)


class Dowel(PlainPin, StandardPart):
    """Dowel of a length that the standard has."""

    @property
    def designation(self) -> str:
        """The standard's name."""
        return f"ISO 2338 - {2 * self.radius:g} {FITS['pin'].code} x {self.length:g}"


class Pin(PlainPin, MadePart):
    """Pin of a length of its own, cut from a ground rod or a longer dowel."""

    def sheet(self, part: str) -> Sheet:
        """Parallel pin."""
        radius, length = self.radius, self.length
        chamfer = min(0.3, radius / 3)
        fit = FITS["pin"].code
        return Sheet(
            part=part,
            title="Parallel pin",
            views=(ALONG_Z.view(0.0, length, section=False),),
            dimensions=(
                ALONG_Z.diameter(radius, chamfer, "left", fit=fit),
                ALONG_Z.length(0.0, length, "below", (radius - chamfer, radius - chamfer)),
                ALONG_Z.chamfer(chamfer, radius, length, -1.0, "above", count=2),
            ),
            fits=(FitLine(2 * radius, fit, "pin"),),
            notes=("May be cut from a longer parallel pin of ISO 2338 or ISO 8734.",),
        )


@dataclass(frozen=True)
class IdlerDims:
    """Idler pulley: smooth steps, a bearing in each end."""

    bottom_z: float
    top_z: float
    surface_radii: tuple[float, ...]
    walls_z: tuple[float, ...]
    seat_radius: float
    seat_depth: float
    shoulder_radius: float

    @property
    def flanged(self) -> bool:
        """Whether the steps at both ends are flanges."""
        return len(self.surface_radii) == 3 and self.surface_radii[1] < min(
            self.surface_radii[0], self.surface_radii[2]
        )

    @property
    def bearings_mm(self) -> tuple[float, float]:
        """Middles of the bearings along the axis."""
        return self.bottom_z + self.seat_depth / 2, self.top_z - self.seat_depth / 2


@dataclass(frozen=True)
class IdlerPulley(MadePart):
    """Idler pulley where it stands in the assembly, axis Z."""

    dims: IdlerDims
    title: str = "Guide pulley"

    def solid(self) -> cq.Solid:
        """Idler pulley where it stands in the assembly, axis Z."""
        dims = self.dims
        levels = [dims.bottom_z, *dims.walls_z, dims.top_z]
        outside: list[Point2] = []
        for radius, low, high in zip(dims.surface_radii, levels[:-1], levels[1:], strict=True):
            outside += [(radius, low), (radius, high)]
        inside: list[Point2] = [
            (dims.seat_radius, dims.top_z),
            (dims.seat_radius, dims.top_z - dims.seat_depth),
            (dims.shoulder_radius, dims.top_z - dims.seat_depth),
            (dims.shoulder_radius, dims.bottom_z + dims.seat_depth),
            (dims.seat_radius, dims.bottom_z + dims.seat_depth),
            (dims.seat_radius, dims.bottom_z),
        ]
        return turned(outside + inside, "idler pulley")

    def in_rings(self) -> tuple[Ring, ...]:
        """Its steps less seats and bore."""
        d = self.dims
        levels = [d.bottom_z, *d.walls_z, d.top_z]
        steps = zip(d.surface_radii, levels[:-1], levels[1:], strict=True)
        low, high = d.bottom_z + d.seat_depth, d.top_z - d.seat_depth
        return (
            *((r, 0.0, a, b) for r, a, b in steps),
            (0.0, d.seat_radius, d.bottom_z, low),
            (0.0, d.shoulder_radius, low, high),
            (0.0, d.seat_radius, high, d.top_z),
        )

    def volume_mm3(self) -> float:
        """Idler pulley: its steps less seats and bore."""
        return rings_mm3(self.in_rings())

    def sheet(self, part: str) -> Sheet:
        """Section along the axis; the steps as a table from end A, the lower end."""
        dims = self.dims
        low, high = dims.bottom_z, dims.top_z
        levels = (low, *dims.walls_z, high)
        seat, land = FITS["idler_seat"].code, FITS["land"].code
        largest = max(dims.surface_radii)
        dimensions = (
            ALONG_Z.diameter(dims.seat_radius, low, "left", fit=seat, count=2, datum="D"),
            ALONG_Z.diameter(dims.shoulder_radius, high - dims.seat_depth, "right"),
            ALONG_Z.length(low, low + dims.seat_depth, "below", (dims.surface_radii[0], dims.seat_radius), count=2),
            ALONG_Z.length(low, high, "below", (dims.surface_radii[0], dims.surface_radii[-1]), decimals=3),
        )
        labels = tuple(
            Label(MAIN, ALONG_Z.point(radius, (a + b) / 2), str(n), leader=True)
            for n, (radius, (a, b)) in enumerate(zip(dims.surface_radii, pairwise(levels), strict=True), 1)
        )
        rows = tuple(
            (str(n), mm3(2 * radius), land, "end" if end == high else mm3(end - low))
            for n, (radius, end) in enumerate(zip(dims.surface_radii, levels[1:], strict=True), 1)
        )
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=True),),
            dimensions=dimensions,
            labels=(*labels, Label(MAIN, ALONG_Z.point(-(dims.seat_radius + largest) / 2, low), "A", leader=True)),
            tables=(Table("Steps, ends measured from face A", ("Step", "%%c", "Fit", "ends at"), rows),),
            fits=(
                FitLine(2 * dims.seat_radius, seat, "bearing seats"),
                *(FitLine(round(2 * r, 6), land, f"step {n}") for n, r in enumerate(dims.surface_radii, 1)),
            ),
            tolerances=(
                ALONG_Z.run_out(
                    tuple((r, (a + b) / 2) for r, (a, b) in zip(dims.surface_radii, pairwise(levels), strict=True)),
                    0.01,
                    "D",
                ),
                ALONG_Z.square(
                    (dims.shoulder_radius, dims.seat_radius), (low + dims.seat_depth, high - dims.seat_depth), 0.01, "D"
                ),
            ),
            notes=(
                "Steps: Ra 0.8; corner between land and flange at most R0.2."
                if dims.flanged
                else "Steps: Ra 0.8, no flanges; corner between two steps at most R0.05.",
            ),
        )
