"""Dimensions of an input pulley of two steps: lands, journals, bore, and the slots that hold the cables' stops.

A cable wound in a helix ends in an inward bend and a chord with the swaged stop. The stop sits in a slot milled from
the end face next to the winding's end: the slot bends the cable inward round a radius and ends in a pocket that the
stop cannot leave."""

from dataclasses import dataclass
from math import acos, atan2, ceil, cos, degrees, floor, hypot, pi, sin, sqrt, tau

from mbcdm_cad.design.bought import TerminationSpec
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.part import segment_mm2
from mbcdm_cad.routes.curves import Arc, Helix, Line, Piece, Triple, Vector

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


# Wall left between the pocket of a stop and the land.
STOP_WALL_MM = 0.75
# Kept over the material's thinnest wall at the pocket's corners.
STOP_CORNER_SPARE_MM = 0.01
# Least land beyond the flank of a winding's last turn: the wall of the slot.
_STOP_LAND_MM = 0.8
# The pieces of a cable's path inside the land, from its end.
STOP_PIECES = ("chord", "bend")


@dataclass(frozen=True)
class StopGeometry:
    """End of a cable in its input pulley: bend inward, then a chord that carries the swaged stop.

    ``end_angle_rad``: where the winding ends, drum centred; ``away``: sense in which the winding runs there (+1
    anticlockwise). Chord coordinates count from the foot of the perpendicular from the axis, positive towards the bend.
    The helix's slope tilts the bend: the chord lies ``chord_offset_mm`` from the axis and ``chord_rise_mm`` further out
    than the winding's end.
    """

    end_angle_rad: float
    away: int
    bend_radius_mm: float
    chord_offset_mm: float
    chord_rise_mm: float
    stop_radius_mm: float
    stop_start_mm: float
    stop_end_mm: float


def stop_geometry(drive: SectorDrive, pitch_radius_mm: float, end_angle_rad: float, away: int) -> StopGeometry:
    """The bend is as wide as the pulley allows: its chord runs just inside the land, clear of neck and bearing."""
    d = drive.cable.diameter_mm
    wall = drive.pulley_material.min_wall_mm
    bend_radius = widest_bend_mm(d, drive.termination, wall, pitch_radius_mm)
    slope = atan2(drive.helix_lead_mm, tau * pitch_radius_mm)
    return StopGeometry(
        end_angle_rad=end_angle_rad,
        away=away,
        bend_radius_mm=bend_radius,
        chord_offset_mm=bend_radius * cos(slope),
        chord_rise_mm=bend_radius * sin(slope),
        stop_radius_mm=drive.termination.stop_radius_ratio * d,
        stop_start_mm=drive.termination.stop_length_ratio * d / 2,
        stop_end_mm=-drive.termination.stop_length_ratio * d / 2,
    )


def widest_bend_mm(d_mm: float, end: TerminationSpec, wall_mm: float, pitch_radius_mm: float) -> float:
    """Bend radius of a rope before its stop in an input pulley of this pitch radius, thinnest wall of its metal given.

    The chord runs just inside the land; the corners of the stop's pocket, further out than its middle, leave the wall
    that they need.
    """
    surface, stop_radius = pitch_radius_mm - d_mm / 2, end.stop_radius_ratio * d_mm
    cutter = STOP_CUTTER * (d_mm + SLOT_PLAY_MM) / 2
    inset = cutter / sqrt(2.0)
    along = end.stop_length_ratio * d_mm / 2 + STOP_PLAY_MM - inset
    room = surface - wall_mm - STOP_CORNER_SPARE_MM - cutter
    deepest = inset + sqrt(max(room**2 - along**2, 0.0)) - stop_radius - STOP_PLAY_MM
    return min(surface - stop_radius - STOP_WALL_MM, deepest)


def neck_mm(d_mm: float, end: TerminationSpec, wall_mm: float, pitch_radius_mm: float) -> float:
    """Radius of an input pulley's neck beside the stop of its cable, where no bearing's shoulder asks for less."""
    bend = widest_bend_mm(d_mm, end, wall_mm, pitch_radius_mm)
    return bend - end.stop_radius_ratio * d_mm - NECK_GAP_MM


def neck_radius_mm(shoulder_mm: float, stop: StopGeometry) -> float:
    """Neck beside a stop: the shoulder of its bearing, but clear of the stop."""
    return min(shoulder_mm / 2, stop.bend_radius_mm - stop.stop_radius_mm - NECK_GAP_MM)


def stop_land_mm(drive: SectorDrive, rise_mm: float = 0.0) -> float:
    """Land beyond the flank of a winding's last turn: the wall of its slot, and no less than a thick stop reaches.

    ``rise_mm``: how far along the axis the stop lies beyond the winding's end.
    """
    d = drive.cable.diameter_mm
    return max(_STOP_LAND_MM, rise_mm + drive.termination.stop_radius_ratio * d - d / 2)


def helix_stop_land_mm(drive: SectorDrive) -> float:
    """The same where the cables are wound in a helix, whose slope carries the stops outwards."""
    return stop_land_mm(drive, max(stop_geometry(drive, c.input_radius_mm, 0.0, 1).chord_rise_mm for c in drive.cables))


def stop_pieces(start: Vector, radial: Vector, back: Vector, radius_mm: float, stop: StopGeometry) -> list[Piece]:
    """Chord and bend of a cable, from its end to ``start``, where its winding ends.

    ``radial`` and ``back``: unit vectors there, away from the axis and the way that the winding would run on;
    ``radius_mm``: pitch radius of the winding.
    """
    rho = stop.bend_radius_mm
    centre = start - rho * radial
    bend_end = centre + rho * back
    chord_end = bend_end - radial * ((radius_mm - rho) - stop.stop_end_mm)
    return [Line(_t(chord_end), _t(bend_end)), Arc(_t(centre), _t(radial), _t(back), rho, pi / 2, 0.0)]


def _t(v: Vector) -> Triple:
    return (float(v[0]), float(v[1]), float(v[2]))


def stop_slot(
    drive: SectorDrive, cable_name: str, radius_mm: float, stop: StopGeometry, end_z: float, face_z: float
) -> StopSlot:
    """The slot of a stop whose cable's winding ends at ``end_z``, milled from the land's face at ``face_z``."""
    outward = 1 if face_z > end_z else -1
    return StopSlot(
        cable_name=cable_name,
        end_angle_rad=stop.end_angle_rad,
        away=stop.away,
        end_z=end_z,
        chord_z=end_z + outward * stop.chord_rise_mm,
        chord_offset=stop.chord_offset_mm,
        face_z=face_z,
        pitch_radius=radius_mm,
        bend_radius=stop.bend_radius_mm,
        width=drive.cable.diameter_mm + SLOT_PLAY_MM,
        stop_radius=stop.stop_radius_mm,
        stop_start=stop.stop_start_mm,
        stop_end=stop.stop_end_mm,
    )


def anchored_groove(drive: SectorDrive, slot: StopSlot, stop: StopGeometry, wound_rad: float) -> Groove:
    """From just past the winding's end in the stop's slot to where the span has risen out of the groove.

    ``wound_rad``: what the cable winds at most.
    """
    d = drive.cable.diameter_mm
    depth, r = GROOVE_DEPTH * d, slot.pitch_radius
    into_slot = d / 2 / r
    # At this angle past its last contact the straight span has risen by the groove's depth.
    out = acos(r / (r + depth))
    wound = wound_rad + out
    outward = 1 if slot.face_z > slot.end_z else -1
    per_rad = outward * drive.helix_lead_mm / tau
    return Groove(
        cable_name=slot.cable_name,
        root_radius=r - d / 2,
        radius=GROOVE_RADIUS * d,
        depth=depth,
        start_angle_rad=stop.end_angle_rad + stop.away * into_slot,
        end_angle_rad=stop.end_angle_rad - stop.away * wound,
        start_z=slot.end_z + per_rad * into_slot,
        end_z=slot.end_z - per_rad * wound,
    )
