"""Frame: walls that can be made, metal round its holes, space; gaps between turning and fixed parts, sectors, box."""

from contextlib import suppress
from math import hypot, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks import motor_head, size, terminals
from mbcdm_cad.checks.bearings import carried_check, input_reactions
from mbcdm_cad.checks.comparison import Comparison, Family, Findings, at_most, check, check_for, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.fixings import STRESS_SAFETY
from mbcdm_cad.checks.geometry import CABLE_GAP_MM, HOLE_WEB_MM, frame_front, rim_points, web_between, wrap_points
from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import PRINTED_WINDUP, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_spur.drive import MOST_SPREAD, SpurDrive
from mbcdm_cad.layouts.siso_spur.idlers import FLANGE_MM
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support import YokeDims, reach_mm
from mbcdm_cad.layouts.siso_spur.support.stiffness import out_of_line_mrad
from mbcdm_cad.parts.bodies import RING_ENCODER_FLATS
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import nut_corner_radius_mm
from mbcdm_cad.parts.fits import SHEAR_SHARE
from mbcdm_cad.parts.motor_head.dims import body_radius_mm, dowel_length_mm, flange_screw

# Space above the pulley that is needed to lead the cable round it (estimate).
WINDING_ROOM_MM = 2.0
# Depth of a mounting screw's thread over its diameter (usual rule).
MOUNT_DIAMETERS = 1.0
# Angle between the rings of a deep-groove ball bearing: makers allow 2 to 10 minutes of arc, by play and load.
OUT_OF_LINE_MRAD = 2.9


_WALL = "material: min_wall_mm"
_SHELVES: tuple[Adjustment, ...] = up(at.support.bearing_shelf_mm, at.support.encoder_shelf_mm)


@check(
    "Walls of frame and motor head are thick enough",
    _WALL,
    *up(at.support.plate_mm, at.support.bridge_mm, at.support.side_wall_mm, at.support.motor_shelf_mm),
    *_SHELVES,
    *up(at.transmission.centre_distance_mm),
)
def walls(s: SpurLayout) -> Findings:
    """The thinnest wall of frame and motor head, against the minimum of the material."""
    support, f = s.drive.support, s.frame
    limit = s.drive.frame_material.min_wall_mm
    names: tuple[str, ...] = ("plate", "bridge", "side_wall", "motor_shelf", "bearing_shelf", "encoder_shelf")
    if s.drive.overhung:
        names = ("plate",) if s.drive.servo else ("plate", "motor_shelf")
    for name in names:
        yield f"support.{name}_mm", getattr(support, f"{name}_mm"), limit
    if s.drive.overhung:
        return
    yield "wall of the motor head", s.head.outer_x - s.head.inner_x, limit
    yield "encoder shelf under its bearing", f.axis_z - f.seat_radius - f.shelf_bottom_z, limit
    yield "encoder shelf beside its bearing", f.shelf_half_width - f.seat_radius, limit
    heads = f.encoder_circle_radius + f.encoder_head_radius
    yield "encoder shelf beside the heads of its screws", f.shelf_half_width - heads, limit


@carried_check("Shelves take the input's bearings", _WALL, *_SHELVES)
def bearing_seats(s: SpurLayout) -> Findings:
    """Shoulders of the shelves behind their bearings."""
    support, bearings, limit = s.drive.support, s.drive.bearings, s.drive.frame_material.min_wall_mm
    for end, shelf, bearing in (
        ("gearhead", support.bearing_shelf_mm, bearings.input_lower),
        ("encoder", support.encoder_shelf_mm, bearings.input_upper),
    ):
        yield f"shoulder of the bearing next to the {end}", shelf - bearing.width_mm, limit


@check(
    "Input and drum turn freely in the frame",
    "clearances.running_mm; 2 mm: estimate",
    *up(at.transmission.centre_distance_mm),
)
def input_room(s: SpurLayout) -> Findings:
    """Pulley and front bearing fit through the plate, the drum clears the shelf, fingers reach round the pulley."""
    drive, f = s.drive, s.frame
    pulley, running = s.inputs[0], drive.clearances.running_mm
    rim = drive.drum_radius_mm + s.flank_mm
    if drive.servo is not None:
        # Where the plate is thicker than the horn's back stands before it, the horn turns in the window.
        servo, plate = drive.servo, drive.support.plate_mm
        before = servo.horn_face_mm - servo.horn_thickness_mm - plate
        beside = f.motor.reach - servo.horn_mm / 2 if f.motor else 0.0
        yield "servo's horn before the plate, or inside its window", max(before, beside), running
        return
    if f.motor is not None:
        what = "pocket of the plate round the hub of the input pulley"
        yield (what, f.motor.pocket_radius - pulley.lower_journal_radius, running)
        return
    over = f.bridge_bottom_z - f.axis_z - max(pulley.lower_land_radius, drive.input_radius_mm + s.flank_mm)
    yield (
        "opening of the plate round the input pulley",
        f.opening_radius - pulley.lower_land_radius,
        0.1 + (drive.cable.diameter_mm if drive.anchored else 0.0),
    )
    yield "opening of the plate round the far bearing", f.opening_radius - f.seat_radius, 0.1
    yield "encoder shelf over the drum's rim and its cable", f.shelf_bottom_z - rim, running
    yield "bridge over the cable on the pulley", over, WINDING_ROOM_MM


def _wall(insert: InsertSpec | None) -> float:
    """Least wall beside a thread, or beside an insert."""
    return insert.wall_mm if insert else HOLE_WEB_MM


@carried_check(
    "Motor head is held and located",
    "usual rule: one diameter",
    *up(at.support.plate_mm),
    *down(at.support.bearing_shelf_mm),
    *up(at.support.side_wall_mm),
)
def flange(s: SpurLayout) -> Findings:
    """Screws and dowels of the motor head engage by their diameter in the plate, with enough metal round them."""
    f, drive, head = s.frame, s.drive, s.head
    screw, shelf, plate = flange_screw(drive), drive.support.bearing_shelf_mm, drive.support.plate_mm
    v = s.levels
    holes: list[tuple[str, float, float, float, float, float]] = [
        ("opening", 0.0, f.axis_z, f.opening_radius, v.plate_back_y, v.front_y),
        ("bearing", 0.0, f.axis_z, head.seat_radius, v.bearing_shelf_bottom_z, v.bearing_shelf_top_z),
    ]
    holes += [("flange screw", x, z, f.flange_screw_radius, v.plate_back_y, v.front_y) for x, z in f.flange_screws]
    holes += [("dowel", x, z, f.dowel_radius, v.plate_back_y, v.plate_back_y + f.dowel_depth) for x, z in f.dowels]
    holes += [("mount", x, z, f.mount_radius, v.plate_back_y, v.front_y) for x, z in f.mounts]
    for stand in f.stands:
        bores = (v.plate_back_y, v.front_y)
        holes += [("idler's axle", side * stand.x, stand.z, stand.axle_radius, *bores) for side in (-1, 1)]
    for name, web in web_between(holes):
        yield f"plate, {name}", web, HOLE_WEB_MM
    into = screw.length_mm - shelf
    reach = max(abs(x) for x, _ in f.flange_screws)
    grip = min(into, f.flange_insert.length_mm) if f.flange_insert else into
    yield "engaged length of a flange screw over its diameter", grip - screw.thread_mm, 0.0
    yield "plate behind the flange screws", plate - into, 0.0
    yield "engaged length of a dowel over its diameter", dowel_length_mm(drive) - shelf - 2 * f.dowel_radius, 0.0
    yield "plate beside a flange screw", f.half_width - reach - f.flange_screw_radius, _wall(f.flange_insert)
    yield "flange beyond its bearing's seat", min(-head.back_y, head.front_y) - head.seat_radius, HOLE_WEB_MM


@check(
    "Mounting threads have metal round them",
    "usual rule: one diameter",
    *up(at.support.plate_mm, at.transmission.centre_distance_mm),
)
def mounts(s: SpurLayout) -> Findings:
    """Mounting threads are deep enough and clear of boss, motor head, stop pin and the edge of the plate."""
    f, plate = s.frame, s.drive.support.plate_mm
    flange_low = f.motor.lowest_z(f.axis_z) if f.motor else f.axis_z + s.head.flange.back_y
    above = "motor's pocket" if f.motor else "motor head's flange"
    yield "mounting thread: depth over the diameter", plate - MOUNT_DIAMETERS * 2 * f.mount_radius, 0.0
    for x, z in f.mounts:
        beside = f.half_width - abs(x) - f.mount_radius
        yield "mounting thread: plate beside the thread", beside, _wall(f.mount_insert)
        yield "mounting thread: drum's boss", (x**2 + z**2) ** 0.5 - f.boss.radius - f.mount_radius, HOLE_WEB_MM
        yield f"mounting thread: {above}", flange_low - z - f.mount_radius, HOLE_WEB_MM
        if f.stop_pin_radius > 0.0:
            pin = (x**2 + (z - f.stop_pin_z) ** 2) ** 0.5 - f.stop_pin_radius - f.mount_radius
            yield "mounting thread: stop pin", pin, HOLE_WEB_MM


@check("Boss takes drum bearings and encoder", _WALL, *down(at.support.back_y_mm))
def boss(s: SpurLayout) -> Findings:
    """Boss of the drum's bearings: the metal of the plate round it, its walls, its ears."""
    f = s.frame
    # The boss of a wide bearing is wider than the plate, which it passes through.
    round_seat = max(f.half_width, f.boss.radius) - f.boss.seat_radius
    yield "plate round the boss", round_seat, s.drive.frame_material.min_wall_mm
    yield "plate before the end of the boss", s.levels.plate_back_y - f.boss.encoder_pocket_floor_y, 0.0
    yield from motor_head.boss_walls(s)


def _long_yoke(s: SpurLayout) -> bool:
    """Whether the yoke reaches further in front of the plate than it is wide; only such a one bends much."""
    f = s.frame
    return f.motor is None and f.levels.top_plate_top_z - f.levels.front_y > 2 * f.shelf_half_width


def _asked_of_yoke(drive: SpurDrive) -> bool:
    layout: Any = layout_of(drive)
    with suppress(NoFigureError):
        return _long_yoke(layout)
    return False


@check(
    "Input's bearings stay in line",
    "bearing makers: 2 to 10 minutes of arc, six times that in plastic: estimate; folded plates; long yokes only",
    *up(at.support.bridge_mm, at.support.plate_mm),
    applies=_asked_of_yoke,
    warn=True,
)
def bearing_line(s: SpurLayout) -> Comparison:
    """Angle between the rings of the input's bearings where the pull of the cables bends plate and yoke."""
    limit = OUT_OF_LINE_MRAD * (PRINTED_WINDUP if s.printed_frame else 1.0)
    if not _long_yoke(s):
        return at_most("rings of the input's bearings: a short yoke holds them in line", 0.0, limit, "mrad")
    _, *loads = (max(each) for each in zip(*s.once("input_reactions", input_reactions), strict=True))
    turns = zip(("lower", "upper"), out_of_line_mrad(s.input_units[0], *loads), strict=True)
    what = "the cables' pull on plate and yoke turns the rings of the input's {} bearing apart by"
    return worst(at_most(what.format(end), turn, limit, "mrad") for end, turn in turns)


SUPPORT = Family(
    "Frame: walls thick enough to be made, metal round its holes, space for pulley, drum and screws.",
    (walls, bearing_seats, motor_head.encoder_shelf, bearing_line, input_room, flange, mounts, boss),
)


# Points on a full circle of the outline.
_CORNERS = 72
_Z: tuple[Adjustment, ...] = (*down(at.transmission.centre_distance_mm), *up(at.transmission.centre_distance_mm))
_APART: tuple[Adjustment, ...] = (*up(at.drum.hub_face_y_mm), *down(at.drum.outer_face_y_mm))


@check("Drum and input clear each other", at.clearances.running_mm, *_Z[1:])
def drum_and_input(s: SpurLayout) -> Findings:
    """Gap between rim and pulley with their cables, and between the rim and the encoder, below or beside it."""
    drive, pulley, running = s.drive, s.inputs[0], s.drive.clearances.running_mm
    rim = drive.drum_radius_mm + s.flank_mm
    own = max(pulley.lower_land_radius, drive.input_radius_mm + s.flank_mm)
    yield "drum's rim from the input pulley, cables on", drive.centre_distance_mm - rim - own, running
    if drive.encoder.absent:
        return
    below = drive.centre_distance_mm - drive.encoder.diameter_mm / 2 - rim
    # The rim of the last of several sectors.
    beside = s.levels.top_plate_top_z - drive.band_mm - s.drum.lands[-1].y_end
    yield "drum's rim from the encoder, below or beside it", max(below, beside), running


@check(
    "Motor clears the drum's boss and encoder",
    at.clearances.running_mm,
    *up(at.transmission.centre_distance_mm, at.support.coupling_space_mm),
)
def bodies_behind(s: SpurLayout) -> Findings:
    """Gap between motor or gearhead and the parts of the drum behind the plate: boss and encoder."""
    drive, boss = s.drive, s.frame.boss
    beside = max(boss.reach, drive.drum_encoder.diameter_mm / 2)
    running, servo = drive.clearances.running_mm, drive.servo
    reach = body_radius_mm(drive) if servo is None else servo.ears_mm / 2 - servo.axis_mm
    gap = drive.centre_distance_mm + s.head.beside_y - reach - beside
    behind = s.levels.back_y - s.levels.motor_shelf_bottom_z
    yield "motor from the drum's boss and encoder, beside or behind them", max(gap, behind), running
    if s.stage is not None:
        # The box of the wheels is wider than a motor.
        box = drive.centre_distance_mm + s.head.back_y - beside
        yield "motor head from the drum's boss and encoder", box, running


def outline(s: SpurLayout, f: YokeDims, d: DrumDims) -> NDArray[np.float64]:
    """Points (n, 2) in x and z that bound the box of one input with its sector, the input above the drum; mm."""
    drive = s.drive
    # The plate alone bears a motor that carries the pulley.
    beside, wide_head, front = 0.0, f.half_width, f.plate_top_z
    if f.motor is None:
        beside, wide_head, front = s.head.beside_y, s.head.outer_x, f.axis_z + s.head.front_y
    sector = [
        rim_points(d),
        wrap_points(d, s.flank_mm),
        *(o for t in d.tensioners for _, o, _, _ in terminals.bodies_of(s, t, moved=False)),
    ]
    encoder = drive.drum_encoder.diameter_mm / 2
    bodies = body_radius_mm(drive)
    wide, low = max(f.half_width, f.boss.ear_reach, encoder), max(f.half_width, d.hub_radius)
    flats = encoder * RING_ENCODER_FLATS
    reach = [(-wide, 0.0), (wide, 0.0), (0.0, -low), (0.0, -flats), (0.0, front)]
    # Motor, gearhead and encoder are round, and the frame's upper corners are rounded.
    angle = np.linspace(0.0, 2 * np.pi, _CORNERS + 1)
    circle = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    corner = np.array([f.half_width, f.plate_top_z]) + f.corner_radius * (circle[: _CORNERS // 4 + 1] - 1.0)
    round_bodies = np.array([0.0, f.axis_z]) + drive.encoder.diameter_mm / 2 * circle
    motor = np.array([0.0, f.axis_z + beside]) + bodies * circle
    heads = np.array([(x, front) for x in (-wide_head, wide_head)])
    return np.concatenate(
        [*sector, np.array(reach), corner, corner * np.array([-1.0, 1.0]), round_bodies, motor, heads]
    )


def box_mm(s: SpurLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v, angles = s.levels, s.drive.angles_rad[: len(s.input_units)]
    # All sectors have the terminals of the first, except for their take-up.
    own = outline(s, s.frame, s.drum)
    cloud = np.concatenate([own @ [[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in angles])
    wide, high = cloud.max(axis=0) - cloud.min(axis=0)
    # The encoder of a common input stands before all its cables, one of several inputs before its own.
    last = s.drive.levels_mm[-1]
    front = max(v.hub_face_y + last, v.encoder_top_z + (last - s.drive.band_mm))
    return float(wide), float(high), front - min(v.motor_bottom_z, v.back_y)


_sectors_check = check_for(lambda drive: len(drive.angles_rad) > 1)


@_sectors_check("Gap between sectors on the shaft", at.clearances.running_mm, *_APART)
def sectors_apart(s: SpurLayout) -> Findings:
    """Rims, terminals and the stop pin of a sector stay behind the rim of the next.

    So do cables on a common input, and idlers on a common axle.
    """
    d, pitch = s.drum, s.drive.pitch_mm
    nut, lug = nut_corner_radius_mm(s.drive), d.lug_half_width
    next_rear = pitch + min(d.lands[0].y_start, d.web_start_y, *(t.y_mm - max(nut, lug) for t in d.tensioners))
    front = max(d.lands[-1].y_end, d.web_end_y + 0.5, *(t.y_mm + nut for t in d.tensioners))
    yield "a sector from the next on the shaft", next_rear - front, s.drive.clearances.running_mm
    if s.drive.parallel == 1:
        return
    if s.drive.idlers is not None:
        gap = pitch - s.drive.idlers.width_mm - 2 * FLANGE_MM
        yield "an idler from the next on its axle", gap, s.drive.clearances.running_mm
    yield "a cable on the input from the next", pitch - 2 * reach_mm(s.drive), CABLE_GAP_MM


@_sectors_check(
    "Stress in the dowels between the hubs",
    "material: yield_MPa; 1.5: usual rule",
    *down(at.loads.peak_torque_Nm),
    *up(at.drum.hub_diameter_mm),
    unit="times",
)
def hub_dowels(s: SpurLayout) -> Findings:
    """The dowels between the last two hubs transmit the torque of all other sectors, motors stalled."""
    drive, pins, metal = s.drive, s.dowels, s.drive.drum_material
    torque = drive.between_hubs_Nm
    force = torque * 1e3 / pins.circle_radius / len(pins.face_angles_deg)
    shear, pressed = force / (pi * pins.radius**2), force / (2 * pins.radius * min(pins.face_depth, pins.back_depth))
    steel = drive.material("steel").yield_MPa
    what = f"at {torque:.4g} N m"
    yield f"shear strength over the hub dowels' {shear:.4g} MPa {what}", SHEAR_SHARE * steel / shear, STRESS_SAFETY
    yield (
        f"yield of {metal.name} over the {pressed:.4g} MPa in the dowels' holes {what}",
        metal.yield_MPa / pressed,
        STRESS_SAFETY,
    )


@_sectors_check("Walls round the dowels in the hub", "usual rule", *up(at.drum.hub_diameter_mm, at.drum.hub_face_y_mm))
def dowel_holes(s: SpurLayout) -> Findings:
    """Walls from the dowels' holes to bore, rim of the hub, payload's threads and set screws.

    In the face the holes are opposite the set screws.
    """
    d, pins = s.drum, s.dowels
    near = pins.circle_radius - pins.radius
    screw = s.drive.screw(d.set_screw).thread_mm / 2
    # The nearest payload hole, an eighth of a turn away.
    payload = 2 * pins.circle_radius * 0.3826834 - pins.radius - d.payload_hole / 2
    rooms = [
        ("bore", near - d.bore_radius),
        ("outside of the hub", d.hub_radius - pins.circle_radius - pins.radius),
        ("payload's thread", payload),
        ("set screw", d.set_screw_y - screw - d.hub_start_y - pins.back_depth),
    ]
    if pins.face_angles_deg == pins.back_angles_deg:
        rooms.append(("next one", d.hub_face_y - pins.face_depth - d.hub_start_y - pins.back_depth))
    for name, room in rooms:
        yield f"hub dowel from the {name}", room, HOLE_WEB_MM


@check(
    "Parallel cables share the load",
    "model: EA, length, pitch of the stud, fits of the lands; a quarter of a flat: estimate",
    *up(at.rope.preload_N),
    advice="a drum.spring under the nuts, a longer span, less travel or less ratio lower it",
    applies=lambda drive: drive.parallel > 1,
    warn=True,
)
def parallel_spread(s: SpurLayout) -> Comparison:
    """What setting by nuts and lands of unequal radii change of a preload, over it."""
    tight = s.loads.peak_forward[s.loads.si.sigma > 0]
    return at_most(
        "preloads off by a quarter of a flat of a nut and lands of unequal radii, over the preload",
        hypot(s.by_nut, s.by_lands),
        MOST_SPREAD,
        "of preload",
        f"nut {s.by_nut:.1%}, lands {s.by_lands:.1%} at the end of the travel (RSS, tolerances of the drawings); "
        f"checks count {s.preload_spread:.1%}, with which the tightest of {s.drive.parallel} cables carries "
        f"{tight.max() / tight.mean() - 1:.1%} more than their mean at peak torque",
    )


_X: tuple[Adjustment, ...] = (*down(at.drum.sector_half_angle_deg), *up(at.drum.sector_half_angle_deg))
_Y: tuple[Adjustment, ...] = (*down(at.support.coupling_space_mm), *up(at.support.coupling_space_mm))
BOX = (*size.box_checks(box_mm, at.targets.envelope_mm, (_X, _Z, _Y)), size.mass_estimate)
GAPS = (frame_front, drum_and_input, bodies_behind)
DOWELS = (hub_dowels, dowel_holes)
ROOM = Family(
    "Gaps between turning and fixed parts, several sectors on one shaft, and the box compared with its target.",
    (*GAPS, sectors_apart, *DOWELS, parallel_spread, *BOX),
)
