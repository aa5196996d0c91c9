"""Frame: walls thick enough to be made, metal round its holes, space for pulley, drum and screws."""

from contextlib import suppress
from typing import Any

from mbcdm_cad.checks.bearings import carried_check, input_reactions
from mbcdm_cad.checks.comparison import Comparison, Findings, at_most, check, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up, ups
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, web_between
from mbcdm_cad.checks.motor_head import boss_walls, encoder_shelf
from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import PRINTED_WINDUP, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.stiffness import out_of_line_mrad
from mbcdm_cad.parts.motor_head.dims import dowel_length_mm, flange_screw

# Space above the pulley that is needed to lead the cable round it (estimate).
WINDING_ROOM_MM = 2.0
# Depth of a mounting screw's thread over its diameter (usual rule).
MOUNT_DIAMETERS = 1.0
# Angle between the rings of a deep-groove ball bearing: makers allow 2 to 10 minutes of arc, by play and load.
OUT_OF_LINE_MRAD = 2.9


_WALL = "material: min_wall_mm"
_SHELVES: tuple[Adjustment, ...] = (up(at.support.bearing_shelf_mm), up(at.support.encoder_shelf_mm))


@check(
    "Walls of frame and motor head are thick enough",
    _WALL,
    *ups(at.support.plate_mm, at.support.bridge_mm, at.support.side_wall_mm, at.support.motor_shelf_mm),
    *_SHELVES,
    up(at.transmission.centre_distance_mm),
)
def walls(s: SpurLayout) -> Findings:
    """The thinnest wall of frame and motor head, against the minimum of the material."""
    support, f = s.drive.support, s.frame
    limit = s.drive.frame_material.min_wall_mm
    names: tuple[str, ...] = (
        "plate_mm",
        "bridge_mm",
        "side_wall_mm",
        "motor_shelf_mm",
        "bearing_shelf_mm",
        "encoder_shelf_mm",
    )
    if s.drive.overhung:
        names = ("plate_mm",) if s.drive.servo else ("plate_mm", "motor_shelf_mm")
    for name in names:
        yield f"support.{name}", getattr(support, name), limit
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
    up(at.transmission.centre_distance_mm),
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
    up(at.support.plate_mm),
    down(at.support.bearing_shelf_mm),
    up(at.support.side_wall_mm),
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
    *ups(at.support.plate_mm, at.transmission.centre_distance_mm),
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


@check("Boss takes drum bearings and encoder", _WALL, down(at.support.back_y_mm))
def boss(s: SpurLayout) -> Findings:
    """Boss of the drum's bearings: the metal of the plate round it, its walls, its ears."""
    f = s.frame
    # The boss of a wide bearing is wider than the plate, which it passes through.
    round_seat = max(f.half_width, f.boss.radius) - f.boss.seat_radius
    yield "plate round the boss", round_seat, s.drive.frame_material.min_wall_mm
    yield "plate before the end of the boss", s.levels.plate_back_y - f.boss.encoder_pocket_floor_y, 0.0
    yield from boss_walls(s)


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
    *ups(at.support.bridge_mm, at.support.plate_mm),
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


CHECKS = (walls, bearing_seats, encoder_shelf, bearing_line, input_room, flange, mounts, boss)
