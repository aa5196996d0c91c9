"""Frame and top plate: engagement and access of screws, flat seats for their heads, room for drives and pulleys."""

from __future__ import annotations

from math import hypot

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, corner_gap
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.plate_screws import key_gap_mm, plate_screw_of
from mbcdm_cad.layouts.miso_bevel.stack import band, outward_of
from mbcdm_cad.layouts.miso_bevel.support.dims import AXLE_SCREW, HEAD_ROOM_MM, dowel_length_mm
from mbcdm_cad.parts.motor_head.dims import CouplingBox
from mbcdm_cad.parts.volume import pocket_corner_mm

# A screw's head may overlap the pocket's rounded corner by its own edge rounding (ISO 4762: under-head edge).
HEAD_EDGE_MM = 0.02
# Gearheads are held by two to four screws; encoders by two, one on each side.
GEARHEAD_SCREWS = (2, 3, 4)
SCREWS_DRAWN = 2


def engagement(s: BevelLayout) -> Comparison:
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
        ("drum encoder's screw", ring, s.frame.encoder_screw_depth - 0.5),
        ("top plate's screw", plate, min(in_frame, insert.length_mm) if insert else in_frame),
        ("axle's set screw", axle, min(axle.length_mm, v.front_y - s.frame.axle_radius)),
        ("hub's set screw", hub, min(hub.length_mm, s.drum.hub_radius - s.drum.set_screw_radius)),
        ("collar's screw", collar, collar.length_mm - c.head_seat - c.slit_width / 2),
    )
    return worst(
        at_least(f"engaged length of the {name} over its diameter", length - screw.thread_mm, 0.0, "mm")
        for name, screw, length in engaged
    )


def dowel_engagement(s: BevelLayout) -> Comparison:
    """Depth of the dowels in the frame: at least one diameter."""
    return at_least(
        "dowel in the frame", dowel_length_mm(s.drive) - s.drive.support.top_plate_mm, 2 * s.frame.dowel_radius, "mm"
    )


def screw_counts(s: BevelLayout) -> Comparison:
    """The numbers of screws of gearhead and encoders are ones for which frame and plate can be drilled."""
    drive = s.drive
    return worst(
        (
            at_least(f"screws of the {drive.mounted}", drive.gearhead.screw_count, min(GEARHEAD_SCREWS), "screws"),
            at_most(f"screws of the {drive.mounted}", drive.gearhead.screw_count, max(GEARHEAD_SCREWS), "screws"),
            *(
                at_most(
                    f"screws of the {name}, off the two drilled", abs(item.screw_count - SCREWS_DRAWN), 0.0, "screws"
                )
                for name, item in (("encoder", drive.encoder), ("drum encoder", drive.drum_encoder))
            ),
        )
    )


def key_access(s: BevelLayout) -> Comparison:
    """The holes for the key of the gearhead's screws lie completely inside the bearing's seat, or outside it."""
    f = s.top_plate.box or s.frame
    inside = f.seat_radius - f.gear_bolt_circle - f.key_hole_radius
    outside = f.gear_bolt_circle - f.key_hole_radius - f.seat_radius - HOLE_WEB_MM
    seat = at_least("gearhead screws' key holes from the wall of the bearing's seat", max(inside, outside), 0.0, "mm")
    return worst((seat, *_keys_in_pocket(s)))


def _keys_in_pocket(s: BevelLayout) -> tuple[Comparison, ...]:
    """Gap of the keys to the upper pocket's walls; screws that are not turned are beside or before the axis."""
    f, v = s.frame, s.levels
    if f.gear_turn_deg == 0.0 or not f.carries_drives:
        return ()
    beside = v.side_inner_x - max(abs(x) for x, _ in f.gear_screws)
    behind = min(y for _, y in f.gear_screws) - f.upper_floor_y
    what = "gearhead screws' key from the upper pocket's walls"
    return (at_least(what, min(beside, behind) - f.key_hole_radius, 0.0, "mm"),)


def head_seats(s: BevelLayout) -> Comparison:
    """The heads of the gearhead's screws rest on the flat floor of the pocket, not on its rounded corner."""
    v, f, box = s.levels, s.frame, s.top_plate.box
    head = s.drive.screw(s.drive.gearhead.screw).head_diameter_mm / 2
    if box is not None:
        return at_least("gearhead screw's head from the pocket's corner", _on_box_mm(box) - head, -HEAD_EDGE_MM, "mm")
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
    return at_least("gearhead screw's head from the pocket's corner", gap, -HEAD_EDGE_MM, "mm")


def _on_box_mm(box: CouplingBox) -> float:
    """Least distance of a gearhead's screw from the edge of the flat under a coupling box's motor shelf."""
    corner = pocket_corner_mm(box.corner_radius, 2 * box.inner_x, box.shelf_bottom_z - box.flange_top_z)
    beside = min(box.inner_x - corner - abs(x) for x, _ in box.gear_screws)
    return min(beside, *(y + box.inner_x for _, y in box.gear_screws), *(box.front_y - y for _, y in box.gear_screws))


def pulley_corner(s: BevelLayout) -> Comparison:
    """Gap between the input pulleys with their cables and the rounded corner between bearing shelf and side wall."""
    v, f = s.levels, s.frame
    found = []
    for p in s.inputs:
        low, high = (c for c in s.steps if c.input_name == p.name)
        lowest = (p.lower_land_radius, p.land_bottom_z)
        if s.drive.motors_above:
            lowest = (p.upper_land_radius, -p.land_top_z)
        edges = (
            lowest,
            (low.input_radius_mm + s.flank_mm, band(s.drive, low, outward_of(s.drive, low)).low_mm),
            (high.input_radius_mm + s.flank_mm, -p.wall_z if s.drive.motors_above else p.wall_z),
        )
        gap = min(
            corner_gap(s.drive.input_x_mm + r, z, v.side_inner_x, v.bearing_shelf_top_z, f.corner_radius)
            for r, z in edges
        )
        what = f"{p.name} input pulley from the upper pocket's corner"
        found.append(at_least(what, gap, s.drive.clearances.running_mm, "mm"))
    return worst(found)


def pocket_depth(s: BevelLayout) -> Comparison:
    """Gap between the input pulleys with their cables and the back plate."""
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    back = s.frame.upper_floor_y
    return at_least(
        "input pulleys, cables on, from the back plate",
        s.drive.input_y_mm - back - reach,
        s.drive.clearances.running_mm,
        "mm",
    )


def mounts(s: BevelLayout) -> Comparison:
    """The mounting screws' heads have flat floor in the lower pockets and, for a screw in the column, there too."""
    v, f = s.levels, s.frame
    head, pockets = f.mount_head_radius, "lower" if s.drive.motors_above else "coupling"
    _, (x, _), _, (inner_x, _), *in_column = f.mounts
    height = v.bearing_shelf_bottom_z - v.shelf_top_z
    rooms = [
        (f"height of the {pockets} pockets", height / 2 - head),
        ("outer mount to the side wall", v.side_inner_x - x - head),
        ("outer to inner mount", x - inner_x - 2 * head),
        *(("width of the column's pocket", f.boss.radius - f.rib_thickness - head) for _ in in_column),
    ]
    return worst(at_least(f"mounting screw's head: {name}", room, HEAD_ROOM_MM, "mm") for name, room in rooms)


def drives_apart(s: BevelLayout) -> Comparison:
    """Gaps between gearheads, motors and encoders, and from these to column, boss and drum encoder, or guide axle."""
    drive, f, box = s.drive, s.frame, s.top_plate.box
    body = max(drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    centre = max(f.boss.radius, f.boss.ear_reach, drive.drum_encoder.diameter_mm / 2)
    gap = drive.clearances.running_mm
    behind = drive.input_y_mm - body - s.levels.back_y
    found = [at_least("gearheads and motors from what the frame is bolted to", behind, gap, "mm")]
    if box is None:
        found.append(at_least("gearheads and motors from column and boss", drive.input_x_mm - body - centre, gap, "mm"))
    else:
        between = drive.input_x_mm - box.outer_x - f.axle_radius
        found += [
            at_least("gearheads and motors from each other", 2 * (drive.input_x_mm - body), gap, "mm"),
            at_least("coupling boxes from the guide's axle", between, HOLE_WEB_MM, "mm"),
            *_encoders_in_frame(s),
            at_least(
                "coupling boxes from what the frame is bolted to",
                drive.input_y_mm + box.back_y - s.levels.back_y,
                0.0,
                "mm",
            ),
        ]
    found.append(at_least("encoders from each other", 2 * drive.input_x_mm - drive.encoder.diameter_mm, gap, "mm"))
    return worst(found)


def _encoders_in_frame(s: BevelLayout) -> tuple[Comparison, ...]:
    """Gaps of encoders in the frame's lower pockets to walls, heads, corners and the lowest shelf."""
    v, f, drive = s.levels, s.frame, s.drive
    reach, x = drive.encoder.diameter_mm / 2, drive.input_x_mm
    height = v.bearing_shelf_bottom_z - v.shelf_top_z
    corner = pocket_corner_mm(f.corner_radius, v.side_inner_x - f.web_half_width, height)
    beside = min(v.side_inner_x - x, x - f.web_half_width)
    return (
        *in_pocket(s, "encoder", reach),
        at_least("encoder from the corners at the bearing shelf", beside - reach - corner, 0.0, "mm"),
        at_least(
            "encoder above the lowest shelf", v.encoder_bottom_z - v.shelf_top_z, drive.clearances.running_mm, "mm"
        ),
    )


def in_pocket(s: BevelLayout, name: str, reach: float) -> tuple[Comparison, ...]:
    """Gaps from a round part in one of the frame's lower pockets to what bounds the pocket."""
    v, f, running = s.levels, s.frame, s.drive.clearances.running_mm
    x = s.drive.input_x_mm
    return (
        at_least(f"{name} from the web between the drives", x - reach - f.web_half_width, running, "mm"),
        at_least(f"{name} from the side wall", v.side_inner_x - x - reach, running, "mm"),
        at_least(
            f"{name} from back plate and mounting screws' heads",
            -max(v.pocket_floor_y, f.mount_seat_y + f.mount_head_height) + s.drive.input_y_mm - reach,
            running,
            "mm",
        ),
    )


def screwdriver(s: BevelLayout) -> Comparison:
    """Gap between the screwdriver on the plate screws and the encoders or motors on top of the plate."""
    p, drive, running = s.top_plate, s.drive, s.drive.clearances.running_mm
    if p.box is None:
        reach = drive.encoder.diameter_mm / 2 + plate_screw_of(drive).key_mm / 3**0.5
        return worst(
            at_least(
                "plate screw's socket from the encoder above the plate",
                hypot(x - centre, y - p.input_y) - reach,
                running,
                "mm",
            )
            for x, y in p.screws
            for centre in p.input_x
        )
    side = p.screw_head_radius + p.box.outer_x + drive.input_x_mm
    return worst(
        (
            *(
                at_least("plate screw's key from the motors", key_gap_mm(drive, x, y), running, "mm")
                for x, y in p.screws
            ),
            *(at_least("plate screw's head from the coupling box", abs(x) - side, running, "mm") for x, _ in p.screws),
        )
    )


CHECKS = (
    Check(
        "engagement",
        "Screws engage over their diameter",
        "usual rule: one diameter",
        engagement,
        adjust=(
            down("support.motor_shelf_mm"),
            down("support.top_plate_mm"),
            up("support.top_plate_mm"),
            up("drum.hub_diameter_mm"),
        ),
        advice="choose a drive.gearhead or drive.encoder with longer screws",
    ),
    Check(
        "dowel_engagement",
        "Dowels reach into the frame",
        "usual rule: one diameter",
        dowel_engagement,
        adjust=(down("support.top_plate_mm"),),
    ),
    Check(
        "screw_counts",
        "Gearhead has two to four screws, encoders two",
        "what frame and plate are drilled for",
        screw_counts,
        advice="choose a drive.gearhead of two to four screws and a drive.encoder of two",
    ),
    Check(
        "key_access",
        "Key holes for the gearheads' screws",
        "derived: assembly order",
        key_access,
        advice="choose a larger input_pulleys.lower_bearing, or a gearhead of smaller bolt circle",
    ),
    Check(
        "head_seats",
        "Gearhead screws' heads on flat floor",
        "derived; 0.02 mm: estimate",
        head_seats,
        adjust=(up("support.back_plate_mm"), up("all radii of transmission")),
    ),
    Check(
        "pulley_corner",
        "Input pulleys clear the pocket's corner",
        "clearances.running_mm",
        pulley_corner,
        adjust=(up("support.back_plate_mm"),),
    ),
    Check(
        "pocket_depth",
        "Input pulleys clear the back plate",
        "clearances.running_mm",
        pocket_depth,
        adjust=(down("support.back_plate_mm"), down("support.back_y_mm")),
    ),
    Check(
        "mounts",
        "Room for the heads of the mounting screws",
        "M3 head; 0.5 mm: estimate",
        mounts,
        adjust=(up("support.coupling_space_mm"), down("support.rib_mm"), up("transmission.centre_distance_mm")),
    ),
    Check(
        "drives_apart",
        "Drives clear column and each other",
        "clearances.running_mm",
        drives_apart,
        adjust=(up("transmission.centre_distance_mm"), down("support.back_y_mm")),
    ),
    Check(
        "screwdriver",
        "Plate screws can be reached",
        "clearances.running_mm",
        screwdriver,
        adjust=(up("support.side_wall_mm"), up("transmission.centre_distance_mm")),
    ),
)
