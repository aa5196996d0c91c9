"""Moments of inertia of pulleys, guide and drum, from the radii and materials of the design file alone.

Plain bodies of revolution (:mod:`mbcdm_cad.model.inertia`); a stud or sleeve at radius R counts as m R^2. Small
features are left out: windows in the web, lugs, the drum's shaft, collars, bearing rings, encoder hubs.
"""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.routes import DRUM, GUIDE
from mbcdm_cad.model.inertia import disc_kg_m2
from mbcdm_cad.parts.drum_sector.inertia import drum_inertia_kg_m2
from mbcdm_cad.routes.route import input_body


def inertias_kg_m2(drive: BevelDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    smallest = min(c.guide_radius_mm for c in drive.cables)
    inner = _surface_mm(drive, smallest) + drive.clearances.transfer_gap_mm
    found = {DRUM: drum_inertia_kg_m2(drive, inner), GUIDE: _guide(drive)}
    return found | {input_body(name): _input_pulley(drive, name) for name in drive.input_names}


def _surface_mm(drive: BevelDrive, pitch_mm: float) -> float:
    return pitch_mm - drive.cable.diameter_mm / 2.0


def _input_pulley(drive: BevelDrive, name: str) -> float:
    """Each step is as long as its cable's band: dead turns, live turns, one rope."""
    total = 0.0
    for cable in (c for c in drive.cables if c.input_name == name):
        live = 2.0 * drive.half_travel_deg / 360.0 * cable.drum_radius_mm / cable.input_radius_mm
        length = drive.helix_lead_mm * (drive.dead_turns + live) + drive.cable.diameter_mm
        density = drive.pulley_material.density_g_cm3
        total += disc_kg_m2(density, length, _surface_mm(drive, cable.input_radius_mm))
    return total


def _guide(drive: BevelDrive) -> float:
    """The guide, kg m2: steps at the distances of the drum's radii, bored for the bearings over the whole length."""
    cables = sorted(drive.cables, key=lambda c: c.step)
    radii = [c.drum_radius_mm for c in cables]
    length = (radii[-1] - radii[0]) / (len(radii) - 1) if len(radii) > 1 else drive.cable.diameter_mm
    bore = drive.bearings.guide.outer_diameter_mm / 2.0
    density = drive.guide_material.density_g_cm3
    return sum(disc_kg_m2(density, abs(length), _surface_mm(drive, c.guide_radius_mm), bore) for c in cables)
