"""Torsion of input pulleys by solid finite elements of their STEP, with the supports that the model assumes.

Units: mm, N, MPa; results in urad per N m.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbcdm_cad.design.bought import Material
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import sum_per_input
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.parts.part import MadePart
from tests.support.frame_solid import resultant
from tests.support.solid_fe import Floats, Solid, tetrahedra

# Longest tetrahedra, over the part's largest radius.
SIZE = 0.3
# Half the band of the lands that takes the torque, over their length.
BAND = 0.15


def solid_of(part: MadePart, material: Material, size_mm: float, folder: Path) -> Solid:
    """The part as drawn, meshed."""
    step = folder / "part.step"
    part.solid().exportStep(str(step))
    return Solid(tetrahedra(step, size_mm, 0.2), material.youngs_modulus_GPa * 1e3, material.poisson_ratio)


def pulley_torsion_urad_Nm(layout: SectorLayout, folder: Path) -> float:
    """Twist of the input pulleys from their collars' upper edge to the middle of their lands, seen by the payload."""
    unit = unit_tensions_N(layout.loads.si)
    torques = sum_per_input(layout.loads.si, unit, layout.loads.si.input_radius_m)
    bill, found = layout.bill(0.0), 0.0
    for pulley, torque in zip(layout.inputs, torques, strict=True):
        part = bill.parts[f"input_pulley_{pulley.name}"].part
        radius = max(pulley.lower_land_radius, pulley.upper_land_radius)
        solid = solid_of(part, layout.drive.pulley_material, SIZE * radius, folder)
        x, y, z = solid.place
        low, high = pulley.land_bottom_z, pulley.land_top_z
        middle, half = (low + high) / 2.0, BAND * (high - low)
        clamped = (z < layout.collar.top_z + 1e-6) & (np.hypot(x, y) > pulley.bore_radius + 1e-3)

        def on_land(p: Floats, low: float = low, high: float = high, least: float = pulley.lower_neck_radius) -> Floats:
            return (p[2] > low - 1e-6) & (p[2] < high + 1e-6) & (np.hypot(p[0], p[1]) > least)

        def round_it(p: Floats, middle: float = middle, half: float = half) -> tuple[Floats, ...]:
            inside = np.abs(p[2] - middle) < half
            return -p[1] * inside, p[0] * inside, 0.0 * inside

        load = solid.traction(solid.facets(on_land), round_it)
        load *= 1e3 * abs(torque) / resultant(solid, load, np.zeros(3))[5]
        found += float(load @ solid.moved(load, np.flatnonzero(clamped))) * 1e3
    return found
