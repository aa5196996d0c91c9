"""Frame and top plate: engagement and access of screws, flat seats for their heads, room for drives and pulleys."""

from math import hypot

from mbcdm_cad.checks.comparison import Findings, at_most, check
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, corner_gap
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import band, key_gap_mm, plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support import AXLE_SCREW, HEAD_ROOM_MM, dowel_length_mm
from mbcdm_cad.parts.part import pocket_corner_mm

# A screw's head may overlap the pocket's rounded corner by its own edge rounding (ISO 4762: under-head edge).
HEAD_EDGE_MM = 0.02
# Gearheads are held by two to four screws; encoders by two, one on each side.
GEARHEAD_SCREWS = (2, 3, 4)
SCREWS_DRAWN = 2


@check(
    "Screws engage over their diameter",
    "usual rule: one diameter",
    *down(at.support.motor_shelf_mm, at.support.top_plate_mm),
    *up(at.support.top_plate_mm, at.drum.hub_diameter_mm),
    advice="choose a drive.gearhead or drive.encoder with longer screws",
)
def engagement(s: BevelLayout) -> Findings:
    """Engaged thread of every screw minus its diameter."""
    drive, support = s.drive, s.drive.support
    gear, encoder, ring = (drive.screw(item.screw) for item in (drive.gearhead, drive.encoder, drive.drum_encoder))
    plate = plate_screw_of(drive)
    axle, hub, collar = (drive.screw(n) for n in (AXLE_SCREW, s.drum.set_screw, s.collar.screw))
    c, v, insert = s.collar, s.levels, s.frame.plate_insert
    in_frame = plate.length_mm - (support.top_plate_mm - plate.head_height_mm)
    engaged = (
        (f"{drive.mounted} screw", gear, gear.length_mm - support.motor_shelf_mm),
        ("encoder screw", encoder, encoder.length_mm - (drive.encoder_plate_mm - encoder.head_height_mm - 0.2)),
        ("drum encoder's screw", ring, s.frame.boss.screw_depth - 0.5),
        ("top plate's screw", plate, min(in_frame, insert.length_mm) if insert else in_frame),
        ("axle's set screw", axle, min(axle.length_mm, v.front_y - s.frame.axle_radius)),
        ("hub's set screw", hub, min(hub.length_mm, s.drum.hub_radius - s.drum.set_screw_radius)),
        ("collar's screw", collar, collar.length_mm - c.head_seat - c.slit_width / 2),
    )
    for name, screw, length in engaged:
        yield f"engaged length of the {name} over its diameter", length - screw.thread_mm, 0.0


@check("Dowels reach into the frame", "usual rule: one diameter", *down(at.support.top_plate_mm))
def dowel_engagement(s: BevelLayout) -> Findings:
    """Depth of the dowels in the frame: at least one diameter."""
    yield "dowel in the frame", dowel_length_mm(s.drive) - s.drive.support.top_plate_mm, 2 * s.frame.dowel_radius


@check(
    "Gearhead has two to four screws, encoders two",
    "what frame and plate are drilled for",
    advice="choose a drive.gearhead of two to four screws and a drive.encoder of two",
    unit="screws",
)
def screw_counts(s: BevelLayout) -> Findings:
    """The numbers of screws of gearhead and encoders are ones for which frame and plate can be drilled."""
    drive = s.drive
    yield f"screws of the {drive.mounted}", drive.gearhead.screw_count, min(GEARHEAD_SCREWS)
    yield at_most(f"screws of the {drive.mounted}", drive.gearhead.screw_count, max(GEARHEAD_SCREWS), "screws")
    for name, item in (("encoder", drive.encoder), ("drum encoder", drive.drum_encoder)):
        yield at_most(f"screws of the {name}, off the two drilled", abs(item.screw_count - SCREWS_DRAWN), 0.0, "screws")


@check(
    "Key holes for the gearheads' screws",
    "derived: assembly order",
    advice="choose a larger input_pulleys.lower_bearing, or a gearhead of smaller bolt circle",
)
def key_access(s: BevelLayout) -> Findings:
    """The holes for the key of the gearhead's screws lie completely inside the bearing's seat, or outside it."""
    f = s.top_plate.box or s.frame
    inside = f.seat_radius - f.gear_bolt_circle - f.key_hole_radius
    outside = f.gear_bolt_circle - f.key_hole_radius - f.seat_radius - HOLE_WEB_MM
    yield "gearhead screws' key holes from the wall of the bearing's seat", max(inside, outside), 0.0
    frame = s.frame
    # Screws that are not turned are beside or before the axis.
    if frame.gear_turn_deg != 0.0 and frame.carries_drives:
        beside = s.levels.side_inner_x - max(abs(x) for x, _ in frame.gear_screws)
        behind = min(y for _, y in frame.gear_screws) - frame.upper_floor_y
        yield "gearhead screws' key from the upper pocket's walls", min(beside, behind) - frame.key_hole_radius, 0.0


@check(
    "Gearhead screws' heads on flat floor",
    "derived; 0.02 mm: estimate",
    *up(at.support.back_plate_mm, "all radii of transmission"),
)
def head_seats(s: BevelLayout) -> Findings:
    """The heads of the gearhead's screws rest on the flat floor of the pocket, not on its rounded corner."""
    v, f, box = s.levels, s.frame, s.top_plate.box
    head = s.drive.screw(s.drive.gearhead.screw).head_diameter_mm / 2
    if box is not None:
        # From the edge of the flat under the box's motor shelf.
        corner = pocket_corner_mm(box.corner_radius, 2 * box.inner_x, box.shelf_bottom_z - box.flange_top_z)
        gaps = [(box.inner_x - corner - abs(x), y + box.inner_x, box.front_y - y) for x, y in box.gear_screws]
        yield "gearhead screw's head from the pocket's corner", min(map(min, gaps)) - head, -HEAD_EDGE_MM
        return
    edge = max(x for x, _ in f.gear_screws) + head
    radius = min(f.corner_radius, 0.49 * (v.bearing_shelf_bottom_z - v.motor_shelf_top_z))
    gap = corner_gap(edge, v.motor_shelf_top_z, v.side_inner_x, v.motor_shelf_top_z, radius)
    inner = min(abs(x) for x, _ in f.gear_screws) - head
    gap = min(
        gap,
        v.side_inner_x - edge,
        corner_gap(-inner, v.motor_shelf_top_z, -f.web_half_width, v.motor_shelf_top_z, radius),
        inner - f.web_half_width,
        min(y for _, y in f.gear_screws) - head - v.pocket_floor_y,
    )
    yield "gearhead screw's head from the pocket's corner", gap, -HEAD_EDGE_MM


@check("Input pulleys clear the pocket's corner", at.clearances.running_mm, *up(at.support.back_plate_mm))
def pulley_corner(s: BevelLayout) -> Findings:
    """Gap between the input pulleys with their cables and the rounded corner between bearing shelf and side wall."""
    v, f = s.levels, s.frame
    for p in s.inputs:
        low, high = (c for c in s.steps if c.input_name == p.name)
        lowest = (p.lower_land_radius, p.land_bottom_z)
        if s.drive.motors_above:
            lowest = (p.upper_land_radius, -p.land_top_z)
        edges = (
            lowest,
            (low.input_radius_mm + s.flank_mm, band(s.drive, low).low_mm),
            (high.input_radius_mm + s.flank_mm, -p.wall_z if s.drive.motors_above else p.wall_z),
        )
        gap = min(
            corner_gap(s.drive.input_x_mm + r, z, v.side_inner_x, v.bearing_shelf_top_z, f.corner_radius)
            for r, z in edges
        )
        what = f"{p.name} input pulley from the upper pocket's corner"
        yield what, gap, s.drive.clearances.running_mm


@check(
    "Input pulleys clear the back plate",
    at.clearances.running_mm,
    *down(at.support.back_plate_mm, at.support.back_y_mm),
)
def pocket_depth(s: BevelLayout) -> Findings:
    """Gap between the input pulleys with their cables and the back plate."""
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    back = s.frame.upper_floor_y
    what = "input pulleys, cables on, from the back plate"
    yield (what, s.drive.input_y_mm - back - reach, s.drive.clearances.running_mm)


@check(
    "Room for the heads of the mounting screws",
    "M3 head; 0.5 mm: estimate",
    *up(at.support.coupling_space_mm),
    *down(at.support.rib_mm),
    *up(at.transmission.centre_distance_mm),
)
def mounts(s: BevelLayout) -> Findings:
    """The mounting screws' heads have flat floor in the lower pockets and, for a screw in the column, there too."""
    v, f = s.levels, s.frame
    head, pockets = f.mount_head_radius, "lower" if s.drive.motors_above else "coupling"
    _, (x, _), _, (inner_x, _), *in_column = f.mounts
    height = v.bearing_shelf_bottom_z - v.shelf_top_z
    for name, room in (
        (f"height of the {pockets} pockets", height / 2 - head),
        ("outer mount to the side wall", v.side_inner_x - x - head),
        ("outer to inner mount", x - inner_x - 2 * head),
        *(("width of the column's pocket", f.boss.radius - f.rib_thickness - head) for _ in in_column),
    ):
        yield f"mounting screw's head: {name}", room, HEAD_ROOM_MM


@check(
    "Drives clear column and each other",
    at.clearances.running_mm,
    *up(at.transmission.centre_distance_mm),
    *down(at.support.back_y_mm),
)
def drives_apart(s: BevelLayout) -> Findings:
    """Gaps between gearheads, motors and encoders, and from these to column, boss and drum encoder, or guide axle."""
    drive, f, box = s.drive, s.frame, s.top_plate.box
    body = max(drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    centre = max(f.boss.radius, f.boss.ear_reach, drive.drum_encoder.diameter_mm / 2)
    gap = drive.clearances.running_mm
    behind = drive.input_y_mm - body - s.levels.back_y
    yield "gearheads and motors from what the frame is bolted to", behind, gap
    if box is None:
        yield "gearheads and motors from column and boss", drive.input_x_mm - body - centre, gap
    else:
        between = drive.input_x_mm - box.outer_x - f.axle_radius
        yield "gearheads and motors from each other", 2 * (drive.input_x_mm - body), gap
        yield "coupling boxes from the guide's axle", between, HOLE_WEB_MM
        yield from _encoders_in_frame(s)
        yield "coupling boxes from what the frame is bolted to", drive.input_y_mm + box.back_y - s.levels.back_y, 0.0
    yield "encoders from each other", 2 * drive.input_x_mm - drive.encoder.diameter_mm, gap


def _encoders_in_frame(s: BevelLayout) -> Findings:
    """Gaps of encoders in the frame's lower pockets to walls, heads, corners and the lowest shelf."""
    v, f, drive = s.levels, s.frame, s.drive
    reach, x = drive.encoder.diameter_mm / 2, drive.input_x_mm
    height = v.bearing_shelf_bottom_z - v.shelf_top_z
    corner = pocket_corner_mm(f.corner_radius, v.side_inner_x - f.web_half_width, height)
    beside = min(v.side_inner_x - x, x - f.web_half_width)
    yield from in_pocket(s, "encoder", reach)
    yield "encoder from the corners at the bearing shelf", beside - reach - corner, 0.0
    yield "encoder above the lowest shelf", v.encoder_bottom_z - v.shelf_top_z, drive.clearances.running_mm


def in_pocket(s: BevelLayout, name: str, reach: float) -> Findings:
    """Gaps from a round part in one of the frame's lower pockets to what bounds the pocket."""
    v, f, running = s.levels, s.frame, s.drive.clearances.running_mm
    x, floor_y = s.drive.input_x_mm, max(v.pocket_floor_y, f.mount_seat_y + f.mount_head_height)
    yield f"{name} from the web between the drives", x - reach - f.web_half_width, running
    yield f"{name} from the side wall", v.side_inner_x - x - reach, running
    yield f"{name} from back plate and mounting screws' heads", -floor_y + s.drive.input_y_mm - reach, running


@check(
    "Plate screws can be reached",
    at.clearances.running_mm,
    *up(at.support.side_wall_mm, at.transmission.centre_distance_mm),
)
def screwdriver(s: BevelLayout) -> Findings:
    """Gap between the screwdriver on the plate screws and the encoders or motors on top of the plate."""
    p, drive, running = s.top_plate, s.drive, s.drive.clearances.running_mm
    if p.box is None:
        reach = drive.encoder.diameter_mm / 2 + plate_screw_of(drive).key_mm / 3**0.5
        for x, y in p.screws:
            for centre in p.input_x:
                what = "plate screw's socket from the encoder above the plate"
                yield (what, hypot(x - centre, y - p.input_y) - reach, running)
        return
    side = p.screw_head_radius + p.box.outer_x + drive.input_x_mm
    for x, y in p.screws:
        yield "plate screw's key from the motors", key_gap_mm(drive, x, y), running
    for x, _ in p.screws:
        yield "plate screw's head from the coupling box", abs(x) - side, running
