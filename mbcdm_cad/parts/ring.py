"""Plain round rings and pins: swaged stops, nuts, pins. Axis Z from z = 0."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart, Part, StandardPart
from mbcdm_cad.parts.shapes import cut, cylinder_z, hexagon_z, turned
from mbcdm_cad.parts.sheets.description import FitLine, Sheet
from mbcdm_cad.parts.sheets.turned import ALONG_Z
from mbcdm_cad.parts.threads import thread
from mbcdm_cad.parts.volume import Ring, ring_mm3, rings_mm3

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
