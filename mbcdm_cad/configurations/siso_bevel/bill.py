"""What the assembly is made of: every part with the function that draws it, every instance with its place."""

from __future__ import annotations

from dataclasses import replace
from math import radians

from mbcdm_cad.configurations.siso_bevel.drive import DirectDrive
from mbcdm_cad.configurations.siso_bevel.layout import DirectLayout
from mbcdm_cad.configurations.siso_bevel.support.dims import DOWEL_LENGTH_MM, FLANGE_SCREW
from mbcdm_cad.parts.bill import Bill, BillBuilder, MovingBody
from mbcdm_cad.parts.drum_sector.items import ENCODER_COLOUR, add_cables, add_drum, add_drum_encoder, add_preload_spring
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.parts.input_pulley.items import add_input_pulley
from mbcdm_cad.parts.placement import Placement

_X, _Y, _DOWN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)
_ALONG_Y = Placement.about(_X, -90.0)
# Parts of the input are drawn with the gearhead below.
_UPSIDE_DOWN = Placement.about(_X, 180.0)
_SUPPORT = "mbcdm_cad.configurations.siso_bevel.support"
# Linear RGB.
_MOTOR_COLOUR = (0.02, 0.02, 0.025)
_GEARHEAD_COLOUR = (0.22, 0.2, 0.15)


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


def _support(b: BillBuilder, lay: DirectLayout, drive: DirectDrive) -> None:
    steel, metal, frame = drive.material("steel"), drive.support.material, lay.frame
    b.add("frame", f"{_SUPPORT}.frame:create_column", (frame,), material=metal)
    insert = frame.flange_insert
    tapped = replace(
        frame,
        flange_screw_radius=frame.flange_screw_radius if insert else drive.screw(FLANGE_SCREW).tap_drill_mm / 2,
        boss=replace(frame.boss, screw_radius=drive.screw(drive.drum_encoder.screw).tap_drill_mm / 2),
    )
    b.drilled("frame", tapped)
    b.add("motor_head", f"{_SUPPORT}.head:create_head", (lay.head,), material=metal)
    b.add(
        "stop_pin",
        "mbcdm_cad.parts.ring:create_pin",
        (frame.stop_pin_radius, lay.drum.web_end_y + 0.5 - frame.stop_pin_start_y),
        material=steel,
        place=_at(0.0, frame.stop_pin_start_y, frame.stop_pin_z) @ _ALONG_Y,
    )
    top = lay.head.flange_top_z
    for n, (x, y) in enumerate(frame.dowels, 1):
        b.add(
            f"dowel_{n}",
            "mbcdm_cad.parts.ring:create_pin",
            (frame.dowel_radius, DOWEL_LENGTH_MM),
            part="dowel",
            material=steel,
            place=_at(x, y, top - DOWEL_LENGTH_MM),
        )
    for n, (x, y) in enumerate(frame.flange_screws, 1):
        b.screw(f"flange_screw_{n}", drive.screw(FLANGE_SCREW), steel, _at(x, y, top))
        if insert is not None:
            b.insert(f"flange_insert_{n}", insert, drive.material("brass"), _at(x, y, frame.top_z))


def _bearings(b: BillBuilder, lay: DirectLayout, drive: DirectDrive) -> None:
    ring, bearings, shaft = drive.material("bearing-steel"), drive.bearings, lay.drum_shaft
    name = drive.input_names[0]
    b.bearing("drum_bearing_rear", bearings.drum, ring, _at(0.0, shaft.rear_bearing_y, 0.0) @ _ALONG_Y)
    add_preload_spring(b, drive, lay.preload_spring)
    b.bearing("drum_bearing_front", bearings.drum, ring, _at(0.0, shaft.front_bearing_y, 0.0) @ _ALONG_Y)
    b.bearing(f"input_bearing_lower_{name}", bearings.input_lower, ring, _at(0.0, 0.0, lay.head.bottom_z))
    seat = lay.frame.encoder_shelf_top_z - bearings.input_upper.width_mm
    b.bearing(f"input_bearing_upper_{name}", bearings.input_upper, ring, _at(0.0, 0.0, seat))


def _drives(b: BillBuilder, lay: DirectLayout, drive: DirectDrive) -> None:
    body, steel = drive.material("stainless"), drive.material("steel")
    gear, encoder, frame, head = drive.gearhead, drive.encoder, lay.frame, lay.head
    gear_screw, encoder_screw = drive.screw(gear.screw), drive.screw(encoder.screw)
    name = drive.input_names[0]
    b.add(
        f"gearhead_{name}",
        "mbcdm_cad.parts.bought.draw:create_gearhead",
        (gear, gear_screw, gear_screw.length_mm - drive.support.motor_shelf_mm + 1.0),
        part="gearhead",
        material=replace(body, colour=_GEARHEAD_COLOUR),
        place=_at(0.0, 0.0, head.top_z) @ _UPSIDE_DOWN,
        mass_g=gear.mass_g,
    )
    b.add(
        f"motor_{name}",
        "mbcdm_cad.parts.bought.draw:create_motor",
        (drive.motor,),
        part="motor",
        material=replace(body, colour=_MOTOR_COLOUR),
        place=_at(0.0, 0.0, head.top_z + gear.length_mm) @ _UPSIDE_DOWN,
        mass_g=drive.motor.mass_g,
    )
    sunk = frame.encoder_head_depth
    b.add(
        f"encoder_{name}",
        "mbcdm_cad.parts.bought.draw:create_encoder",
        (
            encoder,
            encoder_screw,
            ENCODER_INSERTION_MM + 0.5,
            encoder_screw.length_mm - (drive.support.encoder_shelf_mm - sunk) + 0.5,
        ),
        part="encoder",
        material=replace(body, colour=ENCODER_COLOUR),
        place=_at(0.0, 0.0, frame.encoder_shelf_bottom_z) @ _UPSIDE_DOWN,
        mass_g=encoder.mass_g,
    )
    for n, sign in enumerate((-1, 1), 1):
        place = _at(sign * head.gear_bolt_circle, 0.0, head.shelf_bottom_z) @ _UPSIDE_DOWN
        b.screw(f"gearhead_screw_{name}_{n}", gear_screw, steel, place)
        place = _at(sign * frame.encoder_circle_radius, 0.0, frame.encoder_shelf_top_z - sunk)
        b.screw(f"encoder_screw_{name}_{n}", encoder_screw, steel, place)
    add_drum_encoder(b, drive, frame.boss.encoder_pocket_floor_y, frame.boss.screw_circle)


def bill(lay: DirectLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive = lay.drive
    b = BillBuilder(moving_bodies(lay), drum_angle_deg)
    for section in (_support, _bearings, _drives):
        section(b, lay, drive)
    add_drum(b, drive, lay.drum, lay.drum_shaft)
    for pulley in lay.inputs:
        add_input_pulley(b, drive, pulley, lay.collar, drive.support.material, _UPSIDE_DOWN)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()
