"""Dimensions of the input pulley, in bearings or on the motor's shaft alone; the motor's seat on the plate.

Heights count along +Y from the gearhead to the encoder; angles seen in +Y direction.

    gearhead's shaft in a slit journal |neck|  land with its groove  |neck|journal| encoder

Each of several cables in parallel has its own groove. Each of two anchored ones has it too, and a slot for its stop in
the end face next to the end of its winding. In the assembly the part is turned about X by a quarter turn: (x, y, z) of
the part are (x, z, -y) there. On the motor's shaft alone, y to the right (front):

      motor |plate|
            |_____|pocket for the screws' heads
     face ==|=====hub|  land with its groove  |
            |_____|    set screws in the hub
            |     |
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi
from typing import Any

from mbcdm_cad.design.bought import Bearing, Screw, Servo
from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.layouts.siso_spur.cable_path import stop_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, contact_rad, groove_depth_mm, groove_run_out_rad
from mbcdm_cad.parts.bill import ALONG_Y, BillBuilder, Placement
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.coupling import collar_over_shelf_mm
from mbcdm_cad.parts.drum_sector.design import LandLevels
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.input_pulley.dims import HornFlange, InputPulleyDims, SetHub
from mbcdm_cad.parts.input_pulley.items import add_horn
from mbcdm_cad.parts.motor_head.dims import Flange, Places, body_radius_mm


def _through_groove(drive: SpurDrive, name: str, level_mm: float) -> dims.Groove:
    """Groove of a continuous cable: its turns, the walk in both directions, and the run-out at both spans.

    Right-handed, left-handed with open spans, so that the turns walk along the input as the cable does on the drum.
    """
    beyond = drive.input_travel_rad / 2 + groove_run_out_rad(drive)
    start = contact_rad(drive, 1) - pi / 2
    per_rad = drive.input_radius_mm * drive.slope
    return dims.Groove(
        cable_name=name,
        root_radius=drive.input_radius_mm - drive.cable.diameter_mm / 2,
        radius=dims.GROOVE_RADIUS * drive.cable.diameter_mm,
        depth=groove_depth_mm(drive),
        start_angle_rad=start - drive.input_sense * beyond,
        end_angle_rad=start + drive.input_sense * (drive.wrap_rad + beyond),
        start_z=level_mm - drive.leave_mm - per_rad * beyond,
        end_z=level_mm + drive.leave_mm + per_rad * beyond,
    )


def _slots(drive: SpurDrive, levels: LandLevels) -> tuple[dims.StopSlot, ...]:
    """Stop slots of both anchored cables, the lower first."""
    return tuple(
        dims.stop_slot(
            drive,
            c.name,
            c.input_radius_mm,
            stop_of(drive, c),
            drive.level_mm + c.outward * drive.dead_end_mm,
            levels.land_bottom_z if c.outward < 0 else levels.land_top_z,
        )
        for c in sorted(drive.cables, key=lambda c: c.step)
    )


def _grooves(drive: SpurDrive, slots: tuple[dims.StopSlot, ...]) -> tuple[dims.Groove, ...]:
    if not drive.input_pulleys.grooved:
        return ()
    if not drive.anchored:
        levels = (drive.level_mm + level for level in drive.levels_mm)
        return tuple(_through_groove(drive, *each) for each in zip(drive.cable_names, levels, strict=True))
    most = drive.wound_rad + drive.input_travel_rad / 2
    runs = sorted(drive.cables, key=lambda c: c.step)
    return tuple(
        dims.anchored_groove(drive, slot, stop_of(drive, c), most) for c, slot in zip(runs, slots, strict=True)
    )


def input_pulley(drive: SpurDrive, levels: LandLevels) -> dims.InputPulleyDims:
    """Dimensions of the pulley: one land."""
    slots = _slots(drive, levels) if drive.anchored else ()
    bearings, wheel = drive.bearings, drive.stage is not None
    surface = drive.input_radius_mm - drive.cable.diameter_mm / 2

    def neck(bearing: Bearing) -> float:
        if not drive.anchored:
            return bearing.inner_shoulder_mm / 2
        return dims.neck_radius_mm(bearing.inner_shoulder_mm, stop_of(drive, drive.cables[0]))

    own: dict[str, Any] = {}
    if wheel:
        # The journal ends with the wheel that it carries.
        bottom = levels.motor_shelf_top_z + collar_over_shelf_mm(drive)
        own = {
            "journal_bottom_z": bottom,
            "bore_radius": 0.0,
            "bore_top_z": bottom,
            "slit_width": 0.0,
            "slit_top_z": bottom,
        }
    if drive.encoder.absent:
        own["journal_top_z"] = levels.top_plate_bottom_z + bearings.input_upper.width_mm
    plain = coupled_pulley(
        drive,
        levels,
        name=drive.input_names[0],
        x=0.0,
        lower_neck_radius=neck(bearings.input_lower),
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=surface,
        wall_z=drive.level_mm,
        upper_surface_radius=surface,
        land_top_z=levels.land_top_z,
        upper_neck_radius=neck(bearings.input_upper),
        slots=slots,
        grooves=_grooves(drive, slots),
        **own,
    )
    return overhung_pulley(drive, levels, plain) if drive.overhung else plain


# Metal before and behind the set screws in the hub.
HUB_EDGE_MM = 1.0
# Bore beyond the end of the shaft, and metal that closes the pulley in front of it; a thinner end is bored through.
BEYOND_SHAFT_MM, END_WALL_MM = 0.5, 1.0
# Room round the heads of the motor's screws in their pocket, for the socket of the key beside the wall.
HEAD_ROOM_MM = 0.2
# Play round the head of a horn's own screw in the pulley.
RECESS_MM = 0.3
# Plate between the pocket and the threads of the frame's own screws.
POCKET_WEB_MM = 0.6


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
    """Radius of the hub: that of the land, or more for the length of its set screws; of a flange on a servo's horn."""
    if drive.servo is not None:
        return drive.servo.horn_mm / 2
    return max(crest_mm(drive), drive.gearhead.shaft_diameter_mm / 2 + set_screw(drive).length_mm)


def flange_mm(drive: SpurDrive, servo: Servo) -> float:
    """Thickness of the pulley's flange on a servo's horn: it takes the head of the horn's own screw, and a wall."""
    centre = drive.screw(servo.centre_screw)
    return centre.head_height_mm + RECESS_MM + drive.pulley_material.min_wall_mm


def hub_length_mm(drive: SpurDrive) -> float:
    """Length of the hub between plate and land; with a servo from the plate's front to the heads of the horn's screws.

    These and the flange stay behind the drum's rim.
    """
    servo = drive.servo
    if servo is not None:
        heads = drive.screw(servo.horn_screw).head_height_mm + drive.clearances.running_mm
        return max(servo.horn_face_mm + flange_mm(drive, servo) + heads - drive.support.plate_mm, 0.0)
    return set_screw(drive).thread_mm + 2 * HUB_EDGE_MM


@dataclass(frozen=True)
class MotorSeat:
    """Where the motor, or its gearhead, is screwed on the back of the plate, mm; places are (x, z) in the assembly."""

    pocket_radius: float  # from the front, for the heads of its screws
    shelf: float  # plate left behind the pocket
    pilot_radius: float
    screw_clearance: float
    screws: Places
    # Of a servo, in place of pocket, pilot and clearance holes: half width, lower and upper z of its window; the screws
    # are threads.
    window: tuple[float, float, float] | None = None

    @property
    def reach(self) -> float:
        """Half the width of pocket or window."""
        return self.pocket_radius if self.window is None else self.window[0]

    def lowest_z(self, axis_z: float) -> float:
        """Edge of pocket, or of the window and the threads below it, towards the drum."""
        if self.window is None:
            return axis_z - self.pocket_radius
        return min(self.window[1], *(z - self.screw_clearance for _, z in self.screws))


def servo_middle_mm(drive: SpurDrive, servo: Servo) -> float:
    """Middle of a servo's housing in z: it points away from the drum."""
    return drive.centre_distance_mm + servo.axis_mm


def _servo_seat(drive: SpurDrive, servo: Servo) -> MotorSeat:
    play, middle = drive.clearances.running_mm, servo_middle_mm(drive, servo)
    half = servo.body_mm / 2 + play
    screw = drive.screw(drive.gearhead.screw)
    return MotorSeat(
        pocket_radius=0.0,
        shelf=0.0,
        pilot_radius=0.0,
        screw_clearance=screw.thread_mm / 2,
        screws=tuple(
            (x * servo.hole_width_mm / 2, middle + z * servo.hole_length_mm / 2) for z in (-1, 1) for x in (-1, 1)
        ),
        window=(servo.width_mm / 2 + play, middle - half, middle + half),
    )


def _pocket_radius_mm(drive: SpurDrive) -> float:
    gear = drive.gearhead
    heads = (gear.bolt_circle_mm + drive.screw(gear.screw).head_diameter_mm) / 2 + HEAD_ROOM_MM
    return max(heads, hub_radius_mm(drive) + drive.clearances.running_mm)


def motor_seat(drive: SpurDrive) -> MotorSeat:
    """The seat on the plate."""
    if drive.servo is not None:
        return _servo_seat(drive, drive.servo)
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
    if drive.servo is not None:
        return _servo_flange(drive, drive.servo, edge_mm, thread_mm)
    pocket = _pocket_radius_mm(drive)
    beside = max(body_radius_mm(drive) + drive.clearances.running_mm, pocket + POCKET_WEB_MM) + thread_mm / 2
    reach = pocket + max(drive.support.side_wall_mm / 2, drive.frame_material.min_wall_mm)
    return Flange(half_x=beside + edge_mm, back_y=-reach, front_y=reach, screws=(), dowels=())


def _servo_flange(drive: SpurDrive, servo: Servo, edge_mm: float, thread_mm: float) -> Flange:
    """As :func:`seat_flange`: up to the upper ear, and down to the lower one."""
    wall = max(drive.support.side_wall_mm / 2, drive.frame_material.min_wall_mm)
    reach = servo.ears_mm / 2 + wall
    beside = servo.width_mm / 2 + drive.clearances.running_mm + wall + thread_mm / 2
    return Flange(
        half_x=beside + edge_mm, back_y=servo.axis_mm - reach, front_y=servo.axis_mm + reach, screws=(), dowels=()
    )


def shaft_end_z_mm(drive: SpurDrive, levels: LandLevels) -> float:
    """End of the shaft."""
    return levels.motor_shelf_bottom_z + drive.gearhead.shaft_length_mm


def pulley_bottom_z_mm(drive: SpurDrive, levels: LandLevels) -> float:
    """Where the pulley begins: in the pocket, in front of the screws' heads if it does not fit between them."""
    gear, running = drive.gearhead, drive.clearances.running_mm
    if drive.servo is not None:
        return levels.motor_shelf_bottom_z + drive.servo.horn_face_mm
    screw = drive.screw(gear.screw)
    between = (gear.bolt_circle_mm - screw.head_diameter_mm) / 2 - hub_radius_mm(drive)
    heads = 0.0 if between >= running else screw.head_height_mm
    pilot = max(gear.pilot_height_mm - drive.support.motor_shelf_mm, 0.0)
    return levels.motor_shelf_top_z + max(heads, pilot) + running


def bore_end_z_mm(drive: SpurDrive, levels: LandLevels) -> float:
    """End of the bore: past the shaft's end, or through the pulley."""
    end = shaft_end_z_mm(drive, levels) + BEYOND_SHAFT_MM
    return end if end <= levels.land_top_z - END_WALL_MM else levels.land_top_z


def overhung_pulley(drive: SpurDrive, levels: LandLevels, plain: InputPulleyDims) -> InputPulleyDims:
    """The pulley: a hub and the land of ``plain``, one that has bearings."""
    radius, bottom, servo = hub_radius_mm(drive), pulley_bottom_z_mm(drive, levels), drive.servo
    if servo is not None:
        return _on_horn(drive, servo, levels, plain)
    screw = set_screw(drive)
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
        # Of a pulley further along the drum's axis as near to the motor as with the first, where its shaft is.
        hub=SetHub(screw.name, screw.thread_mm, levels.land_bottom_z - drive.level_mm - hub_length_mm(drive) / 2),
    )


def _on_horn(drive: SpurDrive, servo: Servo, levels: LandLevels, plain: InputPulleyDims) -> InputPulleyDims:
    """A pulley whose flange is screwed on a servo's horn, over the head of the horn's own screw."""
    screw, centre = drive.screw(servo.horn_screw), drive.screw(servo.centre_screw)
    bottom = pulley_bottom_z_mm(drive, levels)
    return replace(
        plain,
        journal_bottom_z=bottom,
        lower_journal_radius=hub_radius_mm(drive),
        lower_neck_bottom_z=bottom + flange_mm(drive, servo),
        lower_neck_radius=plain.lower_land_radius,
        upper_neck_radius=plain.upper_land_radius,
        upper_neck_top_z=levels.land_top_z,
        upper_journal_radius=plain.upper_land_radius,
        journal_top_z=levels.land_top_z,
        bore_radius=centre.head_diameter_mm / 2 + RECESS_MM,
        bore_top_z=bottom + centre.head_height_mm + RECESS_MM,
        slit_width=0.0,
        slit_top_z=bottom,
        horn=HornFlange(screw.name, screw.clearance_mm / 2, screw_places(servo.horn_screws, servo.horn_circle_mm / 2)),
    )


class ServoHorn(Attachment):
    """The horn of a servo, on which the pulley is screwed."""

    block = "servo"

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """The horn with its screws."""
        drive, face = self.layout.drive, self.layout.levels.motor_shelf_bottom_z
        add_horn(b, drive, drive.servo, name, turn @ ALONG_Y, face)
