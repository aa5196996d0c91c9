"""An input pulley that the shaft of motor or gearhead alone carries: its hub, and the motor's seat on the plate.

In section, y to the right (front):

      motor |plate|
            |_____|pocket for the screws' heads
     face ==|=====hub|  land with its groove  |
            |_____|    set screws in the hub
            |     |
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi
from typing import Protocol

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, groove_depth_mm
from mbcdm_cad.parts.bought.bodies import screw_places
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims, SetHub
from mbcdm_cad.parts.motor_head.dims import Flange, HeadLevels, Places, body_radius_mm

# Metal before and behind the set screws in the hub.
HUB_EDGE_MM = 1.0
# Bore beyond the end of the shaft, and metal that closes the pulley in front of it; a thinner end is bored through.
BEYOND_SHAFT_MM, END_WALL_MM = 0.5, 1.0
# Room round the heads of the motor's screws in their pocket, for the socket of the key beside the wall.
HEAD_ROOM_MM = 0.2
# Plate between the pocket and the threads of the frame's own screws.
POCKET_WEB_MM = 0.6


class PulleyLevels(HeadLevels, Protocol):
    """Heights along the input's axis, mm."""

    @property
    def land_bottom_z(self) -> float:
        """End of the land towards the motor."""

    @property
    def land_top_z(self) -> float:
        """Other end of the land."""


@lru_cache(maxsize=64)
def _set_screw(screws: tuple[Screw, ...], wall_mm: float) -> Screw:
    """The thickest set screw, of these the longest, that a hub's wall takes whole; else the shortest of all."""
    known = [s for s in screws if s.head_height_mm == 0.0]
    fitting = [s for s in known if s.length_mm <= wall_mm]
    if fitting:
        return max(fitting, key=lambda s: (s.thread_mm, s.length_mm))
    return min(known, key=lambda s: (s.length_mm, s.thread_mm))


def crest_mm(drive: SpurDrive) -> float:
    """Radius of the land, outside its grooves."""
    return drive.input_radius_mm - drive.cable.diameter_mm / 2 + groove_depth_mm(drive)


def set_screw(drive: SpurDrive) -> Screw:
    """The set screw, two of which hold the pulley on the shaft."""
    return _set_screw(drive.screws, crest_mm(drive) - drive.gearhead.shaft_diameter_mm / 2)


def hub_radius_mm(drive: SpurDrive) -> float:
    """Radius of the hub: that of the land, or more for the length of its set screws."""
    return max(crest_mm(drive), drive.gearhead.shaft_diameter_mm / 2 + set_screw(drive).length_mm)


def hub_length_mm(drive: SpurDrive) -> float:
    """Length of the hub between plate and land."""
    return set_screw(drive).thread_mm + 2 * HUB_EDGE_MM


@dataclass(frozen=True)
class MotorSeat:
    """Where the motor, or its gearhead, is screwed on the back of the plate, mm; places are (x, z) in the assembly."""

    pocket_radius: float  # from the front, for the heads of its screws
    shelf: float  # plate left behind the pocket
    pilot_radius: float
    screw_clearance: float
    screws: Places


def _pocket_radius_mm(drive: SpurDrive) -> float:
    gear = drive.gearhead
    heads = (gear.bolt_circle_mm + drive.screw(gear.screw).head_diameter_mm) / 2 + HEAD_ROOM_MM
    return max(heads, hub_radius_mm(drive) + drive.clearances.running_mm)


def motor_seat(drive: SpurDrive) -> MotorSeat:
    """The seat on the plate."""
    gear, z = drive.gearhead, drive.centre_distance_mm
    places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, drive.gearhead_angle_deg)
    return MotorSeat(
        pocket_radius=_pocket_radius_mm(drive),
        shelf=drive.support.motor_shelf_mm,
        pilot_radius=gear.pilot_diameter_mm / 2,
        screw_clearance=drive.screw(gear.screw).clearance_mm / 2,
        # Angles seen from the front; the gearhead is drawn as seen from its face.
        screws=tuple((x, z - y + 0.0) for x, y in places),
    )


def seat_flange(drive: SpurDrive, edge_mm: float, thread_mm: float) -> Flange:
    """Outline of the plate round the seat; the frame's own screws stand beside motor and pocket.

    ``edge_mm``: from the axis of such a screw to the plate's edge; ``thread_mm``: its hole.
    """
    pocket = _pocket_radius_mm(drive)
    beside = max(body_radius_mm(drive) + drive.clearances.running_mm, pocket + POCKET_WEB_MM) + thread_mm / 2
    reach = pocket + max(drive.support.side_wall_mm / 2, drive.frame_material.min_wall_mm)
    return Flange(half_x=beside + edge_mm, back_y=-reach, front_y=reach, screws=(), dowels=())


def shaft_end_z_mm(drive: SpurDrive, levels: PulleyLevels) -> float:
    """End of the shaft."""
    return levels.motor_shelf_bottom_z + drive.gearhead.shaft_length_mm


def pulley_bottom_z_mm(drive: SpurDrive, levels: PulleyLevels) -> float:
    """Where the pulley begins: in the pocket, in front of the screws' heads if it does not fit between them."""
    gear, running = drive.gearhead, drive.clearances.running_mm
    screw = drive.screw(gear.screw)
    between = (gear.bolt_circle_mm - screw.head_diameter_mm) / 2 - hub_radius_mm(drive)
    heads = 0.0 if between >= running else screw.head_height_mm
    pilot = max(gear.pilot_height_mm - drive.support.motor_shelf_mm, 0.0)
    return levels.motor_shelf_top_z + max(heads, pilot) + running


def bore_end_z_mm(drive: SpurDrive, levels: PulleyLevels) -> float:
    """End of the bore: past the shaft's end, or through the pulley."""
    end = shaft_end_z_mm(drive, levels) + BEYOND_SHAFT_MM
    return end if end <= levels.land_top_z - END_WALL_MM else levels.land_top_z


def overhung_pulley(drive: SpurDrive, levels: PulleyLevels, plain: InputPulleyDims) -> InputPulleyDims:
    """The pulley: a hub and the land of ``plain``, one that has bearings."""
    screw, radius = set_screw(drive), hub_radius_mm(drive)
    bottom = pulley_bottom_z_mm(drive, levels)
    return replace(
        plain,
        journal_bottom_z=bottom,
        lower_journal_radius=radius,
        lower_neck_bottom_z=levels.land_bottom_z,
        lower_neck_radius=radius,
        upper_neck_radius=plain.upper_land_radius,
        upper_neck_top_z=levels.land_top_z,
        upper_journal_radius=plain.upper_land_radius,
        journal_top_z=levels.land_top_z,
        bore_radius=drive.gearhead.shaft_diameter_mm / 2,
        bore_top_z=bore_end_z_mm(drive, levels),
        slit_width=0.0,
        slit_top_z=bottom,
        hub=SetHub(screw.name, screw.thread_mm, levels.land_bottom_z - hub_length_mm(drive) / 2),
    )


def pocket_mm3(seat: MotorSeat, plate_mm: float) -> float:
    """Volume of the seat's pocket and holes in a plate of this thickness."""
    pocket = pi * seat.pocket_radius**2 * max(plate_mm - seat.shelf, 0.0)
    holes = pi * (seat.pilot_radius**2 + len(seat.screws) * seat.screw_clearance**2)
    return pocket + holes * min(seat.shelf, plate_mm)
