"""The first rules: names and order of cables, limits, clearances, materials; the rope, its preload and its lead."""

from __future__ import annotations

from itertools import pairwise
from math import radians, sqrt, tan

from mbcdm_cad.checks.geometry import CABLE_GAP_MM
from mbcdm_cad.checks.input_pulley import SHOULDER_MM
from mbcdm_cad.checks.ratios import ANCHOR_RATIO
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, RUN_OUT_MM
from mbcdm_cad.design.blocks import Making
from mbcdm_cad.design.bought import TerminationSpec
from mbcdm_cad.layouts.common_rules import (
    DRUM_MATERIAL,
    LEAST_WIRE_RATIO,
    MESH_TOLERANCE,
    PRELOAD_SHARE,
    RUNNING,
    SCHEMA_VERSION,
    SHAFT_MATERIAL,
    STOP_CLEARANCE,
    SUPPORT_MATERIAL,
    TENSION_SAFETY,
    bend_ratio,
    end_share,
    ropes_to_choose,
    test_torque,
    transfer_gap,
)
from mbcdm_cad.layouts.head_basis import counts_losses
from mbcdm_cad.layouts.miso_bevel.design_file.schema import REFERENCE
from mbcdm_cad.layouts.miso_bevel.sizing.known import LEAD_STEP_MM, STEPS, UNEVEN, BevelKnown
from mbcdm_cad.parts.input_pulley.dims import neck_mm, widest_bend_mm
from mbcdm_cad.sizing.rule import Found, constant, driver_of, rounded_down, rounded_up, rule, significant


@rule(
    "clearances.land_edge_mm",
    "a broken edge and the run-out of the cutter, or less if the steps of the radii leave less",
    "land_edge",
)
def land_edge(given: BevelKnown) -> Found:
    """Edge margin, mm: chamfer and run-out; less with a thin rope, since the bodies must clear each other."""
    limit = given.d_mm / 2 - RUN_OUT_MM
    wanted = EDGE_BREAK_MM + RUN_OUT_MM
    if given.has("transmission.drum_radii_mm") and (
        given.has("transmission.guide_radii_mm") or given.has("transmission.ratios.guide_to_drum")
    ):
        rises = [b - a for a, b in zip(given.guide_mm, given.guide_mm[1:], strict=False)]
        limit = min(limit, rounded_down(min(rises) - given.d_mm / 2, 0.001))
    driver = driver_of({"land_edge": wanted, "land_width": limit}, min)
    return Found(round(max(min(wanted, limit), EDGE_BREAK_MM), 4), driver)


NAMES = (
    SCHEMA_VERSION,
    constant("inputs", REFERENCE.inputs, "one on each side of the guide", "the configuration"),
    constant(
        "cables",
        REFERENCE.cables,
        "two for each input, on neighbouring steps, one for each sense of the drum",
        "the configuration",
    ),
)
LIMITS = (
    STOP_CLEARANCE,
    test_torque,
    bend_ratio,
    constant("limits.fleet_angle_max_deg", 1.5, "usual limit for smooth pulleys", "fleet_angle"),
    TENSION_SAFETY,
    PRELOAD_SHARE,
    MESH_TOLERANCE,
    constant("rope.dead_turns", 1.0, "one turn that never unwinds; its friction relieves the stop", "dead_turns"),
    RUNNING,
)
METALS = (
    DRUM_MATERIAL,
    SHAFT_MATERIAL,
    constant("guide.material", "aluminium-7075", "light; the part is turned", "process"),
    constant("guide.axle_material", "steel", "made from ground bar", "process"),
    constant("input_pulleys.material", "steel", "allows thin walls round stops and bore", "stop_pocket_wall"),
    SUPPORT_MATERIAL,
)
CLEARANCES = (land_edge, transfer_gap)


# Preload over the least at which no cable goes slack at peak torque, cables assumed equal.
PRELOAD_FACTOR = 2.0
# The same if a rope for that preload is too thick: with this factor the longest cable is still taut.
LEAST_PRELOAD_FACTOR = 1.3
# Termination of a rope that the rule chooses, and the thinnest wall of the input pulleys' steel.
USUAL_END, WALL_MM = "swaged", 0.5
# Strength of a swaged end over the rope's, before rope and ends are chosen.
SWAGED_SHARE = 0.9
# Strength over the safety factor, because steps and ends are not known yet when the rope is chosen.
STRENGTH_SPARE = 1.01
# The same if the rope's strength limits the preload: the tension added by the peak torque is an estimate.
HELD_SPARE = 1.02
# What the tolerance of the rope's diameter adds to the lead, over that tolerance: a span gains 0.85 of the lead, other
# tolerances add a little, and the spare of the clearing lead is in it.
THICKER_SPARE = 0.9
# Mean drum radius over that of step 1, before the steps are known.
MEAN_OVER_FIRST = 1.1


def _share_N(given: BevelKnown) -> float:
    """Tension that the peak torque adds to a cable, N, shared by four cables."""
    return float(given["loads.peak_torque_Nm"] * 1e3 / (STEPS * MEAN_OVER_FIRST * given.first_drum_mm))


@rule(
    "rope.type",
    "the thinnest wire rope that holds preload and peak torque with its safety factor",
    "tension",
    lambda given: not given.has("rope.inline"),
)
def rope(given: BevelKnown) -> Found:
    """The thinnest rope of the construction that holds preload and peak torque.

    If the input pulleys are too thin for it, the thickest that they allow, provided that it holds a smaller preload.
    """
    ropes = ropes_to_choose(given)

    def strong(preload_N: float) -> list[tuple[float, str]]:
        held = end_share(given, SWAGED_SHARE)
        share, spare = _share_N(given), STRENGTH_SPARE * given["limits.tension_safety_factor"] / held
        return [(d, name) for d, name, breaking in ropes if breaking >= (UNEVEN * share + preload_N) * spare]

    wanted = strong(PRELOAD_FACTOR * _share_N(given))
    least = strong(LEAST_PRELOAD_FACTOR * _share_N(given))
    if not wanted:
        return Found(ropes[-1][1], "tension", "the thickest of the catalogue")
    thin = [name for d, name in least if d < wanted[0][0] and _bends(given, d)]
    if thin and not _bends(given, wanted[0][0]):
        return Found(thin[-1], "anchor_bend", "next smaller size of the catalogue")
    return Found(wanted[0][1], "tension", "next size of the catalogue")


def _bends(given: BevelKnown, d_mm: float) -> bool:
    """Whether the smallest input pulley has room for a wire rope's bend, its stop, and a neck round the shaft."""
    radius = given.first_drum_mm / given.total_ratio
    needed = given["loads.peak_torque_Nm"] * 1e3 / (2 * given.total_ratio)
    shafts = [head["shaft_diameter_mm"] for head in given.entries("gearheads").values()]
    shaft = min(
        (h["shaft_diameter_mm"] for h in given.entries("gearheads").values() if h["max_torque_mNm"] >= needed),
        default=max(shafts),
    )
    name = given.get("rope.termination") or USUAL_END
    entry = given.entries("terminations")[name]
    end = TerminationSpec(name=name, **{**entry, "constructions": tuple(entry["constructions"])})
    return bool(
        2 * radius >= LEAST_WIRE_RATIO * d_mm
        and 2 * widest_bend_mm(d_mm, end, WALL_MM, radius) >= ANCHOR_RATIO * d_mm
        and neck_mm(d_mm, end, WALL_MM, radius) >= shaft / 2 + WALL_MM + SHOULDER_MM
    )


@rule("rope.preload_N", "twice the preload that keeps every cable taut at peak torque", "no_slack")
def preload(given: BevelKnown) -> Found:
    share = _share_N(given)
    most = given["limits.preload_share_max"] * given.rope["breaking_load_N"]
    ends = given.rope["breaking_load_N"] * given.termination.strength_share
    held = ends / (given["limits.tension_safety_factor"] * HELD_SPARE) - UNEVEN * share
    usual = PRELOAD_FACTOR * share
    driver = driver_of({"no_slack": usual, "tension": min(most, held)}, min)
    return Found(significant(max(min(usual, most, held), 0.5 * usual), 2), driver, "two digits")


@rule(
    "rope.helix_lead_mm",
    "the least lead at which a span clears the turn wound before it at the largest fleet angle; room for a thicker "
    "rope where steps and centre distance leave it",
    "self_clearance",
)
def _lead(given: BevelKnown) -> Found:
    """Room for a rope as thick as its tolerance allows, as far as the steps and a stated centre distance leave it."""
    largest_input = max(given.input_mm)
    clearing = given.clearing_lead_mm(largest_input)
    lead = rounded_up(clearing, LEAD_STEP_MM)
    # Files that reckon as the paper does keep its lead.
    if given.get("input_pulleys.surface", "smooth") == "grooved" or not counts_losses(given):
        return Found(lead, "self_clearance", f"up to {LEAD_STEP_MM:g}")
    thicker = given.get("making.rope_diameter_share", Making.rope_diameter_share) * given.d_mm
    wanted = rounded_up(clearing + THICKER_SPARE * thicker, LEAD_STEP_MM)
    step = min(b - a for a, b in pairwise(given.drum_mm))
    room = ((step - given.d_mm) / 2 - CABLE_GAP_MM) / given.walk_mm(1.0)
    wanted = max(lead, min(wanted, rounded_down(room, LEAD_STEP_MM)))
    if given.has("transmission.centre_distance_mm"):
        across = max(given.guide_mm) + largest_input
        span = sqrt(max(given["transmission.centre_distance_mm"] ** 2 - across**2, 1e-6))
        most = span * tan(radians(given.fleet_limit_deg)) / given.walk_mm(1.0)
        wanted = max(lead, min(wanted, rounded_down(most, LEAD_STEP_MM)))
    return Found(wanted, "self_clearance_stack", f"up to {LEAD_STEP_MM:g}")


LEAD = (_lead,)
