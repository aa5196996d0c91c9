"""The engine end to end on small runs: what is there is named, what is not is not, and a second run finds nothing left.

The runs are made with the package's own model, so they show that the engine works, not that it is right: that is for
the judge of runs made by other means (benchmarks/judge.py).
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.loop import effects
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
LOADED = load_design(REFERENCE)
STEP = 1.9175e-4
Added = Callable[[Floats, Floats], Floats]


def measured(stiffer: float = 0.0, added: Added | None = None, torque: bool = True, seed: int = 4) -> Run:
    """Two minutes of sines under a load of its own rhythm, quantised as the bench's sensors are.

    ``stiffer``: share by which the rope's modulus is higher; ``added``: of angle (rad) and load (N m), to the reading.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 120.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 11.0)
    load = 0.9 * np.sign(np.sin(2.0 * np.pi * t / 17.3 + 0.4)) + 0.3 * np.sin(2.0 * np.pi * t / 5.1)
    load = np.convolve(load, np.hanning(25) / np.hanning(25).sum(), "same") if torque else 0.0 * t
    d = layout_of(LOADED.drive).si
    d = d.with_(modulus_Pa=d.modulus_Pa * (1.0 + stiffer))
    inputs = np.stack([9.0 * angle, 9.0 * angle])
    drum = simulate(d, inputs, load).drum_angle_rad + (added(angle, load) if added else 0.0)
    read = STEP * np.floor(inputs / STEP + rng.random((2, 1)))
    output = 1.3635e-6 * np.round(drum / 1.3635e-6)
    sensed = load + 0.005 * rng.standard_normal(t.size) if torque else None
    return Run(t, read, output, sensed, sensors=Sensors(STEP, 1.3635e-6, 0.005))


def scale(angle: Floats, _: Floats) -> Floats:
    return 4e-4 * angle


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_nothing_is_named_where_nothing_is(seed: int) -> None:
    result = close_loop(LOADED.drive, [measured(seed=seed)])
    assert result.verdict == "none", result.sentence
    assert result.errors.before.value == result.errors.after.value


@pytest.mark.parametrize(
    ("run", "names"),
    [(measured(stiffer=0.3), {"stiffness_error"}), (measured(added=scale), {"ratio_error"})],
    ids=["stiffer", "scale"],
)
@pytest.mark.slow
def test_nothing_is_left_of_what_was_named(run: Run, names: set[str]) -> None:
    first = close_loop(LOADED.drive, [run])
    assert {named.name for named in first.effects} == names, first.sentence
    assert not first.one_of, first.sentence
    assert first.errors.after.value < 0.2 * first.errors.before.value, first.sentence
    as_built = load_text(as_built_text(LOADED, first, "run.csv"), REFERENCE)
    second = close_loop(as_built.drive, [run])
    assert second.verdict == "none", second.sentence
    assert second.errors.before.value == pytest.approx(first.errors.after.value, rel=0.05)


@pytest.mark.slow
def test_a_candidate_that_cannot_be_simulated_drops_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def slack(setup: Setup, values: Floats, _: Simulator) -> Setup:
        if abs(values[0]) > 1e-9:
            raise ModelError("all cables slack")
        return setup.with_added(values[0] * setup.load)

    dead = Effect("dead", "slack", "", "", "", (Parameter("share", 1e-6),), slack)
    far = replace(dead, form="slack from the start", starts=lambda setup, residual: [[1.0]])
    offers = (*effects.offers(), lambda d, p: [dead, far])
    monkeypatch.setattr(effects, "offers", lambda: offers)
    result = close_loop(LOADED.drive, [measured(stiffer=0.3)])
    assert [named.name for named in result.effects] == ["stiffness_error"], result.sentence


@pytest.mark.slow
def test_nothing_impossible_is_named() -> None:
    stiff = close_loop(LOADED.drive, [measured(added=lambda angle, load: 6e-5 * load)])
    figures = [figure for named in stiff.effects for figure in named.parameters.items()]
    assert all(value.value > 0.0 for name, value in figures if name == "compliance_rad_Nm"), stiff.sentence
    soft = close_loop(LOADED.drive, [measured(stiffer=-0.65)])
    assert "modulus of the rope" not in [named.form for named in soft.effects], soft.sentence
    assert any("look for play" in words for words in soft.doubts), (soft.doubts, soft.sentence)


def test_noise_beyond_the_data_sheet_is_told_and_not_explained() -> None:
    run = measured(seed=3)
    rng = np.random.default_rng(8)
    loud = replace(run, output_rad=run.output_rad + 12e-6 * rng.standard_normal(run.time_s.size))
    result = close_loop(LOADED.drive, [loud])
    assert result.verdict == "none" and result.noise is not None, result.sentence
    assert result.noise.total_rad == pytest.approx(12.8e-6, rel=0.1), result.noise
    assert "noisier than declared" in result.doubts[0], result.doubts
    assert result.to_json()["noise"]["declared_rad"] < 5e-6, result.to_json()["noise"]


@pytest.mark.slow
def test_a_bump_in_one_place_is_unknown_and_described() -> None:
    def bump(angle: Floats, _: Floats) -> Floats:
        return np.asarray(6e-5 * np.exp(-0.5 * ((angle - 0.1) / 0.03) ** 2))

    result = close_loop(LOADED.drive, [measured(added=bump)])
    assert result.verdict == "unknown", result.sentence
    assert not result.effects and not result.one_of
    assert result.unknown is not None
    assert result.unknown.patterns[0].variable == "angle", result.sentence
    assert "a bump of" in result.sentence, result.sentence


def test_two_ripples_are_two() -> None:
    def ripples(angle: Floats, _: Floats) -> Floats:
        return np.asarray(3e-5 * np.cos(40.0 * angle + 1.0) + 2e-5 * np.cos(71.0 * angle))

    result = close_loop(LOADED.drive, [measured(added=ripples)])
    assert [named.name for named in result.effects] == ["ripple", "ripple"], result.sentence
    found = sorted(
        (n.parameters["cycles_per_output_rev"].value, n.parameters["amplitude_rad"].value) for n in result.effects
    )
    np.testing.assert_allclose(found, [(40.0, 3e-5), (71.0, 2e-5)], rtol=0.03)


def test_without_torque_only_the_motion_is_judged() -> None:
    result = close_loop(LOADED.drive, [measured(added=scale, torque=False)])
    assert [named.name for named in result.effects] == ["ratio_error"], result.sentence
    assert result.effects[0].parameters["share"].value == pytest.approx(4e-4, rel=0.03)
    assert any("torque" in words for words in result.not_testable), result.not_testable


@pytest.mark.slow
def test_runs_share_what_they_have_in_common() -> None:
    result = close_loop(LOADED.drive, [measured(stiffer=0.3, seed=seed) for seed in (1, 2)])
    assert [named.name for named in result.effects] == ["stiffness_error"], result.sentence
    share = result.effects[0].parameters["share"]
    assert share.value == pytest.approx(0.3, rel=0.03)
    assert len(result.traces) == 2
