"""Moments of inertia of plain bodies of revolution about their axes, kg m2.

disc or ring of length w      pi/2 rho w (R^4 - r^4)
sector of half angle a        a/2 rho w (R^4 - r^4)
"""

from __future__ import annotations

from math import pi

_MM = 1e-3
_G_CM3 = 1e3  # kg/m3


def disc_kg_m2(density_g_cm3: float, length_mm: float, outer_mm: float, inner_mm: float = 0.0) -> float:
    """Disc or ring about its axis, kg m2; radii in mm."""
    return sector_kg_m2(density_g_cm3, length_mm, outer_mm, inner_mm, pi)


def sector_kg_m2(density_g_cm3: float, length_mm: float, outer_mm: float, inner_mm: float, half_rad: float) -> float:
    """Sector of a ring about the ring's axis, kg m2; ``half_rad`` is half of the angle it spans."""
    fourth = (outer_mm * _MM) ** 4 - (inner_mm * _MM) ** 4
    return half_rad / 2.0 * density_g_cm3 * _G_CM3 * length_mm * _MM * fourth
