"""Bill of the assembly: every part, every instance with its placement."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import radians

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, SpurRun
from mbcdm_cad.layouts.siso_spur.idlers import SENSE
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.routes import turned
from mbcdm_cad.layouts.siso_spur.support.idlers import SPACER_NOTE, Strap, strap_screw
from mbcdm_cad.layouts.siso_spur.support.parts import Yoke
from mbcdm_cad.parts.bill import Bill, BillBuilder, MovingBody, Placement, Vector
from mbcdm_cad.parts.coupling import Belt, Wheel, belt_bottom_mm
from mbcdm_cad.parts.drum_sector.items import (
    add_cables,
    add_drum,
    add_drum_encoder,
    add_output,
    add_preload_spring,
    add_terminals,
    drilled_drum,
)
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.input_pulley.items import add_horn, add_input_pulley
from mbcdm_cad.parts.motor_head.part import (
    EncoderShelf,
    add_flange_fixings,
    add_input_bearings,
    add_input_line,
    add_motor,
    add_motor_head,
)
from mbcdm_cad.parts.turned import Axle, Dowel, IdlerPulley, Pin, Spacer

_X, _Y, _Z, _BACK = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)
# Linear RGB.
_RUBBER = (0.015, 0.015, 0.017)
# Parts on the drum's axis and on the input's axis are drawn along Z with the gearhead below.
ALONG_Y = Placement.about(_X, -90.0)
_TO_BACK = Placement.about(_X, 90.0)


def moving_bodies(lay: SpurLayout) -> tuple[MovingBody, ...]:
    """Drum about +Y, idlers about +Y against it, input about -Y, with open spans +Y: theta_i = theta_o r_o/r_i."""
    drive = lay.drive
    inputs = input_bodies(drive, drive.input_names[0], 0.0)
    attached = (body for each in lay.attachments for body in each.moving_bodies())
    return MovingBody("drum", "drum", (0.0, 0.0, 0.0), _Y), *idler_bodies(lay, 0.0), *inputs, *attached


def idler_bodies(lay: SpurLayout, angle_rad: float) -> Iterator[MovingBody]:
    """The idlers of an input at this angle about Y, from +Z towards +X."""
    drive = lay.drive
    for body, _, (cable, n) in lay.idlers if drive.idlers else ():
        x, _, z = _idler_axis(drive, cable, n)
        yield MovingBody(
            body, "passed", turned(angle_rad, x, z), _Y, SENSE * drive.drum_radius_mm, drive.leading.radius_mm
        )


def input_bodies(drive: SpurDrive, name: str, angle_rad: float) -> tuple[MovingBody, ...]:
    """An input at this angle about Y, from +Z towards +X, and the driving wheel of its stage, if it has one."""

    def at(distance_mm: float) -> Vector:
        return turned(angle_rad, 0.0, distance_mm)

    ratio, distance, stage = (drive.drum_radius_mm, drive.input_radius_mm), drive.centre_distance_mm, drive.stage
    axis = _Y if drive.open_spans else _BACK
    body = MovingBody(f"input_{name}", "input", at(distance), axis, *ratio)
    if stage is None:
        return (body,)
    turns = ratio[0] * stage.ratio * stage.sense
    return body, MovingBody(f"driver_{name}", "stage", at(distance + stage.centre_mm), axis, turns, ratio[1])


def _idler_axis(drive: SpurDrive, cable: SpurRun, number: int) -> tuple[float, float, float]:
    place = drive.idler_places[number]
    return cable.drum_side * place.x_mm, 0.0, place.z_mm


def _at(x: float, y: float, z: float) -> Placement:
    return Placement.translation(x, y, z)


def add_stop_pin(b: BillBuilder, lay: SpurLayout) -> None:
    """Pin in the plate, through the slot of the sector; none of a drum that turns further."""
    if not lay.drive.stopped:
        return
    v, frame = lay.levels, lay.frame
    b.add(
        "stop_pin",
        Pin(frame.stop_pin_radius, lay.drum.web_end_y + 0.5 - v.plate_back_y),
        material=lay.drive.material("steel"),
        place=_at(0.0, v.plate_back_y, frame.stop_pin_z) @ ALONG_Y,
    )


def add_drum_bearings(b: BillBuilder, lay: SpurLayout) -> None:
    """Both bearings of the drum's shaft with their spring."""
    drive, shaft = lay.drive, lay.drum_shaft
    ring, bearing = drive.material("bearing-steel"), drive.bearings.drum
    b.bearing("drum_bearing_rear", bearing, ring, _at(0.0, shaft.rear_bearing_y, 0.0) @ ALONG_Y)
    add_preload_spring(b, drive, lay.preload_spring)
    b.bearing("drum_bearing_front", bearing, ring, _at(0.0, shaft.front_bearing_y, 0.0) @ ALONG_Y)


def add_own_input(b: BillBuilder, lay: SpurLayout, turn: Placement, mark: str = "") -> None:
    """Add the fixed items at the one input of ``lay``, turned by ``turn`` about the drum's axis.

    ``mark`` distinguishes its items from those of other inputs.
    """
    drive, f, v = lay.drive, lay.frame, lay.levels
    if f.mount_insert is not None:
        for n, (x, z) in enumerate(f.mounts, 1):
            # The insert is set from behind, the side from which the screw is driven.
            place = turn @ _at(x, lay.levels.plate_back_y, z) @ _TO_BACK
            b.insert(f"mount_insert{mark}_{n}", f.mount_insert, drive.material("brass"), place)
    # Z of the motor head points away from the pulley, to the back.
    stand = turn @ _at(0.0, 0.0, f.axis_z) @ _TO_BACK
    if f.motor is not None:
        add_motor(b, drive, stand @ _at(0.0, 0.0, -v.motor_shelf_bottom_z))
        for n, (x, z) in enumerate(f.motor.screws, 1):
            place = turn @ _at(x, v.motor_shelf_top_z, z) @ ALONG_Y
            if drive.servo is not None:
                place = turn @ _at(x, v.plate_back_y - drive.servo.ear_mm, z) @ _TO_BACK
            name = f"{drive.mounted_stem}_screw_{drive.input_names[0]}_{n}"
            b.screw(name, drive.screw(drive.gearhead.screw), drive.material("steel"), place)
        return
    shelf = EncoderShelf(f.encoder_shelf_bottom_z, f.encoder_shelf_top_z, f.encoder_circle_radius, f.encoder_head_depth)
    add_motor_head(b, drive, lay.head, stand, mark)
    add_flange_fixings(b, drive, lay.head, f.flange_insert, stand, mark)
    add_input_bearings(b, drive, lay.head, shelf, stand)
    add_input_line(b, drive, lay.head, shelf, stand)


def add_own_stage(b: BillBuilder, lay: SpurLayout, pulley: InputPulleyDims, turn: Placement) -> None:
    """Add the wheels of an input's stage and its belt; ``turn`` as for the input's fixed items."""
    drive, dims, name = lay.drive, lay.stage, pulley.name
    if dims is None:
        return
    metal = drive.material("aluminium-7075" if dims.stage.is_belt else "steel")
    along, up = turn @ ALONG_Y, Placement.translation(0.0, 0.0, dims.bottom_z)
    for part, spec, group in (("driven", dims.driven, f"input_{name}"), ("driver", dims.driver, f"driver_{name}")):
        b.add(
            f"stage_{part}_{name}",
            Wheel(spec),
            part=f"stage_{part}",
            material=metal,
            group=group,
            place=along @ up,
            mass_g=dims.mass_g(spec),
        )
    if dims.belt is not None:
        # The belt is drawn with the driver at +Y; turned, it is away from the drum.
        stand = turn @ _at(0.0, 0.0, drive.centre_distance_mm) @ ALONG_Y @ Placement.about(_Z, 180.0)
        b.add(
            f"stage_belt_{name}",
            Belt(dims.belt),
            part="stage_belt",
            material=replace(drive.material("stainless"), colour=_RUBBER),
            place=stand @ Placement.translation(0.0, 0.0, dims.bottom_z + belt_bottom_mm()),
            mass_g=dims.mass_g(dims.belt),
        )


def add_idlers(b: BillBuilder, lay: SpurLayout, turn: Placement, mark: str = "") -> None:
    """Idlers with their bearings, which turn with them, axles and spacers, and the straps with their screws.

    ``turn`` and ``mark`` as for the input's fixed items.
    """
    drive, spec, steel = lay.drive, lay.drive.idler_bearing, lay.drive.material("steel")
    screw, ring = strap_screw(drive), drive.material("bearing-steel")
    for pin in lay.pins:
        at = drive.idler_places[pin.number]
        where = turn @ _at(pin.side * at.x_mm, 0.0, at.z_mm)
        tags = [body.removeprefix("idler_") for body in pin.bodies]
        pulley, between, metal = IdlerPulley(pin.idlers[0], "Idler"), lay.axle_of(pin, 0), drive.shaft_material
        b.add(f"idler_axle_{tags[0]}", Axle(between, "Idler axle"), material=metal, place=where @ ALONG_Y)
        for k, (tag, body, own) in enumerate(zip(tags, pin.bodies, pin.idlers, strict=True)):
            # Those of one axle are equal, and so are the spacers between them.
            level, last = _at(0.0, drive.levels_mm[k], 0.0), k == len(tags) - 1
            b.add(body, pulley, part=pin.bodies[0], material=drive.drum_material, group=body, place=level @ ALONG_Y)
            b.bearing(f"idler_bearing_rear_{tag}", spec, ring, _at(0.0, own.bottom_z, 0.0) @ ALONG_Y, body)
            b.bearing(
                f"idler_bearing_front_{tag}", spec, ring, _at(0.0, own.top_z - spec.width_mm, 0.0) @ ALONG_Y, body
            )
            b.add(
                f"idler_spacer_{tag}",
                Spacer(lay.axle_of(pin, k) if last else between, "Idler spacer", SPACER_NOTE),
                part=f"idler_spacer_{tag if last else tags[0]}",
                material=metal,
                place=where @ ALONG_Y if last else where @ level @ ALONG_Y,
            )
    for n, stand in enumerate(lay.frame.stands, 1):
        b.add(f"idler_strap{mark}_{n}", Strap(stand), material=drive.frame_material, place=turn)
        for k, side in enumerate((-1, 1), 1):
            place = turn @ _at(side * stand.screw_x, stand.strap_front_y, stand.screw_z) @ ALONG_Y
            b.screw(f"idler_strap_screw{mark}_{n}_{k}", screw, steel, place)


def add_sectors(b: BillBuilder, lay: SpurLayout, turns: list[Placement]) -> None:
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
            drilled=drilled_drum(d, screw),
            material=drive.drum_material,
            group="drum",
            place=stand,
        )
        add_terminals(b, drive, unit.drum, stand)
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
    add_output(b, drive, d, lay.drum_shaft, stands[-1])


def bill(lay: SpurLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, f = lay.drive, lay.frame
    b = BillBuilder(moving_bodies(lay), drum_angle_deg)
    b.add("frame", Yoke(f), material=drive.frame_material)
    add_stop_pin(b, lay)
    add_drum_bearings(b, lay)
    add_own_input(b, lay, Placement.identity())
    if drive.idlers:
        add_idlers(b, lay, Placement.identity())
    add_drum_encoder(b, drive, f.boss.encoder_pocket_floor_y, f.boss.screw_circle)
    if drive.parallel == 1:
        add_drum(b, drive, lay.drum, lay.drum_shaft)
    else:
        add_sectors(b, lay, [Placement.identity()] * drive.parallel)
    for pulley in lay.inputs:
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, ALONG_Y)
        add_own_stage(b, lay, pulley, Placement.identity())
        if drive.servo is not None:
            add_horn(b, drive, drive.servo, pulley.name, ALONG_Y, lay.levels.motor_shelf_bottom_z)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    for each in lay.attachments:
        each.add_items(b, drum_angle_deg)
    return b.bill()
