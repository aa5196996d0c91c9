"""Moments of inertia of pulleys, guide and drum, from the radii and materials of the design file alone.

Plain bodies of revolution (:mod:`mbcdm_cad.model.inertia`); a stud or sleeve at radius R counts as m R^2. Small
features are left out: windows in the web, lugs, the drum's shaft, collars, bearing rings, encoder hubs.
"""

from __future__ import annotations

from math import pi, radians

from mbcdm_cad.configurations.miso_bevel.drive import BevelDrive
from mbcdm_cad.configurations.miso_bevel.routes import DRUM, GUIDE
from mbcdm_cad.model.inertia import disc_kg_m2, sector_kg_m2
from mbcdm_cad.routes.route import input_body

_MM = 1e-3


def inertias_kg_m2(drive: BevelDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    found = {DRUM: _drum(drive), GUIDE: _guide(drive)}
    return found | {input_body(name): _input_pulley(drive, name) for name in drive.input_names}


def _surface_mm(drive: BevelDrive, pitch_mm: float) -> float:
    return pitch_mm - drive.cable.diameter_mm / 2.0


def _input_pulley(drive: BevelDrive, name: str) -> float:
    """Each step is as long as its cable's band: dead turns, live turns, one rope."""
    total = 0.0
    for cable in (c for c in drive.cables if c.input_name == name):
        live = 2.0 * drive.half_travel_deg / 360.0 * cable.drum_radius_mm / cable.input_radius_mm
        length = drive.helix_lead_mm * (drive.dead_turns + live) + drive.cable.diameter_mm
        density = drive.input_pulleys.material.density_g_cm3
        total += disc_kg_m2(density, length, _surface_mm(drive, cable.input_radius_mm))
    return total


def _guide(drive: BevelDrive) -> float:
    """Steps as far apart as the drum's radii, bored for the bearings all through."""
    cables = sorted(drive.cables, key=lambda c: c.step)
    radii = [c.drum_radius_mm for c in cables]
    length = (radii[-1] - radii[0]) / (len(radii) - 1) if len(radii) > 1 else drive.cable.diameter_mm
    bore = drive.bearings.guide.outer_diameter_mm / 2.0
    density = drive.guide.material.density_g_cm3
    return sum(disc_kg_m2(density, abs(length), _surface_mm(drive, c.guide_radius_mm), bore) for c in cables)


def _drum(drive: BevelDrive) -> float:
    """Stepped rim, web and hub; studs and sleeves of the tensioners count as solid steel at the pitch radius."""
    spec, cables = drive.drum, sorted(drive.cables, key=lambda c: c.step)
    half, density = radians(spec.sector_half_angle_deg), spec.material.density_g_cm3
    start = _surface_mm(drive, cables[0].guide_radius_mm) + drive.clearances.transfer_gap_mm
    walls = [c.guide_radius_mm - drive.clearances.land_edge_mm for c in cables[1:]] + [spec.outer_face_y_mm]
    hub = spec.hub_diameter_mm / 2.0
    total = disc_kg_m2(density, spec.hub_face_y_mm - start, hub, drive.bearings.drum.bore_mm / 2.0)
    total += sector_kg_m2(density, spec.web_thickness_mm, spec.rim_inner_radius_mm, hub, half)
    edge = start
    for cable, wall in zip(cables, walls, strict=True):
        radius = _surface_mm(drive, cable.drum_radius_mm)
        total += sector_kg_m2(density, wall - edge, radius, spec.rim_inner_radius_mm, half)
        edge = wall
    t = drive.tensioner
    steel = drive.material(t.material).density_g_cm3 * 1e-6  # kg/mm3
    stud = pi / 4.0 * (t.thread_mm**2 * t.stud_length_mm + t.swage_diameter_mm**2 * t.swage_length_mm) * steel
    return total + sum(stud * (c.drum_radius_mm * _MM) ** 2 for c in cables)
