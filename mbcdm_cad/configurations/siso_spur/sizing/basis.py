"""Rules of what comes first: names, limits, materials, the train, radii, rope, preload and turns."""

from __future__ import annotations

from math import degrees, log, sqrt

from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.configurations.siso_spur.design_file.reference import CABLES, INPUTS
from mbcdm_cad.configurations.siso_spur.sizing.known import SpurKnown, whole_turns
from mbcdm_cad.design.bought import NO_GEARHEAD
from mbcdm_cad.sizing.rule import Found, Rule, constant, rounded_up

# D/d below which no life is promised: rope makers' tables of wire rope end there.
LEAST_WIRE_RATIO = 10.0
# Share of the peak torque at which the backlash is asked for, where the file names no test torque.
TEST_SHARE = 0.3
# Preload over what the slip margin asks of an endless wrap: the wrap is not endless.
PRELOAD_SPARE = 1.35
SLIP_MARGIN = 2.0
# Strength of an end over the rope's, before rope and ends are chosen.
END_SHARE = 0.8
CONSTRUCTION = "7x7"
# Rated torque over what the peak torque asks of the motor.
TORQUE_SPARE = 1.02
# Least wall of an input pulley round the motor's shaft and its neck, as a radius beyond the shaft's (estimate).
NECK_MM = 2.5
# Turning of a printed frame over what the cable's spans yield (estimate).
PLASTIC_WINDUP = 20.0
# Angle that both landings take of the wrap, before the centre distance is known, and what should stick besides.
LANDINGS_DEG, STICKING_DEG = 50.0, 20.0


def _is_braid(given: SpurKnown) -> bool:
    known = given.has("rope.type") or given.has("rope.inline")
    return known and given.rope["construction"] == "braid"


def _bend_ratio(given: SpurKnown) -> Found:
    if _is_braid(given):
        return Found(given.rope["bend_ratio_minimum"], "the rope's own minimum")
    return Found(LEAST_WIRE_RATIO, "rope makers' tables of wire rope begin at 10")


def _friction(given: SpurKnown) -> float:
    return 0.1 if _is_braid(given) else 0.15


def _test_torque(given: SpurKnown) -> float:
    return float(f"{TEST_SHARE * given['loads.peak_torque_Nm']:.2g}")


def _windup(given: SpurKnown) -> Found:
    """What the cable's spans yield at the test torque; a plastic frame is some twenty times as soft as one of metal."""
    reach = given["transmission.drum_radius_mm"] + given.input_mm
    span = sqrt(max(given["transmission.centre_distance_mm"] ** 2 - reach**2, 1.0))
    stiffness = 2 * given.axial_stiffness_N / span * given["transmission.drum_radius_mm"] ** 2
    turn = given["loads.test_torque_Nm"] * 1e3 / stiffness * 1e3
    share, driver = (PLASTIC_WINDUP, "printed") if given.printed("support") else (1.0, "spans")
    return Found(float(f"{max(share * turn, 1e-4):.3g}"), driver, "three digits")


def _ratio(given: SpurKnown) -> float:
    """What the motor's continuous torque asks for, its gearhead counted."""
    motor = given.entry("motors", "drive.motor")
    gear = given.gearhead.ratio
    needed = TORQUE_SPARE * given["loads.peak_torque_Nm"] * 1e3 / (motor["rated_torque_mNm"] * gear)
    return rounded_up(max(needed, 1.0), 0.05)


def _drum_radius(given: SpurKnown) -> Found:
    """The smallest input that bends the rope no sharper than its limit and leaves a neck round the shaft."""
    d = given.d_mm
    needs = {
        "bend_ratio": given["limits.bend_ratio_min"] * d / 2,
        "bearing_shoulders": given.gearhead.shaft_diameter_mm / 2 + NECK_MM + d / 2,
    }
    driver = max(needs, key=lambda name: needs[name])
    return Found(rounded_up(needs[driver] * given.ratio, 0.5), driver, "up to 0.5")


def _has_face(given: SpurKnown) -> bool:
    return given.peek("drive.motor") in given.motors_with_faces()


def _gearhead(given: SpurKnown) -> Found:
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


def _motor(given: SpurKnown) -> Found:
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


def _wanted_preload_N(given: SpurKnown) -> float:
    margin = given.get("limits.slip_margin_min", SLIP_MARGIN)
    return float(PRELOAD_SPARE * margin * given.half_torque_N)


def _rope(given: SpurKnown) -> Found:
    """The thinnest rope of the construction that holds preload and peak torque."""
    tension = _wanted_preload_N(given) + given.half_torque_N
    needed = tension * given["limits.tension_safety_factor"] / END_SHARE
    ropes = sorted(
        (entry["diameter_mm"], name, entry["breaking_load_N"])
        for name, entry in given.entries("ropes").items()
        if entry["construction"] == CONSTRUCTION
    )
    strong = [name for _, name, breaking in ropes if breaking >= needed]
    return Found(strong[0] if strong else ropes[-1][1], "tension", "next size of the catalogue")


def _preload(given: SpurKnown) -> Found:
    wanted = _wanted_preload_N(given)
    most = given["limits.preload_share_max"] * given.rope["breaking_load_N"]
    driver = "input_slip" if wanted <= most else "preload_share"
    return Found(float(f"{min(wanted, most):.2g}"), driver, "two digits")


def _turns(given: SpurKnown) -> Found:
    """Wrap for the travel, for what creeps at both ends at peak torque, and for what should stick besides."""
    preload, share, mu = given["rope.preload_N"], given.half_torque_N, given["rope.friction_coefficient"]
    travel = 2 * given["travel.half_angle_deg"] * given.ratio
    slack = max(preload - share, 0.05 * preload)
    creeping = degrees(log((preload + share) / slack)) / mu
    start = whole_turns(travel + creeping + LANDINGS_DEG + STICKING_DEG)
    return given.first("transmission.turns", range(start, min(start + 12, 41)), ("input_slip",))


def _lead(given: SpurKnown) -> Found:
    step = 0.05 if given.d_mm > 0.5 else 0.01
    checks = ("helix_lead", "groove_crest", "self_clearance")
    return given.moved("rope.helix_lead_mm", 1.02 * given.d_mm, step, checks)


NAMES = (
    constant("schema_version", 1, "the version of the file's layout", "the program"),
    constant("inputs", INPUTS, "the one input", "the configuration"),
    constant("cables", CABLES, "the two sides of the one cable", "the configuration"),
)
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
    constant("clearances.land_edge_mm", 0.3, "a broken edge and the run-out beyond it", "rim_width"),
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
RATIO = (
    Rule(
        "transmission.input_to_drum",
        "as much as the motor's continuous torque needs for the peak torque",
        "motor_torque_forward",
        _ratio,
        applies=lambda given: not given.has("transmission.input_radius_mm"),
    ),
)
ROPE = (
    Rule(
        "rope.type",
        "the thinnest wire rope that holds preload and peak torque with its safety factor",
        "tension",
        _rope,
        applies=lambda given: not given.has("rope.inline"),
    ),
    Rule("limits.bend_ratio_min", "least D/d at which the rope has a life at all", "life", _bend_ratio),
    Rule("rope.friction_coefficient", "dry wire rope, or smooth fibre, on metal", "rope", _friction),
)
RADIUS = (
    Rule(
        "transmission.drum_radius_mm",
        "the ratio times the smallest input that the rope and the shaft allow",
        "bend_ratio",
        _drum_radius,
    ),
)
PRELOAD = (
    Rule("rope.preload_N", "what friction needs to hold the slip margin over the peak torque", "input_slip", _preload),
)
WINDING = (
    Rule("rope.helix_lead_mm", "the least lead at which turns and grooves clear each other", "helix_lead", _lead),
    Rule(
        "transmission.turns",
        "as many as the travel, the creep at both ends and the slip margin ask for",
        "input_slip",
        _turns,
    ),
)
WINDUP = (
    Rule(
        "limits.frame_windup_max_mrad",
        "what the cable's spans yield at the test torque, for a printed frame twenty times as much",
        "frame_windup",
        _windup,
    ),
)
