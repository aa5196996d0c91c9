"""How far a ring round the bearings of a shaft gives sideways against the block of metal above it.

The right half is a curved beam from the lowest point, where by antisymmetry only a shear force passes, up into the
block. Units: mm, N, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from mbcdm_cad.model.structure.drum_sector import Isotropic
from mbcdm_cad.routes import Floats

_SHEAR_FACTOR = 5.0 / 6.0


@dataclass(frozen=True)
class BossRing:
    """A boss: radius of its bore, its own radius, the height over its axis up to which the block is solid, its ends."""

    inner_mm: float
    outer_mm: float
    block_mm: float
    from_mm: float
    to_mm: float

    def slice_mm_N(self, material: Isotropic) -> float:
        """Lateral compliance for 1 N per mm of depth along the axis, for a pressure p cos(phi) of the seat.

        The depth of the beam grows from the round wall to the block's corner.
        """
        phi = np.linspace(-pi / 2, pi / 3, 121)
        outer = np.full_like(phi, self.outer_mm)
        up = phi > 0.0
        outer[up] = np.minimum(self.outer_mm / np.cos(phi[up]), self.block_mm / np.sin(phi[up]))
        wall = outer - self.inner_mm
        radius = (self.inner_mm + self.outer_mm) / 2
        step = np.diff(phi)

        def running(values: Floats) -> Floats:
            return np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * step)])

        # Pressure of unit resultant over both halves.
        push = np.cos(phi) / pi
        force_x, force_z = running(push * np.cos(phi)), running(push * np.sin(phi))
        moment = radius * (np.sin(phi) * force_x - np.cos(phi) * force_z)
        # Columns: from the pressure, from a unit shear force at the lowest point.
        bend = np.stack([moment, radius * np.cos(phi)])
        along = np.stack([-np.sin(phi) * force_x + np.cos(phi) * force_z, np.cos(phi)])
        across = np.stack([np.cos(phi) * force_x + np.sin(phi) * force_z, np.sin(phi)])

        def work(a: int, b: int) -> float:
            density = bend[a] * bend[b] * 12.0 / (material.modulus_MPa * wall**3)
            density += along[a] * along[b] / (material.modulus_MPa * wall)
            density += across[a] * across[b] / (_SHEAR_FACTOR * material.shear_MPa * wall)
            return float(radius * running(density)[-1])

        # The shear force does no work, since the lowest point does not leave the mirror plane.
        return 2.0 * (work(0, 0) - work(0, 1) ** 2 / work(1, 1))

    def work_Nmm(self, at_mm: Floats, force_N: Floats, material: Isotropic) -> float:
        """f . u of lateral forces (n,) of bearings at places (n,) along the axis: the ring moves sideways and shears.

        Slices of the ring cannot bend independently: the lower arc connects them and must shear if they move unequally.
        """
        length, middle = self.to_mm - self.from_mm, (self.to_mm + self.from_mm) / 2
        slice_mm_N = self.slice_mm_N(material)
        arc_N = material.shear_MPa * (self.outer_mm**2 - self.inner_mm**2) / 2 * pi / 2
        shift = slice_mm_N / length * force_N.sum() ** 2
        tilt = float(force_N @ (at_mm - middle)) ** 2
        return float(shift + tilt / (length**3 / (12.0 * slice_mm_N) + arc_N * length))
