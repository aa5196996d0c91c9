"""Test whether all sweeps and sectors support an effect, or only one of them; errors clustered by both.

Residuals of a drive are coloured, and what repeats in angle comes back in every sweep. An ordinary test counts each
sample as new evidence and accepts every effect. Here the evidence is what whole sweeps and whole sectors agree on.
Two-way clusters: A. C. Cameron, J. B. Gelbach, D. L. Miller, J. Business & Economic Statistics 29 (2011).

A cell is the part of one sweep that lies in one sector of angle. For columns X and a residual y it keeps the Gram
matrix [1 X y]^T [1 X y] of its samples: one pass over the samples, after which every test needs only the cells.

Two effects that change the prediction by a and b are separated by their difference d = a - b against the residual's
noise along d. The probability to choose the wrong one is Phi(-|d|^2 / (2 s)), s the standard deviation of d . r; for
white noise and equal sizes that is Phi(-sqrt(t^2 (1 - rho) / 2)), t the effect's strength and rho the cosine of a
and b.

An error at one angle, or in one sweep, can be fitted well by effects that are not present: a few ripples form a bump.
In that case the fit changes when one sector, or one sweep, is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution
from scipy.stats import norm
from scipy.stats import t as t_distribution

from mbcdm_cad.loop.prepare.lines import line_of
from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.prepared import SECTORS
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.routes import Floats

# Samples multiplied at one time, so that the copy stays small for a run of any length.
BLOCK = 65_536
# Below this probability of a wrong choice two effects count as separated.
TOLD_APART = 0.01
# The same as the logarithm of odds.
LOG_ODDS = log(1.0 / TOLD_APART - 1.0)
# Fits whose mean squares differ by a smaller share are the same: the fits end within this of their least.
SAME_FIT = 1e-4


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


@dataclass(frozen=True)
class Separation:
    """How well two effects are separated.

    ``reach``: half the sum of squares of the difference d of the two predictions over the standard deviation of d . r;
    ``square`` (rad^2): that sum.
    """

    reach: float
    square: float

    @property
    def probability(self) -> float:
        """Probability of choosing the wrong one, 0.5: pure chance."""
        return float(norm.sf(self.reach))

    @property
    def factor(self) -> float:
        """How many times as large the effect must be, all else equal, to be separated at 1 %; below 1: it is."""
        return float(norm.isf(TOLD_APART) / self.reach) if self.reach > 0.0 else np.inf

    @property
    def apart(self) -> bool:
        """Whether these data separate them."""
        return self.probability <= TOLD_APART

    def log_odds(self, excess: float) -> float:
        """Logarithm of the odds of the better fit, both equally likely before; ``excess`` (rad^2) is the sum of squares
        of the worse one less that of the better one.

        With d = a - b and normal noise of variance s^2 along d, exp(-|r|^2 / 2) of the two fits along d gives
        excess |d|^2 / (2 s^2); |d|^2 / s is twice the reach.
        """
        if self.square == 0.0:
            return 0.0
        return 2.0 * self.reach**2 * excess / self.square

    @property
    def words(self) -> str:
        """In words, for the result."""
        if self.apart:
            return f"separated, {self.probability:.2g} to be wrong"
        if not np.isfinite(self.factor) or self.factor > 100.0:
            return "the same in this experiment at any size"
        return f"{self.probability:.0%} to be wrong; separated if it were {self.factor:.2g} times as large"


def separation(
    first: Floats, second: Floats, residual: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]
) -> Separation:
    """Compare the changes that two effects, each refitted with all else, make to the prediction.

    ``first`` and ``second`` (n,) in rad; ``residual`` (n,) is that of the better fit. The noise along their difference
    is taken from sums over sweeps and over sectors, at least that over their cells.
    """
    difference = first - second
    square = float(difference @ difference)
    sizes = float(np.linalg.norm(first) * np.linalg.norm(second))
    if square <= 1e-12 * sizes:
        return Separation(0.0, 0.0)
    return separated(square, clustered_deviation(difference * residual, sweep, sector))


def separated(square: float, deviation: float) -> Separation:
    """Separation of two predictions whose difference d has the sum of squares ``square`` (rad^2), where the noise along
    it, d . r, has this standard ``deviation`` (rad^2)."""
    if square == 0.0:
        return Separation(0.0, 0.0)
    return Separation(square / (2.0 * deviation) if deviation > 0.0 else np.inf, square)


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


# Probability of a chance effect, over all candidates that were looked at.
ALPHA = 0.05


def chance(fitter: Fitter, fit: Fit) -> float:
    """Probability that the last effect of ``fit`` was found by chance.

    A Wald test of its sizes with all else fitted too, by leaving out sweeps and sectors; linearised at the fit.
    """
    mask = fitter.train
    kept = fit.has_slope
    columns = fitter.centred_on(mask, fit.jacobian[:, kept])
    last = fit.effects[-1]
    start = sum(value.size for value in fit.values[:-1])
    sizes = [start + i for i, parameter in enumerate(last.parameters) if parameter.role == "size"]
    tested = np.searchsorted(np.flatnonzero(kept), sizes).tolist()
    theta = np.zeros(columns.shape[1])
    theta[tested] = [fit.values[-1][i - start] for i in sizes]
    y = fit.residual[mask] + columns @ theta
    if not (np.isfinite(columns).all() and np.isfinite(y).all()):
        # A fit at the edge of what can be simulated has slopes that are not finite, and nothing can support it.
        return 1.0
    found = cluster_estimate(columns, y, fitter.sweep[mask], fitter.sector[mask])
    # With so few half sweeps no effect could pass this test; there the rule on the held-out error decides alone.
    return replace(found, freedom=max(found.freedom, SECTORS - 1)).probability(tested)


def noise_left(fitter: Fitter, fit: Fit) -> Noise:
    """The noise in the residual of a fit."""
    return noise_of(fitter.base, [fit.residual[part] for part in fitter.parts])


def estimate_of(fitter: Fitter, fit: Fit) -> Estimate:
    """All parameters and offsets of a fit, on all samples in use; columns without a slope are left out, as zero."""
    used, kept = fitter.used, fit.has_slope
    columns = fitter.centred_on(used, fit.jacobian[:, kept])
    found = cluster_estimate(columns, fit.residual[used], fitter.sweep[used], fitter.sector[used])
    value, covariance = np.zeros(kept.size), np.zeros((kept.size, kept.size))
    value[kept], covariance[np.ix_(kept, kept)] = found.value, found.covariance
    return replace(found, value=value, covariance=covariance)


def separation_of(fitter: Fitter, worse: Fit, better: Fit) -> Separation:
    """How well the data separate two fits."""
    used = fitter.used
    here = better.residual[used]
    return separation(-here, -worse.residual[used], here, fitter.sweep[used], fitter.sector[used])


def log_odds(fitter: Fitter, worse: Fit, better: Fit) -> float:
    """Logarithm of the odds of the better of two fits, both equally likely before."""
    excess = float(np.sum((worse.residual**2 - better.residual**2)[fitter.used]))
    return separation_of(fitter, worse, better).log_odds(excess)


def chance_without_slope(fitter: Fitter, less: Fit, fit: Fit) -> float:
    """Probability that noise makes ``fit`` differ so from ``less``, the fit without one effect.

    For an effect whose size has no slope: a pulley that does not reach the far face of its play fits equally well with
    any larger play. So the change of the prediction is tested, against the noise that the effect leaves: white and
    coloured noise along that change, and what whole sweeps and sectors show if that is more.
    """
    used = fitter.used
    change = (less.residual - fit.residual)[used]
    square = float(change @ change)
    noise = noise_left(fitter, fit)
    samples = 1.0 + 2.0 * noise.memory_s / min(p.step_s for p in fitter.runs)
    along = np.sqrt(square * (noise.white_rad**2 + samples * noise.coloured_rad**2))
    clusters = clustered_deviation(change * fit.residual[used], fitter.sweep[used], fitter.sector[used])
    return separated(square, max(float(along), clusters)).probability


def supported(fitter: Fitter, less: Fit, fit: Fit, candidates: int) -> bool:
    """Whether sweeps and sectors support the last effect of ``fit`` (``less``: without it), one of so many
    candidates."""
    if fit.effects[-1].saturates:
        return chance_without_slope(fitter, less, fit) <= ALPHA / max(candidates, 1)
    order = fit.effects[-1].order_index
    if order is not None and not is_line(fitter, less, float(fit.values[-1][order])):
        return False
    return chance(fitter, fit) <= ALPHA / max(candidates, 1)


def is_line(fitter: Fitter, less: Fit, order: float) -> bool:
    """Whether the residual without the effect has a steady line of this order in every sector."""
    mask = fitter.train
    angle: Floats = np.concatenate([setup.drum_rad for setup in fitter.base])
    return line_of(order, angle[mask], less.residual[mask], fitter.sweep[mask]).is_line
