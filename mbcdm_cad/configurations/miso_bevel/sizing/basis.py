"""Rules of what comes first: names and order of cables, limits, clearances, materials."""

from __future__ import annotations

from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, RUN_OUT_MM
from mbcdm_cad.configurations.miso_bevel.design_file.reference import CABLES, INPUTS
from mbcdm_cad.configurations.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.sizing.rule import Found, Rule, constant, rounded_down

# D/d below which no life is promised: rope makers' tables of wire rope end there.
LEAST_WIRE_RATIO = 10.0
# Share of the peak torque at which the backlash is asked for, where the file names no test torque.
TEST_SHARE = 0.3


def _is_braid(given: BevelKnown) -> bool:
    known = given.has("rope.type") or given.has("rope.inline")
    return known and given.rope["construction"] == "braid"


def _bend_ratio(given: BevelKnown) -> Found:
    if _is_braid(given):
        return Found(given.rope["bend_ratio_minimum"], "the rope's own minimum")
    return Found(LEAST_WIRE_RATIO, "rope makers' tables of wire rope begin at 10")


def _friction(given: BevelKnown) -> float:
    return 0.1 if _is_braid(given) else 0.15


def _test_torque(given: BevelKnown) -> float:
    return float(f"{TEST_SHARE * given['loads.peak_torque_Nm']:.2g}")


def _land_edge(given: BevelKnown) -> Found:
    """A broken edge and the run-out beyond it; a thin rope leaves less, since bodies must clear each other."""
    limit = given.d_mm / 2 - RUN_OUT_MM
    wanted = EDGE_BREAK_MM + RUN_OUT_MM
    if given.has("transmission.drum_radii_mm") and _guide_is_known(given):
        rises = [b - a for a, b in zip(given.guide_mm, given.guide_mm[1:], strict=False)]
        limit = min(limit, rounded_down(min(rises) - given.d_mm / 2, 0.001))
    driver = "land_edge" if wanted <= limit else "land_width"
    return Found(round(max(min(wanted, limit), EDGE_BREAK_MM), 4), driver)


def _guide_is_known(given: BevelKnown) -> bool:
    return given.has("transmission.guide_radii_mm") or given.has("transmission.ratios.guide_to_drum")


def _transfer_gap(given: BevelKnown) -> Found:
    """What is left of half a rope behind the land's edge and a broken edge, but never less than the run-out."""
    wide = given.d_mm / 2 - given["clearances.land_edge_mm"] - EDGE_BREAK_MM
    return Found(round(max(wide, RUN_OUT_MM), 4), "transfer_gap" if wide > RUN_OUT_MM else "bodies_clear")


NAMES = (
    constant("schema_version", 1, "the version of the file's layout", "the program"),
    constant("inputs", INPUTS, "one input on each side of the guide", "the configuration"),
    constant(
        "cables", CABLES, "two cables of each input, on neighbouring steps and to both sides", "the configuration"
    ),
)
LIMITS = (
    constant(
        "travel.stop_clearance_deg",
        STOP_WINDOW_DEG / 2,
        "the stops engage half way in their window behind the travel",
        "stop_within_half_degree",
    ),
    Rule("loads.test_torque_Nm", "three tenths of the peak torque, where no test is named", "loads", _test_torque),
    Rule("limits.bend_ratio_min", "least D/d at which the rope has a life at all", "life", _bend_ratio),
    constant("limits.fleet_angle_max_deg", 1.5, "usual limit for smooth drums", "fleet_angle"),
    constant("limits.tension_safety_factor", 5.0, "rope makers: 5 to 10", "tension"),
    constant("limits.preload_share_max", 0.5, "rope makers: under half", "preload_share"),
    constant("export.mesh_tolerance_mm", 0.01, "meshes finer than a workshop's tolerances", "export"),
    constant("rope.dead_turns", 1.0, "one turn holds the stop by friction and never unwinds", "dead_turns"),
    constant("clearances.running_mm", 0.25, "room beside moving parts: tolerances and run-out", "frame_front"),
)
METALS = (
    constant("drum.material", "aluminium-7075", "light and strong, milled", "process"),
    constant("drum.shaft_material", "steel", "ground bar", "process"),
    constant("guide.material", "aluminium-7075", "light, turned", "process"),
    constant("guide.axle_material", "steel", "ground bar", "process"),
    constant("input_pulleys.material", "steel", "thin walls round stops and bore", "stop_pocket_wall"),
    constant("support.material", "aluminium-7075", "light and stiff, milled", "process"),
)
FRICTION = (Rule("rope.friction_coefficient", "dry wire rope, or smooth fibre, on metal", "rope", _friction),)
CLEARANCES = (
    Rule(
        "clearances.land_edge_mm",
        "a broken edge and the run-out beyond it, as far as the rise from step to step leaves it",
        "land_edge",
        _land_edge,
    ),
    Rule(
        "clearances.transfer_gap_mm",
        "half a rope less the land's edge and a broken edge",
        "transfer_gap",
        _transfer_gap,
    ),
)
