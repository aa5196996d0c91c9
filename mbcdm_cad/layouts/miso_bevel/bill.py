"""The bill of the assembly: every part, every instance with its place.

This module needs no CAD kernel: if all parts are in the cache, a build draws nothing.
"""

from dataclasses import replace
from math import pi, radians
from typing import Any

from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin, steps
from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support import AXLE_SCREW, ENCODER_HEAD_SUNK_MM, dowel_length_mm
from mbcdm_cad.layouts.miso_bevel.support.parts import Frame, TopPlate
from mbcdm_cad.parts.bill import ALONG_Y, UPSIDE_DOWN, AssemblyStep, Bill, BillBuilder, Placement
from mbcdm_cad.parts.bodies import EncoderBody, screw_places
from mbcdm_cad.parts.drum_sector.items import ENCODER_COLOUR, add_cables, add_drum, add_drum_encoder
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.parts.input_pulley.items import UPRIGHT, add_input_pulley, add_train
from mbcdm_cad.parts.terminal import Tensioner
from mbcdm_cad.parts.turned import Axle, Dowel, IdlerPulley, Spacer

# The same, but what points to the front still does.
_TURNED_OVER = Placement.about((0.0, 1.0, 0.0), 180.0)


def _at(x: float, y: float, z: float) -> Placement:
    return Placement.translation(x, y, z)


def _add_support(b: BillBuilder, lay: BevelLayout) -> None:
    """Frame and top plate with what holds them, the guide's axle, and all bearings."""
    drive, v, f = lay.drive, lay.levels, lay.frame
    metal, steel, ring = drive.frame_material, drive.material("steel"), drive.material("bearing-steel")
    b.add("frame", Frame(f), material=metal)
    b.add("top_plate", TopPlate(lay.top_plate), material=metal)
    b.add("guide_axle", Axle(lay.axle), material=drive.axle_material)
    b.add("guide_spacer", Spacer(lay.axle), material=drive.axle_material)
    add_stop_pin(b, lay, f.stop_pin_start_y)
    pin, length = Dowel(f.dowel_radius, dowel_length_mm(drive)), dowel_length_mm(drive)
    for n, (x, y) in enumerate(f.dowels, 1):
        b.standard(f"dowel_{n}", pin, part="dowel", material=steel, place=_at(x, y, v.top_plate_top_z - length))
    plate_screw = plate_screw_of(drive)
    for n, (x, y) in enumerate(f.plate_screws, 1):
        place = _at(x, y, v.top_plate_top_z - lay.top_plate.screw_head_depth)
        b.screw(f"plate_screw_{n}", plate_screw, steel, place)
        if f.plate_insert is not None:
            b.insert(f"plate_insert_{n}", f.plate_insert, drive.material("brass"), _at(x, y, v.top_plate_bottom_z))
    shelf_z, axle_screw = lay.axle_supports_mm[0], drive.screw(AXLE_SCREW)
    place = _at(0.0, f.axle_radius + axle_screw.length_mm, shelf_z) @ ALONG_Y
    b.screw("axle_set_screw", axle_screw, steel, place)
    add_drum_bearings(b, lay)
    guide = drive.bearings.guide
    for end, z in (("lower", v.guide_bottom_z), ("upper", v.guide_top_z - guide.width_mm)):
        b.bearing(f"guide_bearing_{end}", guide, ring, _at(0.0, 0.0, z), "guide")
    for p in lay.inputs:
        low = _at(p.x, p.y, v.bearing_shelf_top_z - drive.shelf_bearing.width_mm)
        high = _at(p.x, p.y, v.top_plate_bottom_z)
        if drive.motors_above:
            low, high = high, low
        b.bearing(f"input_bearing_lower_{p.name}", drive.bearings.input_lower, ring, low)
        b.bearing(f"input_bearing_upper_{p.name}", drive.bearings.input_upper, ring, high)


def _add_drives(b: BillBuilder, lay: BevelLayout) -> None:
    """Gearheads, motors and encoders; in the frame of each input, z runs from the gearhead to the encoder."""
    drive, v = lay.drive, lay.levels.from_gearhead
    body, steel = drive.material("stainless"), drive.material("steel")
    gear, encoder = drive.gearhead, drive.encoder
    gear_screw, encoder_screw = (drive.screw(x.screw) for x in (gear, encoder))
    gear_depth = gear_screw.length_mm - drive.support.motor_shelf_mm + 1.0
    head_depth = encoder_screw.head_height_mm + ENCODER_HEAD_SUNK_MM
    encoder_depth = encoder_screw.length_mm - (drive.encoder_plate_mm - head_depth) + 0.5
    for p in lay.inputs:
        at_input, turn = _at(p.x, p.y, 0.0) @ _stand(drive), drive.turn_deg(p.x)
        add_train(b, drive, p.name, gear_depth, at_input @ _at(0.0, 0.0, v.motor_shelf_bottom_z), turn)
        b.add(
            f"encoder_{p.name}",
            EncoderBody(encoder, encoder_screw, ENCODER_INSERTION_MM + 0.5, encoder_depth),
            part="encoder",
            material=replace(body, colour=ENCODER_COLOUR),
            place=at_input @ _at(0.0, 0.0, v.top_plate_top_z),
            mass_g=encoder.mass_g,
        )
        for n, (x, y) in enumerate(screw_places(gear.screw_count, gear.bolt_circle_mm / 2, turn), 1):
            place = at_input @ _at(x, y, v.motor_shelf_top_z)
            b.screw(f"{drive.mounted}_screw_{p.name}_{n}", gear_screw, steel, place)
        for n, (x, y) in enumerate(screw_places(2, encoder.bolt_circle_mm / 2), 1):
            place = at_input @ _at(x, y, v.top_plate_bottom_z + head_depth) @ UPSIDE_DOWN
            b.screw(f"encoder_screw_{p.name}_{n}", encoder_screw, steel, place)
    add_drum_encoder(b, drive, lay.frame.boss.encoder_pocket_floor_y, lay.frame.boss.screw_circle)


def _stand(drive: BevelDrive) -> Placement:
    """How parts whose heights count from the gearhead stand."""
    return _TURNED_OVER if drive.motors_above else UPRIGHT


def bill(lay: BevelLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    b, drive = BillBuilder(lay.moving_bodies, drum_angle_deg), lay.drive
    _add_support(b, lay)
    _add_drives(b, lay)
    add_drum(b, drive, lay.drum, lay.drum_shaft)
    b.add("guide", IdlerPulley(lay.guide), material=drive.guide_material, group="guide")
    for p in lay.inputs:
        add_input_pulley(b, drive, p, lay.collar, drive.frame_material, _stand(drive))
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()


def steps_of(lay: BevelLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps of the assembly with the sizes of this design.

    Between guide and back plate a swaged terminal finds no way through. With motors above, the lowest shelf may be
    behind a lug of the centred drum.
    """
    drive, above = lay.drive, lay.drive.motors_above
    return steps(
        lay,
        behind_guide=[c.name for c in drive.cables if winding(drive, c).guide_wrap_rad > pi],
        hidden=[t.cable_name for t in lay.drum.tensioners if above and _before_frame(lay, t)],
        axle_screw=AXLE_SCREW,
        plate_screw=plate_screw_of(drive).name,
        **more,
    )


def _before_frame(lay: BevelLayout, t: Tensioner) -> bool:
    """Whether a part of the terminal, drum centred, has the frame behind it."""
    v, half = lay.levels, lay.drive.tensioner.swage_diameter_mm / 2
    ends = [t.at(along, out) for along in (t.swage_start, t.tip) for out in (-half, half)]
    return any(abs(x) < v.side_outer_x and z > v.shelf_bottom_z for x, z in ends)
