"""Dimensions of a motor head: the part that carries gearhead and motor of one input in line with its pulley.

       | motor  |
       |gearhead|       if there is one
     ==============  motor shelf
     | coupling   |    coupling space, open to the front
   ==================  bearing shelf: the flange on the frame

Along Z, from the flange on the frame to the gearhead, the axis at x = y = 0. Heights of the pulley's parts are measured
in the opposite direction, from the gearhead.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, sqrt
from typing import Any

from mbcdm_cad.design.bought import CableStageOutput, InsertSpec, Screw
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.boss import BossDims
from mbcdm_cad.parts.coupling import collar_over_shelf_mm, collar_sweep_mm
from mbcdm_cad.parts.drum_sector.design import InputLevels, SectorDrive

# Thread of the flange's screws, by the widest body that they carry (estimate).
FLANGE_THREADS_MM = ((22.0, 2.0), (100.0, 3.0), (200.0, 4.0))
FLANGE_THREAD_MOST_MM = 5.0
DOWEL_MM = 2.0
DOWEL_LENGTHS_MM = (6.0, 8.0, 10.0, 12.0, 16.0)
# Way of the motor on its shelf from the middle, each way, to lay a belt on and to tighten it: half of a usual
# tolerance of a belt's length and its stretch (estimate).
BELT_TAKE_UP_MM = 0.6
# Flange of a stage before its bearing seat (estimate).
FLANGE_SEAT_MM = 4.0
# Play of a key in its hole, on the radius.
KEY_PLAY_MM = 0.15
# Longest sensible reach of an end mill, in diameters.
TOOL_SLENDERNESS = 4.0
# Each round changes the pocket's width by a quarter of what the one before did, at most.
_ROUNDS = 12
# Keeps the gap whole where the last digits of a sum are lost.
_ROUNDING_MM = 1e-6

Places = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Flange:
    """Outline of the flange, mm, and places of its screws and dowels, (x, y)."""

    half_x: float
    back_y: float
    front_y: float
    screws: Places
    dowels: Places


@dataclass(frozen=True, kw_only=True)
class CouplingBox:
    """Box on a plate for the coupling of one input, the gearhead on its roof (mm); Z is the input's axis.

    The plate, from ``bottom_z`` to ``flange_top_z``, holds the bearing next to the gearhead.
    """

    bottom_z: float
    flange_top_z: float
    shelf_bottom_z: float
    top_z: float
    front_y: float
    back_y: float
    inner_x: float
    outer_x: float
    corner_radius: float
    seat_radius: float
    seat_depth: float
    shoulder_radius: float
    pilot_radius: float
    gear_screw_clearance: float
    gear_bolt_circle: float
    gear_screws: Places
    key_hole_radius: float
    # Distance of the gearhead's axis from the input's, along y.
    beside_y: float = 0.0
    # How far pilot and holes for the gearhead's screws are longer each way along y, so that a belt can be tightened.
    take_up: float = 0.0


@dataclass(frozen=True, kw_only=True)
class HeadDims(CouplingBox):
    """The motor head (mm): a coupling box whose plate is a flange."""

    flange: Flange
    screw_clearance: float
    dowel_radius: float


@dataclass(frozen=True, kw_only=True)
class SectorFrameDims:
    """What the frame of a drive with a drum sector has whatever its shape, mm: boss, input's seat, stop pin, mounts."""

    boss: BossDims
    corner_radius: float
    seat_radius: float
    seat_depth: float
    seat_shoulder_radius: float
    stop_pin_radius: float
    stop_pin_z: float
    dowels: Places  # in the plane of the flange or plate that they locate
    dowel_radius: float
    dowel_depth: float
    mounts: Places  # (x, z)
    mount_radius: float


@dataclass(frozen=True, kw_only=True)
class HeadFrameDims(SectorFrameDims):
    """Adds what a frame with a motor head has: encoder shelf and the threads of the head's flange, mm."""

    encoder_screw_clearance: float
    encoder_head_radius: float
    encoder_head_depth: float
    encoder_circle_radius: float
    flange_screw_radius: float
    flange_insert: InsertSpec | None
    flange_screws: Places  # in the plane of the motor head's flange


def flange_screw(drive: SectorDrive) -> Screw:
    """The shortest screw that engages its diameter behind the flange, else the longest of its thread."""
    wide = 2 * body_radius_mm(drive)
    thread = next((mm for most, mm in FLANGE_THREADS_MM if wide <= most), FLANGE_THREAD_MOST_MM)
    sizes = [s for s in drive.screws if s.thread_mm == thread and s.head_height_mm > 0.0]
    needed = drive.support.bearing_shelf_mm + thread
    enough = [s for s in sizes if s.length_mm >= needed]
    pick, of = (min, enough) if enough else (max, sizes)
    return pick(of, key=lambda screw: screw.length_mm)


def dowel_length_mm(drive: SectorDrive) -> float:
    """The shortest dowel that engages its diameter behind the flange, else the longest."""
    needed = drive.support.bearing_shelf_mm + DOWEL_MM
    return next((length for length in DOWEL_LENGTHS_MM if length >= needed), DOWEL_LENGTHS_MM[-1])


def inner_half_width_mm(drive: SectorDrive) -> float:
    """Half the width of the coupling space: the collar turns in it, and the gearhead's screws stand off its corners."""
    running, reach = drive.clearances.running_mm, collar_sweep_mm(drive)
    if drive.stage is not None:
        reach = max(reach, *(drive.stage.reach_mm(r) for r in (drive.stage.driven_mm, drive.stage.driver_mm)))
    # Heads of the gearhead's screws stand beside the round corner that the coupling pocket's cutter leaves.
    heads = (drive.gearhead.bolt_circle_mm + drive.screw(drive.gearhead.screw).head_diameter_mm) / 2 + running
    corner = max(drive.frame_material.min_internal_radius_mm, heads / (TOOL_SLENDERNESS - 1.0))
    inner = max(reach + running, heads + corner)
    # The collar stands lower over the shelf than the corner of a wide pocket reaches up, which grows with the width.
    corner_of, over = _corner_radius_mm(drive), collar_over_shelf_mm(drive)
    for _ in range(_ROUNDS):
        corner = corner_of(inner)
        below = corner - over
        if below <= 0.0:
            break
        wider = reach + corner - sqrt(max((corner - running) ** 2 - below**2, 0.0)) + _ROUNDING_MM
        if wider <= inner:
            break
        inner = wider
    return inner


def outer_half_width_mm(drive: SectorDrive) -> float:
    """Half the width of the box."""
    return inner_half_width_mm(drive) + float(drive.support.side_wall_mm) / 2


def _corner_radius_mm(drive: SectorDrive) -> Callable[[float], float]:
    """Corner radius of the coupling pocket, by the cutter that reaches its back, of half the pocket's width."""
    face, least = face_reach_mm(drive), drive.frame_material.min_internal_radius_mm
    return lambda inner_mm: max(least, (inner_mm + max(inner_mm, face)) / TOOL_SLENDERNESS / 2)


def face_reach_mm(drive: SectorDrive) -> float:
    """Reach of the motor shelf from the axis, mm: over the face, or beyond its screws if the face is wider."""
    gear = drive.gearhead
    return min(gear.diameter_mm / 2, gear.bolt_circle_mm / 2 + drive.screw(gear.screw).head_diameter_mm)


def body_radius_mm(drive: SectorDrive) -> float:
    """Half of the wider of gearhead and motor; a motor in front of a first cable stage is not behind the input."""
    if isinstance(drive.gearhead, CableStageOutput):
        return drive.gearhead.diameter_mm / 2
    return max(drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2


def coupling_box(drive: SectorDrive, levels: InputLevels, gear_screws: Places) -> CouplingBox:
    """Dimensions of a coupling box, for screws of the gearhead at these places."""
    return CouplingBox(**_box_values(drive, levels), gear_screws=gear_screws)


def head(drive: SectorDrive, levels: InputLevels, flange: Flange) -> HeadDims:
    """Dimensions of the motor head."""
    gear = drive.gearhead
    places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, drive.gearhead_angle_deg)
    return HeadDims(
        **_box_values(drive, levels),
        # Angles seen from the flange; the gearhead is drawn as seen from its face.
        gear_screws=tuple((x, beside_mm(drive) - y + 0.0) for x, y in places),
        flange=flange,
        screw_clearance=flange_screw(drive).clearance_mm / 2,
        dowel_radius=DOWEL_MM / 2,
    )


def _box_values(drive: SectorDrive, levels: InputLevels) -> dict[str, Any]:
    lower, gear = drive.bearings.input_lower, drive.gearhead
    gear_screw, inner = drive.screw(gear.screw), inner_half_width_mm(drive)
    outer = outer_half_width_mm(drive)
    return {
        "bottom_z": -levels.bearing_shelf_top_z,
        "flange_top_z": -levels.bearing_shelf_bottom_z,
        "shelf_bottom_z": -levels.motor_shelf_top_z,
        "top_z": -levels.motor_shelf_bottom_z,
        "front_y": max(inner, beside_mm(drive) + face_reach_mm(drive)),
        "back_y": -outer,
        "inner_x": inner,
        "outer_x": outer,
        "corner_radius": _corner_radius_mm(drive)(inner),
        "seat_radius": lower.outer_diameter_mm / 2,
        "seat_depth": lower.width_mm,
        "shoulder_radius": lower.outer_shoulder_mm / 2,
        "pilot_radius": gear.pilot_diameter_mm / 2,
        "gear_screw_clearance": gear_screw.clearance_mm / 2,
        "gear_bolt_circle": gear.bolt_circle_mm / 2,
        # The hexagon key passes through the bearing shelf to the gearhead's screws before the bearing is inserted.
        "key_hole_radius": key_hole_mm(drive),
        "beside_y": beside_mm(drive),
        "take_up": BELT_TAKE_UP_MM if drive.stage is not None and drive.stage.is_belt else 0.0,
    }


def beside_mm(drive: SectorDrive) -> float:
    """Distance of the gearhead's axis from the input's: that of a stage's axes, 0 in line with it."""
    return 0.0 if drive.stage is None else drive.stage.centre_mm


def key_hole_mm(drive: SectorDrive) -> float:
    """Radius of the holes for the key of the gearhead's screws; drills come in tenths of a millimetre."""
    wide = 2.0 * (drive.screw(drive.gearhead.screw).key_mm / 3**0.5 + KEY_PLAY_MM)
    return floor(10.0 * wide) / 20.0


def flange_front_mm(drive: SectorDrive) -> float:
    """Front of the flange: that of the box; with a stage before the screws of the gearhead, which a key must reach."""
    inner = inner_half_width_mm(drive)
    if drive.stage is None:
        return max(inner, face_reach_mm(drive))
    free = beside_mm(drive) - drive.gearhead.bolt_circle_mm / 2 - key_hole_mm(drive) - KEY_PLAY_MM
    seat = drive.bearings.input_lower.outer_diameter_mm / 2
    return max(min(inner, free), seat + FLANGE_SEAT_MM)
