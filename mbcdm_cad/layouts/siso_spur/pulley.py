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

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.bought import Bearing, Screw, Servo
from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.layouts.siso_spur.cable_path import stop_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, contact_rad, groove_depth_mm, groove_run_out_rad
from mbcdm_cad.layouts.siso_spur.routes import turned
from mbcdm_cad.parts.bill import ALONG_Y, BillBuilder, MovingBody, Placement
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.coupling import Belt, Wheel, belt_bottom_mm, collar_over_shelf_mm
from mbcdm_cad.parts.drum_sector.design import LandLevels
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.input_pulley.dims import HornFlange, InputPulleyDims, SetHub
from mbcdm_cad.parts.input_pulley.items import add_horn
from mbcdm_cad.parts.motor_head.dims import Flange, Places, body_radius_mm

if TYPE_CHECKING:
    pass


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
        own = dict.fromkeys(("journal_bottom_z", "bore_top_z", "slit_top_z"), bottom)
        own |= {"bore_radius": 0.0, "slit_width": 0.0}
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
    return without_bearings(drive).pulley(levels, plain) if drive.overhung else plain


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


class OnShaft:
    """A pulley that the shaft of motor or gearhead alone carries: its hub, and the motor's seat on the plate."""

    def __init__(self, drive: SpurDrive) -> None:
        self.drive = drive

    @property
    def set_screw(self) -> Screw:
        """The set screw, two of which hold the pulley on the shaft."""
        return _set_screw(self.drive.screws, crest_mm(self.drive) - self.drive.gearhead.shaft_diameter_mm / 2)

    @property
    def hub_radius_mm(self) -> float:
        """Radius of the hub: that of the land, or more for the length of its set screws."""
        return max(crest_mm(self.drive), self.drive.gearhead.shaft_diameter_mm / 2 + self.set_screw.length_mm)

    @property
    def hub_length_mm(self) -> float:
        """Length of the hub between plate and land."""
        return self.set_screw.thread_mm + 2 * HUB_EDGE_MM

    @property
    def _pocket_radius_mm(self) -> float:
        gear = self.drive.gearhead
        heads = (gear.bolt_circle_mm + self.drive.screw(gear.screw).head_diameter_mm) / 2 + HEAD_ROOM_MM
        return max(heads, self.hub_radius_mm + self.drive.clearances.running_mm)

    @property
    def seat(self) -> MotorSeat:
        """The seat on the plate."""
        drive, gear, z = self.drive, self.drive.gearhead, self.drive.centre_distance_mm
        places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, drive.gearhead_angle_deg)
        return MotorSeat(
            pocket_radius=self._pocket_radius_mm,
            shelf=drive.support.motor_shelf_mm,
            pilot_radius=gear.pilot_diameter_mm / 2,
            screw_clearance=drive.screw(gear.screw).clearance_mm / 2,
            # Angles seen from the front; the gearhead is drawn as seen from its face.
            screws=tuple((x, z - y + 0.0) for x, y in places),
        )

    def flange(self, edge_mm: float, thread_mm: float) -> Flange:
        """Outline of the plate round the seat; the frame's own screws stand beside motor and pocket.

        ``edge_mm``: from the axis of such a screw to the plate's edge; ``thread_mm``: its hole.
        """
        drive, pocket = self.drive, self._pocket_radius_mm
        beside = max(body_radius_mm(drive) + drive.clearances.running_mm, pocket + POCKET_WEB_MM) + thread_mm / 2
        reach = pocket + max(drive.support.side_wall_mm / 2, drive.frame_material.min_wall_mm)
        return Flange(half_x=beside + edge_mm, back_y=-reach, front_y=reach, screws=(), dowels=())

    def shaft_end_z_mm(self, levels: LandLevels) -> float:
        """End of the shaft."""
        return levels.motor_shelf_bottom_z + self.drive.gearhead.shaft_length_mm

    def bottom_z_mm(self, levels: LandLevels) -> float:
        """Where the pulley begins: in the pocket, in front of the screws' heads if it does not fit between them."""
        gear, running = self.drive.gearhead, self.drive.clearances.running_mm
        screw = self.drive.screw(gear.screw)
        between = (gear.bolt_circle_mm - screw.head_diameter_mm) / 2 - self.hub_radius_mm
        heads = 0.0 if between >= running else screw.head_height_mm
        pilot = max(gear.pilot_height_mm - self.drive.support.motor_shelf_mm, 0.0)
        return levels.motor_shelf_top_z + max(heads, pilot) + running

    def pulley(self, levels: LandLevels, plain: InputPulleyDims) -> InputPulleyDims:
        """The pulley: a hub and the land of ``plain``, one that has bearings."""
        bottom = self.bottom_z_mm(levels)
        return replace(
            plain,
            journal_bottom_z=bottom,
            lower_journal_radius=self.hub_radius_mm,
            upper_neck_radius=plain.upper_land_radius,
            upper_neck_top_z=levels.land_top_z,
            upper_journal_radius=plain.upper_land_radius,
            journal_top_z=levels.land_top_z,
            slit_width=0.0,
            slit_top_z=bottom,
            **self._hub(levels, plain),
        )

    def _hub(self, levels: LandLevels, plain: InputPulleyDims) -> dict[str, Any]:
        """The bore goes past the shaft's end, or through the pulley."""
        screw, end = self.set_screw, self.shaft_end_z_mm(levels) + BEYOND_SHAFT_MM
        # Of a pulley further along the drum's axis as near to the motor as with the first, where its shaft is.
        screw_z = levels.land_bottom_z - self.drive.level_mm - self.hub_length_mm / 2
        return {
            "lower_neck_bottom_z": levels.land_bottom_z,
            "lower_neck_radius": self.hub_radius_mm,
            "bore_radius": self.drive.gearhead.shaft_diameter_mm / 2,
            "bore_top_z": end if end <= levels.land_top_z - END_WALL_MM else levels.land_top_z,
            "hub": SetHub(screw.name, screw.thread_mm, screw_z),
        }


class OnHorn(OnShaft):
    """A pulley whose flange is screwed on a servo's horn, over the head of the horn's own screw."""

    def __init__(self, drive: SpurDrive, servo: Servo) -> None:
        super().__init__(drive)
        self.servo = servo

    @property
    def hub_radius_mm(self) -> float:
        """Radius of the flange."""
        return self.servo.horn_mm / 2

    @property
    def _flange_mm(self) -> float:
        """Thickness of the flange: it takes the head of the horn's own screw, and a wall."""
        centre = self.drive.screw(self.servo.centre_screw)
        return centre.head_height_mm + RECESS_MM + self.drive.pulley_material.min_wall_mm

    @property
    def hub_length_mm(self) -> float:
        """From the plate's front to the heads of the horn's screws: they and the flange stay behind the drum's rim."""
        drive = self.drive
        heads = drive.screw(self.servo.horn_screw).head_height_mm + drive.clearances.running_mm
        return max(self.servo.horn_face_mm + self._flange_mm + heads - drive.support.plate_mm, 0.0)

    @property
    def seat(self) -> MotorSeat:
        """The window in the plate; the servo's housing points away from the drum."""
        drive, servo, play = self.drive, self.servo, self.drive.clearances.running_mm
        half, middle = servo.body_mm / 2 + play, drive.centre_distance_mm + servo.axis_mm
        wide, long = servo.hole_width_mm / 2, servo.hole_length_mm / 2
        return MotorSeat(
            pocket_radius=0.0,
            shelf=0.0,
            pilot_radius=0.0,
            screw_clearance=drive.screw(drive.gearhead.screw).thread_mm / 2,
            screws=tuple((x * wide, middle + z * long) for z in (-1, 1) for x in (-1, 1)),
            window=(servo.width_mm / 2 + play, middle - half, middle + half),
        )

    def flange(self, edge_mm: float, thread_mm: float) -> Flange:
        """See the base class: up to the upper ear, and down to the lower one."""
        drive, servo = self.drive, self.servo
        wall = max(drive.support.side_wall_mm / 2, drive.frame_material.min_wall_mm)
        half_x = servo.width_mm / 2 + drive.clearances.running_mm + wall + thread_mm / 2 + edge_mm
        back, front = (servo.axis_mm + sign * (servo.ears_mm / 2 + wall) for sign in (-1, 1))
        return Flange(half_x=half_x, back_y=back, front_y=front, screws=(), dowels=())

    def bottom_z_mm(self, levels: LandLevels) -> float:
        """On the horn."""
        return levels.motor_shelf_bottom_z + self.servo.horn_face_mm

    def _hub(self, levels: LandLevels, plain: InputPulleyDims) -> dict[str, Any]:
        servo, bottom = self.servo, self.bottom_z_mm(levels)
        screw, centre = self.drive.screw(servo.horn_screw), self.drive.screw(servo.centre_screw)
        places = screw_places(servo.horn_screws, servo.horn_circle_mm / 2)
        return {
            "lower_neck_bottom_z": bottom + self._flange_mm,
            "lower_neck_radius": plain.lower_land_radius,
            "bore_radius": centre.head_diameter_mm / 2 + RECESS_MM,
            "bore_top_z": bottom + centre.head_height_mm + RECESS_MM,
            "horn": HornFlange(screw.name, screw.clearance_mm / 2, places),
        }


def without_bearings(drive: SpurDrive) -> OnShaft:
    """What carries the pulley of a drive whose inputs have no bearings of their own."""
    return OnShaft(drive) if drive.servo is None else OnHorn(drive, drive.servo)


class ServoHorn(Attachment):
    """The horn of a servo, on which the pulley is screwed."""

    block = "servo"

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """The horn with its screws."""
        drive, face = self.layout.drive, self.layout.levels.motor_shelf_bottom_z
        add_horn(b, drive, drive.servo, name, turn @ ALONG_Y, face)


# Linear RGB.
_RUBBER = (0.015, 0.015, 0.017)


class BeltOrGears(Attachment):
    """The driving wheel stands beyond the input, as seen from the drum."""

    block = "stage"

    def moving_bodies(self, body: MovingBody) -> Iterator[MovingBody]:
        """The driving wheel of an input."""
        drive = self.layout.drive
        if body.kind == "input":
            name = body.name.removeprefix("input_")
            angle = drive.angles_rad[drive.input_names.index(name)]
            at = turned(angle, 0.0, drive.centre_distance_mm + drive.stage.centre_mm)
            turns = body.numerator_mm * drive.stage.ratio * drive.stage.sense
            yield MovingBody(f"driver_{name}", "stage", at, body.axis, turns, body.denominator_mm)

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """Both wheels, and the belt."""
        drive, dims = self.layout.drive, self.layout.stage
        metal = drive.material("aluminium-7075" if dims.stage.is_belt else "steel")
        at = turn @ ALONG_Y @ Placement.translation(0.0, 0.0, dims.bottom_z)
        for part, spec, body in (("driven", dims.driven, "input"), ("driver", dims.driver, "driver")):
            b.add(
                f"stage_{part}_{name}",
                Wheel(spec),
                part=f"stage_{part}",
                material=metal,
                group=f"{body}_{name}",
                place=at,
                mass_g=dims.mass_g(spec),
            )
        if dims.belt is not None:
            # The belt is drawn with the driver at +Y; turned, it is away from the drum.
            stand = turn @ Placement.translation(0.0, 0.0, drive.centre_distance_mm) @ ALONG_Y
            bottom = Placement.translation(0.0, 0.0, dims.bottom_z + belt_bottom_mm())
            b.add(
                f"stage_belt_{name}",
                Belt(dims.belt),
                part="stage_belt",
                material=replace(drive.material("stainless"), colour=_RUBBER),
                place=stand @ Placement.about((0.0, 0.0, 1.0), 180.0) @ bottom,
                mass_g=dims.mass_g(dims.belt),
            )
