"""Dimensions of an input pulley of two steps: lands, journals, bore, and the slots that hold the cables' stops."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, ceil, degrees, floor, hypot, sqrt, tau

from mbcdm_cad.parts.part import segment_mm2
from mbcdm_cad.routes.curves import Helix

ENCODER_INSERTION_MM = 10.0
JOURNAL_SLIT_MM = 0.6
# Play of a cable's stop in its pocket.
STOP_PLAY_MM = 0.05
# Width of the slot over the diameter of its cable.
SLOT_PLAY_MM = 0.1
# Gap between a stop and the neck beside it.
NECK_GAP_MM = 0.1
# Diameter of the pocket's cutter in slot widths: its corners are relieved so that the stop's square ends seat.
STOP_CUTTER = 0.85
# Where the slot leaves the land, the thin wedge outside it is removed up to this thickness.
WEDGE_MM = 0.3

# Helical grooves in rope diameters, and their least lead in groove radii: rope makers' tables for drums give radii of
# 0.53 to 0.55 d, a depth of 0.374 d and leads of 2.065 to 2.18 radii.
GROOVE_RADIUS = 0.53
GROOVE_DEPTH = 0.374
GROOVE_LEAD = 2.065

# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.2


@dataclass(frozen=True)
class StopSlot:
    """Slot for one cable's stop, in the pulley's frame with the drum centred (angles rad, heights mm)."""

    cable_name: str
    end_angle_rad: float
    away: int
    end_z: float
    chord_z: float
    chord_offset: float
    face_z: float  # end face the slot is milled from
    pitch_radius: float
    bend_radius: float
    width: float
    stop_radius: float
    stop_start: float  # along the chord, from the axis' foot; positive towards the bend
    stop_end: float

    @property
    def cutter_radius(self) -> float:
        """Radius of the cutter that relieves the pocket's corners."""
        return STOP_CUTTER * self.width / 2

    @property
    def pocket_reach(self) -> float:
        """Distance of the furthest point of the pocket from the pulley's axis, mm, corner relief included."""
        inset = self.cutter_radius / sqrt(2)
        along, out = self.stop_start + STOP_PLAY_MM, self.bend_radius + self.stop_radius + STOP_PLAY_MM
        return hypot(along - inset, out - inset) + self.cutter_radius

    def open_deg(self, surface_radius: float) -> float:
        """Angle about the bend's centre up to which the slot is open to the outside, on a land of this radius."""
        centre, outer = self.pitch_radius - self.bend_radius, self.bend_radius + self.width / 2
        cosine = ((surface_radius - WEDGE_MM) ** 2 - centre**2 - outer**2) / (2 * centre * outer)
        return degrees(acos(min(1.0, max(0.0, cosine))))

    @property
    def pocket_inner(self) -> float:
        """Least distance of the pocket from the pulley's axis, mm, corner reliefs included."""
        across = self.bend_radius - self.stop_radius - STOP_PLAY_MM - self.cutter_radius * (1 - 1 / sqrt(2))
        return hypot(across, max(0.0, self.stop_end - STOP_PLAY_MM - self.cutter_radius))


@dataclass(frozen=True)
class Groove:
    """Helical groove for one cable, in the pulley's frame with the drum centred (angles rad, heights mm).

    An arc of ``radius`` about a point of the helix at ``root_radius + radius`` from the axis, ``depth`` deep.
    """

    cable_name: str
    root_radius: float
    radius: float
    depth: float
    start_angle_rad: float
    end_angle_rad: float
    start_z: float
    end_z: float

    @property
    def half_width(self) -> float:
        """Half the width along the axis at the land's surface."""
        return sqrt(max(2 * self.radius * self.depth - self.depth**2, 0.0))

    @property
    def lead(self) -> float:
        """Advance along the axis a turn."""
        return abs(self.end_z - self.start_z) * tau / abs(self.end_angle_rad - self.start_angle_rad)

    def helix(self, radius_mm: float) -> Helix:
        """The centre line of the groove at a radius."""
        return Helix((0.0, 0.0), radius_mm, self.start_angle_rad, self.end_angle_rad, self.start_z, self.end_z)

    def crossings_z(self, angle_rad: float) -> list[float]:
        """Heights at which its middle passes the half plane through the axis at an angle."""
        a, turned = self.start_angle_rad, self.end_angle_rad - self.start_angle_rad
        low, high = sorted((a, a + turned))
        turns = range(ceil((low - angle_rad) / tau), floor((high - angle_rad) / tau) + 1)
        return [self.start_z + (angle_rad + tau * n - a) / turned * (self.end_z - self.start_z) for n in turns]

    @property
    def volume_mm3(self) -> float:
        """Pappus: the area of the groove, a segment of its circle, along the helix of the area's centroid."""
        r, half = self.radius, self.half_width
        area = segment_mm2(r, r - self.depth)
        middle = self.root_radius + r - (2 * half) ** 3 / (12 * area)
        turned = abs(self.end_angle_rad - self.start_angle_rad)
        return area * turned * hypot(middle, self.lead / tau)

    @property
    def right_handed(self) -> bool:
        """Whether the helix rises as it turns anticlockwise."""
        return (self.end_z - self.start_z) * (self.end_angle_rad - self.start_angle_rad) > 0.0


# Directions of a hub's set screws about the axis, from +X.
SET_SCREWS_DEG = (0.0, 90.0)


@dataclass(frozen=True)
class SetHub:
    """Hub whose two set screws hold a pulley on a motor's shaft: their name, thread and height, mm."""

    screw: str
    thread: float
    screw_z: float


@dataclass(frozen=True)
class HornFlange:
    """Flange on the horn of a servo: screw, radius of its clearance holes, and their places (x, y), mm."""

    screw: str
    clearance: float
    places: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class InputPulleyDims:
    """One input pulley. Heights along Z from lower journal to encoder journal (mm).

    ``surface`` radii are those on which the cables lie: of a smooth land, or of the root of its groove. ``bore_radius``
    is 0 for a whole journal, which carries a wheel in place of the gearhead's shaft inside it.
    With a ``hub`` it has no journals, necks and slit: the hub has the radius of the lower journal, the land is the
    other end. With a ``horn`` the lower journal is the flange, the lower neck goes on as the land, and the bore is a
    recess.
    """

    name: str
    x: float
    journal_bottom_z: float
    lower_journal_radius: float
    lower_neck_bottom_z: float
    lower_neck_radius: float
    land_bottom_z: float
    lower_surface_radius: float
    wall_z: float
    upper_surface_radius: float
    land_top_z: float
    upper_neck_radius: float
    upper_neck_top_z: float
    upper_journal_radius: float
    journal_top_z: float
    bore_radius: float
    bore_top_z: float
    slit_width: float
    slit_top_z: float
    slots: tuple[StopSlot, ...]
    y: float = 0.0
    grooves: tuple[Groove, ...] = ()
    hub: SetHub | None = None
    horn: HornFlange | None = None

    @property
    def stepped(self) -> bool:
        """Whether the two steps differ: a pulley that one cable goes round has one land."""
        return self.lower_surface_radius != self.upper_surface_radius

    @property
    def _groove_depth(self) -> float:
        return max((groove.depth for groove in self.grooves), default=0.0)

    @property
    def lower_land_radius(self) -> float:
        """Outside of the lower step: its surface, or the crests between its grooves."""
        return self.lower_surface_radius + self._groove_depth

    @property
    def upper_land_radius(self) -> float:
        """Outside of the upper step."""
        return self.upper_surface_radius + self._groove_depth
