"""Frame and top plate: walls that can be made, and enough metal round and between all holes."""

from mbcdm_cad.checks.comparison import Findings, check
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, inside_rounded_rectangle, web_between
from mbcdm_cad.checks.motor_head import encoder_threads
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support import AXLE_SCREW, ENCODER_HEAD_PLAY_MM, ENCODER_HEAD_SUNK_MM

_WALL = "material: min_wall_mm"


_WEB = "0.5 mm between holes: estimate"


@check(
    "Walls of frame and plate are thick enough",
    _WALL,
    *up(
        "support.back_plate_mm",
        "support.side_wall_mm",
        "support.motor_shelf_mm",
        "support.bearing_shelf_mm",
        "support.top_plate_mm",
        "support.rib_mm",
    ),
    *down("support.back_y_mm"),
    *up("support.coupling_space_mm"),
)
def walls(s: BevelLayout) -> Findings:
    """The thinnest wall of frame and top plate, against the minimum of the material."""
    support = s.drive.support
    names = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "top_plate_mm", "rib_mm")
    limit = s.drive.frame_material.min_wall_mm
    for name in names:
        yield f"support.{name}", getattr(support, name), limit
    frame = s.frame
    yield "back plate behind the guide", frame.upper_floor_y - s.levels.back_y, limit
    yield "web over the stop pin", s.levels.bearing_shelf_bottom_z - frame.stop_pin_z - frame.stop_pin_radius, limit


@check("Bearing shelf takes bearings and set screw", _WALL, *up("support.bearing_shelf_mm"))
def bearing_shelf(s: BevelLayout) -> Findings:
    """The shelf has room for its bearings, a shoulder below them, and the axle's set screw with its walls."""
    drive, limit = s.drive, s.drive.frame_material.min_wall_mm
    holes, shelf = s.frame.encoder_holes, drive.support.bearing_shelf_mm
    bearings = "upper" if drive.motors_above else "lower"
    if holes is not None:
        yield "shelf under the encoders' screw heads", shelf - holes.head_depth, limit
    yield f"shoulder under the {bearings} bearings", shelf - drive.shelf_bearing.width_mm, limit
    what = "walls over and under the axle's set screw"
    yield (what, (drive.support.bearing_shelf_mm - drive.screw(AXLE_SCREW).thread_mm) / 2, limit)


@check("Top plate takes bearings and heads", _WALL, *up("support.top_plate_mm"))
def top_plate(s: BevelLayout) -> Findings:
    """The plate has room for its bearings and encoder screws from below, and for its own screws from above."""
    drive, limit = s.drive, s.drive.frame_material.min_wall_mm
    plate = drive.support.top_plate_mm
    sunk = drive.screw(drive.encoder.screw).head_height_mm + ENCODER_HEAD_SUNK_MM
    bearings = "lower" if drive.motors_above else "upper"
    yield f"shoulder over the {bearings} bearings", plate - drive.plate_bearing.width_mm, limit
    if not drive.motors_above:
        yield "plate over the encoders' screw heads", plate - sunk, limit
    yield "plate under its screws' heads", plate - plate_screw_of(drive).head_height_mm, limit


@check(
    "Front walls beside the bearing seats",
    _WALL,
    *up("all radii of transmission"),
    advice="choose a smaller input_pulleys.lower_bearing or drum.bearing",
)
def front_wall(s: BevelLayout) -> Findings:
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
    for name, edge, radius in (
        (f"{in_shelf} bearings", front, s.frame.seat_radius),
        (f"{in_plate} bearings", front, s.top_plate.seat_radius),
        ("gearheads' pilots", shelf, holes.pilot_radius),
        ("encoders' screw heads", front, head),
        ("gearheads' screws", shelf, forward + holes.gear_screw_clearance),
        ("gearheads' key holes", front, forward + holes.key_hole_radius),
    ):
        yield f"front wall beside the {name}", edge - radius, limit


@check("Side walls carry the plate screws' heads", _WALL, *up("support.side_wall_mm"))
def side_wall(s: BevelLayout) -> Findings:
    """Wall of the top plate on both sides of the counterbores for its screws, above the side walls."""
    sunk = 2 * s.top_plate.screw_head_radius
    wall = s.drive.frame_material.min_wall_mm
    width = s.drive.support.side_wall_mm
    yield f"side wall under the {plate_screw_of(s.drive).name} heads, sunk in {sunk:g} mm", width, sunk + 2 * wall


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


def _box_webs(s: BevelLayout) -> Findings:
    """Webs in the motor shelf of a coupling box, and from its screws to its sides."""
    box = s.top_plate.box
    if box is None:
        return
    holes: list[_Hole] = [("pilot", 0.0, 0.0, box.pilot_radius, 0.0, 1.0)]
    holes += [("gearhead screw", x, y, box.gear_screw_clearance, 0.0, 1.0) for x, y in box.gear_screws]
    edges = [
        inside_rounded_rectangle(x, y, box.outer_x, box.back_y, box.front_y, box.corner_radius) - radius
        for _, x, y, radius, _, _ in holes
    ]
    for name, web in web_between(holes):
        yield f"motor shelf, {name}", web, HOLE_WEB_MM
    yield "motor shelf, holes to its edge", min(edges), HOLE_WEB_MM


@check(
    "Metal between the holes of plate and shelf",
    _WEB,
    *up("support.side_wall_mm", "transmission.centre_distance_mm", "support.top_plate_mm"),
    *down("support.back_y_mm"),
)
def hole_webs(s: BevelLayout) -> Findings:
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
    for part, holes in (("top plate", plate), (shelf_name, shelf)):
        for name, web in web_between(holes):
            yield f"{part}, {name}", web, HOLE_WEB_MM
    yield from _box_webs(s)
    for name, x, y, radius, _, _ in plate:
        edge = inside_rounded_rectangle(x, y, v.side_outer_x, v.back_y, v.front_y, p.corner_radius)
        yield f"top plate, {name} to the plate's edge", edge - radius, HOLE_WEB_MM


@check("Threads and dowels inside the side walls", _WALL, *up("support.side_wall_mm"), *down("support.back_y_mm"))
def wall_holes(s: BevelLayout) -> Findings:
    """Wall round the threads and dowels in the side walls, and between them."""
    f, wall = s.frame, s.drive.support.side_wall_mm
    limit = s.drive.frame_material.min_wall_mm
    (_, front), _, (_, back), _ = f.plate_screws
    dowel_y = f.dowels[0][1]
    gap = f.plate_screw_radius + f.dowel_radius
    what = f"side wall beside a plate screw's {'insert' if f.plate_insert else 'thread'}"
    yield (what, wall / 2 - f.plate_screw_radius, f.plate_insert.wall_mm if f.plate_insert else limit)
    yield "side wall beside a dowel", wall / 2 - f.dowel_radius, limit
    yield "metal between front plate screw and dowel", front - dowel_y - gap, limit
    yield "metal between dowel and back plate screw", dowel_y - back - gap, limit


@check(
    "Boss takes both drum bearings",
    _WALL,
    *down("support.back_y_mm"),
    *up("all radii of transmission"),
    *down("support.coupling_space_mm"),
)
def boss(s: BevelLayout) -> Findings:
    """The boss has room for both drum bearings with a shoulder between them; ears and column lie behind its front."""
    v, f = s.levels, s.frame
    limit = s.drive.frame_material.min_wall_mm
    lowest = "motor" if f.carries_drives else "lowest"
    yield "shoulder between the drum's bearings", f.boss.front_seat_start_y - f.boss.rear_seat_end_y, 2 * limit
    yield "boss beyond the ears of the drum encoder's screws", v.boss_front_y - f.boss.ear_front_y, 0.0
    yield f"{lowest} shelf above the boss", v.shelf_bottom_z - f.boss.radius, limit
    yield "stop pin's hole in front of the back plate", f.stop_pin_start_y - v.back_y, limit


@check(
    "Metal round the drum encoder's screws",
    _WEB,
    advice="choose a drum encoder of larger bolt circle, or a smaller drum.bearing",
)
def encoder_screws(s: BevelLayout) -> Findings:
    """The drum encoder's screws lie outside the seat of the rear bearing and inside the encoder."""
    yield from encoder_threads(s.frame.boss, s.drive.drum_encoder)


@check(
    "Corners fit frame and pockets",
    _WALL.replace("wall", "internal_radius"),
    *down("support.back_y_mm"),
    advice="choose a support.material of smaller internal radius",
)
def corner_radii(s: BevelLayout) -> Findings:
    """Frame and plate are larger than the rounded corners that the milling cutter leaves in their pockets."""
    v, f = s.levels, s.frame
    yield "frame's depth over two corner radii", v.front_y - v.back_y - 2 * f.corner_radius, 0.1
    yield "upper pocket's width over two corner radii", 2 * v.side_inner_x - 2 * f.corner_radius, 0.1
    yield "depth of the pockets", v.front_y - v.pocket_floor_y, 0.1
