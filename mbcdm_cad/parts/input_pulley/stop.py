"""Where a cable wound in a helix ends in its input pulley: an inward bend, then a chord with the swaged stop.

The swaged stop sits in a slot milled from the end face next to the winding's end: the slot bends the cable inward round
a radius and ends in a pocket that the stop cannot leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan2, cos, pi, sin, sqrt, tau

from mbcdm_cad.design.bought import TerminationSpec
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.input_pulley.dims import (
    GROOVE_DEPTH,
    GROOVE_RADIUS,
    NECK_GAP_MM,
    SLOT_PLAY_MM,
    STOP_CUTTER,
    STOP_PLAY_MM,
    Groove,
    StopSlot,
)
from mbcdm_cad.routes.curves import Arc, Line, Piece, Triple, Vector

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
