"""Figures of the cables' paths over the travel: those of each input, and the usable travel of all.

And the plan by which the preloads are set.
"""

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.path_figures import SpurFigures, path_lines, tensioned_sides
from mbcdm_cad.layouts.siso_spur.path_figures import path_figures as of_one_input
from mbcdm_cad.model.tensioning import TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes.curves import EndOfTravel

__all__ = ["path_figures", "path_lines"]


def path_figures(layout: RoundDrumLayout) -> SpurFigures:
    """The figures of one design; wrap and walk are the same at every input."""
    units = [of_one_input(unit) for unit in layout.units]

    def nearest(ends: list[tuple[EndOfTravel, ...]]) -> tuple[EndOfTravel, ...]:
        distinct = dict.fromkeys(end for of in ends for end in of)
        return tuple(sorted(distinct, key=lambda end: abs(end.angle_deg)))

    return SpurFigures(
        units[0].drum_angle_deg,
        tuple(cable for unit in units for cable in unit.cables),
        units[0].wrap_deg,
        units[0].walk_mm,
        nearest([unit.limits_positive for unit in units]),
        nearest([unit.limits_negative for unit in units]),
    )


def plan(layout: RoundDrumLayout) -> TensioningPlan:
    """Plan to set the preloads of all sides, in the order of the drive."""
    drive = layout.drive
    cables = [cable for unit in layout.units for cable in tensioned_sides(unit)]
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
