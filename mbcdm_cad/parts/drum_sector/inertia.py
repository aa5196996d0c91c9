"""Moment of inertia of a drum sector, from the radii and materials of the design file alone."""

from __future__ import annotations

from math import pi, radians

from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.volume import disc_kg_m2, sector_kg_m2

_MM = 1e-3


def drum_inertia_kg_m2(drive: SectorDrive, inner_y_mm: float) -> float:
    """Stepped rim, web and hub; studs and sleeves of the tensioners count as solid steel at the pitch radius.

    ``inner_y_mm``: inner face of the rim.
    """
    spec, cables = drive.drum, sorted(drive.cables, key=lambda c: c.step)
    half, density = radians(spec.sector_half_angle_deg), drive.drum_material.density_g_cm3
    flank = drive.cable.diameter_mm / 2.0
    walls = [c.land_y_mm - drive.clearances.land_edge_mm for c in cables[1:]] + [spec.outer_face_y_mm]
    hub = spec.hub_diameter_mm / 2.0
    total = disc_kg_m2(density, spec.hub_face_y_mm - inner_y_mm, hub, drive.bearings.drum.bore_mm / 2.0)
    total += sector_kg_m2(density, spec.web_thickness_mm, spec.rim_inner_radius_mm, hub, half)
    edge = inner_y_mm
    for cable, wall in zip(cables, walls, strict=True):
        total += sector_kg_m2(density, wall - edge, cable.drum_radius_mm - flank, spec.rim_inner_radius_mm, half)
        edge = wall
    t = drive.tensioner
    steel = drive.material(t.material).density_g_cm3 * 1e-6  # kg/mm3
    stud = pi / 4.0 * (t.thread_mm**2 * t.stud_length_mm + t.swage_diameter_mm**2 * t.swage_length_mm) * steel
    return total + sum(stud * (c.drum_radius_mm * _MM) ** 2 for c in cables)
