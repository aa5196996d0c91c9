"""The motor of an input with its gearhead, or alone: items of the bill, and texts."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.design.bought import Servo
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.parts.bill import BillBuilder
from mbcdm_cad.parts.bodies import GearheadBody, HornBody, MotorBody, MotorWithShaft, ServoBody
from mbcdm_cad.parts.placement import Placement

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
