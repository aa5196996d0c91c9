"""What ``mbcdm solve`` may change besides the derived dimensions: choices of parts and arrangement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.layouts.common_freedoms import DRIVE, ENCODERS, INPUTS, SURFACE, first_radius

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


FREEDOMS: tuple[Freedom, ...] = (
    *DRIVE,
    Freedom("guide.bearing", kind="bearings", order="outer_diameter_mm"),
    *INPUTS,
    SURFACE,
    *ENCODERS,
    Freedom("transmission.centre_distance_mm", 0.7, 2.5),
    Freedom("transmission.drum_radii_mm", 0.8, 2.5, _steps, mends=((ALL_RADII, 1),), instead=first_radius),
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
