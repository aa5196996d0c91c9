"""Is a line of the order spectrum one that a wheel would make: steady from sweep to sweep, and there in every sector?

A broad hump or a local texture has peaks too, and a plain false-alarm probability takes them for lines. Here each sweep
gives one pair (cos, sin) of the line, and Hotelling's T^2 asks if their mean is zero, counted for all orders that the
search could have picked; then each sector must show the line at the phase of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from mbcdm_cad.identification.orders import MOST_ORDER
from mbcdm_cad.measurement.run import Floats

# Probability of a false line over all orders searched.
ALPHA = 0.01
# A sector shows the line if its part at the phase of the whole is at least this share of the whole's amplitude.
LEAST_IN_SECTOR = 0.35
# Cycles that a sector or a sweep must hold to say anything about a line.
LEAST_CYCLES = 1.5
LEAST_SAMPLES = 12
# The travel is cut into as many sectors as have room for these cycles, up to a number.
MOST_SECTORS = 8


@dataclass(frozen=True, eq=False)
class Line:
    """Verdict on one order.

    ``probability`` of so steady a line by chance, over all orders searched (at most 1); ``sectors``: the part of the
    line in each sector of the travel, as a share of the whole; ``amplitude`` in the residual's unit.
    """

    order: float
    amplitude: float
    probability: float
    sectors: Floats

    @property
    def steady(self) -> bool:
        """The same in every sweep."""
        return self.probability <= ALPHA

    @property
    def everywhere(self) -> bool:
        """In every sector; a line of few cycles has none to compare."""
        return bool(np.all(self.sectors >= LEAST_IN_SECTOR))

    @property
    def is_line(self) -> bool:
        """Both."""
        return self.steady and self.everywhere


def line_of(
    order: float,
    angle_rad: Floats,
    residual: Floats,
    sweep: NDArray[np.int64],
    most_order: float = MOST_ORDER,
) -> Line:
    """Test one order (cycles a turn of the drum); arrays (n,), samples in use only.

    The search could have picked any order up to ``most_order``: 2 x travel (in turns) x ``most_order`` trials. The wave
    is fitted beside a level and a slope, in all, sweep by sweep and sector by sector.
    """
    wave = np.stack([np.cos(order * angle_rad), np.sin(order * angle_rad)], axis=1)
    travel = float(np.ptp(angle_rad))
    trials = max(1.0, 2.0 * travel / (2.0 * np.pi) * most_order)
    whole = _amplitudes(wave, angle_rad, residual)
    amplitude = float(np.hypot(*whole))
    pairs = []
    for one in np.unique(sweep):
        chosen = sweep == one
        cycles = order * float(np.ptp(angle_rad[chosen])) / (2.0 * np.pi)
        if chosen.sum() >= LEAST_SAMPLES and cycles >= LEAST_CYCLES:
            pairs.append(_amplitudes(wave[chosen], angle_rad[chosen], residual[chosen]))
    probability = min(1.0, trials * hotelling(np.array(pairs).reshape(-1, 2)))
    shares = []
    places = int(min(order * travel / (2.0 * np.pi) / LEAST_CYCLES, MOST_SECTORS))
    place = np.minimum((angle_rad - angle_rad.min()) / travel * places, places - 1).astype(np.int64)
    for one in range(places):
        chosen = place == one
        if chosen.sum() < LEAST_SAMPLES or amplitude == 0.0:
            continue
        part = _amplitudes(wave[chosen], angle_rad[chosen], residual[chosen])
        shares.append(float(part @ whole) / amplitude**2)
    return Line(order, amplitude, probability, np.array(shares))


def _amplitudes(wave: Floats, angle_rad: Floats, residual: Floats) -> Floats:
    """(cos, sin) of a line by least squares, beside a level and a slope."""
    columns = np.column_stack([wave, np.ones(angle_rad.size), angle_rad - angle_rad.mean()])
    return np.asarray(np.linalg.lstsq(columns, residual, rcond=1e-10)[0][:2], dtype=float)


def hotelling(pairs: Floats) -> float:
    """Probability that the mean of ``pairs``, shape (s, 2), is off zero by chance: Hotelling's T^2; 1 if s < 4."""
    count = pairs.shape[0]
    if count < 4:
        return 1.0
    mean = pairs.mean(axis=0)
    covariance = np.cov(pairs, rowvar=False)
    determinant = float(np.linalg.det(covariance))
    if determinant <= 0.0:
        return 0.0 if mean.any() else 1.0
    t_squared = count * float(mean @ np.linalg.solve(covariance, mean))
    return float(f_distribution.sf((count - 2) / (2.0 * (count - 1)) * t_squared, 2, count - 2))
