"""Threaded terminal of a cable: swage with a bore and two flats, stud behind it; axis Z, the cable comes from -Z.

On the stud between lug and nut there may be a spring, a disc of a stack or a coil, axis Z from z = 0. Also the take-up
of the terminals, from slack to the highest preload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, cos, sin
from typing import Any

from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.model.tensioning import TakeUp, TensionedRope, rope_stiffnesses, take_up
from mbcdm_cad.parts.fits import thread
from mbcdm_cad.parts.milled import PlainRing, Step, Turned, block, one_solid, turned
from mbcdm_cad.parts.part import BoughtPart, MadePart, Ring, StandardPart, cq, segment_mm2
from mbcdm_cad.parts.sheet import Linear, Sheet, View, X, Y, minus, mm
from mbcdm_cad.parts.sheet_blocks import ALONG_Z

# What grinding takes from the coils at both ends of a coil spring together (usual: half of each).
_CLOSED = 1.0
# Steps towards a disc's tilt; each leaves less than a tenth of the error.
_STEPS = 20


@dataclass(frozen=True)
class SeatWasher(PlainRing, StandardPart):
    """Washer on either side of the springs: over the slot of their lug, and under the nut; sizes in mm."""

    what = "washer"

    inside: float
    outside: float
    thickness: float

    def ring(self) -> Ring:
        """Round the stud."""
        return (self.outside / 2, self.inside / 2, 0.0, self.thickness)

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
        wire = self.entry.strip_mm
        coils = self.entry.solid_mm / wire - _CLOSED
        mean, rise = (self.entry.inside_mm + wire) / 2, self.height - wire
        helix = cq.Wire.makeHelix(rise / coils, rise, mean, cq.Vector(0, 0, wire / 2))
        profile = cq.Workplane("XZ").center(mean, wire / 2).circle(wire / 2)
        swept: Any = profile.sweep(cq.Workplane(helix), isFrenet=True).val()
        return one_solid(swept, "coil spring")


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
class ThreadedTerminal(Turned, MadePart):
    """Terminal along Z, the cable from -Z; ``end``: how the cable ends in its sleeve, an entry of the catalogue."""

    what, chamfers_mm = "terminal", (CHAMFER_MM, CHAMFER_MM)

    dims: TerminalDims
    end: str = SWAGED

    def steps(self) -> tuple[Step, ...]:
        """Swage and stud."""
        d = self.dims
        return ((d.swage_radius, d.swage_start, d.swage_end), (d.stud_radius, d.swage_end, d.tip))

    def bores(self) -> tuple[Step, ...]:
        """The cable's."""
        return ((self.dims.bore_radius, self.dims.swage_start, self.dims.cable_end),)

    def cuts(self) -> list[cq.Shape]:
        """Flats at +-y: one slides along the wall of its pocket and keeps the rope from twisting."""
        d, r = self.dims, self.dims.swage_radius
        return [block((-r, r), y, (d.swage_start, d.swage_end)) for y in ((d.flat, d.flat + r), (-d.flat - r, -d.flat))]

    def volume_mm3(self) -> float:
        """Swage with its bore and flats, and the stud."""
        d = self.dims
        return super().volume_mm3() - 2 * segment_mm2(d.swage_radius, d.flat) * (d.swage_end - d.swage_start)

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


# Travel is rounded up to this, as a drawing would.
_STEP_MM = 0.1


def highest_preload_N(drive: Drive, cable: CableRun) -> float:
    """Preload of a cable with two of its standard deviations, where it has one."""
    return cable.preload_N + 2.0 * drive.sigmas.preload_N[drive.cables.index(cable)]


def take_up_of(drive: Drive, cable: CableRun, length_mm: float) -> TakeUp:
    """Take-up, m, that a cable of ``length_mm`` needs from its terminal."""
    rope = drive.cable
    return take_up(
        length_mm * 1e-3,
        highest_preload_N(drive, cable),
        rope.axial_stiffness_N,
        rope.bedding_in_share,
        drive.cut_tolerance_mm * 1e-3,
        drive.setting_mm * 1e-3,
    )


def terminal_travel_mm(drive: Drive, longest_mm: Mapping[str, float]) -> tuple[float, dict[str, float]]:
    """(travel of all terminals, take-up of each with a cable of nominal length), mm, from the cables' lengths."""
    needed = {c.name: take_up_of(drive, c, longest_mm[c.name]) for c in drive.cables}
    longest = max(t.total_m for t in needed.values()) * 1e3
    return ceil(longest / _STEP_MM - 1e-9) * _STEP_MM, {name: t.nominal_m * 1e3 for name, t in needed.items()}


def tensioned_rope(drive: Drive) -> TensionedRope:
    """The rope's properties that are needed to set preloads."""
    rope = drive.cable
    wire = drive.material(rope.material)
    loose, bonded = rope_stiffnesses(
        rope.construction, rope.diameter_mm * 1e-3, rope.axial_stiffness_N, wire.youngs_modulus_GPa * 1e9
    )
    return TensionedRope(
        axial_stiffness_N=rope.axial_stiffness_N,
        mass_kg_m=rope.mass_g_m * 1e-3,
        loose_N_m2=loose,
        bonded_N_m2=bonded,
        bedding_share=rope.bedding_in_share,
        cut_tolerance_m=drive.cut_tolerance_mm * 1e-3,
        friction=drive.friction_coefficient,
        setting_m=drive.setting_mm * 1e-3,
        anchor_m_N=drive.anchor_m_N,
        tails_m=drive.ends_per_run * drive.termination.tail_ratio * rope.diameter_mm * 1e-3,
    )
