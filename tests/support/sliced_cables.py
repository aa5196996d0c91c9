"""Two cables in equilibrium with a drum, each wrap integrated in slices: an independent check of the model's law."""

from math import log, sqrt

import numpy as np

from mbcdm_cad.parts.drum_sector.design import SectorDrive

SLICES = 4000


def stretch_m(tension_N: float, preload_N: float, spans_m: tuple[float, float, float], ea_N: float, mu: float) -> float:
    """Stretch of one cable by summing up slices of its wraps; ``spans_m``: free length, radii of input and drum."""
    free, *radii = spans_m
    total = free * (tension_N - preload_N)
    reach = abs(log(tension_N / preload_N)) / mu
    step = reach / SLICES
    sign = 1.0 if tension_N < preload_N else -1.0
    for radius in radii:
        angles = (np.arange(SLICES) + 0.5) * step
        total += radius * step * float(np.sum(tension_N * np.exp(sign * mu * angles) - preload_N))
    return total / ea_N


def by_bisection(drive: SectorDrive, free_m: float, load_Nm: float) -> tuple[float, list[float]]:
    """(drum angle, tensions) at which both cables carry the load, each tension found from its stretch by bisection."""
    rope, mu = drive.cable, drive.friction_coefficient

    def tension(cable: int, angle: float) -> float:
        c = drive.cables[cable]
        radii = (free_m, c.input_radius_mm * 1e-3, c.drum_radius_mm * 1e-3)
        wanted = -c.sense * angle * c.drum_radius_mm * 1e-3
        low, high = 1e-3 * c.preload_N, 50.0 * c.preload_N
        for _ in range(60):
            middle = sqrt(low * high)
            if stretch_m(middle, c.preload_N, radii, rope.axial_stiffness_N, mu) < wanted:
                low = middle
            else:
                high = middle
        return sqrt(low * high)

    def carried(angle: float) -> float:
        return sum(c.sense * tension(k, angle) * c.drum_radius_mm * 1e-3 for k, c in enumerate(drive.cables))

    low, high = -5e-3, 5e-3
    for _ in range(45):
        middle = (low + high) / 2
        if carried(middle) > load_Nm:
            low = middle
        else:
            high = middle
    return middle, [tension(k, middle) for k in range(2)]
