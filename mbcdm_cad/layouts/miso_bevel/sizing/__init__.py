"""Sizing rules of miso_bevel, in the order of the drive."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.design.sized import Freedom, Moved, Sizing, SizingError
from mbcdm_cad.layouts import common_freedoms
from mbcdm_cad.layouts.common_rules import friction, half_travel, missing_travel, needed
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.sizing.basis import CLEARANCES, LEAD, LIMITS, METALS, NAMES, preload, rope
from mbcdm_cad.layouts.miso_bevel.sizing.drum import DRUM, HUB, WEB, WINDOWS, hub_face
from mbcdm_cad.layouts.miso_bevel.sizing.frame import FRAME, STOP_PIN, back, gearhead_turn
from mbcdm_cad.layouts.miso_bevel.sizing.frame_start import MOUNT_SCREW, with_strong_frame
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown, FrameStart
from mbcdm_cad.layouts.miso_bevel.sizing.parts import DRIVES, PARTS, tensioner
from mbcdm_cad.layouts.miso_bevel.sizing.radii import RATIOS, SETBACK, centre_distance, drum_radii, motor_side, surface
from mbcdm_cad.layouts.open_ratio import lightest
from mbcdm_cad.layouts.stiff_sizing import SHARED, bearing, lowered, stiffened, walls
from mbcdm_cad.sizing.engine import fill
from mbcdm_cad.sizing.rule import Rule

# Rope, parts by load, radii, places of the pulleys.
BEFORE_FRAME: tuple[Rule, ...] = (
    half_travel,
    *NAMES,
    *LIMITS,
    rope,
    friction,
    preload,
    *METALS,
    tensioner,
    *DRIVES,
    *PARTS,
    *CLEARANCES,
    drum_radii,
    *RATIOS,
    surface,
    *LEAD,
    motor_side,
    centre_distance,
)
RATIO = "transmission.ratio"
# Then frame and drum; the back plane after the inputs' setback, on which it depends.
FROM_FRAME: tuple[Rule, ...] = (*FRAME, *HUB, *WEB, *STOP_PIN, *DRUM, *SETBACK, back, gearhead_turn, hub_face, *WINDOWS)

# Derived dimensions: fields that are neither a requirement nor a choice of part, screw, material or arrangement.
DERIVED = tuple(
    rule.field
    for rule in (*LEAD, *CLEARANCES, *FRAME, *HUB, *WEB, *STOP_PIN, *DRUM, *SETBACK, back, hub_face)
    if not rule.field.startswith("limits.") and rule.field not in (MOUNT_SCREW, "drum.output_screws")
)


STIFFENERS = lowered(
    (*SHARED, bearing("guide.bearing", "guide's "), *walls("back_plate", "rib")),
    ("drum.hub_diameter_mm", "drum.web_thickness_mm", "support.back_plate_mm", "support.rib_mm"),
)

# A setback is changed by adding, since it is often zero: a factor of 2 means this many mm more.
SETBACK_MM = 20.0


def _steps(radii: Any, factor: float) -> Any:
    """Radii of the drum with larger or smaller steps; the first radius, a requirement, does not change."""
    first = radii[0]
    return [round(first + factor * (radius - first), 3) for radius in radii]


def _further_back(setback_mm: Any, factor: float) -> Any:
    return round(setback_mm + SETBACK_MM * (factor - 1.0), 2)


def _total_ratio(data: Mapping[str, Any]) -> dict[str, Any]:
    ratios = data["transmission"].get("ratios") or {}
    first, second = ratios.get("input_to_guide"), ratios.get("guide_to_drum")
    return {"transmission.ratio": round(first * second, 9)} if first and second else {}


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_freedoms.DRIVE,
    Freedom("guide.bearing", kind="bearings", order="outer_diameter_mm"),
    *common_freedoms.INPUTS,
    common_freedoms.SURFACE,
    *common_freedoms.ENCODERS,
    *common_freedoms.METALS,
    Freedom("transmission.centre_distance_mm", 0.7, 2.5),
    Freedom(
        "transmission.drum_radii_mm", 0.8, 2.5, _steps, mends=((ALL_RADII, 1),), instead=common_freedoms.first_radius
    ),
    Freedom(
        "transmission.ratios.guide_to_drum",
        0.4,
        1.5,
        mends=(("transmission.ratios.input_to_guide", -1), ("transmission.guide_radii_mm", -1)),
    ),
    Freedom("transmission.ratios", instead=_total_ratio),
    Freedom("transmission.input_setback_mm", 1.0, 2.0, _further_back),
    Freedom("drive.motor_side", words=("below", "above")),
)


def size(data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
    """The data with its open fields filled; ``moved`` changes the values of rules.

    The rules are closed forms: of a ``similar`` design only what was raised for its stiffness counts.

    Raises ``SizingError`` where a requirement is missing.
    """

    return stiffened(_plain, data, BevelLayout, STIFFENERS, moved, similar)


def size_first(data: dict[str, Any], moved: Moved | None = None) -> Sizing:
    """The same with the walls with which the rules begin, even where the frame then bends too much."""
    if not _has_ratio(BevelKnown(data)):
        return _plain(data, moved, None)
    return _sized(data, moved, first=True)


def _plain(data: dict[str, Any], moved: Moved | None, similar: Sizing | None) -> Sizing:
    """Without what a stated stiffness raises."""
    if _has_ratio(BevelKnown(data)):
        return _sized(data, moved)
    return lightest(_with_ratio, RATIO, data, moved, similar, layout=BevelLayout)


def _with_ratio(data: dict[str, Any], moved: Moved | None, similar: Sizing | None, ratio: tuple[Rule, ...]) -> Sizing:
    return _sized(data, moved, ratio)


def _sized(data: dict[str, Any], moved: Moved | None, ratio: tuple[Rule, ...] = (), *, first: bool = False) -> Sizing:
    missing = list(_missing(BevelKnown(data)))
    if missing:
        raise SizingError(*missing)

    @cache
    def before(shelves: float) -> Sizing:
        # Of the start, these rules read no more than its shelves.
        return fill(BevelKnown(copy.deepcopy(data), FrameStart(shelves=shelves)), (*ratio, *BEFORE_FRAME), moved)

    def filled_from(start: FrameStart) -> tuple[BevelKnown, Sizing]:
        begun = before(start.shelves)
        given = BevelKnown(copy.deepcopy(begun.data), start)
        rest = fill(given, FROM_FRAME, moved)
        return given, replace(rest, values=(*begun.values, *rest.values))

    return with_strong_frame(filled_from, first=first)


def _has_ratio(given: BevelKnown) -> bool:
    return (
        given.has(RATIO)
        or given.has("transmission.input_radii_mm")
        or all(given.has(f"transmission.ratios.{name}") for name in ("guide_to_drum", "input_to_guide"))
    )


def _missing(given: BevelKnown) -> Any:
    yield from missing_travel(given, "travel from the centre to each side")
    if not given.has("loads.peak_torque_Nm"):
        yield needed("loads.peak_torque_Nm", "add peak_torque_Nm: 3.15 (torque to hold both ways, N m)")
    radii = ("transmission.drum_radii_mm", "transmission.drum_radius_mm")
    if not any(given.has(field) for field in radii):
        yield needed("transmission.drum_radius_mm", "add drum_radius_mm: 54.0 (drum pitch radius of step 1)")
    explicit = any(given.has(f"transmission.{body}_radii_mm") for body in ("guide", "input"))
    if explicit and not given.has("transmission.drum_radii_mm"):
        yield needed("transmission.drum_radii_mm", "add the drum's radii, as other pulleys' are given")
