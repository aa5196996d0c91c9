"""Moments of inertia of what turns, from the radii and materials of the design file alone.

Plain bodies of revolution, in SI:

    disc or ring of length w      pi/2 rho w (R^4 - r^4)
    sector of half angle a        a/2 rho w (R^4 - r^4)
    stud or sleeve at radius R    m R^2

The rig knows no CAD and no layout, so small features are left out: windows in the web, lugs, the drum's shaft, collars,
bearing rings, encoder hubs. The rotor counts 76^2-fold at the input and outweighs them by far.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians

from mbcdm_cad.design.drive import Drive

_MM = 1e-3
_G_CM3 = 1e3  # kg/m3
_G_CM2 = 1e-7  # kg m2


@dataclass(frozen=True)
class Inertias:
    """Moments of inertia in kg m2, each about its own axis; the rotor's is not reflected through the gearhead."""

    rotor_kg_m2: float
    input_pulley_kg_m2: tuple[float, ...]
    guide_kg_m2: float
    drum_kg_m2: float

    def at_drum_kg_m2(self, drive: Drive) -> float:
        """All of it seen at the drum, rotors included."""
        total = self.drum_kg_m2 + self.guide_kg_m2 * guide_turns(drive) ** 2
        for i, name in enumerate(drive.input_names):
            cable = next(c for c in drive.cables if c.input_name == name)
            turns = cable.drum_radius_mm / cable.input_radius_mm
            at_input = self.input_pulley_kg_m2[i] + self.rotor_kg_m2 * drive.gearhead.ratio**2
            total += at_input * turns**2
        return total


def guide_turns(drive: Drive) -> float:
    """Turns of the guide for one of the drum: the mean of r_o/r_g over the cables."""
    return sum(c.drum_radius_mm / c.guide_radius_mm for c in drive.cables) / len(drive.cables)


def inertias(drive: Drive) -> Inertias:
    """Inertias of the moving parts of ``drive``; the closed forms are those of the module's head."""
    return Inertias(
        rotor_kg_m2=drive.motor.rotor_inertia_g_cm2 * _G_CM2,
        input_pulley_kg_m2=tuple(_input_pulley(drive, name) for name in drive.input_names),
        guide_kg_m2=_guide(drive),
        drum_kg_m2=_drum(drive),
    )


def disc_kg_m2(density_g_cm3: float, length_mm: float, outer_mm: float, inner_mm: float = 0.0) -> float:
    """Disc or ring about its axis, kg m2; radii in mm."""
    return sector_kg_m2(density_g_cm3, length_mm, outer_mm, inner_mm, pi)


def sector_kg_m2(density_g_cm3: float, length_mm: float, outer_mm: float, inner_mm: float, half_rad: float) -> float:
    """Sector of a ring about the ring's axis, kg m2; ``half_rad`` is half of the angle it spans."""
    fourth = (outer_mm * _MM) ** 4 - (inner_mm * _MM) ** 4
    return half_rad / 2.0 * density_g_cm3 * _G_CM3 * length_mm * _MM * fourth


def _surface_mm(drive: Drive, pitch_mm: float) -> float:
    return pitch_mm - drive.cable.diameter_mm / 2.0


def _input_pulley(drive: Drive, name: str) -> float:
    """Each step is as long as its cable's band: dead turns, live turns, one rope."""
    total = 0.0
    for cable in (c for c in drive.cables if c.input_name == name):
        live = 2.0 * drive.half_travel_deg / 360.0 * cable.drum_radius_mm / cable.input_radius_mm
        length = drive.helix_lead_mm * (drive.dead_turns + live) + drive.cable.diameter_mm
        density = drive.input_pulleys.material.density_g_cm3
        total += disc_kg_m2(density, length, _surface_mm(drive, cable.input_radius_mm))
    return total


def _guide(drive: Drive) -> float:
    """Steps as far apart as the drum's radii, bored for the bearings all through."""
    cables = sorted(drive.cables, key=lambda c: c.step)
    radii = [c.drum_radius_mm for c in cables]
    length = (radii[-1] - radii[0]) / (len(radii) - 1) if len(radii) > 1 else drive.cable.diameter_mm
    bore = drive.bearings.guide.outer_diameter_mm / 2.0
    density = drive.guide.material.density_g_cm3
    return sum(disc_kg_m2(density, abs(length), _surface_mm(drive, c.guide_radius_mm), bore) for c in cables)


def _drum(drive: Drive) -> float:
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
