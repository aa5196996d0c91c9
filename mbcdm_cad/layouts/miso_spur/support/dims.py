"""Dimensions of the frame: one plate with the drum's boss, and for each input an arm with the yoke of siso_spur."""

from dataclasses import dataclass
from math import cos, radians, sin

from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.motor_head.dims import Places


@dataclass(frozen=True)
class StarDims:
    """The frame (mm): an arm for each input, with its angle about Y from +Z towards +X.

    The arms differ in the reach of their yokes from the plate. Boss and stop pin of the first are shared by all.
    """

    arms: tuple[YokeDims, ...]
    angles_deg: tuple[float, ...]

    def turned(self, index: int, places: Places) -> Places:
        """(x, z) of places given with the input of this index above the drum."""
        angle = radians(self.angles_deg[index])
        return tuple((x * cos(angle) + z * sin(angle), z * cos(angle) - x * sin(angle)) for x, z in places)
