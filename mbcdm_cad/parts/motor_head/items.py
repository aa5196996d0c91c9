"""A motor head with gearhead and motor, and the encoder at the other end of the pulley, as items of a bill.

All in the head's frame: Z along the input's axis, from the encoder towards the motor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.parts.bill import BillBuilder
from mbcdm_cad.parts.bought.bodies import EncoderBody
from mbcdm_cad.parts.bought.train import add_train
from mbcdm_cad.parts.drum_sector.items import ENCODER_COLOUR
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.parts.motor_head.dims import HeadDims, HeadedDrive, dowel_length_mm, flange_screw
from mbcdm_cad.parts.motor_head.part import MotorHead
from mbcdm_cad.parts.placement import Placement
from mbcdm_cad.parts.ring import Dowel

_TURNED = Placement.about((1.0, 0.0, 0.0), 180.0)


@dataclass(frozen=True)
class EncoderShelf:
    """The shelf that carries bearing and encoder: its face towards the pulley is ``top_z``; screws sunk in it, mm."""

    bottom_z: float
    top_z: float
    screw_circle: float
    head_depth: float


def _at(stand: Placement, x: float, y: float, z: float) -> Placement:
    return stand @ Placement.translation(x, y, z)


def add_motor_head(b: BillBuilder, drive: HeadedDrive, head: HeadDims, stand: Placement, mark: str = "") -> None:
    """Add the head. ``mark`` in the names distinguishes its items from those of other heads."""
    b.add(f"motor_head{mark}", MotorHead(head), part="motor_head", material=drive.frame_material, place=stand)


def add_flange_fixings(
    b: BillBuilder, drive: HeadedDrive, head: HeadDims, insert: InsertSpec | None, stand: Placement, mark: str = ""
) -> None:
    """Add the dowels and screws of the head on the frame, and the inserts if the frame has no threads of its own.

    ``mark`` as for the head.
    """
    steel, top, pin = drive.material("steel"), head.flange_top_z, dowel_length_mm(drive)
    for n, (x, y) in enumerate(head.flange.dowels, 1):
        b.standard(
            f"dowel{mark}_{n}",
            Dowel(head.dowel_radius, pin),
            part="dowel",
            material=steel,
            place=_at(stand, x, y, top - pin),
        )
    for n, (x, y) in enumerate(head.flange.screws, 1):
        b.screw(f"flange_screw{mark}_{n}", flange_screw(drive), steel, _at(stand, x, y, top))
        if insert is not None:
            b.insert(f"flange_insert{mark}_{n}", insert, drive.material("brass"), _at(stand, x, y, head.bottom_z))


def add_motor(b: BillBuilder, drive: HeadedDrive, face: Placement) -> None:
    """Gearhead and motor of the one input on their shelf, whose face they lie on has its Z towards them."""
    depth = drive.screw(drive.gearhead.screw).length_mm - drive.support.motor_shelf_mm + 1.0
    add_train(b, drive, drive.input_names[0], depth, face @ _TURNED, drive.gearhead_angle_deg)


def add_input_line(b: BillBuilder, drive: HeadedDrive, head: HeadDims, shelf: EncoderShelf, stand: Placement) -> None:
    """Gearhead and motor on the head, encoder, if any, behind its shelf, with their screws; ``drive`` has one input."""
    body, steel = drive.material("stainless"), drive.material("steel")
    gear, encoder = drive.gearhead, drive.encoder
    gear_screw, encoder_screw = drive.screw(gear.screw), drive.screw(encoder.screw)
    name = drive.input_names[0]
    add_motor(b, drive, _at(stand, 0.0, head.beside_y, head.top_z))
    sunk, thick = shelf.head_depth, shelf.top_z - shelf.bottom_z
    encoder_screws = 0 if encoder.absent else 2
    if not encoder.absent:
        b.add(
            f"encoder_{name}",
            EncoderBody(
                encoder, encoder_screw, ENCODER_INSERTION_MM + 0.5, encoder_screw.length_mm - (thick - sunk) + 0.5
            ),
            part="encoder",
            material=replace(body, colour=ENCODER_COLOUR),
            place=_at(stand, 0.0, 0.0, shelf.bottom_z) @ _TURNED,
            mass_g=encoder.mass_g,
        )
    for n in range(max(encoder_screws, len(head.gear_screws))):
        if n < len(head.gear_screws):
            x, y = head.gear_screws[n]
            place = _at(stand, x, y, head.shelf_bottom_z) @ _TURNED
            b.screw(f"{drive.mounted_stem}_screw_{name}_{n + 1}", gear_screw, steel, place)
        if n < encoder_screws:
            place = _at(stand, (-1, 1)[n] * shelf.screw_circle, 0.0, shelf.top_z - sunk)
            b.screw(f"encoder_screw_{name}_{n + 1}", encoder_screw, steel, place)


def add_input_bearings(
    b: BillBuilder, drive: HeadedDrive, head: HeadDims, shelf: EncoderShelf, stand: Placement
) -> None:
    """The pulley's bearings: in the head's flange and in the encoder's shelf, both on the pulley's side."""
    ring, bearings, name = drive.material("bearing-steel"), drive.bearings, drive.input_names[0]
    b.bearing(f"input_bearing_lower_{name}", bearings.input_lower, ring, _at(stand, 0.0, 0.0, head.bottom_z))
    seat = shelf.top_z - bearings.input_upper.width_mm
    b.bearing(f"input_bearing_upper_{name}", bearings.input_upper, ring, _at(stand, 0.0, 0.0, seat))
