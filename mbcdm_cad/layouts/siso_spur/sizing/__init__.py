"""Sizing rules of siso_spur, in the order of the power flow; miso_spur uses all of them except those of names.

Many rules evaluate checks on a trial drive, whose open fields have the values of the pass before. Passes are repeated
until no field changes; the first one starts with the values of a drive of medium size.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Freedom, Moved, Sizing
from mbcdm_cad.layouts import common_rules
from mbcdm_cad.layouts.common_rules import SCHEMA_VERSION, half_travel, missing_travel, needed
from mbcdm_cad.layouts.head_basis import LIMITS, METALS, ROPE_LIMITS, TRAIN
from mbcdm_cad.layouts.head_parts import PARTS
from mbcdm_cad.layouts.open_ratio import SizingRules
from mbcdm_cad.layouts.siso_spur.schema import MOUNT_BOLTS
from mbcdm_cad.layouts.siso_spur.sizing import dims
from mbcdm_cad.layouts.siso_spur.sizing.basis import (
    LAND_EDGE,
    NAMES,
    PRELOAD,
    RATIO,
    ROPE,
    WINDING,
    SpurKnown,
    drum_radius,
)
from mbcdm_cad.layouts.siso_spur.sizing.stage import FIRST, GUESSES, STAGE, STAGE_RATIO, with_room
from mbcdm_cad.layouts.stiff_sizing import SHARED, walls
from mbcdm_cad.layouts.trial_sizing import MIDDLE_SIZE, ON_SHAFT
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.sizing.rule import Rule

DERIVED = tuple(
    rule.field
    for rule in (*WINDING, *dims.WIDTH, *dims.FRAME, dims.centre_distance, *dims.DRUM, dims.back)
    if rule.field not in (at.transmission.turns, at.drum.windows)
)


# Requirements, rope, train, radii, parts, frame, drum.
RULES: tuple[Rule, ...] = (
    *LIMITS,
    *LAND_EDGE,
    *METALS,
    *STAGE_RATIO,
    *FIRST,
    # With a ratio or radii given, motor and gearhead follow from the ratio; else the ratio from the motor.
    *TRAIN,
    *RATIO,
    *ROPE,
    *ROPE_LIMITS,
    drum_radius,
    *dims.IDLERS,
    *PRELOAD,
    *PARTS,
    *STAGE,
    *dims.FRAME,
    *WINDING,
    *dims.WIDTH,
    dims.centre_distance,
    dims.MOUNT,
    *dims.DRUM,
    dims.back,
)


def _whole(turns: Any, factor: float) -> Any:
    return max(1, round(turns * factor))


STIFFENERS = (*SHARED, *walls("plate", "bridge", "side_wall"))


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_rules.PARTS,
    common_rules.SURFACE,
    Freedom(at.support.mount_screw, words=tuple(MOUNT_BOLTS)),
    Freedom(at.transmission.turns, 0.7, 2.0, _whole),
    Freedom(at.transmission.drum_radius_mm, 0.7, 2.0, mends=((ALL_RADII, 1),)),
    Freedom(at.transmission.input_to_drum, 0.7, 1.5),
    Freedom("stage.ratio", 0.5, 2.0),
    Freedom("idlers.bearing", kind="bearings", order="bore_mm"),
)


def _first_guesses(given: SpurKnown) -> dict[str, Any]:
    """Values of a drive of medium size, for fields that the first pass does not know yet."""
    radius = float(given.peek(at.transmission.drum_radius_mm) or 80.0)
    return {
        **MIDDLE_SIZE,
        **GUESSES.get(str(given.peek("stage.kind")), {}),
        **(ON_SHAFT if given.overhung else {}),
        at.rope.helix_lead_mm: 1.5,
        at.transmission.turns: 5,
        at.transmission.centre_distance_mm: 1.4 * radius,
        at.drum.tensioner: "M3",
        at.drum.sector_half_angle_deg: WHOLE_DEG if given.whole_drum else 110.0,
        at.drum.rim_inner_radius_mm: 0.8 * radius,
        at.drum.outer_face_y_mm: 20.0,
        at.drum.hub_face_y_mm: 30.0,
        at.support.side_wall_mm: 4.0,
        at.support.bridge_mm: 4.0,
        at.support.plate_mm: 8.0,
        at.support.mount_screw: "M3",
        **dims.idler_guesses(given, radius),
    }


def _missing(given: SpurKnown) -> Iterator[Broken]:
    yield from missing_travel(given, "travel from the centre to each side")
    if not given.has(at.loads.peak_torque_Nm):
        yield needed(at.loads.peak_torque_Nm, "add peak_torque_Nm: 2.15 (torque to hold both ways, N m)")
    if given.has(at.transmission.input_radius_mm) and not given.has(at.transmission.drum_radius_mm):
        yield needed(at.transmission.drum_radius_mm, "add drum_radius_mm: 59.4 (drum pitch radius)")


def _open_ratio(given: SpurKnown) -> str:
    """A ratio with neither a motor from which it follows nor a first stage, with which it follows otherwise."""
    known = given.has_ratio or given.has(at.drive.motor) or given.has("first_stage")
    return "" if known else at.transmission.input_to_drum


def spur_rules(known: type[SpurKnown], names: tuple[Rule, ...]) -> SizingRules:
    """The sizing of inputs beside the drum, with the ``known`` of the configuration and its rules for names."""
    first = (SCHEMA_VERSION, half_travel, *names)
    return SizingRules(
        known, first, RULES, STIFFENERS, _first_guesses, _missing, _open_ratio, lambda given: bool(given.anchored)
    )


SIZING_RULES = spur_rules(SpurKnown, NAMES)


def size(data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
    """As :class:`~mbcdm_cad.layouts.open_ratio.SizingRules`; the input of a first stage stands where it has room."""
    return with_room(partial(SIZING_RULES, moved=moved), data, similar)
