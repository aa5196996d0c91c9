"""Rules of a belt or gears before the input, and of a first cable stage: ratios, wheels, motor, place."""

import copy
from collections.abc import Callable
from dataclasses import replace
from math import ceil, pi
from operator import methodcaller
from typing import Any

from mbcdm_cad.checks.transfer import wrap_left
from mbcdm_cad.design import stage
from mbcdm_cad.design.bought import NO_GEARHEAD
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.sized import SizedValue, Sizing, SizingError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.head_basis import counts_losses, gearhead_output_mNm, input_needs_mNm, stage_force_N
from mbcdm_cad.layouts.siso_spur.checks.stage import RATIO_SHARE, TOOTH_SHARE, lewis_factor, motor_beside_mm
from mbcdm_cad.layouts.siso_spur.first_stage import gearhead_word, last_ratio, of_data, split_ratio
from mbcdm_cad.layouts.siso_spur.sizing.basis import SpurKnown
from mbcdm_cad.sizing import Found, rounded_up, rule

# Ratios that the rule for a stated motor gives (choices).
RATIO_STEP, LEAST_RATIO, MOST_RATIO = 0.25, 1.5, 8.0
# Usual width of small gears and the widest, in modules.
GEAR_WIDTH, GEAR_WIDTH_MOST = 6.0, 12.0
# Turn of a face with as many screws, with which the belt passes between them.
SCREWS_TURNED_DEG = {3: 180.0, 4: 45.0}
# Numbers of teeth of the driver that are tried beyond the least, and belts longer than the shortest.
MORE_TEETH, MORE_BELTS = 25, 60
# What a file asks for.
_HAS_STAGE, _HAS_FIRST_STAGE = methodcaller("has", "stage.kind"), methodcaller("has", "first_stage")


def _is(kind: str) -> Callable[[SpurKnown], bool]:
    return lambda given: bool(given.peek("stage.kind") == kind)


def _force_N(given: SpurKnown, pitch_mm: float) -> float:
    """Force at the driven wheel with the least teeth, with the service factor."""
    return stage_force_N(given, float(given.input_peak_Nm) * 1e3 / given.ratio, pitch_mm)


@rule("stage.belt", "the finest belt that carries the input's torque", "stage_strength", _is("belt"))
def _belt(given: SpurKnown) -> Found:
    name = stage.carrying_belt(lambda pitch: _force_N(given, pitch), given.get("stage.width_mm"))
    return Found(name, "stage_strength", "next size")


@rule("stage.module_mm", "the finest gears that carry it", "stage_strength", _is("gears"))
def _module(given: SpurKnown) -> Found:
    allowed = TOOTH_SHARE * given.entries("materials")["steel"]["yield_MPa"]
    form = lewis_factor(given.get("stage.driver_teeth") or stage.LEAST_TEETH["gears"])

    def carries(module: float) -> bool:
        width = given.get("stage.width_mm") or GEAR_WIDTH * module
        return bool(_force_N(given, pi * module) <= allowed * width * module * form)

    return Found(next((m for m in stage.MODULES_MM if carries(m)), stage.MODULES_MM[-1]), "stage_strength", "next size")


@rule(
    "stage.driver_teeth",
    "the fewest that give the ratio, go round the shaft and spare it; gears: that leave room for a key",
    "stage_ratio",
    _HAS_STAGE,
)
def teeth(given: SpurKnown) -> Found:
    """The fewest that give the ratio, and a driver that its shaft fits; gears also keep their axes far enough apart."""
    kind, ratio, shaft = given["stage.kind"], float(given["stage.ratio"]), given.gearhead.shaft_diameter_mm
    if kind == "belt":
        belt = stage.BELTS[given["stage.belt"]]
        pitch, below = belt.pitch_mm, belt.below_mm + belt.tooth_mm
    else:
        pitch, below = pi * given["stage.module_mm"], 1.25 * given["stage.module_mm"]
    least = stage.least_driver_teeth(kind, pitch, below, shaft)
    candidates = range(least, least + MORE_TEETH)
    close = [z for z in candidates if abs(stage.driven_teeth(z, ratio) / z / ratio - 1.0) <= RATIO_SHARE / 2]
    wanted = close or sorted(candidates, key=lambda z: abs(stage.driven_teeth(z, ratio) / z / ratio - 1.0))
    room = () if kind == "belt" else ("stage_room", "key_access")
    return given.first("stage.driver_teeth", wanted, (*room, "stage_shaft"))


@rule("stage.width_mm", "the narrowest that carries the input's torque", "stage_strength", _HAS_STAGE)
def _width(given: SpurKnown) -> Found:
    if given["stage.kind"] == "belt":
        return given.first("stage.width_mm", stage.BELTS[given["stage.belt"]].widths_mm, ("stage_strength",))
    module = given["stage.module_mm"]
    start = rounded_up(GEAR_WIDTH * module, 0.5)
    widths = [start + 0.5 * k for k in range(int((GEAR_WIDTH_MOST - GEAR_WIDTH) * module / 0.5) + 1)]
    return given.first("stage.width_mm", widths, ("stage_strength", "stage_bond", "shaft_grip"))


@rule("stage.belt_teeth", "the shortest belt that leaves room for wheels, clamp and screws", "stage_room", _is("belt"))
def belt_teeth(given: SpurKnown) -> Found:
    """The shortest belt with which wheels, clamp and key have room and enough teeth mesh."""
    belt, driver = stage.BELTS[given["stage.belt"]], given["stage.driver_teeth"]
    small, large = (belt.pitch_mm * z / (2 * pi) for z in (driver, stage.driven_teeth(driver, given["stage.ratio"])))
    shortest = ceil(stage.belt_length_mm(small, large, small + large + 2.0) / belt.pitch_mm)
    checks = ("stage_room", "key_access", "stage_mesh", "stage_key")
    return given.first("stage.belt_teeth", range(shortest, shortest + MORE_BELTS), checks)


@rule(at.drive.gearhead_angle_deg, "turned so that a key reaches its screws beside the belt", "stage_key", _is("belt"))
def turn(given: SpurKnown) -> float:
    """One screw between the spans, one beyond the driver, the others beside them."""
    return SCREWS_TURNED_DEG.get(given.gearhead.screw_count, 0.0)


@rule(
    "stage.ratio",
    "the least with which a stated motor holds the peak torque; else the usual ratio of one pair of wheels",
    "motor_torque_forward",
    _HAS_STAGE,
)
def _ratio(given: SpurKnown) -> Found:
    """Of a stated motor and gearhead: the least with which they hold the peak torque; else the usual one."""
    known = given.has(at.drive.motor) and given.has_ratio
    head = given.peek(at.drive.gearhead)
    if not known or (head is None and given.peek(at.drive.motor) not in given.motors_with_faces()):
        return Found(stage.USUAL_RATIO, "usual for one pair of wheels")
    motor = given.entry("motors", at.drive.motor)
    entry = None if head in (None, NO_GEARHEAD) else given.entry("gearheads", at.drive.gearhead)
    passed = stage.EFFICIENCY[given["stage.kind"]] if counts_losses(given) else 1.0
    needed = input_needs_mNm(given) / given.ratio / (gearhead_output_mNm(given, motor, entry) * passed)
    return Found(
        min(max(rounded_up(needed, RATIO_STEP), LEAST_RATIO), MOST_RATIO), "motor_torque_forward", "up to 0.25"
    )


STAGE_RATIO = (_ratio,)
STAGE = (_belt, _module, teeth, _width, turn, belt_teeth)
# For a pass that does not know them yet.
GUESSES: dict[str, dict[str, Any]] = {
    "belt": {"stage.belt": "3GT", "stage.belt_teeth": 70, "stage.width_mm": 9.0, "stage.driver_teeth": 20},
    "gears": {"stage.module_mm": 0.8, "stage.width_mm": 8.0, "stage.driver_teeth": 20},
}


# Sizings after which the first stage stands where it stands.
_ROUNDS = 4
DISTANCE, RADIUS = "centre_distance_mm", "drum_radius_mm"
_TEXT = "the least at which the motor of the first stage clears the frame of the second"


@rule(
    "transmission.input_to_drum",
    "the root of the whole ratio, or less where the first drum would turn too far",
    "first_stage.total_ratio",
    lambda given: given.has("first_stage") and not given.has("transmission.input_radius_mm"),
)
def _last(given: SpurKnown) -> Found:
    return Found(split_ratio(given.get), "", "up to 0.05, down where the first drum would turn too far")


@rule(
    "first_stage.ratio",
    "the whole ratio over that of the second stage",
    "first_stage.total_ratio",
    lambda given: given.has("first_stage.total_ratio"),
)
def _first(given: SpurKnown) -> float:
    return float(given["first_stage.total_ratio"]) / last_ratio(given.get)


@rule("drive.motor", "that of the first stage", "first_stage", _HAS_FIRST_STAGE)
def motor(given: SpurKnown) -> str:
    return of_data(given.get).drive.motor.name


@rule("drive.gearhead", "that of the first stage", "first_stage", _HAS_FIRST_STAGE)
def gearhead(given: SpurKnown) -> str:
    return gearhead_word(of_data(given.get).drive)


FIRST = (_last, _first, motor, gearhead)


def with_room(size: Callable[..., Sizing], data: dict[str, Any], similar: Sizing | None = None) -> Sizing:
    """The sizing of ``size``; the input of a first stage stands as far from its drum as its motor needs.

    The motor stands beside the frame of the second stage, whose sizes follow from the first one's shaft. Where the
    cable of an input further away leaves the drum too little wrap, drum and input are larger instead.
    """
    start = copy.deepcopy(data)
    found = size(data, similar=similar)
    block = start.get("first_stage")
    if not isinstance(block, dict):
        return found
    design = block.get("design") or {}
    own = design.get("transmission") or {}
    if DISTANCE in own:
        return found
    words: dict[str, float] = {}
    for _ in range(_ROUNDS):
        try:
            layout: Any = SpurKnown(found.data, {}).drives.under_test(found.data)
            first = layout.first_stage_unit
            miss = motor_beside_mm(layout, first)
        except (NoFigureError, SizingError):
            break  # what the file states gives no drive, or leaves a stage no geometry; its checks say so
        wrapped = wrap_left.measure(first).holds
        if miss <= 0.0 and (wrapped or RADIUS in words or not words):
            break
        at = first.drive.centre_distance_mm
        if wrapped and RADIUS not in words:
            words = {DISTANCE: rounded_up(at + miss, 0.5)}
        elif RADIUS in own:
            break
        else:
            # As much larger as the input must stand further away from the drum, from where the rules put it.
            rest = first.drive.total_ratio / (1.0 + first.drive.total_ratio)
            before = first.drive.drum_radius_mm
            words = {RADIUS: rounded_up(max((at + miss) * rest, before + miss * rest), 0.5)}
        again = copy.deepcopy(start)
        again["first_stage"]["design"] = {**design, "transmission": {**own, **words}}
        found = size(again, similar=found)
    told = tuple(
        SizedValue(f"first_stage.design.transmission.{name}", value, _TEXT, "first_stage_room", {}, "up to 0.5")
        for name, value in words.items()
    )
    return replace(found, values=(*found.values, *told))
