"""The bill of the assembly: that of siso_spur for each input, turned about the drum's axis, and the shared parts."""

from __future__ import annotations

from math import degrees, radians

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.miso_spur.support.parts import Star
from mbcdm_cad.layouts.siso_spur.bill import (
    ALONG_Y,
    add_drum_bearings,
    add_idlers,
    add_own_input,
    add_own_stage,
    add_sectors,
    add_stop_pin,
    idler_bodies,
    input_bodies,
)
from mbcdm_cad.parts.bill import Bill, BillBuilder, MovingBody, Placement
from mbcdm_cad.parts.drum_sector.items import add_cables, add_drum_encoder
from mbcdm_cad.parts.input_pulley.items import add_horn, add_input_pulley

_Y = (0.0, 1.0, 0.0)


def moving_bodies(lay: RoundDrumLayout) -> tuple[MovingBody, ...]:
    """Drum about +Y and inputs about -Y: theta_i = theta_o r_o/r_i."""
    drive = lay.drive
    bodies = [MovingBody("drum", "drum", (0.0, 0.0, 0.0), _Y)]
    for unit, angle in zip(lay.units, drive.angles_rad, strict=True):
        bodies += [*idler_bodies(unit, angle), *input_bodies(unit.drive, unit.drive.input_names[0], angle)]
    return tuple(bodies)


def bill(lay: RoundDrumLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, star, frame = lay.drive, lay.star, lay.frame
    b = BillBuilder(moving_bodies(lay), drum_angle_deg)
    turns = [Placement.about(_Y, degrees(angle)) for angle in drive.angles_rad]
    b.add("frame", Star(star), material=drive.frame_material)
    add_stop_pin(b, lay.units[0])
    add_drum_bearings(b, lay.units[0])
    add_drum_encoder(b, drive, frame.boss.encoder_pocket_floor_y, frame.boss.screw_circle)
    for unit, turn in zip(lay.units, turns, strict=True):
        add_own_input(b, unit, turn, f"_{unit.drive.input_names[0]}")
        if drive.idlers:
            add_idlers(b, unit, turn, f"_{unit.drive.input_names[0]}")
    add_sectors(b, lay, turns)
    for pulley, turn in zip(lay.inputs, turns, strict=True):
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, turn @ ALONG_Y)
    for unit, turn in zip(lay.units, turns, strict=True):
        add_own_stage(b, unit, unit.inputs[0], turn)
        if drive.servo is not None:
            name = unit.inputs[0].name
            add_horn(b, drive, drive.servo, name, turn @ ALONG_Y, unit.levels.motor_shelf_bottom_z)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()
