"""Volume of the frame in closed form, for the estimate of mass."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, tan
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.support.parts import arm_mm3, boss_mm3
from mbcdm_cad.parts.part import MadePart

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def star_mm3(d: StarDims) -> float:
    """Arms minus the volume that neighbours share near the axis, and the boss. The round end lies within the arms."""
    first, n = d.arms[0], len(d.arms)
    # Half the angle between two arms; two opposite arms are in line and share nothing.
    slope = tan(pi / n) if n > 2 else inf
    shared = n * first.half_width**2 / slope * (first.levels.front_y - first.levels.plate_back_y)
    return sum(arm_mm3(arm) for arm in d.arms) - shared + boss_mm3(first)


@dataclass(frozen=True)
class Star(MadePart):
    """Frame where it stands in the assembly."""

    dims: StarDims

    def solid(self) -> cq.Solid:
        """Drawn by ``frame.py`` beside this module."""
        from mbcdm_cad.layouts.miso_spur.support.frame import create_star

        return create_star(self.dims)

    def volume_mm3(self) -> float:
        """Closed form, mm^3."""
        return star_mm3(self.dims)

    def sheet(self, part: str) -> Sheet:
        """Described by ``frame_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.miso_spur.support.frame_sheet import star_sheet

        return star_sheet(part, self.dims)
