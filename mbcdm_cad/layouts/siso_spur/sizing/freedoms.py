"""What ``mbcdm solve`` may change besides the derived dimensions: parts, the pulley's surface, turns and radii."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.layouts.common_freedoms import PARTS, SURFACE
from mbcdm_cad.layouts.siso_spur.drive import MOUNT_BOLTS


def _whole(turns: Any, factor: float) -> Any:
    return max(1, round(turns * factor))


FREEDOMS: tuple[Freedom, ...] = (
    *PARTS,
    SURFACE,
    Freedom("support.mount_screw", words=tuple(MOUNT_BOLTS)),
    Freedom("transmission.turns", 0.7, 2.0, _whole),
    Freedom("transmission.drum_radius_mm", 0.7, 2.0, mends=((ALL_RADII, 1),)),
    Freedom("transmission.input_to_drum", 0.7, 1.5),
)
