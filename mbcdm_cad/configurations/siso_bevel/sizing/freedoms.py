"""What ``mbcdm solve`` may change besides the derived dimensions: parts, and the ratio."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbcdm_cad.configurations.head_freedoms import PARTS
from mbcdm_cad.design.freedom import Freedom


def _first_radius(data: Mapping[str, Any]) -> dict[str, Any]:
    radii = data["transmission"].get("drum_radii_mm")
    return {"transmission.drum_radius_mm": radii[0]} if radii else {}


FREEDOMS: tuple[Freedom, ...] = (
    *PARTS,
    Freedom("transmission.input_to_drum", 0.5, 1.0),
    # The second radius is moved: the first is asked for.
    Freedom("transmission.drum_radii_mm", 0.5, 3.0, instead=_first_radius),
)
