"""A plan's promises: what it says will be named is named, what it says is too small is not, rivals are rivals."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.loop.result import Noise
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.loop.search.evidence import LOG_ODDS
from mbcdm_cad.measurement.run import Run, Sensors, TorqueClass
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.plan import Foresight, PlannedMotion, RunPlan, noise_from, plan_of
from mbcdm_cad.routes import Floats
from tests.support.reference import DRIVE

STEP, FINE = 1.9175e-4, 1.3635e-6


def bench(share: float = 0.0, seed: int = 1, noise_rad: float = 0.0, amplitude_rad: float = 0.45) -> Run:
    """A minute and a half under a load of its own rhythm; ``share`` is a ratio error."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 90.0, 0.04)
    angle = amplitude_rad * np.sin(2.0 * np.pi * t / 11.0)
    load = 0.6 * np.sin(2.0 * np.pi * t / 5.1) + 0.4 * np.sin(2.0 * np.pi * t / 17.3)
    inputs = np.stack([9.0 * angle, 9.0 * angle])
    drum: Floats = simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad + share * angle
    read = STEP * np.floor(inputs / STEP + rng.random((2, 1)))
    output = FINE * np.round((drum + noise_rad * rng.standard_normal(t.size)) / FINE)
    return Run(t, read, output, load + 0.005 * rng.standard_normal(t.size), sensors=Sensors(STEP, FINE, 0.005))


@cache
def usual() -> RunPlan:
    """The plan of the bench as declared."""
    return plan_of(DRIVE, bench())


def smallest(plan: RunPlan, label: str) -> float:
    found = next(one for one in plan.effects if one.label.startswith(label))
    assert found.smallest is not None, found
    return found.smallest


@pytest.mark.slow
def test_promises_hold_on_a_louder_bench_than_declared() -> None:
    pilot = noise_from(DRIVE, bench(noise_rad=9e-6, seed=7))
    plan = plan_of(DRIVE, bench(), pilot)
    least = smallest(plan, "ratio_error")
    assert least > 1.3 * smallest(usual(), "ratio_error"), "more noise, less to be seen"
    seen = close_loop(DRIVE, [bench(share=1.4 * least, noise_rad=9e-6)])
    names = {named.name for named in (*seen.effects, *(one for group in seen.one_of for one in group))}
    assert "ratio_error" in names, (least, seen.sentence)
    small = close_loop(DRIVE, [bench(share=0.5 * least, noise_rad=9e-6)])
    assert small.verdict == "none", (least, small.sentence)


def test_short_travel_confuses_ratio_and_drum() -> None:
    """A wave of the drum that is a straight line over the travel is taken for a ratio until its curve shows."""
    wide, short = usual(), plan_of(DRIVE, bench(amplitude_rad=0.05))
    assert smallest(short, "once_per_rev drum") > 50.0 * smallest(wide, "once_per_rev drum")
    assert smallest(short, "ratio_error") == pytest.approx(9.0 * smallest(wide, "ratio_error"), rel=0.2)


def test_without_torque_what_hangs_on_load_is_not_offered() -> None:
    plan = plan_of(DRIVE, replace(bench(), load_Nm=None))
    assert not [one.label for one in plan.effects if one.label.startswith(("stiffness", "preload", "winding"))]
    assert "named from (power 0.9)" in plan.text() and plan.to_json()["power"] == 0.9


def test_a_size_that_no_part_can_have_is_not_promised() -> None:
    run = replace(bench(), load_Nm=None)
    loud = replace(plan_of(DRIVE, run).noise, total_rad=1e5, white_rad=1e5)
    plan = plan_of(DRIVE, run, loud)
    assert {one.smallest for one in plan.effects} == {None}, plan.text()
    assert "this run cannot show it" in plan.text()


def test_each_sign_of_a_preload_has_a_size_of_its_own() -> None:
    """Louder noise asks for changes of the preload so large that the signs show unlike: a low preload shows more."""
    noise = Noise(1.5e-5, 1.5e-5, 0.0, 0.0, 4.4e-6, "as the test has it")
    found = next(one for one in plan_of(DRIVE, bench(), noise).effects if one.label == "preload_error (all cables)")
    assert found.if_positive is not None and found.if_negative is not None
    assert found.smallest == max(found.if_positive, found.if_negative)
    assert found.if_positive > 1.2 * found.if_negative, found


@pytest.mark.parametrize("power", [0.5, 0.9])
def test_the_evidence_of_drawn_noise_gives_the_promised_power(power: float) -> None:
    """White and slow noise on the promised size: the odds that the loop's evidence gives, on many draws."""
    noise = Noise(1.2e-5, 1.06e-5, 5.6e-6, 0.3, 4.4e-6, "as the test has it")
    planned = PlannedMotion(DRIVE, bench(), noise)
    i = next(k for k, one in enumerate(planned.shown) if one[0].name == "ratio_error")
    column = planned.shown[i][3].columns
    size = Foresight(planned.white, [planned.shown[i][3]], planned.names).likely(0, power)
    rng, seen, n = np.random.default_rng(2), [], column.shape[0]
    keep = np.exp(-planned.fitter.runs[0].step_s / noise.memory_s)
    for _ in range(200):
        kicks = np.sqrt(1.0 - keep**2) * rng.normal(size=n)
        slow = noise.coloured_rad * lfilter([1.0], [1.0, -keep], kicks)
        y = size * column[:, 0] + slow + noise.white_rad * rng.normal(size=n)
        sd = np.array([float(np.std(y)) / float(np.std(column))])
        free = np.array([[-np.inf], [np.inf]])
        named = planned.white.evidence_of(np.column_stack([column, y]), sd, free).log
        without = planned.white.evidence_of(y[:, None], np.zeros(0), np.zeros((2, 0))).log
        seen.append(named - without > LOG_ODDS + np.log(planned.names))
    print(f"promised {power}, found {np.mean(seen):.3f}")
    assert abs(float(np.mean(seen)) - power) < 0.1


def test_a_load_from_currents_hides_a_modulus_within_the_spread_of_the_torque_constant() -> None:
    """A rope that is softer by what the torque constant may be wrong by is not promised; runout does not care."""

    def told(sigma: float) -> tuple[float, float]:
        sensors = Sensors(STEP, FINE, 0.005, torque_class=TorqueClass.of_motors(sigma))
        plan = plan_of(DRIVE, replace(bench(), sensors=sensors))
        return smallest(plan, "stiffness_error (modulus"), smallest(plan, "once_per_rev drum")

    few, many = told(0.004), told(0.02)
    assert many[0] > 1.2 * few[0] and many[1] == pytest.approx(few[1], rel=0.1), (few, many)
