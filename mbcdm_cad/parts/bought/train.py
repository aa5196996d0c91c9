"""The motor of an input with its gearhead, or alone: items of the bill, and texts."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.parts.bill import BillBuilder
from mbcdm_cad.parts.bought.bodies import GearheadBody, MotorBody, MotorWithShaft
from mbcdm_cad.parts.placement import Placement

# Linear RGB.
_MOTOR_COLOUR = (0.02, 0.02, 0.025)
_GEARHEAD_COLOUR = (0.22, 0.2, 0.15)


def add_train(b: BillBuilder, drive: Drive, name: str, hole_depth_mm: float, face: Placement, turn_deg: float) -> None:
    """Gearhead and motor of input ``name`` behind ``face``, whose z points to the shaft's end; or the motor alone.

    ``hole_depth_mm``: depth of the tapped holes in the face; ``turn_deg``: how far both are turned about their axis.
    """
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


def train_items(drive: Drive, name: str) -> tuple[str, ...]:
    """Names of the items of one input: gearhead and motor, or the motor alone."""
    return (f"motor_{name}",) if drive.gearhead.absent else (f"gearhead_{name}", f"motor_{name}")


def train_words(drive: Drive) -> str:
    """Name of the assembly that is screwed on for one input, for texts."""
    return "motor" if drive.gearhead.absent else "gearhead with its motor"
