"""Can two explanations of one residual be told apart, and how much larger would the effect have to be?

Two effects that change the prediction by a and b are told by their difference d = a - b against the residual's noise
along d. The probability to take the wrong one is Phi(-|d|^2 / (2 s)), s the standard deviation of d . r; for white
noise and equal sizes that is Phi(-sqrt(t^2 (1 - rho) / 2)), t the effect's strength and rho the cosine of a and b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from mbcdm_cad.measurement.run import Floats

# Below this probability of a wrong choice two effects count as told apart.
TOLD_APART = 0.01


@dataclass(frozen=True)
class Separation:
    """How well two effects are told apart.

    ``likeness``: cosine between what they do to the prediction; ``probability`` of taking the wrong one (0.5: a toss);
    ``factor`` by which the effect must be larger, all else equal, to be told at 1 % (below 1: it is told now).
    """

    likeness: float
    probability: float
    factor: float

    @property
    def told(self) -> bool:
        """Told apart by these data."""
        return self.probability <= TOLD_APART

    @property
    def words(self) -> str:
        """For people."""
        if self.told:
            return f"told apart, {self.probability:.2g} to be wrong"
        if not np.isfinite(self.factor) or self.factor > 100.0:
            return "the same in this experiment at any size"
        return f"{self.probability:.0%} to be wrong; told apart if it were {self.factor:.2g} times as large"


def separation(
    first: Floats, second: Floats, residual: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]
) -> Separation:
    """Compare the changes that two effects, each refitted with all else, make to the prediction.

    ``first`` and ``second`` (n,) in rad; ``residual`` (n,) what is left with the better one; the noise along their
    difference is taken from sums over sweeps and over sectors, at least that over their cells.
    """
    apart = first - second
    square = float(apart @ apart)
    sizes = float(np.linalg.norm(first) * np.linalg.norm(second))
    likeness = float(first @ second) / sizes if sizes > 0.0 else 1.0
    if square <= 1e-12 * sizes:
        return Separation(likeness, 0.5, np.inf)
    noise = clustered_deviation(apart * residual, sweep, sector)
    if noise == 0.0:
        return Separation(likeness, 0.0, 0.0)
    reach = square / (2.0 * noise)
    return Separation(likeness, float(norm.sf(reach)), float(norm.isf(TOLD_APART) / reach))


def clustered_deviation(terms: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]) -> float:
    """Standard deviation of the sum of ``terms`` (n,), correlated within sweeps and within sectors."""
    sweeps, sweep_number = np.unique(sweep, return_inverse=True)
    sectors, sector_number = np.unique(sector, return_inverse=True)
    table = np.bincount(sweep_number * sectors.size + sector_number, terms, sweeps.size * sectors.size)
    sums = np.asarray(table, dtype=float).reshape(sweeps.size, sectors.size)

    def variance(of: Floats) -> float:
        return float(np.sum(of**2)) * of.size / max(of.size - 1, 1)

    cells = variance(sums.ravel())
    return float(np.sqrt(max(cells, variance(sums.sum(axis=0)) + variance(sums.sum(axis=1)) - cells)))


def confusion_probability(strength: float, likeness: float) -> float:
    """Phi(-sqrt(t^2 (1 - |rho|) / 2)): the same for white noise, from the effect's t and the cosine rho."""
    return float(norm.sf(np.sqrt(strength**2 * (1.0 - abs(likeness)) / 2.0)))
