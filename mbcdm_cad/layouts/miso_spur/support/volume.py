"""Volume of the frame in closed form, for the estimate of mass."""

from __future__ import annotations

from math import inf, pi, tan

from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.support.volume import arm_mm3, boss_mm3
from mbcdm_cad.parts.volume import Volume


def star_mm3(d: StarDims) -> float:
    """Arms minus the volume that neighbours share near the axis, and the boss. The round end lies within the arms."""
    first, n = d.arms[0], len(d.arms)
    # Half the angle between two arms; two opposite arms are in line and share nothing.
    slope = tan(pi / n) if n > 2 else inf
    shared = n * first.half_width**2 / slope * (first.levels.front_y - first.levels.plate_back_y)
    return sum(arm_mm3(arm) for arm in d.arms) - shared + boss_mm3(first)


VOLUMES: dict[str, Volume] = {"mbcdm_cad.layouts.miso_spur.support.frame:create_star": star_mm3}
