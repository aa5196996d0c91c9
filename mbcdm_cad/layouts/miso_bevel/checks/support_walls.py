"""Frame and top plate: walls that can be made, and enough metal round and between all holes."""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, inside_rounded_rectangle, web_between
from mbcdm_cad.checks.motor_head import encoder_threads
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.plate_screws import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support.dims import AXLE_SCREW, ENCODER_HEAD_PLAY_MM, ENCODER_HEAD_SUNK_MM


def walls(s: BevelLayout) -> Comparison:
    """The thinnest wall of frame and top plate, against the minimum of the material."""
    support = s.drive.support
    names = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "top_plate_mm", "rib_mm")
    limit = s.drive.frame_material.min_wall_mm
    found = [at_least(f"support.{name}", getattr(support, name), limit, "mm") for name in names]
    frame = s.frame
    found.append(at_least("back plate behind the guide", frame.upper_floor_y - s.levels.back_y, limit, "mm"))
    found.append(
        at_least(
            "web over the stop pin",
            s.levels.bearing_shelf_bottom_z - frame.stop_pin_z - frame.stop_pin_radius,
            limit,
            "mm",
        )
    )
    return worst(found)


def bearing_shelf(s: BevelLayout) -> Comparison:
    """The shelf has room for its bearings, a shoulder below them, and the axle's set screw with its walls."""
    drive, limit = s.drive, s.drive.frame_material.min_wall_mm
    holes, shelf = s.frame.encoder_holes, drive.support.bearing_shelf_mm
    under_heads = (
        ()
        if holes is None
        else (at_least("shelf under the encoders' screw heads", shelf - holes.head_depth, limit, "mm"),)
    )
    bearings = "upper" if drive.motors_above else "lower"
    return worst(
        (
            *under_heads,
            at_least(f"shoulder under the {bearings} bearings", shelf - drive.shelf_bearing.width_mm, limit, "mm"),
            at_least(
                "walls over and under the axle's set screw",
                (drive.support.bearing_shelf_mm - drive.screw(AXLE_SCREW).thread_mm) / 2,
                limit,
                "mm",
            ),
        )
    )


def top_plate(s: BevelLayout) -> Comparison:
    """The plate has room for its bearings and encoder screws from below, and for its own screws from above."""
    drive, limit = s.drive, s.drive.frame_material.min_wall_mm
    plate = drive.support.top_plate_mm
    sunk = drive.screw(drive.encoder.screw).head_height_mm + ENCODER_HEAD_SUNK_MM
    over_heads = (
        () if drive.motors_above else (at_least("plate over the encoders' screw heads", plate - sunk, limit, "mm"),)
    )
    bearings = "lower" if drive.motors_above else "upper"
    return worst(
        (
            at_least(f"shoulder over the {bearings} bearings", plate - drive.plate_bearing.width_mm, limit, "mm"),
            *over_heads,
            at_least("plate under its screws' heads", plate - plate_screw_of(drive).head_height_mm, limit, "mm"),
        )
    )


def front_wall(s: BevelLayout) -> Comparison:
    """Wall between the bearing seats and the front of shelf and plate, or of the coupling boxes' motor shelf."""
    drive = s.drive
    box, front = s.top_plate.box, s.levels.front_y - drive.input_y_mm
    head = drive.screw(drive.encoder.screw).head_diameter_mm / 2 + ENCODER_HEAD_PLAY_MM
    in_shelf, in_plate = ("upper", "lower") if drive.motors_above else ("lower", "upper")
    # Screws stand around the face's axis; in the shelf of a box they are seen from its other side.
    screws, holes, shelf = (
        ([y - drive.input_y_mm for _, y in s.frame.gear_screws], s.frame, front)
        if box is None
        else ([y for _, y in box.gear_screws], box, box.front_y)
    )
    forward = max(screws)
    limit = drive.frame_material.min_wall_mm
    return worst(
        at_least(f"front wall beside the {name}", edge - radius, limit, "mm")
        for name, edge, radius in (
            (f"{in_shelf} bearings", front, s.frame.seat_radius),
            (f"{in_plate} bearings", front, s.top_plate.seat_radius),
            ("gearheads' pilots", shelf, holes.pilot_radius),
            ("encoders' screw heads", front, head),
            ("gearheads' screws", shelf, forward + holes.gear_screw_clearance),
            ("gearheads' key holes", front, forward + holes.key_hole_radius),
        )
    )


def side_wall(s: BevelLayout) -> Comparison:
    """Wall of the top plate on both sides of the counterbores for its screws, above the side walls."""
    sunk = 2 * s.top_plate.screw_head_radius
    wall = s.drive.frame_material.min_wall_mm
    width = s.drive.support.side_wall_mm
    return at_least(
        f"side wall under the {plate_screw_of(s.drive).name} heads, sunk in {sunk:g} mm", width, sunk + 2 * wall, "mm"
    )


_Hole = tuple[str, float, float, float, float, float]


def _encoder_screws(s: BevelLayout, x: float, z: tuple[float, float], face_z: float) -> list[_Hole]:
    """Holes of an input's encoder through a plate between two heights, heads sunk in the face at ``face_z``."""
    drive, y = s.drive, s.drive.input_y_mm
    screw, found = drive.screw(drive.encoder.screw), list[_Hole]()
    depth = screw.head_height_mm + ENCODER_HEAD_SUNK_MM
    sunk = (face_z, face_z + depth) if face_z == z[0] else (face_z - depth, face_z)
    for sign in (-1, 1):
        at = x + sign * drive.encoder.bolt_circle_mm / 2
        found.append(("encoder screw", at, y, screw.clearance_mm / 2, *z))
        found.append(("encoder screw head", at, y, screw.head_diameter_mm / 2 + ENCODER_HEAD_PLAY_MM, *sunk))
    return found


def _shelf_holes(s: BevelLayout) -> tuple[str, list[_Hole]]:
    """The shelf of the frame that is drilled most, and its holes: for gearheads, or for bearings and encoders."""
    f, v = s.frame, s.levels
    if f.carries_drives:
        through = (v.motor_shelf_bottom_z, v.motor_shelf_top_z)
        pilots: list[_Hole] = [("pilot", x, f.input_y, f.pilot_radius, *through) for x in f.input_x]
        screws: list[_Hole] = [("gearhead screw", x, y, f.gear_screw_clearance, *through) for x, y in f.gear_screws]
        return "motor shelf", pilots + screws
    low, high = v.bearing_shelf_bottom_z, v.bearing_shelf_top_z
    holes: list[_Hole] = [("axle", 0.0, 0.0, f.axle_radius, low, high)]
    for x in f.input_x:
        holes.append(("upper bearing", x, f.input_y, f.seat_radius, high - f.seat_depth, high))
        holes.append(("upper shoulder", x, f.input_y, f.seat_shoulder_radius, low, high))
        holes += _encoder_screws(s, x, (low, high), high)
    return "bearing shelf", holes


def _box_webs(s: BevelLayout) -> list[Comparison]:
    """Webs in the motor shelf of a coupling box, and from its screws to its sides."""
    box = s.top_plate.box
    if box is None:
        return []
    holes: list[_Hole] = [("pilot", 0.0, 0.0, box.pilot_radius, 0.0, 1.0)]
    holes += [("gearhead screw", x, y, box.gear_screw_clearance, 0.0, 1.0) for x, y in box.gear_screws]
    edges = [
        inside_rounded_rectangle(x, y, box.outer_x, box.back_y, box.front_y, box.corner_radius) - radius
        for _, x, y, radius, _, _ in holes
    ]
    return [
        *(at_least(f"motor shelf, {name}", web, HOLE_WEB_MM, "mm") for name, web in web_between(holes)),
        at_least("motor shelf, holes to its edge", min(edges), HOLE_WEB_MM, "mm"),
    ]


def hole_webs(s: BevelLayout) -> Comparison:
    """Wall between neighbouring holes of top plate and shelf, and from the holes to the plate's edge."""
    v = s.levels
    p, box = s.top_plate, s.top_plate.box
    low, high = v.top_plate_bottom_z, v.top_plate_top_z
    plate: list[_Hole] = [("axle", 0.0, 0.0, p.axle_radius, low, high)]
    bearing = "lower" if s.drive.motors_above else "upper"
    for x in p.input_x:
        plate.append((f"{bearing} bearing", x, p.input_y, p.seat_radius, low, low + p.seat_depth))
        plate.append((f"{bearing} shoulder", x, p.input_y, p.shoulder_radius, low, high))
        if box is None:
            plate += _encoder_screws(s, x, (low, high), low)
    for x, y in p.screws:
        plate.append(("plate screw head", x, y, p.screw_head_radius, high - p.screw_head_depth, high))
        plate.append(("plate screw", x, y, p.screw_clearance, low, high))
    for x, y in p.dowels:
        plate.append(("dowel", x, y, p.dowel_radius, low, high))
    shelf_name, shelf = _shelf_holes(s)
    found = [at_least(f"top plate, {name}", web, HOLE_WEB_MM, "mm") for name, web in web_between(plate)]
    found += [at_least(f"{shelf_name}, {name}", web, HOLE_WEB_MM, "mm") for name, web in web_between(shelf)]
    found += _box_webs(s)
    for name, x, y, radius, _, _ in plate:
        edge = inside_rounded_rectangle(x, y, v.side_outer_x, v.back_y, v.front_y, p.corner_radius)
        found.append(at_least(f"top plate, {name} to the plate's edge", edge - radius, HOLE_WEB_MM, "mm"))
    return worst(found)


def wall_holes(s: BevelLayout) -> Comparison:
    """Wall round the threads and dowels in the side walls, and between them."""
    f, wall = s.frame, s.drive.support.side_wall_mm
    limit = s.drive.frame_material.min_wall_mm
    (_, front), _, (_, back), _ = f.plate_screws
    dowel_y = f.dowels[0][1]
    gap = f.plate_screw_radius + f.dowel_radius
    return worst(
        (
            at_least(
                f"side wall beside a plate screw's {'insert' if f.plate_insert else 'thread'}",
                wall / 2 - f.plate_screw_radius,
                f.plate_insert.wall_mm if f.plate_insert else limit,
                "mm",
            ),
            at_least("side wall beside a dowel", wall / 2 - f.dowel_radius, limit, "mm"),
            at_least("metal between front plate screw and dowel", front - dowel_y - gap, limit, "mm"),
            at_least("metal between dowel and back plate screw", dowel_y - back - gap, limit, "mm"),
        )
    )


def boss(s: BevelLayout) -> Comparison:
    """The boss has room for both drum bearings with a shoulder between them; ears and column lie behind its front."""
    v, f = s.levels, s.frame
    limit = s.drive.frame_material.min_wall_mm
    lowest = "motor" if f.carries_drives else "lowest"
    return worst(
        (
            at_least(
                "shoulder between the drum's bearings",
                f.boss.front_seat_start_y - f.boss.rear_seat_end_y,
                2 * limit,
                "mm",
            ),
            at_least(
                "boss beyond the ears of the drum encoder's screws", v.boss_front_y - f.boss.ear_front_y, 0.0, "mm"
            ),
            at_least(f"{lowest} shelf above the boss", v.shelf_bottom_z - f.boss.radius, limit, "mm"),
            at_least("stop pin's hole in front of the back plate", f.stop_pin_start_y - v.back_y, limit, "mm"),
        )
    )


def encoder_screws(s: BevelLayout) -> Comparison:
    """The drum encoder's screws lie outside the seat of the rear bearing and inside the encoder."""
    return worst(encoder_threads(s.frame.boss, s.drive.drum_encoder))


def corner_radii(s: BevelLayout) -> Comparison:
    """Frame and plate are larger than the rounded corners that the milling cutter leaves in their pockets."""
    v, f = s.levels, s.frame
    return worst(
        (
            at_least("frame's depth over two corner radii", v.front_y - v.back_y - 2 * f.corner_radius, 0.1, "mm"),
            at_least("upper pocket's width over two corner radii", 2 * v.side_inner_x - 2 * f.corner_radius, 0.1, "mm"),
            at_least("depth of the pockets", v.front_y - v.pocket_floor_y, 0.1, "mm"),
        )
    )


_SHELF: tuple[Adjustment, ...] = (up("support.bearing_shelf_mm"),)
_WALL = "material: min_wall_mm"
_WEB = "0.5 mm between holes: estimate"
CHECKS = (
    Check(
        "walls",
        "Walls of frame and plate are thick enough",
        _WALL,
        walls,
        adjust=(
            up("support.back_plate_mm"),
            up("support.side_wall_mm"),
            up("support.motor_shelf_mm"),
            up("support.bearing_shelf_mm"),
            up("support.top_plate_mm"),
            up("support.rib_mm"),
            down("support.back_y_mm"),
            up("support.coupling_space_mm"),
        ),
    ),
    Check("bearing_shelf", "Bearing shelf takes bearings and set screw", _WALL, bearing_shelf, adjust=_SHELF),
    Check("top_plate", "Top plate takes bearings and heads", _WALL, top_plate, adjust=(up("support.top_plate_mm"),)),
    Check(
        "front_wall",
        "Front walls beside the bearing seats",
        _WALL,
        front_wall,
        adjust=(up("all radii of transmission"),),
        advice="choose a smaller input_pulleys.lower_bearing or drum.bearing",
    ),
    Check(
        "side_wall", "Side walls carry the plate screws' heads", _WALL, side_wall, adjust=(up("support.side_wall_mm"),)
    ),
    Check(
        "hole_webs",
        "Metal between the holes of plate and shelf",
        _WEB,
        hole_webs,
        adjust=(
            up("support.side_wall_mm"),
            up("transmission.centre_distance_mm"),
            up("support.top_plate_mm"),
            down("support.back_y_mm"),
        ),
    ),
    Check(
        "wall_holes",
        "Threads and dowels inside the side walls",
        _WALL,
        wall_holes,
        adjust=(up("support.side_wall_mm"), down("support.back_y_mm")),
    ),
    Check(
        "boss",
        "Boss takes both drum bearings",
        _WALL,
        boss,
        adjust=(down("support.back_y_mm"), up("all radii of transmission"), down("support.coupling_space_mm")),
    ),
    Check(
        "encoder_screws",
        "Metal round the drum encoder's screws",
        _WEB,
        encoder_screws,
        advice="choose a drum encoder of larger bolt circle, or a smaller drum.bearing",
    ),
    Check(
        "corner_radii",
        "Corners fit frame and pockets",
        _WALL.replace("wall", "internal_radius"),
        corner_radii,
        adjust=(down("support.back_y_mm"),),
        advice="choose a support.material of smaller internal radius",
    ),
)
