"""Errors of a prediction that noise causes: correlated noise of the residual, and noise that reaches the friction.

The colour of the noise: how much of it lasts from sample to sample, and what it does along an effect.

A slow load step sees the slow part of the noise, a ripple the white part. The floor of the loop is its RMS; the power
of a plan depends on its spectrum. The noise is modelled as white noise and a part whose correlation falls as
exp(-t / T).

What the noise of the inputs and of the torque sensor does to the prediction, by way of the cables' friction.

The friction follows the load and the difference of the inputs. Both are smoothed before they drive it; what noise the
smoothing leaves, and what it takes of the true motion, moves the friction in another way in each run. These errors are
found by a parametric bootstrap (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993): noise is added to
the smoothed signals, they are smoothed again, and the prediction is made anew.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import minimize
from scipy.signal import lfilter
from scipy.special import expit, logit

from mbcdm_cad.loop.prepare.noise import FEWEST_SWEEPS, Noise, curves
from mbcdm_cad.loop.prepare.quiet import SignalNoise, quiet_load, slow_difference
from mbcdm_cad.loop.prepare.setup import Setup
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

# Samples that the colour is found on.
MOST_FITTED = 8_000
# Logits of the share of the mean square that lasts, and logarithms of its correlation time, s, between which the
# likelihood is searched; and shares and times from the best of which the search begins.
BOUNDS = np.array([[logit(1e-3), np.log(0.02)], [logit(0.999), np.log(5.0)]])
MEMORIES_S, SHARES = (0.05, 0.25, 1.0, 3.0), (0.05, 0.27, 0.73)
# First corners of the search around its beginning: in the logarithms of share / (1 - share) and of the memory.
FIRST_STEPS = np.array([[0.0, 0.0], [0.7, 0.0], [0.0, -0.5]])
# Step of the second differences, least curvature, number of likely colours.
CURVED, FLATTEST, LIKELY, PROFILE_SEED = 0.3, 0.25, 24, 2
# A pause between samples this many times as long as the usual step begins a new stretch.
PAUSE = 3.0
# Directions of the curves with a smaller share of the largest one's size are none.
RANK = 1e-8


def coloured(noise: Noise, setup: Setup, residual: Floats) -> Noise:
    """``noise`` with the colour that the residual (n,) of its run has; unchanged if too few half sweeps repeat, or if
    the floor is that of the declared steps.

    Curves that are fitted to the residual follow its slow noise too, so what they leave has too short a memory. The
    restricted likelihood is that of the part of the residual that no curve can follow: H. D. Patterson, R. Thompson,
    Biometrika 58 (1971).
    """
    p = setup.p
    at = np.flatnonzero(p.used)
    at = at[:: max(1, at.size // MOST_FITTED)]
    if noise.total_rad <= noise.declared_rad or p.few or np.unique(p.sweep[at]).size < FEWEST_SWEEPS:
        return noise
    columns = curves(setup, residual, at)[0]
    basis, size, _ = np.linalg.svd(columns / (np.sqrt(np.mean(columns**2, axis=0)) + 1e-30), full_matrices=False)
    y = residual[at] - residual[at].mean()
    steps = np.diff(p.time_s[at])
    step = float(np.median(steps))
    starts = np.concatenate([[0], np.flatnonzero(steps > PAUSE * step) + 1, [at.size]])
    rows = np.vstack([basis[:, size > RANK * size[0]].T, y / np.linalg.norm(y)])
    likelihood = _Likelihood(rows, starts, step)
    greatest = likelihood.greatest()
    share, memory = _colour(greatest)
    return replace(
        noise,
        white_rad=noise.total_rad * float(np.sqrt(1.0 - share)),
        coloured_rad=noise.total_rad * float(np.sqrt(share)),
        memory_s=memory,
        likely=likelihood.likely(greatest),
    )


@dataclass(frozen=True, eq=False)
class _Likelihood:
    """Restricted likelihood of the last of ``rows`` (k + 1, n), given that the others are fitted to it.

    ``starts``: first samples of the stretches without a pause, and n; ``step_s``: time between samples.
    """

    rows: Floats
    starts: NDArray[np.int64]
    step_s: float

    def greatest(self) -> Floats:
        """Where the likelihood is greatest, (2,): logit of the share of the mean square that lasts, log of its
        memory in s."""
        begins = [np.array([logit(share), np.log(memory)]) for share in SHARES for memory in MEMORIES_S]
        first = min(begins, key=self._badness)
        options = {"xatol": 0.02, "fatol": 0.02, "initial_simplex": first + FIRST_STEPS}
        return np.asarray(minimize(self._badness, first, method="Nelder-Mead", bounds=BOUNDS.T, options=options).x)

    def likely(self, greatest: Floats) -> tuple[tuple[float, float], ...]:
        """Equally likely shares and memories, from the curvature of the likelihood at its maximum (Laplace)."""
        steps = CURVED * np.eye(2)
        curved = np.empty((2, 2))
        for i, one in enumerate(steps):
            for j, other in enumerate(steps):
                corners = [self._badness(greatest + a * one + b * other) for a in (1, -1) for b in (1, -1)]
                curved[i, j] = (corners[0] - corners[1] - corners[2] + corners[3]) / (4.0 * CURVED**2)
        values, vectors = np.linalg.eigh(0.25 * (curved + curved.T))
        spread = vectors / np.sqrt(np.maximum(values, FLATTEST))
        drawn = greatest + np.random.default_rng(PROFILE_SEED).standard_normal((LIKELY, 2)) @ spread.T
        return tuple(_colour(one) for one in np.clip(drawn, BOUNDS[0], BOUNDS[1]))

    def _badness(self, at: Floats) -> float:
        """Twice the negative logarithm of the likelihood, but for a constant, at (logit of the share, log memory)."""
        white = self._whitened(*_colour(at))
        gram = white @ white.T
        root = np.linalg.cholesky(gram[:-1, :-1])
        known = solve_triangular(root, gram[:-1, -1], lower=True)
        left = float(gram[-1, -1] - known @ known)
        free = self.rows.shape[1] - self.rows.shape[0] + 1
        return float(free * np.log(left) + 2.0 * np.sum(np.log(np.diag(root))))

    def _whitened(self, share: float, memory_s: float) -> Floats:
        """The rows filtered so that such a noise becomes white.

        With phi the correlation of the slow part from sample to sample, (1 - phi B) of the noise is (1 - theta B) of
        white noise (B: one sample back): an ARMA(1, 1) process.
        """
        phi = float(np.exp(-self.step_s / memory_s))
        now = (1.0 - share) * (1.0 + phi**2) + share * (1.0 - phi**2)
        near = phi * (1.0 - share) / now
        theta = 2.0 * near / (1.0 + float(np.sqrt(1.0 - 4.0 * near**2)))
        parts = np.split(self.rows, self.starts[1:-1], axis=1)
        return np.hstack([lfilter([1.0, -phi], [1.0, -theta], part, axis=1) for part in parts])


def _colour(at: Floats) -> tuple[float, float]:
    """Share and memory in s, from (logit of the share, log memory)."""
    return float(expit(at[0])), float(np.exp(at[1]))


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


# Repetitions of the run, and samples in all of them.
MOST_REPEATED, FEWEST_REPEATED, MOST_SAMPLES = 60, 10, 1_500_000
SEED = 3


def friction_errors(fitter: Fitter, bare: Fit, noise: SignalNoise) -> Floats:
    """Errors of the bare prediction of the fitter's only run in repetitions of it with such a noise, (m, n) on the used
    samples, less their means over the training samples. They are added to the noise of the residual.

    m is 0 where the run has neither a load nor two inputs; a repetition in which a cable is slack is left out.
    """
    p = fitter.runs[0]
    alone = p.run.input_rad.shape[0] == 1
    if fitter.d is None or (alone and p.run.load_Nm is None):
        return np.empty((0, int(p.used.sum())))
    quiet = _smooth(p.run)
    still = fitter.predict([], [], bare.offsets)
    rng, found = np.random.default_rng(SEED), []
    for _ in range(int(np.clip(MOST_SAMPLES // p.run.time_s.size, FEWEST_REPEATED, MOST_REPEATED))):
        again = Fitter(fitter.d, fitter.ratio, [p.driven_by(_noisy(quiet, noise, rng))], fitter.known)
        try:
            moved = still - again.predict([], [], bare.offsets)
        except ModelError:
            continue
        found.append(fitter.centred(moved, fitter.train)[fitter.used])
    return np.array(found).reshape(-1, int(p.used.sum()))


def _smooth(run: Run) -> Run:
    """The run with the smoothed difference of the inputs and load in the place of the measured ones."""
    load = None if run.load_Nm is None else quiet_load(run)[0]
    return replace(run, input_rad=run.input_rad.mean(axis=0) + slow_difference(run)[0], load_Nm=load)


def _noisy(run: Run, noise: SignalNoise, rng: np.random.Generator) -> Run:
    """The run with other noise. That of the differences leaves the mean of the inputs as it is."""
    errors = rng.standard_normal(run.input_rad.shape)
    apart = errors - errors.mean(axis=0)
    size = np.array(noise.difference_rad)[:, None] / np.maximum(np.std(apart, axis=1, keepdims=True), 1e-30)
    load = None if run.load_Nm is None else run.load_Nm + noise.load_Nm * rng.standard_normal(run.load_Nm.size)
    return replace(run, input_rad=run.input_rad + size * apart, load_Nm=load)
