"""Least squares with errors clustered by half sweep and sector of angle.

Residuals of a drive are coloured, and what repeats in angle comes back in every sweep. An ordinary test counts each
sample as new evidence and accepts every effect. Here the evidence is what whole sweeps and whole sectors agree on.
Two-way clusters: A. C. Cameron, J. B. Gelbach, D. L. Miller, J. Business & Economic Statistics 29 (2011).

A cell is the part of one sweep that lies in one sector of angle. For columns X and a residual y it keeps the Gram
matrix [1 X y]^T [1 X y] of its samples: one pass over the samples, after which every test needs only the cells.

An error at one angle, or in one sweep, can be fitted well by effects that are not present: a few ripples form a bump.
In that case the fit changes when one sector, or one sweep, is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from mbcdm_cad.routes import Floats

# Samples multiplied at one time, so that the copy stays small for a run of any length.
BLOCK = 65_536


@dataclass(frozen=True, eq=False)
class Cells:
    """Grams (cells, k + 2, k + 2) of [1, X, y], y last, and the sweep and sector number of each cell."""

    gram: Floats
    sweep: NDArray[np.int64]
    sector: NDArray[np.int64]

    @property
    def total(self) -> Floats:
        """Gram of all samples."""
        return np.asarray(self.gram.sum(axis=0))


def cell_grams(columns: Floats, y: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]) -> Cells:
    """Grams of ``columns`` (n, k) and ``y`` (n,) over the cells given by ``sweep`` and ``sector``, each (n,)."""
    _, sweep_number = np.unique(sweep, return_inverse=True)
    sectors, sector_number = np.unique(sector, return_inverse=True)
    cell = sweep_number * sectors.size + sector_number
    wide = columns.shape[1] + 2
    gram = np.zeros((int(cell.max()) + 1, wide, wide))
    for start in range(0, y.size, BLOCK):
        part = slice(start, start + BLOCK)
        order = np.argsort(cell[part], kind="stable")
        here = cell[part][order]
        table = np.column_stack([np.ones(here.size), columns[part], y[part]])[order]
        edges = np.flatnonzero(np.diff(here)) + 1
        for rows in np.split(np.arange(here.size), edges):
            some = table[rows[0] : rows[-1] + 1]
            gram[here[rows[0]]] += some.T @ some
    filled = np.flatnonzero(gram[:, 0, 0] > 0.0)
    return Cells(gram[filled], filled // sectors.size, filled % sectors.size)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Least squares of a residual on columns and a constant.

    ``value`` (k,), ``covariance`` (k, k) clustered two ways, ``freedom``: degrees of freedom, one less than the smaller
    number of clusters. A column that the others make up has value 0 and infinite variance.
    """

    value: Floats
    covariance: Floats
    freedom: int

    def probability(self, which: Sequence[int]) -> float:
        """Probability of such values of the columns ``which`` by chance if all are zero (Wald test, as F)."""
        chosen = list(which)
        block = self.covariance[np.ix_(chosen, chosen)]
        if not np.all(np.isfinite(block)):
            return 1.0
        value = self.value[chosen]
        if not value.any():
            return 1.0
        rank = min(len(chosen), self.freedom)
        square = float(value @ np.linalg.pinv(block, rcond=1e-12, hermitian=True) @ value)
        # Hotelling's correction: with few clusters the covariance is itself uncertain.
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
    """The same from sums over cells."""
    gram = cells.total
    size = np.sqrt(np.diag(gram))
    size[size == 0.0] = 1.0
    each = cells.gram / np.outer(size, size)
    value, covariance = jackknifed(each[:, :-1, :-1], each[:, :-1, -1], cells.sweep, cells.sector)
    to_unit = size[-1] / size[:-1]
    value = value * to_unit
    covariance = covariance * np.outer(to_unit, to_unit)
    whole = each.sum(axis=0)[:-1, :-1]
    lost = np.abs(np.diag(np.linalg.pinv(whole, rcond=1e-12, hermitian=True) @ whole) - 1.0) > 1e-6
    value[lost] = 0.0
    covariance[lost, lost] = np.inf
    clusters = min(np.unique(cells.sweep).size, np.unique(cells.sector).size)
    return Estimate(value[1:], covariance[1:, 1:], max(1, clusters - 1))


def jackknifed(
    grams: Floats, sides: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]
) -> tuple[Floats, Floats]:
    """Least squares (..., k) and its covariance (..., k, k) from cells with the grams X^T X (cells, k, k) of columns of
    similar size and the sums X^T y (..., cells, k) of one or more responses.

    The covariance of each kind of cluster is a jackknife: how far the estimate moves when one cluster is left out. With
    as few clusters as there are sectors the plain sandwich is far too sure.
    """
    solved = _solve(grams.sum(axis=0)[None], sides.sum(axis=-2)[..., None, :])
    by_sweep, by_sector, by_cell = (
        _jackknife(grams, sides, group, solved) for group in (sweep, sector, np.arange(grams.shape[0]))
    )
    return solved[..., 0, :], _at_least(by_sweep + by_sector - by_cell, by_cell)


def _solve(grams: Floats, sides: Floats) -> Floats:
    """Least squares from a stack of grams (m, k, k) and of sums (..., m, k); (..., m, k)."""
    inverse = np.linalg.pinv(grams, rcond=1e-12, hermitian=True)
    return np.asarray((inverse @ sides[..., None])[..., 0])


def _jackknife(grams: Floats, sides: Floats, group: NDArray[np.int64], solved: Floats) -> Floats:
    """Covariance from leaving out one group of cells at a time."""
    groups, number = np.unique(group, return_inverse=True)
    if groups.size < group.size:
        chosen = (number == np.arange(groups.size)[:, None]).astype(float)
        own_grams, own_sides = np.tensordot(chosen, grams, axes=1), chosen @ sides
    else:  # every cell is a group: a matrix of cells by cells would take 800 MiB for a long run
        own_grams, own_sides = grams, sides
    moved = _solve(grams.sum(axis=0) - own_grams, sides.sum(axis=-2)[..., None, :] - own_sides) - solved
    return np.asarray((groups.size - 1) / groups.size * np.swapaxes(moved, -1, -2) @ moved)


def _at_least(covariance: Floats, least: Floats) -> Floats:
    """The covariance, at least that of the cells in each direction: the difference of clusters need not be positive.

    Both have the shape (..., k, k).
    """
    wide = least.shape[-1]
    trace = np.maximum(np.trace(least, axis1=-2, axis2=-1), 1e-300)[..., None, None]
    root = np.linalg.cholesky(least + 1e-12 * trace / wide * np.eye(wide))
    back = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(back @ covariance @ np.swapaxes(back, -1, -2))
    spread = root @ vectors
    return np.asarray((spread * np.maximum(values, 1.0)[..., None, :]) @ np.swapaxes(spread, -1, -2))
