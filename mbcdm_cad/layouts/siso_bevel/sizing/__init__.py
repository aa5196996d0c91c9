"""Sizing rules of siso_bevel, in the order of the power flow; many evaluate checks on a trial drive (trial_sizing)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Moved, Sizing, SizingError
from mbcdm_cad.layouts import common_freedoms
from mbcdm_cad.layouts.common_rules import HALF_TRAVEL, missing_travel, needed
from mbcdm_cad.layouts.head_basis import LIMITS, METALS, ROPE_LIMITS, TRAIN
from mbcdm_cad.layouts.head_parts import PARTS
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.sizing.rules import (
    BACK,
    DRUM,
    FRAME,
    MOUNT,
    NAMES,
    PRELOAD,
    RATIO,
    RESERVE,
    RESERVE_DEG,
    ROPE,
    TRANSFER,
    DirectKnown,
)
from mbcdm_cad.layouts.stiff_sizing import SHARED, stiffened, walls
from mbcdm_cad.layouts.trial_sizing import MIDDLE_SIZE, repeated
from mbcdm_cad.parts.mounting import MOUNT_SCREWS
from mbcdm_cad.sizing.rule import Rule

RULES: tuple[Rule, ...] = (
    HALF_TRAVEL,
    *NAMES,
    *LIMITS,
    *METALS,
    *ROPE,
    *ROPE_LIMITS,
    *PRELOAD,
    *RATIO,
    *TRAIN,
    *TRANSFER,
    *RESERVE,
    *PARTS,
    *FRAME,
    *MOUNT,
    *DRUM,
    *BACK,
)
DERIVED = tuple(
    rule.field
    for rule in (*TRANSFER, *FRAME, *DRUM, *BACK)
    if not rule.field.startswith("limits.") and rule.field != "drum.windows"
)


STIFFENERS = (*SHARED, *walls("support.back_plate_mm", "support.rib_mm", "support.side_wall_mm"))


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_freedoms.PARTS,
    Freedom("support.mount_screw", words=tuple(MOUNT_SCREWS)),
    Freedom("transmission.input_to_drum", 0.5, 1.0),
    # Only the second radius changes: the first is a requirement.
    Freedom("transmission.drum_radii_mm", 0.5, 3.0, instead=common_freedoms.first_radius),
)


def size(data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
    """The data with all open fields filled; ``moved`` changes the values that rules give.

    ``similar``: see :func:`~mbcdm_cad.layouts.trial_sizing.repeated`. Raises ``SizingError`` if a requirement
    is missing.
    """
    given = DirectKnown(data, {})
    missing = list(_missing(given))
    if missing:
        raise SizingError(*missing)
    guesses = _first_guesses(given.drum_mm)
    if given.has("transmission.input_to_drum"):
        # An open ratio is found with the reserve open too: a guess of it would exclude the highest ratios.
        guesses["transmission.reserve_deg"] = RESERVE_DEG

    def plain(data: dict[str, Any], moved: Moved | None, similar: Sizing | None) -> Sizing:
        return repeated(data, DirectKnown, RULES, guesses, moved, similar)

    return stiffened(plain, data, DirectLayout, STIFFENERS, moved, similar)


def _first_guesses(radius_mm: float) -> dict[str, Any]:
    """Values of a drive of medium size, for fields that the first pass does not know yet."""
    return {
        **MIDDLE_SIZE,
        "transmission.drum_radii_mm": [radius_mm, 1.06 * radius_mm],
        "clearances.land_edge_mm": 0.15,
        "clearances.transfer_gap_mm": 0.1,
        "drive.motor": "motor-2.9mNm-15",
        "drive.gearhead": "gearhead-76-16",
        "drum.tensioner": "M2",
        "drum.sector_half_angle_deg": 90.0,
        "drum.rim_inner_radius_mm": 0.8 * radius_mm,
        "drum.outer_face_y_mm": 40.0,
        "drum.hub_face_y_mm": 60.0,
        "support.side_wall_mm": 5.0,
        "support.back_plate_mm": 4.0,
        "support.rib_mm": 5.0,
        "support.mount_screw": "M3",
    }


def _missing(given: DirectKnown) -> Iterator[Broken]:
    yield from missing_travel(given, "travel each way from the centred drum")
    if not given.has("loads.peak_torque_Nm"):
        yield needed("loads.peak_torque_Nm", "add peak_torque_Nm: 0.98 (torque to hold both ways, N m)")
    if not any(given.has(f"transmission.{name}") for name in ("drum_radii_mm", "drum_radius_mm")):
        yield needed("transmission.drum_radius_mm", "add drum_radius_mm: 58.0 (drum pitch radius of step 1)")
    elif given.has("transmission.input_radii_mm") and not given.has("transmission.drum_radii_mm"):
        yield needed("transmission.drum_radii_mm", "add the drum's radii, because those of the input are given")
