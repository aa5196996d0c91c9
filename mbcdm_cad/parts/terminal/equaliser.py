"""Equaliser of two terminals side by side: a rocker on a dowel on a bridge, between the nuts and the lugs.

In section through both studs, the cables below; z runs along the studs from the lugs, y across them:

      nut                   nut
     _===_                 _===_      crowned ends
    | | | |_______________| | | |
    | | | |    rocker     | | | |
     ^^^^^^^^^^^^\\_O_/^^^^^^^^^^^     dowel, bonded to the rocker
    | | | |    bridge     | | | |
    |_|_|_|---------------|_|_|_|     feet
     lug                   lug

The bridge puts each cable's pull on its own lug, as a nut alone would. The rocker turns until both pulls are equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import asin, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.design.bought import TensionerSpec
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import cut, cylinder, cylinder_z, one_solid
from mbcdm_cad.parts.sheets.description import Holes, Linear, Radius, Sheet, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.volume import ring_mm3, segment_mm2

if TYPE_CHECKING:
    import cadquery as cq

# Dowels of ISO 2338: radius, and least length of those that the bars take flush with their sides.
_DOWELS = ((0.5, 4.0), (0.75, 4.0), (1.0, 6.0), (1.25, 6.0), (1.5, 8.0), (2.0, 8.0), (2.5, 10.0), (3.0, 12.0))
_LENGTHS = (4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0)
# A dowel is at least this share of a bar's thickness, so that the groove leaves most of it; and how far its axis lies
# over the bar's face, in radii: the groove holds it, and the bars may tip until they touch.
DOWEL_SHARE, OVER = 0.5, 0.3
# Radius of the crowned ends over the nut's width across flats (estimate: a check says whether the nut dents them).
CROWN = 2.5
# How far the feet stand out at least, mm.
LEAST_FOOT_MM = 0.2
# Give of a bar over that of the beam that it is: the groove, and the places where dowel, nuts and lugs press (solid
# elements of drawn bars give 1.23 to 1.24).
LOCAL_GIVE = 1.25
# Friction of the dowel in its groove (steel on steel, greased: estimate), and how far the groove is from the middle
# between both crests, to which the sheet holds it.
FRICTION, MIDDLE_MM = 0.15, 0.05
_FRONT, _TOP = "front", "top"


def _sag_mm(radius: float, reach: float) -> float:
    """Height that a crown loses at ``reach`` from its crest."""
    return radius - sqrt(radius**2 - reach**2)


@dataclass(frozen=True)
class EqualiserDims:
    """Rocker and bridge of the terminals of one side, mm."""

    arm: float  # from the dowel to each stud
    reach: float  # of the bars beyond the stud
    width: float
    bar: float
    foot: float  # how far feet and crowned ends stand out from the bar
    crown_radius: float
    dowel_radius: float
    bridge_hole: float  # diameters
    rocker_hole: float

    @property
    def gap(self) -> float:
        """Between both bars."""
        return 2 * OVER * self.dowel_radius

    @property
    def height(self) -> float:
        """From lug to nut."""
        return 2 * (self.bar + self.foot) + self.gap

    @property
    def net(self) -> float:
        """Thickness of a bar under its groove."""
        return self.bar - (1.0 - OVER) * self.dowel_radius

    @property
    def tilt_rad(self) -> float:
        """Angle from level at which the bars touch."""
        return self.gap / (self.arm + self.reach)

    @property
    def stroke(self) -> float:
        """How much further one end of a cable may move than the other, to each side of level."""
        return 2 * self.arm * self.tilt_rad

    def unequal(self, moved: float) -> float:
        """Half the difference of both pulls over their mean where one end is ``moved`` mm further than the other.

        Friction of the dowel, unequal arms, and the way of the nuts on the crowned ends, which lengthens one arm. The
        play of the studs does not count: each nut rests on the crest of its end.
        """
        return (FRICTION * self.dowel_radius + MIDDLE_MM + self.crown_radius * moved / (2 * self.arm)) / self.arm

    def bending_MPa(self, pull_N: float) -> float:
        """Stress under the dowel, at which both pulls come together: M = F a, on the bar less its groove.

        That of a beam: solid elements give 0.76 of it on the face away from the dowel.
        """
        return 6 * pull_N * self.arm / (self.width * self.net**2)

    def give_mm_N(self, youngs_modulus_MPa: float) -> float:
        """How far a nut sinks for each newton at both, by bending and shear of both bars, ``LOCAL_GIVE`` times."""
        second, shear = self.width * self.bar**3 / 12, youngs_modulus_MPa / 2.6 * self.width * self.bar / 1.2
        return 2 * LOCAL_GIVE * (self.arm**3 / (3 * youngs_modulus_MPa * second) + self.arm / shear)


def equaliser(t: TensionerSpec, arm_mm: float, bar_mm: float) -> EqualiserDims:
    """Bars of thickness ``bar_mm`` whose studs are ``arm_mm`` to both sides of the dowel."""
    flats, reach = t.nut_across_flats_mm, t.nut_across_flats_mm / sqrt(3.0)
    radius, least = next((d for d in _DOWELS if 2 * d[0] >= DOWEL_SHARE * bar_mm), _DOWELS[-1])
    crown = CROWN * flats
    bridge_hole = t.clearance_mm
    foot = max(LEAST_FOOT_MM, _sag_mm(crown, reach))
    tilt = 2 * OVER * radius / (arm_mm + reach)
    return EqualiserDims(
        arm=arm_mm,
        reach=reach,
        width=next((w for w in _LENGTHS if w >= max(flats, least)), _LENGTHS[-1]),
        bar=bar_mm,
        foot=round(foot + 0.05, 1),
        crown_radius=crown,
        dowel_radius=radius,
        bridge_hole=bridge_hole,
        # The stud stands upright in a bar that tips.
        rocker_hole=round(bridge_hole + tilt * bar_mm + 0.05, 1),
    )


@dataclass(frozen=True)
class EqualiserBar(MadePart):
    """A bar across both studs, feet or crowned ends at z = 0, the groove in the middle of its other face."""

    dims: EqualiserDims
    rocker: bool

    @property
    def hole(self) -> float:
        """Diameter of the studs' holes."""
        return self.dims.rocker_hole if self.rocker else self.dims.bridge_hole

    @property
    def top(self) -> float:
        """Face with the groove."""
        return self.dims.bar + self.dims.foot

    @property
    def _sag(self) -> float:
        """Height that a crowned end has lost at its edge."""
        return _sag_mm(self.dims.crown_radius, self.dims.reach) if self.rocker else 0.0

    def solid(self) -> cq.Solid:
        """A prism along X less groove and holes."""
        import cadquery as cq

        d, x = self.dims, -self.dims.width / 2

        def at(y: float, z: float) -> cq.Vector:
            return cq.Vector(x, y, z)

        def end(y: float) -> list[cq.Edge]:
            """The end at ``y`` from its low y to its high y, with the steps to the bar's face."""
            first, last = at(y - d.reach, self._sag), at(y + d.reach, self._sag)
            if not self.rocker:
                return [cq.Edge.makeLine(first, last)]
            return [cq.Edge.makeThreePointArc(first, at(y, 0.0), last)]

        def line(*points: cq.Vector) -> list[cq.Edge]:
            return [cq.Edge.makeLine(a, b) for a, b in pairwise(points)]

        inner, outer = d.arm - d.reach, d.arm + d.reach
        edges = [
            *end(-d.arm),
            *line(at(-inner, self._sag), at(-inner, d.foot), at(inner, d.foot), at(inner, self._sag)),
            *end(d.arm),
            *line(at(outer, self._sag), at(outer, self.top), at(-outer, self.top), at(-outer, self._sag)),
        ]
        body = one_solid(
            cq.Solid.extrudeLinear(cq.Wire.assembleEdges(edges), [], cq.Vector(d.width, 0, 0)), "equaliser bar"
        )
        groove = cylinder(
            d.dowel_radius, (x - 1.0, 0.0, self.top + OVER * d.dowel_radius), (1.0, 0.0, 0.0), d.width + 2.0
        )
        holes = [cylinder_z(self.hole / 2, 0.0, y, -1.0, self.top + 1.0) for y in (-d.arm, d.arm)]
        return cut(body, [groove, *holes], "equaliser bar")

    def volume_mm3(self) -> float:
        """The prism less groove and holes, of the crowned ends without the sag inside the holes."""
        d = self.dims
        lost = 0.0
        if self.rocker:
            r, e = d.crown_radius, d.reach
            lost = 2 * (2 * r * e - e * sqrt(r**2 - e**2) - r**2 * asin(e / r))
        area = 2 * (d.arm + d.reach) * self.top - 2 * (d.arm - d.reach) * d.foot - lost
        area -= segment_mm2(d.dowel_radius, OVER * d.dowel_radius)
        return area * d.width - 2 * ring_mm3(self.hole / 2, 0.0, self.top)

    def sheet(self, part: str) -> Sheet:
        """From the side, with the profile, and from the face with the groove."""
        d = self.dims
        half, outer, inner = d.width / 2, d.arm + d.reach, d.arm - d.reach
        places = tuple((0.0, y, self.top) for y in (-d.arm, d.arm))
        holes = (Holes("A", self.hole, THROUGH, places, "grooved face", "studs"),)
        crowned = f"Ends crowned R{mm(d.crown_radius)}, crests over holes A. " if self.rocker else "Feet flat. "
        groove = (half, 0.0, self.top + OVER * d.dowel_radius)
        return Sheet(
            part=part,
            title="Rocker of the equaliser" if self.rocker else "Bridge of the equaliser",
            views=(View(_FRONT, Y, Z), View(_TOP, Y, minus(X), row=-1)),
            dimensions=(
                Linear(_FRONT, (half, -outer, self.top), (half, outer, self.top), 2 * outer, "above"),
                Linear(_FRONT, (half, inner, d.foot), (half, outer, self.top), d.bar, "right"),
                Linear(_FRONT, (half, -d.arm, 0.0), (half, -outer, self.top), self.top, "left"),
                Linear(_FRONT, (half, -inner, d.foot), (half, inner, d.foot), 2 * inner, "below"),
                Radius(_FRONT, groove, (half, 0.0, self.top - (1.0 - OVER) * d.dowel_radius), d.dowel_radius),
                Linear(_TOP, (-half, outer, self.top), (half, outer, self.top), d.width, "right"),
            ),
            labels=hole_labels(holes, _TOP),
            holes=holes,
            tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the middle")),
            notes=(
                f"{crowned}Groove in the middle between holes A within {mm(MIDDLE_MM)}, its depth "
                f"{mm((1.0 - OVER) * d.dowel_radius)}, parallel to the faces.",
                "Edges of the groove broken 0.1 at most.",
            ),
        )
