"""Rules of a first cable stage: how the ratio is split, and its motor and gearhead."""

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from mbcdm_cad.checks.transfer import wrap_left
from mbcdm_cad.design.sized import SizedValue, Sizing, SizingError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.siso_spur.checks.stage import motor_beside_mm
from mbcdm_cad.layouts.siso_spur.first_stage import gearhead_word, last_ratio, split_ratio
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.sizing.rule import Found, rounded_up, rule

# Sizings after which the first stage stands where it stands.
_ROUNDS = 4
DISTANCE, RADIUS = "centre_distance_mm", "drum_radius_mm"
_TEXT = "the least at which the motor of the first stage clears the frame of the second"


def has_first_stage(given: SpurKnown) -> bool:
    """Whether the file asks for one."""
    return given.has("first_stage")


@rule(
    "transmission.input_to_drum",
    "the root of the whole ratio, or less where the first drum would turn too far",
    "first_stage.total_ratio",
    lambda given: has_first_stage(given) and not given.has("transmission.input_radius_mm"),
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
    last = last_ratio(given.get)
    assert last is not None
    return float(given["first_stage.total_ratio"]) / last


@rule("drive.motor", "that of the first stage", "first_stage", has_first_stage)
def motor(given: SpurKnown) -> str:
    first = given.first_stage
    assert first is not None
    return first.drive.motor.name


@rule("drive.gearhead", "that of the first stage", "first_stage", has_first_stage)
def gearhead(given: SpurKnown) -> str:
    first = given.first_stage
    assert first is not None
    return gearhead_word(first.drive)


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
    words: dict[str, float] = {}
    for _ in range(_ROUNDS):
        layout = _under_test(found)
        if layout is None or DISTANCE in own:
            break
        first = layout.first_stage_unit
        try:
            miss = motor_beside_mm(layout, first)
        except NoFigureError:
            break  # what the file states leaves one of the stages no geometry; its checks say so
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


def _under_test(found: Sizing) -> Any:
    """The design under test; None for no drive."""
    given = SpurKnown(found.data, {})
    try:
        return given.drives.under_test(found.data)
    except (NoFigureError, SizingError):
        return None
