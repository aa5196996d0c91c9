"""The order of assembly: figures for ``assembly.md.j2``."""

from __future__ import annotations

from math import pi

from mbcdm_cad.layouts.assembly import steps
from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.plate_screws import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support.dims import AXLE_SCREW
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.terminal import Tensioner


def assembly_order(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step.

    Between guide and back plate a swaged terminal finds no way through. With motors above, the lowest shelf may be
    behind a lug of the centred drum.
    """
    drive, above = layout.drive, layout.drive.motors_above
    return steps(
        layout,
        behind_guide=[c.name for c in drive.cables if winding(drive, c).guide_wrap_rad > pi],
        hidden=[t.cable_name for t in layout.drum.tensioners if above and _before_frame(layout, t)],
        axle_screw=AXLE_SCREW,
        plate_screw=plate_screw_of(drive).name,
    )


def _before_frame(layout: BevelLayout, t: Tensioner) -> bool:
    """Whether a part of the terminal, drum centred, has the frame behind it."""
    v, half = layout.levels, layout.drive.tensioner.swage_diameter_mm / 2
    ends = [t.at(along, out) for along in (t.swage_start, t.tip) for out in (-half, half)]
    return any(abs(x) < v.side_outer_x and z > v.shelf_bottom_z for x, z in ends)
