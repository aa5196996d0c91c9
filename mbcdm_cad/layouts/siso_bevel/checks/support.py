"""Frame: walls thick enough to be made, metal round its holes, space for the encoder and the heads of the screws."""

from __future__ import annotations

from math import inf

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.geometry import corner_gap
from mbcdm_cad.checks.motor_head import ENCODER_SHELF, boss_walls
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support.dims import MOUNT_HEAD_ROOM_MM, POCKET_FLAT_MM
from mbcdm_cad.parts.motor_head.dims import dowel_length_mm, flange_screw


def walls(s: DirectLayout) -> Comparison:
    """The thinnest wall of frame and motor head, against the minimum of the material."""
    support, f = s.drive.support, s.frame
    names = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "encoder_shelf_mm", "rib_mm")
    limit = s.drive.frame_material.min_wall_mm
    found = [at_least(f"support.{name}", getattr(support, name), limit, "mm") for name in names]
    pin = (f.stop_shelf_top_z - f.stop_shelf_bottom_z) / 2 - f.stop_pin_radius
    found.append(at_least("stop shelf over and under its pin", pin, limit, "mm"))
    found.append(at_least("wall of the motor head", s.head.outer_x - s.head.inner_x, limit, "mm"))
    return worst(found)


def pockets(s: DirectLayout) -> Comparison:
    """Frame and pockets are larger than the rounded corners that the milling cutter leaves."""
    v, f = s.levels, s.frame
    sizes = (
        ("frame's depth", v.front_y - v.back_y),
        ("width of the pulley's box", 2 * v.side_inner_x),
        ("column's pocket", f.encoder_shelf_bottom_z - f.stop_shelf_top_z),
        ("lower pocket", f.stop_shelf_bottom_z - f.low_pocket_bottom_z),
    )
    return worst(
        at_least(f"{name} over two corner radii", size - 2 * f.corner_radius, POCKET_FLAT_MM, "mm")
        for name, size in sizes
    )


def bearing_seats(s: DirectLayout) -> Comparison:
    """Shoulders of the shelves behind their bearings, and walls in front of the seats."""
    drive, v, limit = s.drive, s.levels, s.drive.frame_material.min_wall_mm
    return worst(
        (
            at_least(
                "shoulder over the bearing next to the gearhead",
                drive.support.bearing_shelf_mm - drive.bearings.input_lower.width_mm,
                limit,
                "mm",
            ),
            at_least(
                "shoulder under the bearing next to the encoder",
                drive.support.encoder_shelf_mm - drive.bearings.input_upper.width_mm,
                limit,
                "mm",
            ),
            at_least("front wall beside the bearing next to the gearhead", v.front_y - s.head.seat_radius, limit, "mm"),
            at_least("front wall beside the bearing next to the encoder", v.front_y - s.frame.seat_radius, limit, "mm"),
        )
    )


def pulley_room(s: DirectLayout) -> Comparison:
    """Gap of pulley and cables to back plate and side walls, whose corners are rounded."""
    v, f, running = s.levels, s.frame, s.drive.clearances.running_mm
    p, found = s.inputs[0], []
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    found.append(at_least("input pulley, cables on, from the back plate", -v.pocket_floor_y - reach, running, "mm"))
    edges = [(p.upper_surface_radius, -p.land_top_z)]
    edges += [(c.input_radius_mm + s.flank_mm, c.drum_radius_mm - s.flank_mm) for c in s.steps]
    for x, z in edges:
        gap = corner_gap(x, z, v.side_inner_x, f.encoder_shelf_top_z, f.corner_radius)
        found.append(at_least("input pulley, cables on, from the box's side and its corner", gap, running, "mm"))
    return worst(found)


def encoder_room(s: DirectLayout) -> Comparison:
    """Gap of the encoder to the corners of the column's pocket, the back plate and the heads of the mounting screws."""
    v, f, encoder = s.levels, s.frame, s.drive.encoder
    radius = encoder.diameter_mm / 2
    heads = v.pocket_floor_y + s.mounting.height_mm(s.mount_washers)
    return worst(
        at_least(f"encoder from the {name}", gap, s.drive.clearances.running_mm, "mm")
        for name, gap in (
            ("corner of its pocket", f.pocket_half_width - f.corner_radius - radius),
            ("heads of the mounting screws", -radius - heads),
            ("stop shelf", -v.encoder_top_z - f.stop_shelf_top_z),
        )
    )


def mounts(s: DirectLayout) -> Comparison:
    """The heads of the mounting screws fit on the flat floor of both pockets of the column."""
    f, head = s.frame, s.mounting.seat_mm(s.mount_washers) / 2
    _, (x, high), _, (_, low) = f.mounts
    rooms = (
        ("side of the pocket", f.pocket_half_width - x - head),
        ("height of the upper pocket", f.encoder_shelf_bottom_z - high - head),
        ("height of the lower pocket", f.stop_shelf_bottom_z - low - head),
        ("each other", x - head),
    )
    return worst(at_least(f"mounting screw's head: {name}", room, MOUNT_HEAD_ROOM_MM, "mm") for name, room in rooms)


def flange(s: DirectLayout) -> Comparison:
    """Screws and dowels of the motor head are inside the side walls, engage by their diameter, and are apart."""
    f, drive = s.frame, s.drive
    limit, wall = drive.frame_material.min_wall_mm, drive.support.side_wall_mm
    screw, shelf = flange_screw(drive), drive.support.bearing_shelf_mm
    (x, front), _, (_, back), _ = f.flange_screws
    dowel_y, gap = f.dowels[0][1], f.flange_screw_radius + f.dowel_radius
    heads = abs(x) - screw.head_diameter_mm / 2 - s.head.outer_x
    return worst(
        (
            at_least(
                f"side wall beside a flange screw's {'insert' if f.flange_insert else 'thread'}",
                wall / 2 - f.flange_screw_radius,
                f.flange_insert.wall_mm if f.flange_insert else limit,
                "mm",
            ),
            at_least("side wall beside a dowel", wall / 2 - f.dowel_radius, limit, "mm"),
            at_least("metal between flange screw and dowel", min(front - dowel_y, dowel_y - back) - gap, limit, "mm"),
            at_least(
                "engaged length of a flange screw over its diameter",
                min(screw.length_mm - shelf, f.flange_insert.length_mm if f.flange_insert else inf) - screw.thread_mm,
                0.0,
                "mm",
            ),
            at_least(
                "engaged length of a dowel over its diameter",
                dowel_length_mm(drive) - shelf - 2 * f.dowel_radius,
                0.0,
                "mm",
            ),
            at_least("heads of the flange screws from the motor head's wall", heads, 0.1, "mm"),
        )
    )


def boss(s: DirectLayout) -> Comparison:
    """Walls of the boss round both drum bearings and their shoulder, and of its ears round the encoder's screws."""
    f, limit = s.frame, s.drive.frame_material.min_wall_mm
    above = at_least("lower pocket above the boss", f.low_pocket_bottom_z - f.boss.radius, limit, "mm")
    return worst((above, *boss_walls(s)))


_WALL = "material: min_wall_mm"
_SHELVES: tuple[Adjustment, ...] = (up("support.bearing_shelf_mm"), up("support.encoder_shelf_mm"))
_DEEPER: tuple[Adjustment, ...] = (down("support.back_y_mm"), down("support.back_plate_mm"))
CHECKS = (
    Check(
        "walls",
        "Walls of frame and motor head are thick enough",
        _WALL,
        walls,
        adjust=(
            up("support.back_plate_mm"),
            up("support.side_wall_mm"),
            up("support.motor_shelf_mm"),
            *_SHELVES,
            up("support.rib_mm"),
        ),
    ),
    Check("pockets", "Corners fit frame and pockets", "material: min_internal_radius_mm", pockets, adjust=_DEEPER),
    Check("bearing_seats", "Shelves take the input's bearings", _WALL, bearing_seats, adjust=_SHELVES),
    ENCODER_SHELF,
    Check("pulley_room", "Input pulley turns freely in its box", "clearances.running_mm", pulley_room, adjust=_DEEPER),
    Check(
        "encoder_room",
        "Encoder clears the column",
        "clearances.running_mm",
        encoder_room,
        adjust=_DEEPER,
        advice="choose a smaller drive.encoder",
    ),
    Check(
        "mounts",
        "Room for the heads of the mounting screws",
        "heads of ISO 4762; 0.5 mm: estimate",
        mounts,
        adjust=(up("all radii of transmission"),),
        advice="choose a shorter drive.encoder",
    ),
    Check(
        "flange",
        "Motor head is held and located",
        "usual rule: one diameter",
        flange,
        adjust=(up("support.side_wall_mm"), down("support.bearing_shelf_mm")),
    ),
    Check("boss", "Boss takes drum bearings and encoder", _WALL, boss, adjust=(down("support.back_y_mm"),)),
)
