"""Rules of the pitch radii and of the places of the pulleys."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan, hypot, inf, pi, sqrt
from typing import Any

import numpy as np

from mbcdm_cad.checks.geometry import CABLE_GAP_MM, HOLE_WEB_MM
from mbcdm_cad.checks.terminals import TERMINAL_GAP_MM
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.cable_path import BLEND_DIAMETERS
from mbcdm_cad.layouts.miso_bevel.checks.room import MOVING_GAP_MM, drum_sweep
from mbcdm_cad.layouts.miso_bevel.design_file.resolve import MOST_SETBACK
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.sizing.boxes import box_mm
from mbcdm_cad.layouts.miso_bevel.sizing.known import LATER, LEAD_STEP_MM, STEPS, BevelKnown, span_for_fleet_mm
from mbcdm_cad.layouts.miso_bevel.support.dims import STOP_WEB_MM
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.boss import BEARING_WALL_MM, EAR_WALL_MM
from mbcdm_cad.parts.coupling import collar_sweep_mm
from mbcdm_cad.parts.motor_head.dims import KEY_PLAY_MM
from mbcdm_cad.sizing.rule import Found, driver_of, largest, rounded_down, rounded_up, rule

STEP_MM = 0.1
# Message for a centre distance that leaves no free span; a search may still find radii for it.
NO_ROOM = "too short for guide and input pulley beside each other"
# Spare of a land's width over what it needs: the gap between a cable's flank and the next land.
FLANK_GAP_MM = 0.045
# Estimates before the values are known: outermost radius and centre distance over the first drum radius; wrap on the
# drum beyond the travel and arc on the guide, both in drum radii.
USUAL_OUTER, USUAL_DISTANCE = 1.4, 0.9
ANCHOR_SPARE_RAD, USUAL_GUIDE = 0.6, 0.7
# The same where a terminal is known: arc of the longest cable on the guide and from there to the drum, in radii of the
# guide's largest step, and its wrap on the drum beyond the travel, both those of drives that the rules size.
GUIDE_ARC_RAD, ANCHOR_RAD = 5.5, 0.5
# Share of the gap between neighbouring terminals that is lost because they are at different angles.
SLANT_MM = 0.4
# The free span is longer by this than the fleet angle needs, so that rounding does not make it too short.
SPAN_SPARE = 1.01


def _wide_enough(given: BevelKnown) -> bool:
    return not given.has("transmission.guide_radii_mm")


def drive_radius_mm(given: BevelKnown) -> float:
    """Half the larger of gearhead and motor."""
    sizes = [float(given.entry(kind, f"drive.{name}")["diameter_mm"]) for kind, name in _DRIVES]
    return max(sizes) / 2


_DRIVES = (("gearheads", "gearhead"), ("motors", "motor"))


def _steps_ratio(given: BevelKnown, step_mm: float) -> float:
    """Outermost drum radius over that of step 1."""
    return 1.0 + (STEPS - 1) * step_mm / given.first_drum_mm


def _swage_mm(given: BevelKnown) -> float:
    return float(given.entry("tensioners", "drum.tensioner")["swage_diameter_mm"] / 2)


def least_step_mm(given: BevelKnown) -> float:
    """Least step for rope, travel and terminals, mm, before lead, gaps and guide are known."""
    d = given.d_mm
    walk = given.walk_mm(d)
    return max(d + 2 * walk, given.nut_pocket_mm - d / 2, given.nut_mm + _swage_mm(given)) + TERMINAL_GAP_MM


def _step_needs(given: BevelKnown, step_mm: float) -> dict[str, float]:
    """Least step from one drum radius to the next for each check, mm."""
    d = given.d_mm
    outer_input = given.first_drum_mm * _steps_ratio(given, step_mm) / given.total_ratio
    lead = rounded_up(given.clearing_lead_mm(outer_input), LEAD_STEP_MM)
    needs = {
        "input_walk": d + 2 * given.walk_mm(lead) + 2 * CABLE_GAP_MM,
        "lands_intact": given.nut_pocket_mm - d / 2 + TERMINAL_GAP_MM,
        "terminals_apart": given.nut_mm + _swage_mm(given) + TERMINAL_GAP_MM + SLANT_MM,
    }
    if given.has("transmission.ratios.guide_to_drum"):
        per_mm = float(given["transmission.ratios.guide_to_drum"])
    else:
        per_mm = given.first_drum_mm / _guide_wanted(given, step_mm)[1]
    needs["land_width"] = per_mm * (d / 2 + given["clearances.land_edge_mm"] + FLANK_GAP_MM)
    return needs


@rule(
    "transmission.drum_radii_mm",
    "equal steps, large enough for the walk on the inputs, for the terminals and for the lands",
    "input_walk",
)
def drum_radii(given: BevelKnown) -> Found:
    """Radii with equal steps; the lead depends on the radii and the step on the lead, so a few passes are needed."""
    step = 3.0
    needs: dict[str, float] = {}
    for _ in range(4):
        needs = _step_needs(given, step)
        step = max(needs.values())
    found = largest(needs, STEP_MM)
    first = given.first_drum_mm
    return Found([round(first + k * found.value, 6) for k in range(STEPS)], found.driver, f"steps {found.rounding}")


def _guide_wanted(given: BevelKnown, step_mm: float) -> tuple[str, float]:
    """(check, least guide radius of step 1) where only the total ratio is given."""
    d, running = given.d_mm, given["clearances.running_mm"]
    nut, gap = given.terminal_mm, given["clearances.transfer_gap_mm"]
    outer_input = given.first_drum_mm * _steps_ratio(given, step_mm) / given.total_ratio
    guide, lower = given.entry("bearings", "guide.bearing"), given.entry("bearings", "input_pulleys.lower_bearing")
    needs = {
        "guide_wall": guide["outer_diameter_mm"] / 2 + given.wall_mm("guide") + d / 2,
        "front_wall": lower["outer_diameter_mm"] / 2 + given.wall_mm("support") + running + max(nut, d / 2 - gap),
        "drum_sweep": outer_input + d + MOVING_GAP_MM + max(nut - d / 2, -gap),
        "bend_ratio": given["limits.bend_ratio_min"] * d / 2,
    }
    radius, room = max(needs.values()), _guide_room_mm(given, outer_input, step_mm)
    if radius > room:
        # Needs that a setback of the inputs can also meet are ignored if the file gives the centre distance.
        left = {name: min(need, room) if name in _MENDED_BY_SETBACK else need for name, need in needs.items()}
        driver = max(left, key=lambda name: left[name])
        return "centre_distance" if driver in _MENDED_BY_SETBACK else driver, left[driver]
    return driver_of(needs, max), float(radius)


_MENDED_BY_SETBACK = ("front_wall", "drum_sweep")


def _guide_room_mm(given: BevelKnown, outer_input_mm: float, step_mm: float) -> float:
    """Largest guide radius of step 1 that a centre distance in the file leaves beside the input pulley."""
    distance = given.get("transmission.centre_distance_mm")
    if distance is None:
        return inf
    d, outer = given.d_mm, _steps_ratio(given, step_mm)
    walk = given.walk_mm(rounded_up(given.grooved_lead_mm(outer_input_mm), LEAD_STEP_MM))
    span = max(span_for_fleet_mm(walk, given.grooved_fleet_deg) * SPAN_SPARE, 2 * BLEND_DIAMETERS * d)
    across = min(sqrt(max(distance**2 - span**2, 0.0)), distance - d - given["clearances.running_mm"])
    return float((across - outer_input_mm) / outer)


@rule(
    "transmission.ratios.guide_to_drum",
    "the smallest guide with space for its bearing, for the front walls beside the input bearings and for the "
    "inputs behind the drum",
    "guide_wall",
    _wide_enough,
)
def guide_to_drum(given: BevelKnown) -> Found:
    if given.has("transmission.ratios.input_to_guide"):
        return Found(given["transmission.ratio"] / given["transmission.ratios.input_to_guide"], "transmission.ratio")
    step = given.drum_mm[1] - given.drum_mm[0] if given.has("transmission.drum_radii_mm") else 3.6
    driver, radius = _guide_wanted(given, step)
    if driver == "centre_distance":
        return Found(rounded_up(given.first_drum_mm / radius, 0.01), driver, "up to 0.01")
    return Found(rounded_down(given.first_drum_mm / radius, 0.05), driver, "down to 0.05")


@rule(
    "transmission.ratios.input_to_guide",
    "the total ratio over the ratio of guide to drum",
    "transmission.ratio",
    _wide_enough,
)
def input_to_guide(given: BevelKnown) -> float:
    return float(round(given["transmission.ratio"] / given["transmission.ratios.guide_to_drum"], 9))


@rule(
    "transmission.centre_distance_mm",
    "the shortest free span within the limit of the fleet angle, with space for pulleys, drives and encoders",
    "fleet_angle",
)
def centre_distance(given: BevelKnown) -> Found:
    d, running = given.d_mm, given["clearances.running_mm"]
    fleet = given.fleet_limit_deg
    guide, pulley = max(given.guide_mm), max(given.input_mm)
    span = span_for_fleet_mm(given.walk_mm(given["rope.helix_lead_mm"]), fleet) * SPAN_SPARE
    apart = _apart_mm(given, given.motors_above)
    setback = _expected_setback_mm(given)
    needs = {
        "fleet_angle": hypot(span, guide + pulley),
        "pulley_gap": guide + pulley + d + running,
        "centre_distance": hypot(guide + pulley, 2 * BLEND_DIAMETERS * d),
        # The gap between the drives is along x, and the inputs' x is sqrt(L^2 - setback^2).
        "drives_apart": hypot(apart, setback),
        "transmission.input_setback_mm": setback / MOST_SETBACK,
    }
    return largest(needs, STEP_MM)


def _apart_mm(given: BevelKnown, above: bool) -> float:
    """Least distance of an input's axis from the plane x = 0 for drives, encoders, column and boss."""
    running = given["clearances.running_mm"]
    drum_bearing = given.entry("bearings", "drum.bearing")
    ring, input_encoder = given.entry("encoders", "drive.drum_encoder"), given.entry("encoders", "drive.encoder")
    encoder = input_encoder["diameter_mm"] / 2
    if above:
        return float(max(drive_radius_mm(given) + running, box_mm(given) + _axle_mm(given), encoder + _web_mm(given)))
    ears = ring["bolt_circle_mm"] / 2 + given.screw(ring["screw"]).thread_mm / 2 + EAR_WALL_MM
    column = max(drum_bearing["outer_diameter_mm"] / 2 + BEARING_WALL_MM, ears, ring["diameter_mm"] / 2)
    return float(max(drive_radius_mm(given) + column, encoder) + running)


def _crowded_below(given: BevelKnown) -> bool:
    """Whether the stated centre distance leaves space for motors above only."""
    if not given.has("transmission.centre_distance_mm"):
        return False
    distance = given["transmission.centre_distance_mm"]
    return bool(distance < _apart_mm(given, False)) and bool(distance >= _apart_mm(given, True))


# Where it does not apply, the schema's own value stays.
@rule(
    "drive.motor_side",
    "above, because the stated centre distance leaves no space for the drives beside the drum's bearings",
    "drives_apart",
    _crowded_below,
)
def motor_side(given: BevelKnown) -> str:
    return "above" if _crowded_below(given) else "below"


def _axle_mm(given: BevelKnown) -> float:
    """From the plane x = 0 past the guide's axle to a coupling box."""
    return float(given.entry("bearings", "guide.bearing")["bore_mm"] / 2 + HOLE_WEB_MM)


def _web_mm(given: BevelKnown) -> float:
    """From the plane x = 0 past web and pocket's corner to an encoder, with the smallest cutter."""
    corner = given.entry("materials", "support.material")["min_internal_radius_mm"]
    return float(STOP_WEB_MM / 2 + max(corner, given["clearances.running_mm"]))


@rule(
    "input_pulleys.surface",
    "smooth, or grooved if the stated centre distance gives a fleet angle that only grooves allow",
    "fleet_angle",
)
def surface(given: BevelKnown) -> Found:
    """Smooth, unless the given centre distance causes a fleet angle that only grooves allow."""
    if not given.has("transmission.centre_distance_mm"):
        return Found("smooth", "centre distance follows")
    distance = given["transmission.centre_distance_mm"]
    across = max(given.guide_mm) + max(given.input_mm)
    if distance <= across:
        raise SizingError(
            Broken(
                ("transmission", "centre_distance_mm"),
                NO_ROOM,
                _shown_mm(distance),
                f"over {_shown_mm(across)}, their radii",
                "raise it, lower the drum's radius, or leave it out",
                may_move=True,
            )
        )
    span = sqrt(max(distance**2 - across**2, 1e-6))
    angle = atan(given.walk_mm(given.clearing_lead_mm(max(given.input_mm))) / span) * 180.0 / pi
    return Found("smooth" if angle <= given["limits.fleet_angle_max_deg"] else "grooved", "fleet_angle")


def _shown_mm(length_mm: float) -> str:
    """A length for a message; of a column the shortest."""
    return f"{float(np.min(length_mm)):.4g} mm"


@rule("transmission.input_setback_mm", "the least with which drum and terminals clear the drives", "drum_sweep")
def _setback(given: BevelKnown) -> Found:
    """Zero if the drum passes drives and pulleys without setback; else the setback at which its terminals pass them."""
    passing = {"drum_sweep": 0.0} if _drum_passes(given) else _passing_needs_mm(given)
    return largest({**passing, "front_wall": _front_wall_mm(given)}, STEP_MM)


def _expected_setback_mm(given: BevelKnown) -> float:
    """The setback of the file, else the one with which the drum passes in front of the drives.

    Whether the drum also clears them without a setback is known only after the frame is sized.
    """
    if given.has("transmission.input_setback_mm"):
        return float(given["transmission.input_setback_mm"])
    needs = (*_passing_needs_mm(given).values(), _front_wall_mm(given))
    return rounded_up(max(0.0, *needs), STEP_MM)


def _lowest_mm(given: BevelKnown) -> float:
    """Lowest y of the parts that turn with the drum: its inner face or a terminal."""
    return min(given.guide_mm[0] - given.terminal_mm, given.drum_inner_mm)


def _front_wall_mm(given: BevelKnown) -> float:
    """Least setback with which the frame has a wall in front of the seats of the inputs' bearings and gearheads."""
    lower, upper = (given.entry("bearings", f"input_pulleys.{end}_bearing") for end in ("lower", "upper"))
    gear = given.gearhead
    seat = max(lower["outer_diameter_mm"], upper["outer_diameter_mm"]) / 2
    if given.motors_above:
        # Nothing else keeps the holes for the key of the gearheads' screws behind the front of the plate.
        turn = given.get("drive.gearhead_angle_deg", 0.0)
        places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, turn)
        seat = max(seat, max(y for _, y in places) + given.screw(gear.screw).key_mm / 3**0.5 + KEY_PLAY_MM)
    else:
        seat = max(seat, gear.pilot_diameter_mm / 2)
    return float(seat + given.wall_mm("support") - (_lowest_mm(given) - given["clearances.running_mm"]))


def _passing_needs_mm(given: BevelKnown) -> dict[str, float]:
    """Least setbacks with which drum and terminals pass in front of drives, collars and pulleys."""
    d, lowest = given.d_mm, _lowest_mm(given)
    if given.motors_above:
        drives = given.entry("encoders", "drive.encoder")["diameter_mm"] / 2
    else:
        drives = drive_radius_mm(given)
    collars = {} if given.motors_above else {"collars": _collar_mm(given) + MOVING_GAP_MM - lowest}
    return {
        "drum_sweep": drives + given["clearances.running_mm"] - lowest,
        **collars,
        "input pulleys": max(given.input_mm) + d / 2 + MOVING_GAP_MM - min(lowest, given.guide_mm[0] - d / 2),
    }


def _drum_passes(given: BevelKnown) -> bool:
    """Whether drum, terminals and cables pass drives and pulleys that are not set back."""
    try:
        return drum_sweep(BevelLayout(given.trial(**LATER))).holds
    except NoFigureError:
        return True


def _collar_mm(given: BevelKnown) -> float:
    journal = given.entry("bearings", "input_pulleys.lower_bearing")["bore_mm"]
    return collar_sweep_mm(given, journal, given.wall_mm("support"), given["input_pulleys.collar_screw"])


def take_up_mm(given: BevelKnown) -> float:
    """Take-up of the longest cable for stretch, bedding-in and cut length, mm, estimated conservatively.

    As long as steps and centre distance are open, those of a drive with usual proportions are used.
    """
    first = given.first_drum_mm
    known = given.has("transmission.drum_radii_mm")
    outer = max(given.drum_mm) if known else USUAL_OUTER * first
    distance = float(given.get("transmission.centre_distance_mm", USUAL_DISTANCE * first))
    wound = 2 * outer * given.half_travel_rad + 2 * pi * outer / given.total_ratio * given["rope.dead_turns"]
    return _take_up_of(given, wound + distance + outer * (ANCHOR_SPARE_RAD + USUAL_GUIDE))


def take_up_with_mm(given: BevelKnown, terminal: Mapping[str, Any]) -> float:
    """The same with a terminal of the catalogue, mm, from the least radii that rope, travel and terminal allow.

    At a small ratio half of the cable lies on guide and input pulley, so that the usual proportions are too short.
    """
    d, first = given.d_mm, given.first_drum_mm
    nut = terminal["nut_across_flats_mm"] / sqrt(3.0)
    walk = given.walk_mm(d)
    step = max(d + 2 * walk, nut + terminal["swage_diameter_mm"] / 2 + SLANT_MM) + TERMINAL_GAP_MM
    outer = max(given.drum_mm) if given.has("transmission.drum_radii_mm") else first + (STEPS - 1) * step
    pulley = outer / given.total_ratio
    if given.has("transmission.ratios.guide_to_drum"):
        guide = outer / given["transmission.ratios.guide_to_drum"]
    else:
        beside = pulley + d + MOVING_GAP_MM + nut
        guide = max(beside, given["limits.bend_ratio_min"] * d / 2) * outer / first
    distance = given.get("transmission.centre_distance_mm")
    if distance is None:
        span = span_for_fleet_mm(walk, given["limits.fleet_angle_max_deg"])
    else:
        span = sqrt(max(distance**2 - (guide + pulley) ** 2, 0.0))
    wound = 2 * outer * given.half_travel_rad + 2 * pi * pulley * given["rope.dead_turns"]
    return _take_up_of(given, wound + span + GUIDE_ARC_RAD * guide + ANCHOR_RAD * outer)


def _take_up_of(given: BevelKnown, length_mm: float) -> float:
    cut = 2 * float(given.get("rope.cut_tolerance_mm", 0.5))
    stretch = given["rope.preload_N"] / (given.modulus_GPa * 1e3 * given.area_mm2)
    setting = 2 * given.termination.setting_ratio * given.d_mm
    return float(length_mm * (stretch + given.rope["bedding_in_share"]) + cut + setting)


RATIOS = (guide_to_drum, input_to_guide)
SETBACK = (_setback,)
