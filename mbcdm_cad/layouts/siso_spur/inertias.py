"""Moments of inertia of pulley and drum, from radii and materials of the design file.

Plain bodies of revolution (:mod:`mbcdm_cad.model.inertia`); studs and sleeves of the terminals count as m R^2. Small
features are left out: windows in the web, lugs, shafts, the collar, bearing rings, encoder hubs, grooves.
"""

from __future__ import annotations

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.routes import DRUM
from mbcdm_cad.layouts.siso_spur.stack import spur_stack
from mbcdm_cad.model.inertia import disc_kg_m2
from mbcdm_cad.parts.drum_sector.inertia import drum_inertia_kg_m2
from mbcdm_cad.routes.route import input_body


def inertias_kg_m2(drive: SpurDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    v = spur_stack(drive)
    surface = drive.input_radius_mm - drive.cable.diameter_mm / 2
    density = drive.pulley_material.density_g_cm3
    pulley = disc_kg_m2(density, v.land_top_z - v.land_bottom_z, surface)
    return {DRUM: drum_inertia_kg_m2(drive, v.drum_inner_y), input_body(drive.input_names[0]): pulley}
