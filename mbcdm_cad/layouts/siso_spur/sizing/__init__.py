"""Sizing rules of siso_spur, in the order of the power flow; miso_spur uses all of them except those of names.

Many rules evaluate checks on a trial drive, whose open fields have the values of the pass before. Passes are repeated
until no field changes; the first one starts with the values of a drive of medium size.
"""

from collections.abc import Iterator
from functools import partial
from math import hypot
from operator import methodcaller
from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Freedom, Moved, Sizing
from mbcdm_cad.layouts import common_rules, head_dims, head_parts, stiff_sizing, trial_sizing
from mbcdm_cad.layouts.common_rules import SCHEMA_VERSION, half_travel, missing_travel, needed
from mbcdm_cad.layouts.head_basis import LIMITS, METALS, ROPE_LIMITS, TRAIN
from mbcdm_cad.layouts.open_ratio import SizingRules
from mbcdm_cad.layouts.siso_spur.routes import flange_radius_mm
from mbcdm_cad.layouts.siso_spur.schema import MOUNT_BOLTS
from mbcdm_cad.layouts.siso_spur.sizing import basis
from mbcdm_cad.layouts.siso_spur.sizing.stage import FIRST, GUESSES, STAGE, STAGE_RATIO, with_room
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.sizing import Found, Rule, largest, rounded_up, rule

# Walls of a milled part and of a printed one, mm (estimate: the modulus of filament is about twenty times smaller).
PLATE_MM, BRIDGE_MM = (5.0, 8.0), (4.0, 7.0)
# Largest multiple of its usual thickness to which a bridge grows for the line of its bearings (a choice).
MOST_BRIDGE = 5.0
# Radius of an idler over that of the input, since the cable is bent back behind it (rope makers: a quarter larger).
REVERSE = 1.25
# Wall between the outer ring of a bearing and the land of its idler, mm (estimate).
WALL_MM = 1.5
# Radius that terminals reach beyond the cable on the drum, over the thread of their stud (estimate; a check measures).
REACH = 2.0
# Bearings of a radius that is tried first, before their loads are known.
_BEARING = "624"
_HAS_IDLERS = methodcaller("has", "idlers")


@rule(at.support.plate_mm, "usual thickness, or more for the screws of motor or motor head", "flange")
def plate(given: basis.SpurKnown) -> Found:
    start, check = head_dims.either(given, "support", PLATE_MM), "flange"
    if given.overhung or given.servo is not None:
        check = "motor_seat"
    if given.overhung and given.servo is None:
        sunk = given[at.support.motor_shelf_mm] + given.screw(given.gearhead.screw).head_height_mm
        usual, grip = max(start, sunk), "motor_shaft_grip"
        # The shaft ends soon behind its face.
        start = usual if given.margins(at.support.plate_mm, usual, (grip,))[grip][0] >= 0.0 else sunk
    return given.moved(at.support.plate_mm, start, 0.1, (check,))


@rule(at.support.bridge_mm, "usual thickness for making it in its material, more where its bearings lean", "walls")
def bridge(given: basis.SpurKnown) -> Found:
    usual = head_dims.either(given, "support", BRIDGE_MM)
    if given.overhung:
        return Found(usual, head_dims.UNUSED)
    start = rounded_up(max(usual, given.wall_mm("support")), 0.5)
    if not given.drives.passes:
        return Found(start)
    lean = given.moved(at.support.bridge_mm, start, 0.5, ("bearing_line",))
    return lean if lean.value <= MOST_BRIDGE * start else Found(start)


@rule(at.transmission.centre_distance_mm, "the shortest that span, bearings, screws and motor allow", "input_room")
def centre_distance(given: basis.SpurKnown) -> Found:
    start = given[at.transmission.drum_radius_mm] + given.input_mm + 2 * given.d_mm
    if given.has("idlers.places"):
        far = max(place["z_mm"] for place in given["idlers.places"])
        start = max(start, far + 2 * (given.input_mm + given["idlers.radius_mm"]))
    checks = (
        "free_span",
        "drum_and_input",
        "land_spacing",
        "cables_apart",
        "input_room",
        "walls",
        "mounts",
        "bodies_behind",
        *(("hub_and_drum", "motor_seat") if given.overhung else ()),
    )
    come_by = ("terminal_clears_input",) if given.whole_drum else ()
    # The box of a wheel, or of a first stage, reaches far towards the threads of the frame's own screws; so does the
    # motor of a first stage, whose drum is small.
    wide = given.has("stage.kind") or given.has("first_stage") or given.get(at.drum.shaft_end_mm, 0.0) > 0.0
    beside = ("flange",) if wide else ()
    return given.moved(at.transmission.centre_distance_mm, start, 0.5, (*checks, *beside, *come_by))


@rule(at.support.back_y_mm, "nearest plane with enough distance between the drum's bearings", "drum_bearing_spacing")
def back(given: basis.SpurKnown) -> Found:
    return given.moved(at.support.back_y_mm, -10.0, -0.5, ("drum_bearing_spacing", "boss"))


@rule(at.drum.outer_face_y_mm, "least width for cable and terminals", "outer_face")
def _outer_face(given: basis.SpurKnown) -> Found:
    checks = ("rim_width", "outer_face", "terminals_apart", "lands_intact", "lug_stress", "web_in_rim")
    return given.moved(at.drum.outer_face_y_mm, 2.0, 0.1, checks)


def idler_guesses(given: basis.SpurKnown, drum_mm: float) -> dict[str, Any]:
    """Values of idlers that the first pass does not know yet; none for a design without idlers."""
    found = {
        "idlers.bearing": _BEARING,
        "idlers.radius_mm": 12.0,
        "idlers.width_mm": 20.0,
        "idlers.places": [{"x_mm": 14.0, "z_mm": 1.05 * drum_mm + 20.0}],
    }
    return found if _HAS_IDLERS(given) else {}


@rule(
    "idlers.radius_mm",
    "the limit of the bend ratio, a quarter more than the input's radius, or room for the bearing",
    "bend_ratio",
    _HAS_IDLERS,
)
def radius(given: basis.SpurKnown) -> Found:
    """The limit of the bend ratio, a quarter more than the input, and room for the bearing."""
    stated, bearings = given.has("idlers.bearing"), given.entries("bearings")
    bearing = given.entry("bearings", "idlers.bearing") if stated else bearings[given.guesses["idlers.bearing"]]
    needs = {
        "bend_ratio": given[at.limits.bend_ratio_min] * given.d_mm / 2,
        "life": REVERSE * given.input_mm,
        "idler_bearings": bearing["outer_diameter_mm"] / 2 + WALL_MM + given.d_mm / 2,
    }
    return largest(needs, 0.5)


@rule(
    "idlers.places",
    "one pair as near to the drum as its terminals allow, side by side; the cables pass between the two",
    "idler_room",
    _HAS_IDLERS,
)
def places(given: basis.SpurKnown) -> Found:
    """One pair before the drum: the cables pass between the two, whose flanges leave a gap, and go on to the drum."""
    running, flange = given[at.clearances.running_mm], flange_radius_mm(given["idlers.radius_mm"], given.d_mm)
    across = rounded_up(flange + running, 0.1)
    tensioner = given.entries("tensioners")[given.get(at.drum.tensioner, given.guesses[at.drum.tensioner])]
    corner = REACH * tensioner["thread_mm"]
    reach = hypot(given.drum_mm + corner, tensioner["stud_length_mm"])
    apart = reach + flange + running
    return Found([{"x_mm": across, "z_mm": rounded_up((apart**2 - across**2) ** 0.5, 0.5)}], "idler_room", "up to 0.5")


@rule(
    "idlers.bearing",
    "the lightest that carries the pull of both spans and whose axle is strong enough",
    "idler_bearings",
    _HAS_IDLERS,
)
def idler_bearing(given: basis.SpurKnown) -> Found:
    return given.first("idlers.bearing", head_parts.by_mass(given, "bearings"), ("idler_bearings", "idler_axles"))


@rule(
    "idlers.width_mm",
    "least land for the walk of the cable and its rise, and for two bearings",
    "idler_walk",
    _HAS_IDLERS,
)
def width(given: basis.SpurKnown) -> Found:
    bearing = given.entry("bearings", "idlers.bearing")
    return given.moved("idlers.width_mm", 2.0 * bearing["width_mm"] + 1.0, 0.1, ("idler_walk",))


FRAME = (
    head_dims.motor_shelf,
    Rule(
        at.support.side_wall_mm,
        "usual thickness for the stiffness and for making it in its material",
        "walls",
        head_dims.side_wall,
    ),
    bridge,
    head_dims.bearing_shelf,
    head_dims.encoder_shelf,
    head_dims.coupling_space,
    plate,
)
DRUM = head_dims.drum_rules(_outer_face)
WIDTH = (idler_bearing, width)


DERIVED = tuple(
    rule.field
    for rule in (*basis.WINDING, *WIDTH, *FRAME, centre_distance, *DRUM, back)
    if rule.field not in (at.transmission.turns, at.drum.windows)
)


# Requirements, rope, train, radii, parts, frame, drum.
RULES: tuple[Rule, ...] = (
    *LIMITS,
    basis.land_edge,
    *METALS,
    *STAGE_RATIO,
    *FIRST,
    # With a ratio or radii given, motor and gearhead follow from the ratio; else the ratio from the motor.
    *TRAIN,
    basis.ratio,
    basis.thinnest_rope,
    *ROPE_LIMITS,
    basis.drum_radius,
    radius,
    places,
    basis.least_preload,
    *head_parts.PARTS,
    *STAGE,
    *FRAME,
    *basis.WINDING,
    *WIDTH,
    centre_distance,
    # The centre distance makes room for it.
    head_dims.mount_screw(MOUNT_BOLTS),
    *DRUM,
    back,
)


STIFFENERS = (*stiff_sizing.SHARED, *stiff_sizing.walls("plate", "bridge", "side_wall"))


def _whole(turns: float, factor: float) -> float:
    """A whole number of turns; a name, since freedoms go to the workers of a cluster."""
    return max(1, round(turns * factor))


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_rules.PARTS,
    common_rules.SURFACE,
    Freedom(at.support.mount_screw, words=tuple(MOUNT_BOLTS)),
    Freedom(at.transmission.turns, 0.7, 2.0, _whole),
    Freedom(at.transmission.drum_radius_mm, 0.7, 2.0, mends=((ALL_RADII, 1),)),
    Freedom(at.transmission.input_to_drum, 0.7, 1.5),
    Freedom("stage.ratio", 0.5, 2.0),
    Freedom("idlers.bearing", kind="bearings", order="bore_mm"),
)


def _first_guesses(given: basis.SpurKnown) -> dict[str, Any]:
    """Values of a drive of medium size, for fields that the first pass does not know yet."""
    radius = float(given.peek(at.transmission.drum_radius_mm) or 80.0)
    return {
        **trial_sizing.MIDDLE_SIZE,
        **GUESSES.get(str(given.peek("stage.kind")), {}),
        **(trial_sizing.ON_SHAFT if given.overhung else {}),
        at.rope.helix_lead_mm: 1.5,
        at.transmission.turns: 5,
        at.transmission.centre_distance_mm: 1.4 * radius,
        at.drum.tensioner: "M3",
        at.drum.sector_half_angle_deg: WHOLE_DEG if given.whole_drum else 110.0,
        at.drum.rim_inner_radius_mm: 0.8 * radius,
        at.drum.outer_face_y_mm: 20.0,
        at.drum.hub_face_y_mm: 30.0,
        at.support.side_wall_mm: 4.0,
        at.support.bridge_mm: 4.0,
        at.support.plate_mm: 8.0,
        at.support.mount_screw: "M3",
        **idler_guesses(given, radius),
    }


def _missing(given: basis.SpurKnown) -> Iterator[Broken]:
    yield from missing_travel(given, "travel from the centre to each side")
    if not given.has(at.loads.peak_torque_Nm):
        yield needed(at.loads.peak_torque_Nm, "add peak_torque_Nm: 2.15 (torque to hold both ways, N m)")
    if given.has(at.transmission.input_radius_mm) and not given.has(at.transmission.drum_radius_mm):
        yield needed(at.transmission.drum_radius_mm, "add drum_radius_mm: 59.4 (drum pitch radius)")


def _open_ratio(given: basis.SpurKnown) -> str:
    """A ratio with neither a motor from which it follows nor a first stage, with which it follows otherwise."""
    known = given.has_ratio or given.has(at.drive.motor) or given.has("first_stage")
    return "" if known else at.transmission.input_to_drum


def spur_rules(known: type[basis.SpurKnown], names: tuple[Rule, ...]) -> SizingRules:
    """The sizing of inputs beside the drum, with the ``known`` of the configuration and its rules for names."""
    first = (SCHEMA_VERSION, half_travel, *names)
    return SizingRules(
        known, first, RULES, STIFFENERS, _first_guesses, _missing, _open_ratio, lambda given: bool(given.anchored)
    )


SIZING_RULES = spur_rules(basis.SpurKnown, basis.NAMES)


def size(data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
    """As :class:`~mbcdm_cad.layouts.open_ratio.SizingRules`; the input of a first stage stands where it has room."""
    return with_room(partial(SIZING_RULES, moved=moved), data, similar)
