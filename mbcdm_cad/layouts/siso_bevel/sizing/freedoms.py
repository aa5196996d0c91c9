"""What ``mbcdm solve`` may change besides the derived dimensions: parts, and the ratio."""

from __future__ import annotations

from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.layouts.common_freedoms import PARTS, first_radius

FREEDOMS: tuple[Freedom, ...] = (
    *PARTS,
    Freedom("transmission.input_to_drum", 0.5, 1.0),
    # Only the second radius changes: the first is a requirement.
    Freedom("transmission.drum_radii_mm", 0.5, 3.0, instead=first_radius),
)
