"""Spring on the stud of a terminal, between lug and nut: a disc of a stack, or a coil; axis Z from z = 0."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.parts.part import BoughtPart, StandardPart
from mbcdm_cad.parts.shapes import one_solid, turned
from mbcdm_cad.parts.volume import Ring, rings_mm3

if TYPE_CHECKING:
    import cadquery as cq

# What grinding takes from the coils at both ends of a coil spring together (usual: half of each).
_CLOSED = 1.0
# Steps towards a disc's tilt; each leaves less than a tenth of the error.
_STEPS = 20


@dataclass(frozen=True)
class SeatWasher(StandardPart):
    """Washer on either side of the springs: over the slot of their lug, and under the nut; sizes in mm."""

    inside: float
    outside: float
    thickness: float

    def solid(self) -> cq.Solid:
        """A plain ring."""
        inner, outer, high = self.inside / 2, self.outside / 2, self.thickness
        return turned([(inner, 0.0), (outer, 0.0), (outer, high), (inner, high)], "washer")

    def in_rings(self) -> tuple[Ring, ...]:
        """A plain ring."""
        return ((self.outside / 2, self.inside / 2, 0.0, self.thickness),)

    def volume_mm3(self) -> float:
        """A plain ring."""
        return rings_mm3(self.in_rings())

    @property
    def designation(self) -> str:
        """Its sizes and that it is hard, as disc springs need it."""
        return f"Supporting washer {self.inside:g} x {self.outside:g} x {self.thickness:g}, hardened"


@dataclass(frozen=True)
class TerminalSpring(BoughtPart):
    """One spring, compressed to ``height`` mm; a disc rests on its outer edge."""

    entry: SpringSpec
    height: float

    def in_rings(self) -> tuple[Ring, ...]:
        """Its space between hole and outside."""
        return ((self.entry.outside_mm / 2, self.entry.inside_mm / 2, 0.0, self.height),)

    def solid(self) -> cq.Solid:
        """A cone of even thickness, or wire along its helix."""
        return self._disc() if self.entry.kind == "disc" else self._coil()

    def _disc(self) -> cq.Solid:
        inner, outer, strip = self.entry.inside_mm / 2, self.entry.outside_mm / 2, self.entry.strip_mm
        # A rectangle, long by ``along`` from rim to bore and tilted so that its highest corner is at the height.
        wide, tilt, along = outer - inner, 0.0, outer - inner
        for _ in range(_STEPS):
            along = (wide - strip * sin(tilt)) / cos(tilt)
            tilt += (self.height - along * sin(tilt) - strip * cos(tilt)) / wide
        return turned(
            [
                (outer - strip * sin(tilt), 0.0),
                (outer, strip * cos(tilt)),
                (inner + strip * sin(tilt), along * sin(tilt) + strip * cos(tilt)),
                (inner, along * sin(tilt)),
            ],
            "disc spring",
        )

    def _coil(self) -> cq.Solid:
        import cadquery as cq

        wire = self.entry.strip_mm
        coils = self.entry.solid_mm / wire - _CLOSED
        mean, rise = (self.entry.inside_mm + wire) / 2, self.height - wire
        helix = cq.Wire.makeHelix(rise / coils, rise, mean, cq.Vector(0, 0, wire / 2))
        profile = cq.Workplane("XZ").center(mean, wire / 2).circle(wire / 2)
        swept: Any = profile.sweep(cq.Workplane(helix), isFrenet=True).val()
        return one_solid(swept, "coil spring")
