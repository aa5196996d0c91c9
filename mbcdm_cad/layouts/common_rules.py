"""Rules that every configuration has: limits, the rope's limits, clearances, materials; and required fields."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, RUN_OUT_MM
from mbcdm_cad.design.rules import Broken, broken_ends
from mbcdm_cad.sizing.arithmetic import greatest, significant
from mbcdm_cad.sizing.known import KnownFields, RopeKnown
from mbcdm_cad.sizing.rule import Found, Rule, constant, driver_of

# Least D/d in the rope makers' tables of wire rope; they state no life below it.
LEAST_WIRE_RATIO = 10.0
# Screws of the clamp collars, by size.
COLLAR_SCREWS = ("M1.6x6", "M2x8", "M2.5x10", "M3x12", "M4x16", "M5x20", "M6x25")
# Share of the peak torque at which backlash is stated, if the file has no test torque.
TEST_SHARE = 0.3


def _is_braid(given: RopeKnown) -> bool:
    known = given.has("rope.type") or given.has("rope.inline")
    return known and given.rope["construction"] == "braid"


def _bend_ratio(given: RopeKnown) -> Found:
    if _is_braid(given):
        return Found(given.rope["bend_ratio_minimum"], "the rope's own minimum")
    return Found(LEAST_WIRE_RATIO, "rope makers' tables of wire rope begin at 10")


def _friction(given: RopeKnown) -> float:
    return 0.1 if _is_braid(given) else 0.15


def _test_torque(given: KnownFields) -> float:
    return significant(TEST_SHARE * given["loads.peak_torque_Nm"], 2)


def _transfer_gap(given: RopeKnown) -> Found:
    """Half a rope minus the land's edge margin and the chamfer, mm, but at least the run-out."""
    wide = given.d_mm / 2 - given["clearances.land_edge_mm"] - EDGE_BREAK_MM
    driver = driver_of({"bodies_clear": RUN_OUT_MM, "transfer_gap": wide}, max)
    return Found(round(greatest(wide, RUN_OUT_MM), 4), driver)


def needed(field: str, remedy: str) -> Broken:
    """The error for a missing requirement."""
    what = "missing; it is a requirement, so no sizing rule gives it"
    return Broken(tuple(field.split(".")), what, "", "", remedy, missing=True)


def missing_travel(given: KnownFields, meaning: str) -> Iterator[Broken]:
    """What the file lacks, or contradicts, of the travel: half of it, or both ends."""
    ends = given.peek("travel.from_deg"), given.peek("travel.to_deg")
    yield from broken_ends(*ends)
    if ends == (None, None) and not given.has("travel.half_angle_deg"):
        yield needed("travel.half_angle_deg", f"add half_angle_deg: 35.0 ({meaning}, deg), or from_deg and to_deg")


def _half_travel(given: KnownFields) -> float:
    return float(given["travel.to_deg"] - given["travel.from_deg"]) / 2


HALF_TRAVEL = Rule(
    "travel.half_angle_deg",
    "half of the way from from_deg to to_deg; the drum is centred in its middle",
    "the file",
    _half_travel,
)
SCHEMA_VERSION = constant("schema_version", 1, "the version of the file's layout", "the program")
STOP_CLEARANCE = constant(
    "travel.stop_clearance_deg",
    STOP_WINDOW_DEG / 2,
    "middle of the range beyond the travel in which the stops must engage",
    "stop_within_half_degree",
)
TEST_TORQUE = Rule("loads.test_torque_Nm", "0.3 of the peak torque", "loads", _test_torque)
BEND_RATIO = Rule("limits.bend_ratio_min", "least D/d for which the rope's maker states a life", "life", _bend_ratio)
TENSION_SAFETY = constant("limits.tension_safety_factor", 5.0, "usual factor; rope makers state 5 to 10", "tension")
PRELOAD_SHARE = constant("limits.preload_share_max", 0.5, "rope makers' limit: less than half", "preload_share")
MESH_TOLERANCE = constant("export.mesh_tolerance_mm", 0.01, "finer than the tolerances of usual workshops", "export")
RUNNING = constant(
    "clearances.running_mm", 0.25, "gap for the tolerances and the run-out of moving parts", "frame_front"
)
FRICTION = Rule(
    "rope.friction_coefficient", "usual value of dry wire rope, or of smooth fibre, on metal", "rope", _friction
)
TRANSFER_GAP = Rule(
    "clearances.transfer_gap_mm",
    "half the rope's diameter less the edge margin of the land and a broken edge",
    "transfer_gap",
    _transfer_gap,
)
DRUM_MATERIAL = constant("drum.material", "aluminium-7075", "light and strong; the part is milled", "process")
SHAFT_MATERIAL = constant("drum.shaft_material", "steel", "made from ground bar", "process")
SUPPORT_MATERIAL = constant("support.material", "aluminium-7075", "light and stiff; the part is milled", "process")
