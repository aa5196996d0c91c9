"""The joint fit: what is simulated and what is not, and that a short cut ends where the long way does."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare import setup
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.search.fit import Fitter, _bounded_step
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.routes import Floats

D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si
RATIO = float(np.mean(D.total_ratio))
STEP = 1.9175e-4


def fitter() -> Fitter:
    """A minute of sines with a rope 10 % stiffer and a ratio 2e-4 off."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 7.0)
    load = 0.9 * np.sin(2.0 * np.pi * t / 11.0) + 0.3 * np.sin(2.0 * np.pi * t / 5.1)
    inputs = np.stack([RATIO * angle, RATIO * angle])
    drum = simulate(D.with_(modulus_Pa=1.1 * D.modulus_Pa), inputs, load).drum_angle_rad + 2e-4 * angle
    read = STEP * np.floor(inputs / STEP + rng.random((2, 1)))
    run = Run(t, read, 1.3635e-6 * np.round(drum / 1.3635e-6), load, sensors=Sensors(STEP, 1.3635e-6, 0.005))
    return Fitter(D, RATIO, [prepare(run, RATIO)[1]])


def effect(f: Fitter, label: str) -> Effect:
    return next(e for e in library(D, f.runs[0]) if e.label == label)


MODULUS = "stiffness_error (modulus of the rope)"
SCALE = "ratio_error (pitch radius or encoder scale)"
LATE = "delay (late sensor)"


def test_kinds() -> None:
    f = fitter()
    kinds = {e.label: f.kind(e) for e in library(D, f.runs[0])}
    assert [kinds[e] for e in (MODULUS, "friction (bearing torque)", "once_per_rev guide (eccentric pulley)")] == [
        0
    ] * 3
    assert kinds["winding_history (profiles move with the pulleys)"] == 1, kinds
    assert [kinds[e] for e in (SCALE, LATE, "lash (play at the output)")] == [2] * 3


def test_friction_at_the_drum_loads_the_cables_and_not_the_shaft() -> None:
    f = fitter()
    friction, drag, shaft = (
        effect(f, label)
        for label in ("friction (bearing torque)", "delay (viscous drag)", "stiffness_error (compliance in series)")
    )
    rubs = [np.array([0.2]), np.array([0.3])]
    without = f.predict((friction, drag), rubs, np.zeros(f.free.size))
    with_it = f.predict((friction, drag, shaft), [*rubs, np.array([1e-4])], np.zeros(f.free.size))
    assert with_it - without == pytest.approx(-1e-4 * f.runs[0].load_Nm, abs=1e-12)


def test_what_only_adds_costs_no_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0
    real = setup.respond

    def counted(*arguments: Any) -> Floats:
        nonlocal calls
        calls += 1
        return real(*arguments)

    monkeypatch.setattr(setup, "respond", counted)
    f = fitter()
    effects = [effect(f, SCALE), effect(f, MODULUS), effect(f, LATE)]
    f.predict(effects, [np.zeros(1)] * 3, np.zeros(1))
    first = calls
    for share in (1e-4, 2e-4, 3e-4):
        f.predict(effects, [np.array([share]), np.zeros(1), np.array([share])], np.zeros(1))
    assert calls == first, f"{calls - first} simulations for what only adds to the reading"
    f.predict(effects, [np.zeros(1), np.array([0.1]), np.zeros(1)], np.zeros(1))
    assert calls == first + 1


def test_order_of_effects_does_not_matter() -> None:
    f = fitter()
    one, two = effect(f, SCALE), effect(f, MODULUS)
    there = f.predict([one, two], [np.array([2e-4]), np.array([0.1])], np.zeros(1))
    back = f.predict([two, one], [np.array([0.1]), np.array([2e-4])], np.zeros(1))
    assert np.array_equal(there, back)


def test_slopes_from_elsewhere_end_at_the_same_values() -> None:
    f = fitter()
    effects = [effect(f, MODULUS), effect(f, SCALE)]
    exact = f.fit(effects, [[0.0], [0.0]])
    far = f.fit(effects, [[0.4], [1e-3]], iterations=0)
    quick = f.fit(effects, [[0.4], [1e-3]], slopes=far.jacobian, fresh=False, iterations=12)
    apart = [abs(float(q[0] / e[0]) - 1.0) for q, e in zip(quick.values, exact.values, strict=True)]
    assert exact.values[0][0] == pytest.approx(0.1, rel=0.03)
    assert exact.values[1][0] == pytest.approx(2e-4, rel=0.03)
    assert max(apart) < 2e-2, apart


def test_a_step_that_meets_a_bound_is_the_best_within_it() -> None:
    rng = np.random.default_rng(5)
    stopped = 0
    for _ in range(200):
        columns, aim = rng.normal(size=(30, 4)), rng.normal(size=30)
        columns[:, 1] = columns[:, 0] + 0.05 * columns[:, 1]  # as an offset of two encoders resembles an effect
        bounds = np.full((2, 4), np.inf) * [[-1.0], [1.0]]
        bounds[:, 0] = -rng.random(), rng.random()
        step = _bounded_step(columns.T @ columns, columns.T @ aim, 0.0, bounds)
        best = lsq_linear(columns, aim, bounds, tol=1e-12)
        assert step == pytest.approx(best.x, abs=1e-5), (step, best.x)
        stopped += bool(best.active_mask[0])
    assert stopped > 20, f"only {stopped} steps met the bound"
