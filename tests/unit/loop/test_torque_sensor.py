"""The torque sensor: within its class it is no effect of the drive, beyond it is told from it; frictions."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.loop.effects import friction, known_effects
from mbcdm_cad.loop.effects.load_sensor import _sides
from mbcdm_cad.loop.page import finding
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.result import LoopResult, result_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors, TorqueClass
from mbcdm_cad.measurement.vet_signals import friction_alike
from tests.support.bench_data import friction_run, through_files
from tests.support.bench_effects import Effect
from tests.support.bench_layouts import made
from tests.support.bench_score import outcome_of, values_of
from tests.support.bench_torque import TorqueSensor, torque_bench
from tests.support.reference import DRIVE


def said(result: LoopResult) -> list[str]:
    return [one.name for one in result.effects] + [one.name for group in result.one_of for one in group]


@pytest.mark.parametrize(
    ("sensor", "load"),
    [
        (TorqueSensor(gain=0.007), "steps"),
        pytest.param(TorqueSensor(gain=0.006, zero_Nm=-0.005, lag_s=0.005), "bias", marks=pytest.mark.slow),
        pytest.param(TorqueSensor(lag_s=0.008), "steps", marks=pytest.mark.slow),
    ],
)
def test_within_its_class_the_sensor_is_no_effect_of_the_drive(sensor: TorqueSensor, load: str) -> None:
    result = close_loop(DRIVE, [torque_bench(DRIVE, sensor, load=load)])
    assert not said(result) and result.verdict == "none", result.sentence
    assert "torque sensor within its class (0.01 of gain and range" in result.sentence, result.sentence
    assert "Nothing is missing of the drive" in finding(result), finding(result)
    if sensor.gain:
        (found,) = (float(x) for x in re.findall(r"gain share ([-\d.]+) %", result.sentence))
        assert found == pytest.approx(-100.0 * sensor.gain, abs=0.25), result.sentence


@pytest.mark.slow
def test_a_stiffness_beyond_the_class_is_named_beside_a_wrong_gain() -> None:
    soft = Effect("stiffness_error", "modulus", {"share": -0.08})
    result = close_loop(DRIVE, [torque_bench(DRIVE, TorqueSensor(gain=0.004), (soft,))])
    assert said(result) == ["stiffness_error"], result.sentence
    assert result.effects[0].parameters["share"].value == pytest.approx(-0.08, abs=0.012), result.sentence


@pytest.mark.slow
def test_a_stated_class_of_a_better_sensor_leaves_the_effect_to_the_drive() -> None:
    run = torque_bench(DRIVE, TorqueSensor(gain=0.007))
    fine = Sensors(
        run.sensors.input_resolution_rad,
        run.sensors.output_resolution_rad,
        run.sensors.torque_noise_Nm,
        run.sensors.input_noise_rad,
        run.sensors.output_noise_rad,
        TorqueClass(0.0005, 1e-4, True),
    )
    result = close_loop(DRIVE, [Run(run.time_s, run.input_rad, run.output_rad, run.load_Nm, sensors=fine)])
    assert "stiffness_error" in said(result), result.sentence


def gearbox(zero_Nm: float, sign: float, play: float, compliance: float) -> Run:
    """A drive of which the ratio is known, under a load of its own frequency."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 100.0, 0.04)
    angle, load = 0.5 * np.sin(2.0 * np.pi * t / 17.0), 0.25 * np.sin(2.0 * np.pi * t / 5.3)
    out = angle - 0.5 * play * np.sign(load) - compliance * load + 1e-4 * rng.standard_normal(t.size)
    shown = sign * load + zero_Nm + 5e-4 * rng.standard_normal(t.size)
    return Run(t, (5.0 * angle)[None], out, shown, input_names=("input",), ratio=5.0)


def test_play_whose_sides_change_off_zero_is_play_and_tells_the_sensors_zero() -> None:
    result = close_loop(None, [gearbox(0.03, 1.0, 0.02, 0.0)])
    assert said(result) == ["lash"], result.sentence
    figures = result.effects[0].parameters
    assert figures["play_rad"].value == pytest.approx(0.02, rel=0.03), result.sentence
    assert figures["zero_Nm"].value == pytest.approx(0.03, abs=0.004), result.sentence


def test_a_reversed_load_is_told_where_only_the_ratio_is_known() -> None:
    result = close_loop(None, [gearbox(0.0, -1.0, 0.0, 0.01)])
    assert said(result) == ["load_sign"], result.sentence
    assert "scale: -1" in result.effects[0].where_to_look
    right = close_loop(None, [gearbox(0.0, 1.0, 0.0, 0.01)])
    assert said(right) == ["stiffness_error"], right.sentence


def test_a_late_load_is_named_where_its_flanks_show_it() -> None:
    """A load in steps behind a soft shaft, read 80 ms late."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 100.0, 0.02)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 17.0)

    def load(at: np.ndarray) -> np.ndarray:
        return np.asarray(0.3 * np.sin(2.0 * np.pi * at / 1.7) + 0.2 * np.sin(2.0 * np.pi * at / 0.9))

    out = angle - 0.01 * load(t) + 3e-5 * rng.standard_normal(t.size)
    run = Run(t, (5.0 * angle)[None], out, load(t - 0.08), input_names=("input",), ratio=5.0)
    result = close_loop(None, [run])
    assert sorted(said(result)) == ["load_lag", "stiffness_error"], result.sentence
    (late,) = (one for one in result.effects if one.name == "load_lag")
    assert late.parameters["lag_s"].value == pytest.approx(0.08, rel=0.1), result.sentence


@pytest.mark.slow
def test_a_torque_from_the_motors_current_contains_its_friction() -> None:
    """The current shows the load and the friction before the drum, which follows the sense of motion."""
    run = torque_bench(DRIVE, TorqueSensor())
    assert run.load_Nm is not None
    speed = np.gradient(run.input_rad.mean(axis=0), run.time_s)
    shown = run.load_Nm + 0.05 * np.tanh(speed / (0.01 * speed.std()))
    result = close_loop(DRIVE, [Run(run.time_s, run.input_rad, run.output_rad, shown, sensors=run.sensors)])
    (found,) = result.effects
    assert (found.name, found.form) == ("friction", "friction in the measured torque"), result.sentence
    assert found.parameters["torque_Nm"].value == pytest.approx(0.05, rel=0.1), result.sentence


def within(load_Nm: np.ndarray, half_Nm: float) -> np.ndarray:
    """What a sensor shows that follows a load within so much to either side."""
    out, now = np.empty_like(load_Nm), 0.0
    for k, one in enumerate(load_Nm):
        now = min(max(now, one - half_Nm), one + half_Nm)
        out[k] = now
    return out


@pytest.mark.parametrize("wave", ["sine", "steps"])
def test_the_load_behind_a_hysteresis_comes_back_from_its_reading(wave: str) -> None:
    t = np.arange(0.0, 40.0, 0.01)
    load = 1.5 * np.sin(2.0 * np.pi * t / 9.0)
    load = load if wave == "sine" else np.interp(np.round(t / 5.0), range(9), [0, 1, -1, 0.4, 1.2, -1.3, 0, 1, 0])
    shown = within(load, 0.1)
    late = t > 10.0
    back = shown + 0.1 * _sides(shown, t, 0.1, 0.01)
    assert np.sqrt(np.mean((back - load)[late] ** 2)) < 0.1 * np.sqrt(np.mean((shown - load)[late] ** 2))


def test_a_hysteresis_is_named_beside_what_is_soft() -> None:
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 100.0, 0.02)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 17.0)
    load = 0.3 * np.sin(2.0 * np.pi * t / 5.3) + 0.2 * np.sin(2.0 * np.pi * t / 2.9)
    out = angle - 0.01 * load + 3e-5 * rng.standard_normal(t.size)
    shown = within(load, 0.025) + 5e-4 * rng.standard_normal(t.size)
    result = close_loop(None, [Run(t, (5.0 * angle)[None], out, shown, input_names=("input",), ratio=5.0)])
    assert sorted(said(result)) == ["load_hysteresis", "stiffness_error"], result.sentence
    (found,) = (one for one in result.effects if one.name == "load_hysteresis")
    assert found.parameters["half_width_Nm"].value == pytest.approx(0.025, rel=0.1), result.sentence


@pytest.mark.slow
def test_cross_talk_is_no_runout_of_the_drive() -> None:
    """A run of the rig, which had a set of stiffness, friction and preload."""
    drive, run, truth = made("outside", "torque crosstalk", 200402)
    result = close_loop(drive, [run]).to_json()
    assert outcome_of(result, truth) == "exact", result["sentence"]
    values = values_of(result, truth)
    true = {what: at for what, at, *_ in values}
    shown = {what: value for what, _, value, *_ in values}
    assert len(shown) == 2 and shown == pytest.approx(true, rel=0.15), values


T = np.arange(0.0, 40.0, 0.05)


def prepared(wave: str = "sine") -> Prepared:
    phase = 2.0 * np.pi * T / 8.0
    angle = 0.45 * (np.sin(phase) if wave == "sine" else 2.0 / np.pi * np.arcsin(np.sin(phase)))
    return prepare(Run(T, np.stack([9.0 * angle, 9.0 * angle]), angle, 0.5 * np.cos(T)), 9.0)[1]


FORMS = {form.form: form for form in friction.friction(friction.BEYOND, (friction.CONSTANT,), prepared()).richer()}  # type: ignore[misc]


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(sorted(FORMS)), st.lists(st.floats(0.0, 1.0), min_size=8, max_size=8))
def test_every_form_takes_energy_and_is_the_same_both_ways(name: str, sizes: list[float]) -> None:
    terms = next(t for t in friction.all_terms(friction.BEYOND, True) if friction.form_name(friction.BEYOND, t) == name)
    rng = np.random.default_rng(1)
    speed, load = rng.normal(0.0, 0.1, 50), rng.normal(0.0, 1.0, 50)
    sense, weights = np.tanh(speed / 1e-4), np.array(sizes[: len(terms)])
    terms = friction.sizes_of(terms)
    weights = weights[: len(terms)]
    torque = weights @ friction.bases(terms, sense, speed, load, 0.05)
    back = weights @ friction.bases(terms, -sense, -speed, -load, 0.05)
    assert np.all(torque * speed >= 0.0) and np.allclose(back, -torque), name


def test_terms_are_those_of_bam() -> None:
    """M2 and M5 at rest-free points, by hand."""
    at = np.array([0.2]), np.array([0.2]), np.array([3.0])
    stribeck = np.array([0.1, 0.5, 0.3]) @ friction.bases((0, 1, 2), np.ones(1), at[0], at[2], 0.1)
    assert stribeck[0] == pytest.approx(0.1 + 0.5 * 0.2 + 0.3 * np.exp(-4.0))
    assert friction.bases((2,), np.ones(1), at[0], at[2], 0.1, 1.0) == pytest.approx(np.exp(-np.abs(at[0]) / 0.1)[None])
    driving, driven = friction.bases((4, 5), np.ones(1), at[0], at[2], 1.0)
    assert driving[0] == pytest.approx(3.0, rel=1e-3) and abs(driven[0]) < 3e-3
    named = {name[-3:-1] for name in FORMS if "BAM" in name}
    assert named == {"M1", "M2", "M3", "M4", "M5", "M6"}, named


def test_a_form_with_terms_is_read_back_from_a_design_file() -> None:
    p, form = prepared(), "bearing torque: constant, viscous, Stribeck (BAM M2)"
    figures = {"torque_Nm": 0.1, "drag_Nm_s": 0.5, "stribeck_Nm": 0.2, "fades_rad_s": 0.03}
    entry = AsBuilt(name="friction", form=form, values=tuple(AsBuiltValue(name=n, value=v) for n, v in figures.items()))
    ((effect, values),) = known_effects(layout_of(DRIVE).si, p, [entry])
    assert effect.form == form and values.tolist() == list(figures.values())


def test_what_a_run_does_not_tell_is_said() -> None:
    p = prepared()
    load = np.where((T // 8.0) % 2 == 0, 1.0, 0.3) * 0.7
    assert friction_alike(p.speed_rad_s, load * np.sign(np.sin(T))) == []
    brake = friction_alike(prepared("triangle").speed_rad_s, 0.7 * np.sign(p.speed_rad_s))
    assert [words.split(":")[0] for words in brake] == [
        "a viscous or Stribeck part",
        "a part in proportion to the load",
        "a part by the sense of power",
    ]
    assert friction_alike(p.speed_rad_s, None) == ["a part in proportion to the load: there is no load"]


def judged(law: dict[str, float], seed: int, noise_rad: float = 0.0) -> LoopResult:
    """A bench of chains of rope pieces, with a friction that builds up over a Dahl-like presliding."""
    return close_loop(DRIVE, [through_files(friction_run(DRIVE, law, seed, noise_rad), DRIVE.input_names)])


@pytest.mark.slow
def test_stribeck_friction_with_another_exponent_and_presliding() -> None:
    law = {"torque_Nm": 0.08, "stribeck_Nm": 0.12, "fades_rad_s": 0.03, "exponent": 1.4, "presliding_rad": 3e-4}
    result = judged(law, 1, noise_rad=5e-6)
    (found,) = result.effects
    assert found.form == "bearing torque: constant, Stribeck, built up over a path", result.sentence
    assert found.parameters["torque_Nm"].value == pytest.approx(0.08, rel=0.1), result.sentence
    assert found.physical["design_torque_Nm"] == pytest.approx(0.1776, rel=1e-3)
    assert "the design's losses are 177.6 mN m there" in result_text(result)


@pytest.mark.slow
def test_friction_by_the_sense_of_power_is_no_preload() -> None:
    """A linear estimate takes it for a slack cable 3, and for a soft rope beside a friction of the load."""
    result = judged({"torque_Nm": 0.05, "driving_share": 0.15, "driven_share": 0.03}, 1)
    (found,) = result.effects
    assert found.form == "bearing torque: constant, by the sense of power, built up over a path", result.sentence
    figures = {name: value.value for name, value in found.parameters.items() if name != "built_up_rad"}
    assert figures == pytest.approx({"torque_Nm": 0.05, "driving_share": 0.15, "driven_share": 0.03}, rel=0.15)
