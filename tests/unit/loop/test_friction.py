"""Forms of friction: benches with a friction law, presliding and noise of their own, and what a run can tell apart."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effects import friction, known_effects
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.result import LoopResult, result_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet_signals import friction_alike
from tests.support.bench_data import friction_run, through_files

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
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
