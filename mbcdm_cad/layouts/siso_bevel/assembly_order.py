"""The order of assembly: figures for ``assembly.md.j2``."""

from __future__ import annotations

from mbcdm_cad.layouts.assembly import steps
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.motor_head.dims import flange_screw


def assembly_order(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    return steps(layout, flange=flange_screw(layout.drive).name)
