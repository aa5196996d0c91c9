"""Rules of what comes first for drives with a motor head: limits, materials, motor and gearhead, the rope's limits."""

from __future__ import annotations

from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.configurations.trial_sizing import TrialKnown
from mbcdm_cad.design.bought import NO_GEARHEAD
from mbcdm_cad.sizing.rule import Found, Rule, constant, rounded_up

# D/d below which no life is promised: rope makers' tables of wire rope end there.
LEAST_WIRE_RATIO = 10.0
# Share of the peak torque at which the backlash is asked for, where the file names no test torque.
TEST_SHARE = 0.3
# Rated torque over what the peak torque asks of the motor.
TORQUE_SPARE = 1.02


def _is_braid(given: TrialKnown) -> bool:
    known = given.has("rope.type") or given.has("rope.inline")
    return known and given.rope["construction"] == "braid"


def _bend_ratio(given: TrialKnown) -> Found:
    if _is_braid(given):
        return Found(given.rope["bend_ratio_minimum"], "the rope's own minimum")
    return Found(LEAST_WIRE_RATIO, "rope makers' tables of wire rope begin at 10")


def _friction(given: TrialKnown) -> float:
    return 0.1 if _is_braid(given) else 0.15


def _test_torque(given: TrialKnown) -> float:
    return float(f"{TEST_SHARE * given['loads.peak_torque_Nm']:.2g}")


def needed_ratio(given: TrialKnown) -> float:
    """What the motor's continuous torque asks for, its gearhead counted."""
    motor = given.entry("motors", "drive.motor")
    gear = given.gearhead.ratio
    needed = TORQUE_SPARE * given["loads.peak_torque_Nm"] * 1e3 / (motor["rated_torque_mNm"] * gear)
    return rounded_up(max(needed, 1.0), 0.05)


def _has_face(given: TrialKnown) -> bool:
    return given.peek("drive.motor") in given.motors_with_faces()


def _gearhead(given: TrialKnown) -> Found:
    if _has_face(given):
        given["drive.motor"]
        return Found(NO_GEARHEAD, "the motor's own shaft")
    needed = TORQUE_SPARE * given["loads.peak_torque_Nm"] * 1e3 / given.ratio
    motors = given.entries("motors") if not given.has("drive.motor") else {"": given.entry("motors", "drive.motor")}
    pairs = [
        (motor["mass_g"] + head["mass_g"], name)
        for motor in motors.values()
        for name, head in given.entries("gearheads").items()
        if "shaft_diameter_mm" not in motor
        and motor["rated_torque_mNm"] * head["ratio"] >= needed
        and head["max_torque_mNm"] >= needed
        and motor["diameter_mm"] <= head["diameter_mm"] + 1.0
    ]
    if pairs:
        return Found(min(pairs)[1], "motor_torque_forward", "lightest of the catalogue")
    return Found(NO_GEARHEAD, "no gearhead with a motor of the catalogue reaches the torque")


def _motor(given: TrialKnown) -> Found:
    needed = TORQUE_SPARE * given["loads.peak_torque_Nm"] * 1e3 / given.ratio
    head = given["drive.gearhead"]
    if head == NO_GEARHEAD:
        rated = {name: motor for name, (motor, _) in given.motors_with_faces().items()}
        ratio, wide = 1.0, float("inf")
    else:
        entry = given.entry("gearheads", "drive.gearhead")
        rated = {name: m for name, m in given.entries("motors").items() if "shaft_diameter_mm" not in m}
        ratio, wide = entry["ratio"], entry["diameter_mm"] + 1.0
    fitting = {
        name: m for name, m in rated.items() if m["rated_torque_mNm"] * ratio >= needed and m["diameter_mm"] <= wide
    }
    if not fitting:
        strongest = max(rated, key=lambda name: rated[name]["rated_torque_mNm"])
        return Found(strongest, "motor_torque_forward", "nothing in the catalogue does: the strongest")
    return Found(min(fitting, key=lambda name: (fitting[name]["mass_g"], name)), "motor_torque_forward", "the lightest")


LIMITS = (
    constant(
        "travel.stop_clearance_deg",
        STOP_WINDOW_DEG / 2,
        "the stops engage half way in their window behind the travel",
        "stop_within_half_degree",
    ),
    Rule("loads.test_torque_Nm", "three tenths of the peak torque, where no test is named", "loads", _test_torque),
    constant("limits.tension_safety_factor", 5.0, "rope makers: 5 to 10", "tension"),
    constant("limits.preload_share_max", 0.5, "rope makers: under half", "preload_share"),
    constant("export.mesh_tolerance_mm", 0.01, "meshes finer than a workshop's tolerances", "export"),
    constant("clearances.running_mm", 0.25, "room beside moving parts: tolerances and run-out", "frame_front"),
)
METALS = (
    constant("drum.material", "aluminium-7075", "light and strong, milled", "process"),
    constant("drum.shaft_material", "steel", "ground bar", "process"),
    constant("input_pulleys.material", "steel", "thin walls round the motor's shaft", "bore_wall"),
    constant("support.material", "aluminium-7075", "light and stiff, milled", "process"),
)
TRAIN = (
    Rule(
        "drive.gearhead",
        "none with a motor that has a shaft of its own, else that of the lightest pair that holds the torque",
        "motor_torque_forward",
        _gearhead,
    ),
    Rule("drive.motor", "the lightest motor that holds the peak torque", "motor_torque_forward", _motor),
)
ROPE_LIMITS = (
    Rule("limits.bend_ratio_min", "least D/d at which the rope has a life at all", "life", _bend_ratio),
    Rule("rope.friction_coefficient", "dry wire rope, or smooth fibre, on metal", "rope", _friction),
)
