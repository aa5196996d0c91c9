"""Errors of the prediction from noise in the signals that drive the friction: as in runs that are made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.prepare.quiet import signal_noise
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.detectable import planned_fitter
from mbcdm_cad.planning.prediction_noise import friction_errors
from mbcdm_cad.routes import Floats

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
STEP = 1.9175e-4
TORQUE_NM, INPUT_RAD = 0.02, 8e-5


def true_signals() -> tuple[Floats, Floats, Floats]:
    """Time, inputs that track unlike, and a load in steps."""
    t = np.arange(0.0, 100.0, 0.02)
    drum = 0.45 * np.sin(2.0 * np.pi * t / 10.0)
    apart = 9.0 * 1e-5 * (np.sin(2.0 * np.pi * 0.31 * t) + np.sin(2.0 * np.pi * 0.87 * t + 1.0))
    load = 0.8 * np.sign(np.sin(2.0 * np.pi * t / 7.3)) * (1.0 - np.exp(-t / 0.3))
    return t, np.stack([9.0 * drum + 0.5 * apart, 9.0 * drum - 0.5 * apart]), load


def logged(seed: int) -> Run:
    """The same run with other noise of the sensors; the drum is read without noise."""
    t, inputs, load = true_signals()
    drum = simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad
    rng = np.random.default_rng(seed)
    read = STEP * np.round((inputs + INPUT_RAD * rng.standard_normal(inputs.shape)) / STEP + rng.random((2, 1)))
    return Run(
        t, read, drum, load + TORQUE_NM * rng.standard_normal(t.size), sensors=Sensors(STEP, 1e-9, None), source="bench"
    )


def still(fitter: Fitter) -> Fit:
    """The declared model without a fit of the offsets."""
    return fitter.fit(offsets=np.zeros(1), iterations=0)


def true_error(run: Run, column: Floats) -> float:
    """How much of ``column``, of length 1, noise puts into the prediction of one run, against its true signals."""
    fitter = planned_fitter(DRIVE, run)
    p, (_, inputs, load) = fitter.runs[0], true_signals()
    apart = inputs - inputs.mean(axis=0)
    true = replace(p, apart_rad=apart[:, p.cut.index], load_Nm=load[p.cut.index])
    known = Fitter(fitter.d, fitter.ratio, [true], DRIVE.as_built).predict([], [], np.zeros(1))
    error = known - fitter.predict([], [], np.zeros(1))
    return float(column @ fitter.centred(error, fitter.train)[fitter.used])


def test_they_spread_and_lie_as_in_runs_that_are_made_again() -> None:
    run = logged(0)
    fitter = planned_fitter(DRIVE, run)
    assert fitter.d is not None
    softer = Fitter(replace(fitter.d, modulus_Pa=1.05 * fitter.d.modulus_Pa), 9.0, fitter.runs)
    change = softer.predict([], [], np.zeros(1)) - fitter.predict([], [], np.zeros(1))
    column = fitter.centred(change, fitter.train)[fitter.used]
    column = column / np.linalg.norm(column)
    foreseen = friction_errors(fitter, still(fitter), signal_noise(run)) @ column
    again = np.array([true_error(logged(seed), column) for seed in range(1, 31)])
    print(f"spread {foreseen.std():.3g} rad foreseen, {again.std():.3g} in 30 runs")
    print(f"mean {foreseen.mean():.3g} rad foreseen, {again.mean():.3g} in 30 runs")
    assert foreseen.std() == pytest.approx(again.std(), rel=0.4)
    assert abs(foreseen.mean() - again.mean()) < 0.75 * again.std()
    assert abs(again.mean()) < 0.5 * again.std(), "noise must not make the drive look too soft or too stiff"
