"""The plan to set the preloads: each cable as in siso_spur, with the drum and all inputs held together."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.tensioning import tensioned_sides
from mbcdm_cad.model.tensioning_plan import TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.take_up import tensioned_rope


def plan(layout: RoundDrumLayout) -> TensioningPlan:
    """Plan to set the preloads of all sides, in the order of the drive."""
    drive = layout.drive
    cables = [cable for unit in layout.units for cable in tensioned_sides(unit)]
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
