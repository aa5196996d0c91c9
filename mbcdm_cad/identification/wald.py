"""Robust tests and intervals: covariance clustered by sweep and by angle sector, and the Wald test on it.

Residuals of a drive are coloured, and what repeats in angle comes back in every sweep. An ordinary test counts each
sample as new evidence and fires on everything. Here the evidence is what whole sweeps, and whole sectors, agree upon.
Two-way clusters: A. C. Cameron, J. B. Gelbach, D. L. Miller, J. Business & Economic Statistics 29 (2011).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from mbcdm_cad.identification.cells import Cells, cell_grams
from mbcdm_cad.measurement.run import Floats


@dataclass(frozen=True, eq=False)
class Estimate:
    """Least squares of a residual on columns, a level besides.

    ``value`` (k,), ``covariance`` (k, k) clustered two ways, ``freedom``: degrees of freedom, one less than the smaller
    number of clusters. A column that the others make up has value 0 and infinite variance.
    """

    value: Floats
    covariance: Floats
    freedom: int

    def probability(self, which: Sequence[int]) -> float:
        """Probability that the columns ``which`` are all zero and only look as they do (Wald, as F)."""
        chosen = list(which)
        block = self.covariance[np.ix_(chosen, chosen)]
        if not np.all(np.isfinite(block)):
            return 1.0
        value = self.value[chosen]
        if not value.any():
            return 1.0
        rank = min(len(chosen), self.freedom)
        square = float(value @ np.linalg.pinv(block, rcond=1e-12, hermitian=True) @ value)
        # Hotelling's correction: with few clusters the covariance is itself a guess.
        freedom = self.freedom - rank + 1
        if freedom < 1:
            return 1.0
        return float(f_distribution.sf(square * freedom / (self.freedom * rank), rank, freedom))

    def half_width(self) -> Floats:
        """Half the width of the 95 % interval of each value, (k,)."""
        return np.asarray(t_distribution.ppf(0.975, self.freedom) * np.sqrt(np.diag(self.covariance)))


def cluster_estimate(columns: Floats, y: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]) -> Estimate:
    """Estimate with covariance clustered by ``sweep`` and ``sector``; ``columns`` (n, k), the others (n,).

    Nuisance columns are simply among the columns: what they can explain is no evidence for the rest.
    """
    return estimate(cell_grams(columns, y, sweep, sector))


def estimate(cells: Cells) -> Estimate:
    """The same from sums over cells.

    The covariance of each kind of cluster is a jackknife: how far the estimate moves when one cluster is left out. With
    as few clusters as there are sectors the plain sandwich is far too sure.
    """
    gram = cells.total
    size = np.sqrt(np.diag(gram))
    size[size == 0.0] = 1.0
    scale = np.outer(size, size)
    each = cells.gram / scale
    whole = each.sum(axis=0)
    solved = _solve(whole[None])[0]
    by_sweep, sweeps = _jackknife(whole, each, cells.sweep, solved)
    by_sector, sectors = _jackknife(whole, each, cells.sector, solved)
    by_cell, _ = _jackknife(whole, each, np.arange(each.shape[0]), solved)
    covariance = _at_least(by_sweep + by_sector - by_cell, by_cell)
    to_unit = size[-1] / size[:-1]
    value = solved * to_unit
    covariance = covariance * np.outer(to_unit, to_unit)
    inverse = np.linalg.pinv(whole[:-1, :-1], rcond=1e-12, hermitian=True)
    lost = np.abs(np.diag(inverse @ whole[:-1, :-1]) - 1.0) > 1e-6
    value[lost] = 0.0
    covariance[lost, lost] = np.inf
    return Estimate(value[1:], covariance[1:, 1:], max(1, min(sweeps, sectors) - 1))


def _solve(grams: Floats) -> Floats:
    """Least squares from a stack of grams (m, k + 1, k + 1), the response last; (m, k)."""
    inverse = np.linalg.pinv(grams[:, :-1, :-1], rcond=1e-12, hermitian=True)
    return np.asarray(np.einsum("mij,mj->mi", inverse, grams[:, :-1, -1]))


def _jackknife(whole: Floats, each: Floats, group: NDArray[np.int64], solved: Floats) -> tuple[Floats, int]:
    """Covariance from leaving out one group of cells at a time, and the number of groups."""
    groups, number = np.unique(group, return_inverse=True)
    left_out = np.zeros((groups.size, *whole.shape))
    np.add.at(left_out, number, each)
    moved = _solve(whole - left_out) - solved
    return np.asarray((groups.size - 1) / groups.size * moved.T @ moved), int(groups.size)


def _at_least(covariance: Floats, least: Floats) -> Floats:
    """The difference of clusters need not be a covariance: no direction may fall below that of the cells alone."""
    root = np.linalg.cholesky(least + 1e-12 * max(np.trace(least), 1e-300) / least.shape[0] * np.eye(least.shape[0]))
    back = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(back @ covariance @ back.T)
    return np.asarray(root @ (vectors * np.maximum(values, 1.0)) @ vectors.T @ root.T)
