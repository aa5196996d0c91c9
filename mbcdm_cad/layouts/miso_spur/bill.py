"""The bill of the assembly: that of siso_spur for each input, turned about the drum's axis, and the shared parts."""

from math import degrees, radians
from typing import Any

from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.miso_spur.support.parts import Star
from mbcdm_cad.layouts.siso_spur.bill import add_idlers, add_own_input, add_sectors
from mbcdm_cad.layouts.siso_spur.bill import steps_of as of_axes
from mbcdm_cad.parts.bill import ALONG_Y, AssemblyStep, Bill, BillBuilder, Placement
from mbcdm_cad.parts.drum_sector.items import add_cables, add_drum_encoder
from mbcdm_cad.parts.input_pulley.items import add_input_pulley

_Y = (0.0, 1.0, 0.0)


def bill(lay: RoundDrumLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, star, frame = lay.drive, lay.star, lay.frame
    b = BillBuilder(lay.moving_bodies, drum_angle_deg)
    turns = [Placement.about(_Y, degrees(angle)) for angle in drive.angles_rad]
    b.add("frame", Star(star), material=drive.frame_material)
    add_stop_pin(b, lay.unit, lay.levels.plate_back_y)
    add_drum_bearings(b, lay.unit)
    add_drum_encoder(b, drive, frame.boss.encoder_pocket_floor_y, frame.boss.screw_circle)
    for unit, turn in zip(lay.units, turns, strict=True):
        add_own_input(b, unit, turn, f"_{unit.drive.input_names[0]}")
        add_idlers(b, unit, turn, f"_{unit.drive.input_names[0]}")
    add_sectors(b, lay, turns)
    for pulley, turn in zip(lay.inputs, turns, strict=True):
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, turn @ ALONG_Y)
    for unit, turn in zip(lay.units, turns, strict=True):
        for each in unit.attachments:
            each.add_on_input(b, unit.inputs[0].name, turn)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()


def steps_of(lay: RoundDrumLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps of the assembly with the sizes of this design."""
    mm = {c.name: c.cut_length_m * 1e3 for c in lay.tensioning.cables} if lay.tensioning else {}
    units = zip(lay.units, lay.drive.input_names, strict=True)
    cuts = (f", {sum(mm[side.name] for side in unit.drive.cables):.1f} mm for {name}" for unit, name in units)
    return of_axes(lay, cuts="".join(cuts), **more)
