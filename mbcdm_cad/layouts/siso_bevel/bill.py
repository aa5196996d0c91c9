"""The bill of the assembly: every part, every instance with its place."""

from __future__ import annotations

from math import radians

from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support.parts import ColumnFrame
from mbcdm_cad.parts.bill import Bill, BillBuilder, MovingBody, Placement
from mbcdm_cad.parts.drum_sector.items import add_cables, add_drum, add_drum_encoder, add_preload_spring
from mbcdm_cad.parts.input_pulley.items import UPRIGHT, add_input_pulley
from mbcdm_cad.parts.motor_head.part import (
    EncoderShelf,
    add_flange_fixings,
    add_input_bearings,
    add_input_line,
    add_motor_head,
)
from mbcdm_cad.parts.turned import Pin

_X, _Y, _DOWN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)
_ALONG_Y = Placement.about(_X, -90.0)
# Parts of the input are drawn with the gearhead below.
_UPSIDE_DOWN = Placement.about(_X, 180.0)


def moving_bodies(lay: DirectLayout) -> tuple[MovingBody, ...]:
    """Drum about +Y and input about -Z: theta_m = theta_o r_o/r_m."""
    run, origin = lay.drive.cables[0], (0.0, 0.0, 0.0)
    name = f"input_{lay.drive.input_names[0]}"
    return (
        MovingBody("drum", "drum", origin, _Y),
        MovingBody(name, "input", origin, _DOWN, run.drum_radius_mm, run.input_radius_mm),
    )


def _at(x: float, y: float, z: float) -> Placement:
    return Placement.translation(x, y, z)


def _shelf(lay: DirectLayout) -> EncoderShelf:
    f = lay.frame
    return EncoderShelf(f.encoder_shelf_bottom_z, f.encoder_shelf_top_z, f.encoder_circle_radius, f.encoder_head_depth)


def _support(b: BillBuilder, lay: DirectLayout, drive: DirectDrive) -> None:
    steel, metal, frame = drive.material("steel"), drive.frame_material, lay.frame
    b.add("frame", ColumnFrame(frame), material=metal)
    add_motor_head(b, drive, lay.head, UPRIGHT)
    b.add(
        "stop_pin",
        Pin(frame.stop_pin_radius, lay.drum.web_end_y + 0.5 - frame.stop_pin_start_y),
        material=steel,
        place=_at(0.0, frame.stop_pin_start_y, frame.stop_pin_z) @ _ALONG_Y,
    )
    add_flange_fixings(b, drive, lay.head, frame.flange_insert, UPRIGHT)


def _bearings(b: BillBuilder, lay: DirectLayout, drive: DirectDrive) -> None:
    ring, bearings, shaft = drive.material("bearing-steel"), drive.bearings, lay.drum_shaft
    b.bearing("drum_bearing_rear", bearings.drum, ring, _at(0.0, shaft.rear_bearing_y, 0.0) @ _ALONG_Y)
    add_preload_spring(b, drive, lay.preload_spring)
    b.bearing("drum_bearing_front", bearings.drum, ring, _at(0.0, shaft.front_bearing_y, 0.0) @ _ALONG_Y)
    add_input_bearings(b, drive, lay.head, _shelf(lay), UPRIGHT)


def bill(lay: DirectLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive = lay.drive
    b = BillBuilder(moving_bodies(lay), drum_angle_deg)
    for section in (_support, _bearings):
        section(b, lay, drive)
    add_input_line(b, drive, lay.head, _shelf(lay), UPRIGHT)
    add_drum_encoder(b, drive, lay.frame.boss.encoder_pocket_floor_y, lay.frame.boss.screw_circle)
    add_drum(b, drive, lay.drum, lay.drum_shaft)
    for pulley in lay.inputs:
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, _UPSIDE_DOWN)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()
