"""The colour of the noise: how much of it lasts from sample to sample, and what it does along an effect.

A slow load step sees the slow part of the noise, a ripple the white part. The floor of the loop is its RMS; the power
of a plan depends on its spectrum. The noise is modelled as white noise and a part whose correlation falls as
exp(-t / T).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.signal import lfilter

from mbcdm_cad.identification.noise import FEWEST_SWEEPS, MOST_SAMPLES, Noise, curves
from mbcdm_cad.identification.setup import Setup
from mbcdm_cad.routes import Floats

# Lags of the autocovariance, s, and correlation times that are tried, s.
LONGEST_LAG_S, LAGS = 2.0, 24
MEMORIES_S = np.geomspace(0.02, 5.0, 40)


def coloured(noise: Noise, setup: Setup, residual: Floats) -> Noise:
    """``noise`` with the colour that the residual (n,) of its run has; unchanged if too few half sweeps repeat, or if
    the floor is that of the declared steps.

    Curves that are fitted to the residual follow its slow noise too, and those fitted to the other half sweeps add
    errors of their own. The product of what both leave has the expectation of the noise: for y = noise and the curves'
    projection H, the block of (1 - H) y y' (1 - H)' (1 - H)^-1 of a half sweep is that of y y' where y is white.
    """
    p = setup.p
    at = np.flatnonzero(p.train)
    at = at[:: max(1, at.size // MOST_SAMPLES)]
    sweep = p.sweep[at]
    if noise.total_rad <= noise.declared_rad or p.few or np.unique(sweep).size < FEWEST_SWEEPS:
        return noise
    seen, unseen = _left(setup, residual, at)
    step = float(np.median(np.diff(p.time_s[at])))
    most = min(round(LONGEST_LAG_S / step), at.size // 8)
    lags = np.unique(np.concatenate([[0], np.geomspace(1, max(most, 3), LAGS).astype(np.int64)]))
    found = np.array([_covariance(seen, unseen, sweep, int(lag)) for lag in lags])
    trials = []
    for memory in MEMORIES_S:
        shapes = np.stack([(lags == 0).astype(float), np.exp(-lags * step / memory)], axis=1)
        squares, left = nnls(shapes, found)
        trials.append((float(left), float(memory), squares))
    _, memory, (white, slow) = min(trials, key=lambda trial: trial[0])
    if white + slow <= 0.0:
        return noise
    share = slow / (white + slow)
    return replace(
        noise,
        white_rad=noise.total_rad * float(np.sqrt(1.0 - share)),
        coloured_rad=noise.total_rad * float(np.sqrt(share)),
        memory_s=memory if share > 0.0 else 0.0,
    )


def _left(setup: Setup, residual: Floats, at: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """What the curves leave of a residual, (n,), and what those leave that were fitted to all other half sweeps."""
    columns, prior = curves(setup, residual, at)
    sweep = setup.p.sweep[at]
    y = residual[at] - residual[at].mean()
    scale = np.sqrt(np.mean(columns**2, axis=0)) + 1e-30
    columns = columns / scale
    gram, side = columns.T @ columns + np.diag(prior / scale**2), columns.T @ y
    unseen = np.empty_like(y)
    for number in np.unique(sweep):
        mine = sweep == number
        own = columns[mine]
        unseen[mine] = y[mine] - own @ np.linalg.solve(gram - own.T @ own, side - own.T @ y[mine])
    return y - columns @ np.linalg.solve(gram, side), unseen


def _covariance(seen: Floats, unseen: Floats, sweep: NDArray[np.int64], lag: int) -> float:
    """Covariance of the noise with itself ``lag`` samples later, within half sweeps."""
    n = sweep.size - lag
    same = sweep[lag:] == sweep[:n]
    return float(np.mean((0.5 * (seen[lag:] * unseen[:n] + unseen[lag:] * seen[:n]))[same])) if same.any() else 0.0


def along(column: Floats, noise: Noise, step_s: float, logged_s: float | None = None) -> float:
    """Variance of the noise along a column (n,) of samples ``step_s`` apart, over that of white noise of the floor's
    RMS; above 1 where the column is as slow as the noise.

    ``logged_s``: time between the samples of the run to be made, if the column has fewer or more.
    """
    square = float(column @ column)
    white = noise.white_rad**2 * (1.0 if logged_s is None else logged_s / step_s)
    if noise.memory_s == 0.0 or square == 0.0:
        return float((white + noise.coloured_rad**2) / noise.total_rad**2)
    summed = lfilter([1.0], [1.0, -np.exp(-step_s / noise.memory_s)], column)
    lasting = max(2.0 * float(column @ summed) / square - 1.0, 0.0)
    return float((white + noise.coloured_rad**2 * lasting) / noise.total_rad**2)
