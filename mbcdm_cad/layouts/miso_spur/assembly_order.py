"""The order of assembly: figures for ``assembly.md.j2``."""

from __future__ import annotations

from mbcdm_cad.layouts.assembly import steps
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.assembly_order import figures
from mbcdm_cad.parts.bill import AssemblyStep


def assembly_order(layout: RoundDrumLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    mm = {c.name: c.cut_length_m * 1e3 for c in layout.tensioning.cables} if layout.tensioning else {}
    units = zip(layout.units, layout.drive.input_names, strict=True)
    cuts = (f", {sum(mm[side.name] for side in unit.drive.cables):.1f} mm for {name}" for unit, name in units)
    return steps(layout, cuts="".join(cuts), **figures(layout))
