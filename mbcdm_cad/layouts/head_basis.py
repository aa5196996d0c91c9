"""The first rules of all layouts: limits, materials, motor and gearhead, the rope's limits."""

from collections.abc import Callable, Mapping, Sequence
from math import inf, pi
from operator import itemgetter
from typing import Any

import numpy as np

from mbcdm_cad.design.blocks import DutyBlock
from mbcdm_cad.design.bought import NO_GEARHEAD, Motor
from mbcdm_cad.design.fields import validated
from mbcdm_cad.design.stage import EFFICIENCY, LEAST_TEETH, SERVICE, belt_reach_mm, carrying_belt, driven_teeth
from mbcdm_cad.layouts import common_rules
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.trial_sizing import TrialKnown
from mbcdm_cad.model.duty import DEFAULT_PEAK_SHARE, DEFAULT_PERIOD_S, DEFAULT_TORQUE_SHARE, Duty, default_duty, of_rows
from mbcdm_cad.model.heat import RATED_AT_C, STANDSTILL_SHARE, motor_heat
from mbcdm_cad.model.losses import BEARINGS, GEARHEAD_IDLE_SHARE, ROPE, motor_idle_mNm, tangent_share, turned_back_mNm
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.sizing import Found, KnownFields, Rule, constant, rounded_up, rule

# Assumed strength of a rope's end over that of the rope, before rope and ends are chosen.
END_SHARE = 0.8
# Preload over the least that keeps a cable taut at peak torque, if friction on an input need not hold the cable.
PRELOAD_FACTOR = 2.0
# Required rated torque of the motor over its torque at the peak torque.
TORQUE_SPARE = 1.02
# The same of the torque that heats it: losses of the drive that follows are not known yet.
HEAT_SPARE = 1.05
# Tensions of the two cables of an input over the pull of the peak torque on the drum, at the preload by which friction
# holds the cable; what they lose on the drum and in the bearings besides the input (estimate).
PRELOADS, LOST_SPARE = 2.7, 1.2
# Torque on an input with a stage over its share of the peak torque, for what cables and bearings lose (estimate).
STAGE_LOSSES = 1.25


def thinnest_rope_by(given: TrialKnown, tension_N: Callable[[float], float]) -> Found:
    """The thinnest rope of the construction that holds a tension with its safety factor.

    The tension depends on the rope's diameter, mm.
    """
    ropes = common_rules.ropes_to_choose(given)
    strong = (one[1] for one in ropes if one[2] >= holding_N(given, tension_N, one))
    return Found(next(strong, ropes[-1][1]), "tension", "next size of the catalogue")


def holding_N(given: TrialKnown, tension_N: Callable[[float], float], one: tuple[float, str, float]) -> float:
    """Breaking load that a rope (diameter in mm, name, breaking load) needs for its tension, safety factor and ends."""
    needed = float(given["limits.tension_safety_factor"]) / common_rules.end_share(given, END_SHARE)
    return needed * tension_N(one[0])


def taut_rope(given: TrialKnown) -> Found:
    """The thinnest rope for the preload that keeps every cable taut at peak torque."""
    share = given.half_torque_N
    return thinnest_rope_by(given, lambda d_mm: PRELOAD_FACTOR * share + share)


def taut_preload(given: TrialKnown) -> Found:
    """The preload that keeps every cable taut at peak torque, or the highest that the rope may have."""
    return preload(given, PRELOAD_FACTOR * given.half_torque_N, "no_slack")


def preload(given: TrialKnown, wanted_N: float, driver: str) -> Found:
    """The preload that ``driver`` needs, or the highest that the rope may have."""
    most = given["limits.preload_share_max"] * given.rope["breaking_load_N"]
    return Found(float(f"{min(wanted_N, most):.2g}"), driver if wanted_N <= most else "preload_share", "two digits")


def rope(value: Callable[[Any], Found]) -> Rule:
    """The rule of the rope, if the file gives none."""
    return Rule(
        "rope.type",
        "the thinnest wire rope that holds preload and peak torque with its safety factor",
        "tension",
        value,
        applies=lambda given: not given.has("rope.inline"),
    )


def counts_losses(given: KnownFields) -> bool:
    """Whether losses count; they do where the file does not say."""
    return bool(given.get("limits.losses", "counted") == "counted")


def needed_ratio(given: TrialKnown) -> float:
    """Least ratio of drum to input with which the motor, through its gearhead, holds the peak torque continuously."""
    motor, gear = given.entry("motors", "drive.motor"), given.gearhead
    entry = {"ratio": gear.ratio, "efficiency": gear.efficiency, "rated_torque_mNm": gear.rated_torque_mNm}
    needed = input_needs_mNm(given) / output_mNm(given, motor, None if gear.absent else entry)
    return rounded_up(max(needed, 1.0), 0.05)


def output_mNm(given: KnownFields, motor: Mapping[str, Any], head: Mapping[str, Any] | None) -> float:
    """Continuous torque of a motor at its input, behind gearhead and stage; with losses where these count."""
    turns, passed = stage_gain(given)
    return gearhead_output_mNm(given, motor, head) * (passed if counts_losses(given) else turns)


def gearhead_output_mNm(given: KnownFields, motor: Mapping[str, Any], head: Mapping[str, Any] | None) -> float:
    """Continuous torque of a motor at its gearhead's output, or on its own shaft; with losses where these count."""
    if head is None:
        return float(motor["rated_torque_mNm"])
    lossless = float(motor["rated_torque_mNm"] * head["ratio"])
    if not counts_losses(given):
        return lossless
    return (lossless - GEARHEAD_IDLE_SHARE * float(head["rated_torque_mNm"])) * float(head["efficiency"])


def stage_gain(given: KnownFields) -> tuple[float, float]:
    """Torque at the input over that at the gearhead by belt or gears, without losses and with them; 1 without."""
    if not given.has("stage.kind"):
        return 1.0, 1.0
    ratio, kind = float(given["stage.ratio"]), str(given["stage.kind"])
    return ratio, ratio * float(given.get("stage.efficiency") or EFFICIENCY[kind])


def input_needs_mNm(given: TrialKnown) -> float:
    """Torque at the inputs together over their ratio; where losses count, with those of cables and bearings.

    The cables' tensions add up to the usual preloads, and lose at the inputs most of all.
    """
    needed = TORQUE_SPARE * given.input_peak_Nm * 1e3
    if not counts_losses(given):
        return needed
    lost = float(tangent_share(1.0, max(given.get("limits.bend_ratio_min", common_rules.LEAST_WIRE_RATIO), 1.0)))
    return needed * (1.0 + LOST_SPARE * PRELOADS * lost)


def lasting_share(given: KnownFields) -> float:
    """Continuous torque, or that of the payload's weight, over the peak torque: 0 where the file asks for neither."""
    stated, weight = given.get("loads.continuous_torque_Nm"), given.payload.weight_torque_Nm
    if stated is None and weight == 0.0:
        return 0.0
    return float(max(stated or 0.0, weight) / given["loads.peak_torque_Nm"])


def gearhead_share(given: KnownFields) -> float:
    """Torque over the peak torque that a gearhead must keep up: as stated, else the cubic mean of the duty.

    Without a stated duty that of the assumed one; 0 for files that count no losses. A payload's weight counts whole.
    """
    lasting = lasting_share(given)
    if given.get("loads.continuous_torque_Nm") is not None or not counts_losses(given):
        return lasting
    if has_rows(given):
        return max(lasting, float(duty_of(given).lasting_torque_Nm / given["loads.peak_torque_Nm"]))
    if given.payload.weight_torque_Nm == 0.0:
        return default_duty(1.0, 1.0, RATED_AT_C).lasting_torque_Nm
    carried = max(lasting, DEFAULT_TORQUE_SHARE)
    return float(np.cbrt(DEFAULT_PEAK_SHARE + (1.0 - DEFAULT_PEAK_SHARE) * carried**3))


def has_rows(given: KnownFields) -> bool:
    """Whether the file states a duty by which parts can be chosen."""
    return bool((given.get("loads.duty") or {}).get("rows"))


def duty_of(given: KnownFields) -> Duty:
    """The duty that the file states by rows; a record stands as rows while parts are chosen."""
    block = validated(DutyBlock, given["loads.duty"])
    travel = 2.0 * given["travel.half_angle_deg"]
    ambient = RATED_AT_C if block.ambient_C is None else block.ambient_C
    return of_rows(block.rows, block.period_s or DEFAULT_PERIOD_S, travel, ambient)


def _turning_cables_Nm(given: TrialKnown) -> float:
    """Torque at the drum that starts cables and bearings, of the drive of the pass before; 0 in the first pass."""
    if not given.drives.passes:
        return 0.0
    try:
        found = given.before().losses.backdrive
    except (NoFigureError, ModelError):
        return 0.0
    return 0.0 if found is None else found.start_of_Nm(ROPE, BEARINGS)


def _ratio_with(given: TrialKnown, motor: Mapping[str, Any], head: Mapping[str, Any] | None) -> float:
    """The ratio of drum to input radius; an open one is the least with which a motor holds the torque."""
    return given.ratio if given.has_ratio else max(input_needs_mNm(given) / output_mNm(given, motor, head), 1.0)


def _easy(given: TrialKnown, motor: Mapping[str, Any], head: Mapping[str, Any] | None) -> float:
    """Torque at the drum that may be needed to turn it over the one that is, less 1; infinite where none is asked for.

    The drum turns gearheads and motors without current, cables and bearings; an open ratio is the least that holds.
    """
    wanted = given.get("loads.backdrive_Nm")
    if wanted is None:
        return inf
    turns = _ratio_with(given, motor, head) * stage_gain(given)[0]
    idle = motor_idle_mNm(float(motor["rated_torque_mNm"]), Motor(name="", **motor).idle_torque_mNm)
    gears = (1.0, 1.0, 0.0) if head is None else (head["ratio"], head["efficiency"], head["rated_torque_mNm"])
    turned = max(1, len(given.get("inputs", ()))) * turns * turned_back_mNm(idle, *gears) * 1e-3
    return float(wanted / (turned + _turning_cables_Nm(given)) - 1.0)


def _is_cool(given: TrialKnown, motor: Mapping[str, Any], head: Mapping[str, Any] | None) -> bool:
    """Whether a motor stands the stated duty, in files that count losses; an open ratio is the least that holds.

    Moving against the load counts for both ways.
    """
    ratio = _ratio_with(given, motor, head)
    moving, still = (HEAT_SPARE * (mNm / ratio) for mNm in (input_needs_mNm(given), given.input_peak_Nm * 1e3))
    if not counts_losses(given) or not has_rows(given):
        return True
    duty, heat = duty_of(given), motor_heat(Motor(name="", **motor))
    share = np.abs(duty.torque_Nm) / float(given["loads.peak_torque_Nm"])
    moving = moving / output_mNm(given, motor, head) * float(motor["rated_torque_mNm"])
    turns = (1.0 if head is None else float(head["ratio"])) * stage_gain(given)[0]
    still = still / turns / (STANDSTILL_SHARE if heat.brushless else 1.0)
    torque = share * np.where(duty.speed_deg_s == 0.0, still, moving) * 1e-3
    found = heat.repeated(duty.time_s, torque, duty.ambient_C)
    return found is not None and heat.limit_C > duty.ambient_C and found.hottest_winding_C <= heat.limit_C


def _is_fast(given: TrialKnown, motor: Mapping[str, Any], head: Mapping[str, Any] | None, needed_mNm: float) -> bool:
    """Whether a motor turns the drum fast enough under the load that lasts; an open ratio is the least that holds.

    One without electrical values does not, where the file asks for a speed.
    """
    holds = output_mNm(given, motor, head)
    ratio = _ratio_with(given, motor, head)
    load = (lasting_share(given) or 1.0) * (needed_mNm if given.has_ratio else holds)
    torque_mNm, wanted = min(load / holds, 1.0) * motor["rated_torque_mNm"], given.get("loads.speed_deg_s")
    if wanted is None:
        return True
    constant, ohms = motor.get("torque_constant_mNm_A"), motor.get("resistance_ohm")
    volts = given.get("drive.bus_voltage_V") or motor.get("voltage_V")
    if constant is None or ohms is None or volts is None:
        return False
    turns = (1.0 if head is None else head["ratio"]) * stage_gain(given)[0] * ratio
    reached = max(volts - ohms * torque_mNm / constant, 0.0) / (constant * 1e-3) / turns
    return bool(reached * 180.0 / pi / wanted >= 1.0)


@rule(
    "drive.gearhead",
    "none for a motor with its own shaft, else that of the lightest motor and gearhead that hold the torque",
    "motor_torque_forward",
)
def gearhead(given: TrialKnown) -> Found:
    if given.has("drive.motor") and given.peek("drive.motor") in given.motors_with_faces():
        given["drive.motor"]
        return Found(NO_GEARHEAD, "the motor's own shaft")
    # If the ratio follows from motor and gearhead, any of them holds the torque.
    needed = input_needs_mNm(given) / given.ratio if given.has_ratio else 0.0
    lasting, heads, behind = gearhead_share(given), given.entries("gearheads"), stage_gain(given)[1]
    motors = given.entries("motors") if not given.has("drive.motor") else {"": given.entry("motors", "drive.motor")}
    pairs = [
        (motor["mass_g"] + head["mass_g"], name, motor)
        for motor in motors.values()
        for name, head in heads.items()
        if "shaft_diameter_mm" not in motor
        and output_mNm(given, motor, head) >= needed
        and behind * head["max_torque_mNm"] >= (needed or output_mNm(given, motor, head))
        and behind * head["rated_torque_mNm"] >= lasting * (needed or output_mNm(given, motor, head))
        and _is_fast(given, motor, head, needed)
        and motor["diameter_mm"] <= head["diameter_mm"] + 1.0
        and _has_key_room(given, head, output_mNm(given, motor, head))
    ]
    if given.get("loads.backdrive_Nm") is not None:
        # A motor on its own shaft turns back most easily.
        pairs += [
            (motor["mass_g"], NO_GEARHEAD, motor)
            for motor, _ in given.motors_with_faces().values()
            if "servo" not in motor
            and motor in motors.values()
            and output_mNm(given, motor, None) >= needed
            and _is_fast(given, motor, None, needed)
            and _has_key_room(given, motor, output_mNm(given, motor, None))
        ]
    if not pairs:
        asked = "the torque" if given.get("loads.speed_deg_s") is None else "the torque at the speed"
        return Found(NO_GEARHEAD, f"no gearhead with a motor of the catalogue is sure to reach {asked}")
    pairs.sort(key=itemgetter(0, 1))
    lightest = pairs[0][1]
    trains = [(name, motor, heads.get(name)) for _, name, motor in pairs]
    return _preferred(given, "drive.gearhead", trains, lightest, "lightest of the catalogue")


def _preferred(
    given: TrialKnown,
    field: str,
    trains: Sequence[tuple[str, Mapping[str, Any], Mapping[str, Any] | None]],
    lightest: str,
    rounding: str,
) -> Found:
    """The first of named trains (motor, gearhead) that stands the duty and that the drum turns as easily as asked.

    If none does both, the one that turns most easily; where the file asks for no such ease, the first.
    """
    easy = [(name, motor, head) for name, motor, head in trains if _easy(given, motor, head) >= 0.0]
    if not easy:
        nearest = max(trains, key=lambda train: _easy(given, train[1], train[2]))[0]
        return Found(nearest, "backdrive", "nothing in the catalogue does: the nearest")
    if given.overhung:
        # The shaft must carry the cables too.
        cool = [name for name, motor, head in easy if _is_cool(given, motor, head)] or [name for name, *_ in easy]
        return given.first(field, dict.fromkeys(cool), ("motor_shaft_load",))
    found = next((name for name, motor, head in easy if _is_cool(given, motor, head)), easy[0][0])
    if found == lightest:
        return Found(found, "motor_torque_forward", rounding)
    return Found(found, "duty" if found != easy[0][0] else "backdrive", rounding)


def stage_force_N(given: TrialKnown, input_mNm: float, pitch_mm: float) -> float:
    """Force at the driven wheel of a stage with the least teeth, with the service factor.

    ``input_mNm``: torque on the input at the peak torque, without losses.
    """
    teeth = driven_teeth(given.get("stage.driver_teeth") or LEAST_TEETH[given["stage.kind"]], given["stage.ratio"])
    return float(SERVICE * STAGE_LOSSES * input_mNm / (pitch_mm * teeth / (2 * pi)))


def _has_key_room(given: TrialKnown, face: Mapping[str, Any], held_mNm: float) -> bool:
    """Whether a key reaches the screws of a face beside the driving pulley of a belt that carries the torque.

    ``held_mNm``: what motor and gearhead hold, which is the torque on the input where its ratio is open.
    """
    if given.get("stage.kind") != "belt":
        return True
    input_mNm = float(given.input_peak_Nm) * 1e3 / given.ratio if given.has_ratio else held_mNm
    belt = given.get("stage.belt") or carrying_belt(
        lambda pitch: stage_force_N(given, input_mNm, pitch), given.get("stage.width_mm")
    )
    beside = belt_reach_mm(belt, face["shaft_diameter_mm"], given.get("stage.driver_teeth"))
    return bool(face["bolt_circle_mm"] / 2 >= beside + given.screw(face["screw"]).key_mm)


@rule("drive.motor", "the lightest motor that holds the peak torque", "motor_torque_forward")
def _motor(given: TrialKnown) -> Found:
    needed = input_needs_mNm(given) / given.ratio
    head = given["drive.gearhead"]
    if head == NO_GEARHEAD:
        rated = {name: motor for name, (motor, _) in given.motors_with_faces().items() if "servo" not in motor}
        entry, wide = None, float("inf")
    else:
        entry = given.entry("gearheads", "drive.gearhead")
        rated = {name: m for name, m in given.entries("motors").items() if "shaft_diameter_mm" not in m}
        wide = entry["diameter_mm"] + 1.0
    fitting = {
        name: m
        for name, m in rated.items()
        if output_mNm(given, m, entry) >= needed and m["diameter_mm"] <= wide and _is_fast(given, m, entry, needed)
    }
    if not fitting:
        strongest = max(rated, key=lambda name: rated[name]["rated_torque_mNm"])
        return Found(strongest, "motor_torque_forward", "no motor of the catalogue does: the strongest")
    names = sorted(fitting, key=lambda name: (fitting[name]["mass_g"], name))
    trains = [(name, fitting[name], entry) for name in names]
    return _preferred(given, "drive.motor", trains, names[0], "the lightest")


LIMITS = (
    common_rules.STOP_CLEARANCE,
    common_rules.test_torque,
    common_rules.TENSION_SAFETY,
    common_rules.PRELOAD_SHARE,
    common_rules.MESH_TOLERANCE,
    common_rules.RUNNING,
)
METALS = (
    common_rules.DRUM_MATERIAL,
    common_rules.SHAFT_MATERIAL,
    constant("input_pulleys.material", "steel", "allows thin walls round the motor's shaft", "bore_wall"),
    common_rules.SUPPORT_MATERIAL,
)
TRAIN = (gearhead, _motor)
ROPE_LIMITS = (common_rules.bend_ratio, common_rules.friction)
