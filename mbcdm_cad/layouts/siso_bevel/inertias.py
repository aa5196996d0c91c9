"""Moments of inertia of pulley and drum, from the radii and materials of the design file alone.

Plain bodies of revolution (:mod:`mbcdm_cad.model.inertia`); studs and sleeves of the terminals count as m R^2. Small
features are left out: windows in the web, lugs, shafts, the collar, bearing rings, encoder hubs.
"""

from __future__ import annotations

from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.routes import DRUM
from mbcdm_cad.layouts.siso_bevel.stack import direct_stack
from mbcdm_cad.model.inertia import disc_kg_m2
from mbcdm_cad.parts.drum_sector.inertia import drum_inertia_kg_m2
from mbcdm_cad.routes.route import input_body


def inertias_kg_m2(drive: DirectDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    v, flank, density = direct_stack(drive), drive.cable.diameter_mm / 2, drive.pulley_material.density_g_cm3
    # The wall between the steps stands in the middle of the land.
    width = (v.land_top_z - v.land_bottom_z) / 2
    pulley = sum(disc_kg_m2(density, width, c.input_radius_mm - flank) for c in drive.cables)
    return {DRUM: drum_inertia_kg_m2(drive, v.drum_inner_y), input_body(drive.input_names[0]): pulley}
