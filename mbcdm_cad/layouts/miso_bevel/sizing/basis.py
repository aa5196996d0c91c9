"""The first rules: names and order of cables, limits, clearances, materials."""

from __future__ import annotations

from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, RUN_OUT_MM
from mbcdm_cad.layouts.common_rules import (
    BEND_RATIO,
    DRUM_MATERIAL,
    MESH_TOLERANCE,
    PRELOAD_SHARE,
    RUNNING,
    SCHEMA_VERSION,
    SHAFT_MATERIAL,
    STOP_CLEARANCE,
    SUPPORT_MATERIAL,
    TENSION_SAFETY,
    TEST_TORQUE,
    TRANSFER_GAP,
)
from mbcdm_cad.layouts.miso_bevel.design_file.schema import REFERENCE
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.sizing.arithmetic import greatest, least
from mbcdm_cad.sizing.rule import Found, Rule, constant, driver_of, rounded_down


def _land_edge(given: BevelKnown) -> Found:
    """Edge margin, mm: chamfer and run-out; less with a thin rope, since the bodies must clear each other."""
    limit = given.d_mm / 2 - RUN_OUT_MM
    wanted = EDGE_BREAK_MM + RUN_OUT_MM
    if given.has("transmission.drum_radii_mm") and _guide_is_known(given):
        rises = [b - a for a, b in zip(given.guide_mm, given.guide_mm[1:], strict=False)]
        limit = least(limit, rounded_down(least(*rises) - given.d_mm / 2, 0.001))
    driver = driver_of({"land_edge": wanted, "land_width": limit}, min)
    return Found(round(greatest(least(wanted, limit), EDGE_BREAK_MM), 4), driver)


def _guide_is_known(given: BevelKnown) -> bool:
    return given.has("transmission.guide_radii_mm") or given.has("transmission.ratios.guide_to_drum")


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
    TEST_TORQUE,
    BEND_RATIO,
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
CLEARANCES = (
    Rule(
        "clearances.land_edge_mm",
        "a broken edge and the run-out of the cutter, or less if the steps of the radii leave less",
        "land_edge",
        _land_edge,
    ),
    TRANSFER_GAP,
)
