"""Covariance of a fit whose residual is coloured and repeats in angle: clusters by sweep and by angle sector.

Two-way cluster sandwich (Cameron, Gelbach and Miller): V = V_sweep + V_sector - V_both, each B M B with B the inverse
of the normal matrix and M the sum over clusters of the outer products of the clusters' scores.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.run import Floats


def _meat(scores: Floats, cluster: NDArray[np.int64]) -> Floats:
    """Sum of outer products of the clusters' scores, with the small-sample factor G/(G - 1)."""
    _, number = np.unique(cluster, return_inverse=True)
    count = int(number.max()) + 1
    total = np.stack([np.bincount(number, column, count) for column in scores.T], axis=1)
    return np.asarray(total.T @ total * count / max(count - 1, 1))


def cluster_covariance(
    columns: Floats, residual: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]
) -> Floats:
    """Covariance of the coefficients of ``columns`` (n, k), mean taken off, given the residual (n,); shape (k, k).

    Never less than that of white noise, which the two-way form, a difference, does not ensure by itself.
    """
    if columns.shape[1] == 0:
        return np.zeros((0, 0))
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    unit = columns / size
    bread = np.linalg.pinv(unit.T @ unit, rcond=1e-10, hermitian=True)
    scores = unit * residual[:, None]
    both = sweep * (int(sector.max()) + 1) + sector
    by_cell = _meat(scores, both)
    meat = _meat(scores, sweep) + _meat(scores, sector) - by_cell
    white = bread * float(np.mean(residual**2))
    found = bread @ meat @ bread
    least = np.maximum(np.diag(white), np.diag(bread @ by_cell @ bread))
    variance = np.maximum(np.diag(found), least)
    # Keep the correlations where the matrix is one, and raise the variances that came out too small.
    scale = np.sqrt(variance / np.where(np.diag(found) > 0.0, np.diag(found), variance))
    found = found * np.outer(scale, scale)
    np.fill_diagonal(found, variance)
    return np.asarray(found / np.outer(size, size))
