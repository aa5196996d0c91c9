"""Bill of the assembly: every part, every instance with its placement."""

from math import degrees, radians, tau
from typing import Any

from mbcdm_cad.checks.bearings import stage_torque_Nm
from mbcdm_cad.design.stage import SET_TENSION
from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin, steps
from mbcdm_cad.layouts.siso_spur.idlers import strap_screw
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.pulley import without_bearings
from mbcdm_cad.parts.bill import AGAINST_Y, ALONG_Y, AssemblyStep, Bill, BillBuilder, Placement
from mbcdm_cad.parts.drum_sector import items
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.input_pulley.items import add_input_pulley
from mbcdm_cad.parts.motor_head import part
from mbcdm_cad.parts.motor_head.dims import flange_screw
from mbcdm_cad.parts.turned import Dowel

_at = Placement.translation


def _add_fixed_at_input(b: BillBuilder, lay: SpurLayout, turn: Placement, mark: str = "") -> None:
    """Add the fixed items at the one input of ``lay``, turned by ``turn`` about the drum's axis.

    ``mark`` distinguishes its items from those of other inputs.
    """
    drive, f, v = lay.drive, lay.frame, lay.levels
    if f.mount_insert is not None:
        for n, (x, z) in enumerate(f.mounts, 1):
            # The insert is set from behind, the side from which the screw is driven.
            place = turn @ _at(x, lay.levels.plate_back_y, z) @ AGAINST_Y
            b.insert(f"mount_insert{mark}_{n}", f.mount_insert, drive.material("brass"), place)
    # Z of the motor head points away from the pulley, to the back.
    stand = turn @ _at(0.0, 0.0, f.axis_z) @ AGAINST_Y
    if f.motor is not None:
        part.add_motor(b, drive, stand @ _at(0.0, 0.0, -v.motor_shelf_bottom_z))
        for n, (x, z) in enumerate(f.motor.screws, 1):
            place = turn @ _at(x, v.motor_shelf_top_z, z) @ ALONG_Y
            if drive.servo is not None:
                place = turn @ _at(x, v.plate_back_y - drive.servo.ear_mm, z) @ AGAINST_Y
            name = f"{drive.mounted_stem}_screw_{drive.input_names[0]}_{n}"
            b.screw(name, drive.screw(drive.gearhead.screw), drive.material("steel"), place)
        return
    shelf = part.EncoderShelf(
        f.encoder_shelf_bottom_z, f.encoder_shelf_top_z, f.encoder_circle_radius, f.encoder_head_depth
    )
    part.add_motor_head(b, drive, lay.head, stand, mark)
    part.add_flange_fixings(b, drive, lay.head, f.flange_insert, stand, mark)
    part.add_input_bearings(b, drive, lay.head, shelf, stand)
    part.add_input_line(b, drive, lay.head, shelf, stand)


def _add_sectors(b: BillBuilder, lay: SpurLayout, turns: list[Placement]) -> None:
    """Add several sectors, hub on hub, the dowels between them, and the shaft, which the last hub holds.

    ``turns``: of each sector about the drum's axis.
    """
    drive, d, pins = lay.drive, lay.drum, lay.dowels
    screw, names = drive.screw(d.set_screw), drive.sector_names
    stands = [turn @ _at(0.0, level, 0.0) for turn, level in zip(turns, drive.levels_mm, strict=True)]
    for unit, stand, name in zip(lay.units, stands, names, strict=True):
        b.add(
            f"drum_{name}",
            DrumSector(d, screw.thread_mm),
            part="drum",
            drilled=items.drilled_drum(d, screw),
            material=drive.drum_material,
            group="drum",
            place=stand,
        )
        items.add_terminals(b, drive, unit.drum, stand)
    for stand, name in zip(stands[:-1], names[:-1], strict=True):
        for n, (x, z) in enumerate(pins.places(pins.face_angles_deg), 1):
            b.standard(
                f"hub_dowel_{name}_{n}",
                Dowel(pins.radius, pins.length),
                part="hub_dowel",
                material=drive.material("steel"),
                group="drum",
                place=stand @ _at(x, d.hub_face_y - pins.face_depth, z) @ ALONG_Y,
            )
    items.add_output(b, drive, d, lay.drum_shaft, stands[-1])


def bill(lay: SpurLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, boss = lay.drive, lay.frame.boss
    b = BillBuilder(lay.moving_bodies, drum_angle_deg)
    b.add("frame", lay.frame_part, material=drive.frame_material)
    add_stop_pin(b, lay, lay.levels.plate_back_y)
    add_drum_bearings(b, lay)
    turns = [Placement.about((0.0, 1.0, 0.0), degrees(angle)) for angle in drive.angles_rad]
    inputs = list(zip(lay.input_units, turns, drive.input_names, strict=False))
    for unit, turn, name in inputs:
        mark = f"_{name}" if len(inputs) > 1 else ""
        _add_fixed_at_input(b, unit, turn, mark)
        for each in unit.attachments:
            each.add_at_input(b, turn, mark)
    items.add_drum_encoder(b, drive, boss.encoder_pocket_floor_y, boss.screw_circle)
    if len(turns) == 1:
        items.add_drum(b, drive, lay.drum, lay.drum_shaft)
    else:
        _add_sectors(b, lay, turns)
    for pulley, (unit, turn, name) in zip(lay.inputs, inputs, strict=True):
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, turn @ ALONG_Y)
        for each in unit.attachments:
            each.add_on_input(b, name, turn)
    items.add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    for each in lay.attachments:
        each.add_items(b, drum_angle_deg)
    return b.bill()


def steps_of(lay: SpurLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps of the assembly of a layout with parallel axes, with the sizes of this design."""
    drive = lay.drive
    figures = {
        "based": True,
        "tau": tau,
        "flange": flange_screw(drive).name,
        "strap_screw": strap_screw(drive).name if drive.idlers else "",
        "set_screw": without_bearings(drive).set_screw.name if drive.overhung else "",
        "span_N": lambda unit: SET_TENSION * unit.drive.stage.force_N(stage_torque_Nm(unit)),
    }
    return steps(lay, **figures | more)
