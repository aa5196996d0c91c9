"""An input as items of a bill: pulley, clamp collar, stops of its cables; the motor with its gearhead, or alone."""

from dataclasses import replace
from math import cos, degrees, sin

from mbcdm_cad.design.bought import Material, Servo
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.parts.bill import ALONG_Y, BillBuilder, Placement
from mbcdm_cad.parts.bodies import GearheadBody, HornBody, MotorBody, MotorWithShaft, ServoBody
from mbcdm_cad.parts.coupling import Collar, CollarDims
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.input_pulley.dims import SET_SCREWS_DEG, InputPulleyDims, SetHub
from mbcdm_cad.parts.input_pulley.part import InputPulley
from mbcdm_cad.parts.turned import Sleeve

UPRIGHT = Placement.identity()


def _add_set_screws(b: BillBuilder, drive: SectorDrive, pulley: InputPulleyDims, hub: SetHub, stand: Placement) -> None:
    """The set screws of a pulley on a motor's shaft, their points on the shaft."""
    screw = drive.screw(hub.screw)
    out = pulley.bore_radius + screw.length_mm
    for n, deg in enumerate(SET_SCREWS_DEG, 1):
        turn = Placement.about((0.0, 0.0, 1.0), deg)
        place = turn @ Placement.translation(out, 0.0, hub.screw_z) @ Placement.about((0.0, 1.0, 0.0), 90.0)
        b.screw(
            f"pulley_set_screw_{pulley.name}_{n}", screw, drive.material("steel"), stand @ place, f"input_{pulley.name}"
        )


def add_input_pulley(
    b: BillBuilder,
    drive: SectorDrive,
    pulley: InputPulleyDims,
    collar: CollarDims,
    collar_metal: Material,
    stand: Placement = UPRIGHT,
) -> None:
    """Pulley, collar with its screw and stops, in the frame of the pulley's group; ``stand`` turns all of them in it.

    Dimensions of pulley and collar have their heights along +Z, the gearhead below.
    """
    group = f"input_{pulley.name}"
    b.add(
        f"input_pulley_{pulley.name}",
        InputPulley(pulley),
        material=drive.pulley_material,
        drilled=None
        if pulley.hub is None
        else InputPulley(replace(pulley, hub=replace(pulley.hub, thread=drive.screw(pulley.hub.screw).tap_drill_mm))),
        group=group,
        place=stand,
    )
    if pulley.horn is not None:
        screw, top = drive.screw(pulley.horn.screw), pulley.lower_neck_bottom_z
        for n, (x, y) in enumerate(pulley.horn.places, 1):
            at = stand @ Placement.translation(x, y, top)
            b.screw(f"flange_screw_{pulley.name}_{n}", screw, drive.material("steel"), at, group)
        return
    if pulley.hub is not None:
        _add_set_screws(b, drive, pulley, pulley.hub, stand)
        return
    screw = drive.screw(collar.screw)
    b.add(
        f"collar_{pulley.name}",
        Collar(collar, screw.thread_mm, screw.clearance_mm, screw.head_diameter_mm),
        part="collar",
        drilled=Collar(collar, screw.tap_drill_mm, screw.clearance_mm, screw.head_diameter_mm),
        material=collar_metal,
        group=group,
        place=stand,
    )
    middle = Placement.translation(collar.screw_offset, collar.head_seat, (collar.bottom_z + collar.top_z) / 2)
    b.screw(f"collar_screw_{pulley.name}", screw, drive.material("steel"), stand @ middle @ ALONG_Y, group)
    for slot in pulley.slots:
        # A stop is drawn along +Z from its end next to the bend, and laid on the chord.
        a, away = slot.end_angle_rad, slot.away * slot.chord_offset
        x, y = slot.stop_start * cos(a) - away * sin(a), slot.stop_start * sin(a) + away * cos(a)
        turn = Placement.about((0.0, 0.0, 1.0), degrees(a) + 180.0) @ Placement.about((0.0, 1.0, 0.0), 90.0)
        b.add(
            f"stop_{slot.cable_name}",
            Sleeve(drive.cable.diameter_mm / 2, slot.stop_radius, slot.stop_start - slot.stop_end),
            part="stop",
            material=drive.material("stainless"),
            group=group,
            place=stand @ Placement.translation(x, y, slot.chord_z) @ turn,
        )


# Linear RGB.
_MOTOR_COLOUR = (0.02, 0.02, 0.025)
_GEARHEAD_COLOUR = (0.22, 0.2, 0.15)


def add_train(b: BillBuilder, drive: Drive, name: str, hole_depth_mm: float, face: Placement, turn_deg: float) -> None:
    """Gearhead and motor of input ``name`` behind ``face``, whose z points to the shaft's end; or the motor alone.

    ``hole_depth_mm``: depth of the tapped holes in the face; ``turn_deg``: how far both are turned about their axis.
    """
    if drive.cable_stage is not None:
        return  # parts of its own
    if drive.servo is not None:
        _add_servo(b, drive, drive.servo, name, face)
        return
    face = face @ Placement.about((0.0, 0.0, 1.0), turn_deg)
    body, gear, motor = drive.material("stainless"), drive.gearhead, drive.motor
    screw, black = drive.screw(gear.screw), replace(body, colour=_MOTOR_COLOUR)
    if gear.absent:
        b.add(
            f"motor_{name}",
            MotorWithShaft(motor, gear, screw, hole_depth_mm),
            part="motor",
            material=black,
            place=face,
            mass_g=motor.mass_g,
        )
        return
    b.add(
        f"gearhead_{name}",
        GearheadBody(gear, screw, hole_depth_mm),
        part="gearhead",
        material=replace(body, colour=_GEARHEAD_COLOUR),
        place=face,
        mass_g=gear.mass_g,
    )
    b.add(
        f"motor_{name}",
        MotorBody(motor),
        part="motor",
        material=black,
        place=face @ Placement.translation(0.0, 0.0, -gear.length_mm),
        mass_g=motor.mass_g,
    )


def _add_servo(b: BillBuilder, drive: Drive, servo: Servo, name: str, face: Placement) -> None:
    """Servo with its ears on ``face``."""
    place = face @ Placement.about((0.0, 0.0, 1.0), -90.0)
    hole = drive.screw(drive.gearhead.screw).clearance_mm / 2
    black = replace(drive.material("stainless"), colour=_MOTOR_COLOUR)
    b.add(
        f"servo_{name}",
        ServoBody(drive.motor, servo, hole, drive.screw(servo.centre_screw)),
        part="servo",
        material=black,
        place=place,
        mass_g=drive.motor.mass_g,
    )


def add_horn(b: BillBuilder, drive: Drive, servo: Servo, name: str, stand: Placement, face_z: float) -> None:
    """Horn of a servo with its own screw, in the group of its pulley; ``face_z``: the ears' front along the pulley."""
    at, group = stand @ Placement.translation(0.0, 0.0, face_z), f"input_{name}"
    centre, thread = drive.screw(servo.centre_screw), drive.screw(servo.horn_screw).thread_mm / 2
    metal = replace(drive.material("stainless"), colour=_GEARHEAD_COLOUR)
    b.add(
        f"horn_{name}",
        HornBody(drive.motor, servo, thread, centre),
        part="horn",
        material=metal,
        group=group,
        place=at,
        mass_g=0.0,
    )
    top = at @ Placement.translation(0.0, 0.0, servo.horn_face_mm)
    b.screw(f"horn_screw_{name}", centre, drive.material("steel"), top, group)


def train_words(drive: Drive) -> str:
    """Name of the assembly that is screwed on for one input, for texts."""
    return "gearhead with its motor" if drive.mounted == "gearhead" else drive.mounted
