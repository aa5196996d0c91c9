"""The bill of the assembly: every part, every instance with its place.

This module needs no CAD kernel: if all parts are in the cache, a build draws nothing.
"""

from dataclasses import replace
from math import pi, radians
from typing import Any

from mbcdm_cad.design.bought import Bearing, Screw
from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin, steps
from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support import AXLE_SCREW, ENCODER_HEAD_SUNK_MM, dowel_length_mm
from mbcdm_cad.layouts.miso_bevel.support.parts import Frame, TopPlate
from mbcdm_cad.parts.bill import ALONG_Y, FIXED, UPSIDE_DOWN, AssemblyStep, Bill, BillBuilder, Placement
from mbcdm_cad.parts.bodies import EncoderBody, screw_places
from mbcdm_cad.parts.drum_sector.items import ENCODER_COLOUR, add_cables, add_drum, add_drum_encoder
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.parts.input_pulley.items import UPRIGHT, add_input_pulley, add_train
from mbcdm_cad.parts.terminal import Tensioner
from mbcdm_cad.parts.turned import Axle, Dowel, IdlerPulley, Spacer

# The same, but what points to the front still does.
_TURNED_OVER = Placement.about((0.0, 1.0, 0.0), 180.0)


class _Builder(BillBuilder):
    """Knows the layout and what bought parts are made of."""

    def __init__(self, layout: BevelLayout, drum_angle_deg: float) -> None:
        super().__init__(layout.moving_bodies, drum_angle_deg)
        self.layout = layout
        self.drive: BevelDrive = layout.drive

    def steel_screw(self, name: str, screw: Screw, place: Placement, group: str = FIXED) -> None:
        """A screw of the catalogue's steel."""
        self.screw(name, screw, self.drive.material("steel"), place, group)

    def steel_bearing(self, name: str, bearing: Bearing, place: Placement, group: str = FIXED) -> None:
        """A bearing of the catalogue's bearing steel."""
        self.bearing(name, bearing, self.drive.material("bearing-steel"), place, group)


def _at(x: float, y: float, z: float) -> Placement:
    return Placement.translation(x, y, z)


def _support(b: _Builder) -> None:
    lay, drive, v = b.layout, b.drive, b.layout.levels
    metal = drive.frame_material
    head = drive.screw(drive.encoder.screw)
    insert = lay.frame.plate_insert
    b.add("frame", Frame(lay.frame), material=metal)
    b.add(
        "top_plate", TopPlate(lay.top_plate, head.head_diameter_mm / 2 + 0.1, head.head_height_mm + 0.2), material=metal
    )
    steel = drive.axle_material
    b.add("guide_axle", Axle(lay.axle), material=steel)
    b.add("guide_spacer", Spacer(lay.axle), material=steel)
    add_stop_pin(b, lay, lay.frame.stop_pin_start_y)
    for n, (x, y) in enumerate(lay.frame.dowels, 1):
        b.standard(
            f"dowel_{n}",
            Dowel(lay.frame.dowel_radius, dowel_length_mm(drive)),
            part="dowel",
            material=drive.material("steel"),
            place=_at(x, y, v.top_plate_top_z - dowel_length_mm(drive)),
        )
    plate_screw = plate_screw_of(drive)
    for n, (x, y) in enumerate(lay.frame.plate_screws, 1):
        b.steel_screw(f"plate_screw_{n}", plate_screw, _at(x, y, v.top_plate_top_z - lay.top_plate.screw_head_depth))
        if insert is not None:
            b.insert(f"plate_insert_{n}", insert, drive.material("brass"), _at(x, y, v.top_plate_bottom_z))
    shelf_z = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    axle_screw = drive.screw(AXLE_SCREW)
    b.steel_screw(
        "axle_set_screw", axle_screw, _at(0.0, lay.frame.axle_radius + axle_screw.length_mm, shelf_z) @ ALONG_Y
    )


def _bearings(b: _Builder) -> None:
    lay, v, bearings = b.layout, b.layout.levels, b.drive.bearings
    add_drum_bearings(b, lay)
    b.steel_bearing("guide_bearing_lower", bearings.guide, _at(0.0, 0.0, v.guide_bottom_z), "guide")
    b.steel_bearing(
        "guide_bearing_upper", bearings.guide, _at(0.0, 0.0, v.guide_top_z - bearings.guide.width_mm), "guide"
    )
    shelf_z, plate_z = v.bearing_shelf_top_z, v.top_plate_bottom_z
    for p in lay.inputs:
        low = _at(p.x, p.y, shelf_z - b.drive.shelf_bearing.width_mm)
        high = _at(p.x, p.y, plate_z)
        if b.drive.motors_above:
            low, high = high, low
        b.steel_bearing(f"input_bearing_lower_{p.name}", bearings.input_lower, low)
        b.steel_bearing(f"input_bearing_upper_{p.name}", bearings.input_upper, high)


def _drives(b: _Builder) -> None:
    """Gearheads, motors and encoders; in the frame of each input, z runs from the gearhead to the encoder."""
    lay, drive, v = b.layout, b.drive, b.layout.levels.from_gearhead
    body = drive.material("stainless")
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
        # Sorted by number, since the order of the items is that in the files.
        gear_places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, turn)
        encoder_places = screw_places(2, encoder.bolt_circle_mm / 2)
        for n in range(max(len(gear_places), len(encoder_places))):
            if n < len(gear_places):
                x, y = gear_places[n]
                at = at_input @ _at(x, y, v.motor_shelf_top_z)
                b.steel_screw(f"{drive.mounted}_screw_{p.name}_{n + 1}", gear_screw, at)
            if n < len(encoder_places):
                x, y = encoder_places[n]
                place = at_input @ _at(x, y, v.top_plate_bottom_z + head_depth) @ UPSIDE_DOWN
                b.steel_screw(f"encoder_screw_{p.name}_{n + 1}", encoder_screw, place)
    add_drum_encoder(b, drive, lay.frame.boss.encoder_pocket_floor_y, lay.frame.boss.screw_circle)


def _stand(drive: BevelDrive) -> Placement:
    """How parts whose heights count from the gearhead stand."""
    return _TURNED_OVER if drive.motors_above else UPRIGHT


def _pulleys(b: _Builder) -> None:
    lay, drive = b.layout, b.drive
    b.add("guide", IdlerPulley(lay.guide), material=drive.guide_material, group="guide")
    for p in lay.inputs:
        add_input_pulley(b, drive, p, lay.collar, drive.frame_material, _stand(drive))


def bill(layout: BevelLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    b = _Builder(layout, drum_angle_deg)
    for section in (_support, _bearings, _drives):
        section(b)
    add_drum(b, b.drive, layout.drum, layout.drum_shaft)
    _pulleys(b)
    add_cables(b, b.drive, layout.cable_paths(radians(drum_angle_deg)))
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
