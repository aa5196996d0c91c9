"""What the noise of the inputs and of the torque sensor does to the prediction, by way of the cables' friction.

The friction follows the load and the difference of the inputs. Both are smoothed before they drive it; what noise the
smoothing leaves, and what it takes of the true motion, moves the friction in another way in each run. These errors are
found by a parametric bootstrap (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993): noise is added to
the smoothed signals, they are smoothed again, and the prediction is made anew.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbcdm_cad.loop.prepare.quiet import SignalNoise, quiet_load, slow_difference
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

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
