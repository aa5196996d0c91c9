"""The probability that the loop names an effect of a given size, by the two rules by which it accepts one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ncfdtr, ndtr
from scipy.stats import f as f_distribution

from mbcdm_cad.identification.colour import along
from mbcdm_cad.identification.evidence import ALPHA
from mbcdm_cad.identification.noise import Noise
from mbcdm_cad.identification.prepared import SECTORS, Prepared
from mbcdm_cad.identification.select import LEAST_FALL
from mbcdm_cad.routes import Floats

# Relative error of the smallest size.
SIZE_ERROR = 1e-4


@dataclass(frozen=True)
class Shown:
    """How an effect shows: the RMS of one unit of its size on the half sweeps held back and on the others, and the
    standard deviation of the noise along it there, all over the floor; the number of its sizes, and the value of F from
    which it is supported."""

    seen: float
    held: float
    supporting: float
    trained: float
    sizes: int
    critical: float

    def chance(self, size: float) -> float:
        """Probability that an effect of this size is named.

        The fall of the held-out mean square must be ``LEAST_FALL`` of the floor's: noise along the effect changes it,
        and the error of the fitted sizes lowers it. And the others must support it, by a test whose own estimate of the
        noise, from few sectors, is uncertain: F is noncentral. The noise of the two is independent.
        """
        seen, known = size * self.seen, size * self.supporting / self.trained
        fall = seen**2 - LEAST_FALL**2 - self.sizes * (self.trained * self.seen / self.supporting) ** 2
        freedom = max(SECTORS - self.sizes, 1)
        supported = 1.0 - float(ncfdtr(self.sizes, freedom, known**2, self.critical))
        return float(ndtr(fall / (2.0 * self.held * seen))) * supported


def shown(columns: Floats, noise: Noise, p: Prepared, candidates: int) -> Shown:
    """From derivatives (n, k) on the used samples; ``candidates``: effects that are looked at.

    An effect of two sizes, a wave, is taken at the phase that shows least in the whole run. Where the load differs from
    sweep to sweep, the half sweeps held back, or the others, may show less of the effect than all do.
    """
    test, k = p.test[p.used], columns.shape[1]
    if len(columns) < k:
        return Shown(0.0, np.inf, 0.0, np.inf, k, np.inf)
    worst = columns @ np.linalg.svd(columns, full_matrices=False)[2][-1]

    def of_unit(chosen: NDArray[np.bool_]) -> tuple[float, float]:
        count = max(int(chosen.sum()), 1)
        part = np.where(chosen, worst, 0.0)
        rms = float(np.linalg.norm(part)) / np.sqrt(count) / noise.total_rad
        return rms, float(np.sqrt(along(part, noise, p.step_s) / count))

    seen, held = of_unit(test)
    supporting, trained = of_unit(~test)
    critical = float(f_distribution.isf(ALPHA / candidates, k, max(SECTORS - k, 1)))
    sweep, sector, trains = p.sweep[p.used], p.sector[p.used], np.where(test, 0.0, worst)
    unsure = _jackknifed(trains, sweep) + _jackknifed(trains, sector) - _jackknifed(trains, sweep * SECTORS + sector)
    return Shown(seen, held, supporting, trained, k, critical * max(unsure, 1.0))


def _jackknifed(column: Floats, clusters: NDArray[np.int64]) -> float:
    """Expectation of the variance that leaving out one cluster at a time finds, over the true one.

    The residual of a cluster with a share h of the column's sum of squares grows by 1 / (1 - h) if it is left out, so
    the test finds too much noise where few clusters carry the effect.
    """
    shares = np.bincount(np.unique(clusters, return_inverse=True)[1], column**2) / max(float(column @ column), 1e-300)
    shares = shares[(shares > 0.0) & (shares < 1.0)]
    return float((shares.size - 1) / max(shares.size, 1) * np.sum(shares / (1.0 - shares)))


def smallest(way: Shown, power: float) -> float:
    """Size that is named with this power; infinite if no size is."""
    if min(way.seen, way.supporting) <= 0.0:
        return np.inf
    low = high = LEAST_FALL / way.seen

    def beyond(logarithm: float) -> float:
        return way.chance(float(np.exp(logarithm))) - power

    while beyond(np.log(low)) > 0.0:
        low *= 0.5
    while beyond(np.log(high)) < 0.0:
        high *= 2.0
    return float(np.exp(brentq(beyond, np.log(low), np.log(high), xtol=SIZE_ERROR)))
