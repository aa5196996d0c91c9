"""The bill of the assembly: every part, every instance with its place."""

from math import radians
from typing import Any

from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin, steps
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support.parts import ColumnFrame
from mbcdm_cad.parts.bill import UPSIDE_DOWN, AssemblyStep, Bill, BillBuilder
from mbcdm_cad.parts.drum_sector.items import add_cables, add_drum, add_drum_encoder
from mbcdm_cad.parts.input_pulley.items import UPRIGHT, add_input_pulley
from mbcdm_cad.parts.motor_head import part
from mbcdm_cad.parts.motor_head.dims import flange_screw

# Parts of the input are drawn with the gearhead below.


def bill(lay: DirectLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, head, f = lay.drive, lay.head, lay.frame
    b = BillBuilder(lay.moving_bodies, drum_angle_deg)
    b.add("frame", ColumnFrame(f), material=drive.frame_material)
    part.add_motor_head(b, drive, head, UPRIGHT)
    add_stop_pin(b, lay, f.stop_pin_start_y)
    part.add_flange_fixings(b, drive, head, f.flange_insert, UPRIGHT)
    add_drum_bearings(b, lay)
    shelf = part.EncoderShelf(
        f.encoder_shelf_bottom_z, f.encoder_shelf_top_z, f.encoder_circle_radius, f.encoder_head_depth
    )
    part.add_input_bearings(b, drive, head, shelf, UPRIGHT)
    part.add_input_line(b, drive, head, shelf, UPRIGHT)
    add_drum_encoder(b, drive, f.boss.encoder_pocket_floor_y, f.boss.screw_circle)
    add_drum(b, drive, lay.drum, lay.drum_shaft)
    for pulley in lay.inputs:
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, UPSIDE_DOWN)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()


def steps_of(lay: DirectLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps of the assembly with the sizes of this design."""
    return steps(lay, flange=flange_screw(lay.drive).name, **more)
