"""Motor head, encoder shelf and boss of a drive with one input: screws and access to them, walls, clearances."""

from collections.abc import Iterator

from mbcdm_cad.checks.bearings import carried_check
from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, corner_gap, web_between
from mbcdm_cad.design.bought import Encoder
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.sector import HeadLayout
from mbcdm_cad.parts.boss import EAR_WALL_MM, BossDims
from mbcdm_cad.parts.coupling import collar_sweep_mm

# Numbers of holes in the parts: for the encoders' screws, one on each side, and for those of motor or gearhead.
SCREWS_DRAWN = 2
FACE_SCREWS = (2, 3, 4)


@check(
    "Screws engage over their diameter",
    "usual rule: one diameter",
    *down(at.support.motor_shelf_mm),
    *up(at.drum.hub_diameter_mm),
    advice="choose a drive.gearhead or drive.encoder with longer screws",
)
def engagement(s: HeadLayout) -> Findings:
    """Engaged thread of every screw minus its diameter."""
    drive, f = s.drive, s.frame
    gear, encoder, ring = (drive.screw(item.screw) for item in (drive.gearhead, drive.encoder, drive.drum_encoder))
    hub = drive.screw(s.drum.set_screw)
    through = drive.support.motor_shelf_mm if drive.servo is None else drive.servo.ear_mm
    engaged = [(f"{drive.mounted} screw", gear, gear.length_mm - through)]
    if not drive.encoder.absent:
        through = drive.support.encoder_shelf_mm - f.encoder_head_depth
        engaged.append(("encoder screw", encoder, encoder.length_mm - through))
    if not drive.drum_encoder.absent:
        engaged.append(("drum encoder's screw", ring, f.boss.screw_depth - 0.5))
    engaged.append(("hub's set screw", hub, min(hub.length_mm, s.drum.hub_radius - s.drum.set_screw_radius)))
    if not drive.overhung:
        screw = drive.screw(s.collar.screw)
        inside = screw.length_mm - s.collar.head_seat - s.collar.slit_width / 2
        engaged.append(("collar's screw", screw, inside))
    for name, screw, length in engaged:
        yield f"engaged length of the {name} over its diameter", length - screw.thread_mm, 0.0


@check(
    "Gearhead has two to four screws, encoders have two",
    "the parts are drilled for them",
    advice="choose a drive.gearhead, or drive.motor, of two to four screws and a drive.encoder of two",
    unit="screws",
)
def screw_counts(s: HeadLayout) -> Findings:
    """Gearhead or motor, and encoders, are held by as many screws as the parts can be drilled for."""
    drive, count = s.drive, s.drive.gearhead.screw_count
    items = (("encoder", drive.encoder), ("drum encoder", drive.drum_encoder))
    for name, item in items:
        if not item.absent:
            yield at_most(
                f"screws of the {name}, off the two drilled", abs(item.screw_count - SCREWS_DRAWN), 0.0, "screws"
            )
    yield f"screws of the {drive.mounted}", count, min(FACE_SCREWS)
    yield at_most(f"screws of the {drive.mounted}", count, max(FACE_SCREWS), "screws")


@carried_check(
    "Key holes for the gearhead's screws",
    "derived: assembly order",
    advice="choose a larger input_pulleys.lower_bearing, or a gearhead of smaller bolt circle",
)
def key_access(s: HeadLayout) -> Comparison:
    """The holes for the key of the gearhead's screws lie completely inside the bearing's seat, or outside it."""
    h = s.head
    if s.stage is not None:
        before = h.beside_y - h.gear_bolt_circle - h.key_hole_radius - h.flange.front_y
        return at_least(f"{s.drive.mounted} screws' key before the flange", before, 0.0, "mm")
    inside = h.seat_radius - h.gear_bolt_circle - h.key_hole_radius
    outside = h.gear_bolt_circle - h.key_hole_radius - h.seat_radius - HOLE_WEB_MM
    what = f"{s.drive.mounted} screws' key holes from the wall of the bearing's seat"
    return at_least(what, max(inside, outside), 0.0, "mm")


def collar_gaps(s: HeadLayout) -> Iterator[tuple[str, float]]:
    """Gaps of collar, screws' heads and wheels in the coupling space, mm."""
    v, h, c, drive = s.levels, s.head, s.collar, s.drive
    reach = collar_sweep_mm(drive)
    head = h.gear_bolt_circle + drive.screw(drive.gearhead.screw).head_diameter_mm / 2
    corner = min(h.corner_radius, 0.49 * (v.bearing_shelf_bottom_z - v.motor_shelf_top_z))

    def beside(what: str, reach_mm: float, bottom_z: float, top_z: float) -> Iterator[tuple[str, float]]:
        """A turning part from the shelf below it and from the one above, with the walls at each."""
        below = corner_gap(reach_mm, bottom_z, h.inner_x, v.motor_shelf_top_z, corner)
        above = corner_gap(reach_mm, -top_z, h.inner_x, -v.bearing_shelf_bottom_z, corner)
        yield from ((f"{what} from walls and motor shelf", below), (f"{what} from walls and bearing shelf", above))

    yield from beside("clamp collar", reach, c.bottom_z, c.top_z)
    yield f"{drive.mounted} screws' heads from the corner", h.inner_x - corner - head
    if s.stage is not None:
        wheel = max(s.stage.stage.reach_mm(r) for r in (s.stage.stage.driven_mm, s.stage.stage.driver_mm))
        yield from beside("wheel", wheel, s.stage.bottom_z, s.stage.top_z)


@carried_check("Clamp collar turns freely", at.clearances.running_mm, *up(at.support.coupling_space_mm))
def collar_space(s: HeadLayout) -> Findings:
    """Collar and gearhead screws' heads stand clear of the coupling space's walls and rounded corners."""
    for name, gap in collar_gaps(s):
        yield name, gap, s.drive.clearances.running_mm


@carried_check(
    "Encoder shelf takes bearing and screws",
    "material: min_wall_mm",
    *up(at.support.bearing_shelf_mm, at.support.encoder_shelf_mm),
)
def encoder_shelf(s: HeadLayout) -> Findings:
    """The encoder's screws have metal under their heads and enough thread in its housing."""
    f, drive = s.frame, s.drive
    if drive.encoder.absent:
        rest = drive.support.encoder_shelf_mm - f.seat_depth
        yield "shelf behind the far bearing", rest, drive.frame_material.min_wall_mm
        return
    screw, limit = drive.screw(drive.encoder.screw), drive.frame_material.min_wall_mm
    shelf = drive.support.encoder_shelf_mm
    low, high = f.encoder_shelf_bottom_z, f.encoder_shelf_top_z
    holes: list[tuple[str, float, float, float, float, float]] = [
        ("bearing", 0.0, 0.0, f.seat_radius, high - f.seat_depth, high),
        ("shoulder", 0.0, 0.0, f.seat_shoulder_radius, low, high),
    ]
    for sign in (-1, 1):
        x = sign * f.encoder_circle_radius
        holes.append(("screw", x, 0.0, f.encoder_screw_clearance, low, high))
        holes.append(("screw head", x, 0.0, f.encoder_head_radius, high - f.encoder_head_depth, high))
    for name, web in web_between(holes):
        yield f"encoder shelf, {name}", web, HOLE_WEB_MM
    yield "metal under the encoder's screw heads", shelf - f.encoder_head_depth, limit
    yield "encoder's screw heads sunk", f.encoder_head_depth - screw.head_height_mm, 0.0


def boss_walls(s: HeadLayout) -> Findings:
    """The boss has room for both drum bearings and a shoulder between them, its ears for the encoder's screws."""
    b, encoder = s.frame.boss, s.drive.drum_encoder
    limit = s.drive.frame_material.min_wall_mm
    yield "shoulder between the drum's bearings", b.front_seat_start_y - b.rear_seat_end_y, 2 * limit
    if encoder.absent:
        return
    yield "boss beyond the ears of the drum encoder's screws", b.front_y - b.ear_front_y, 0.0
    yield from encoder_threads(b, encoder)


def encoder_threads(b: BossDims, encoder: Encoder) -> Findings:
    """Walls round the threads for the drum encoder's screws."""
    yield "drum encoder's threads from the bearing's seat", b.screw_circle - b.screw_radius - b.seat_radius, HOLE_WEB_MM
    housing = encoder.diameter_mm / 2 - b.screw_circle - b.screw_radius
    yield "drum encoder's threads inside its housing", housing, HOLE_WEB_MM
    ear = max(b.ear_reach, b.radius) - b.screw_circle - b.screw_radius
    yield "ear round the drum encoder's threads", ear, EAR_WALL_MM
