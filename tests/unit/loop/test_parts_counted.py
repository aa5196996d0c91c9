"""A drive measured with its structure and losses: what the design computes of them is blamed on no cable.

The runs are the rig's, which takes the figures of the parts from the design and does its own mechanics."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.loop.effects.load_sensor import within_prior
from mbcdm_cad.loop.effects.stiffness_error import offer
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.prepare.quiet import told_from_noise
from mbcdm_cad.loop.prepare.setup import Simulator, declared
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.loads import parts_seen
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.schema import CountedParts
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.rig.experiment import Experiment, read_experiment, run_files
from mbcdm_cad.rig.quasistatic import simulate

ROOT = Path(__file__).parents[3]
DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
BOTH = CountedParts()


def plan(effects: list[dict[str, Any]], **changes: Any) -> Experiment:
    """The library's run at four levels of a brake, half as long, with structure and losses."""
    experiment = read_experiment(ROOT / "params" / "experiments" / "null-short-levels.yaml")
    assert isinstance(experiment, Experiment)
    physics = experiment.physics.model_dump() | {"structure": True, "losses": True}
    shorter = {"duration_s": 80.0, "sample_rate_Hz": 50.0, "physics": physics, "effects": effects}
    return Experiment.model_validate(experiment.model_dump() | shorter | changes)


def logged(experiment: Experiment, counted: CountedParts | None) -> Run:
    seen = simulate(DRIVE, experiment)
    s = experiment.sensors
    steps = Sensors(s.input_resolution_rad, s.output_resolution_rad, s.torque_noise_Nm)
    read = seen.measured_input_rad, seen.measured_output_rad, seen.measured_load_Nm
    return Run(seen.time_s, *read, sensors=steps, counted=counted)


def test_give_and_friction_are_those_of_the_encoders_of_the_run() -> None:
    structure, losses = structure_of(layout_of(DRIVE)), layout_of(DRIVE).losses
    assert structure is not None
    drum = parts_seen(DRIVE, BOTH, motor_side=False)
    assert drum.give_rad_Nm == pytest.approx(structure.encoder_urad_Nm * 1e-6)
    payload = CountedParts(output_at="payload")
    assert parts_seen(DRIVE, payload, False).give_rad_Nm == pytest.approx(structure.payload_urad_Nm * 1e-6)
    assert parts_seen(DRIVE, payload, True).give_rad_Nm == pytest.approx(structure.motor_urad_Nm * 1e-6)
    before = parts_seen(DRIVE, BOTH, True).give_sigma_rad_Nm
    assert before > 2.0 * drum.give_sigma_rad_Nm > 0.0, "gearheads are known to a factor of two"
    # What rubs at the drum: all rows without load, but those of inputs, gearheads and motors.
    still = losses.moving(np.array([0.0]), 1).losses
    outside = ("inputs", "input pulleys", "gearheads", "motors")
    at_drum = sum(float(x.torque_Nm[0]) for x in still if not any(word in x.name for word in outside))
    assert drum.friction_Nm == pytest.approx(at_drum, rel=0.02), [(x.name, x.torque_Nm) for x in still]
    nothing = parts_seen(DRIVE, CountedParts(structure=False, losses=False), False)
    assert (nothing.give_rad_Nm, nothing.friction_Nm) == (0.0, 0.0)


def test_the_rig_writes_what_its_run_counts_and_files_of_before_count_nothing(tmp_path: Path) -> None:
    for experiment, counted in ((plan([], duration_s=10.0), BOTH), (plan([], duration_s=10.0, physics={}), None)):
        for name, data in run_files(simulate(DRIVE, experiment), experiment, DRIVE.input_names).items():
            (tmp_path / name).write_bytes(data)
        assert load_file(tmp_path / "null-short-levels.yaml").content.parts == counted


def test_the_declared_prediction_of_a_run_with_parts_is_that_of_the_rig() -> None:
    """Without noise, the residual of the declared model stays small beside what the parts do."""
    sensors = {"input_resolution_rad": 0.0, "output_resolution_rad": 0.0, "torque_noise_Nm": 0.0}
    experiment = plan([], duration_s=40.0, sensors=sensors)
    ratio = float(layout_of(DRIVE).si.total_ratio[0])

    def spread_urad(counted: CountedParts | None) -> float:
        p = prepare(arranged(logged(experiment, counted), DRIVE), ratio)[0]
        left = p.output_rad - Simulator()(declared(layout_of(DRIVE).si, ratio, p))
        return float(np.std(left[p.used])) * 1e6

    counted, rigid = spread_urad(BOTH), spread_urad(None)
    assert rigid > 100.0 and counted < 0.05 * rigid, f"{counted:.2f} urad with the parts, {rigid:.2f} without"


def test_the_structure_may_be_softer_or_stiffer_and_its_sigma_bounds_what_is_no_effect() -> None:
    p = prepare(arranged(logged(plan([], duration_s=40.0), BOTH), DRIVE), 9.0)[0]
    assert p.run.parts is not None
    series = next(e for e in offer(layout_of(DRIVE).si, p) if e.form == "compliance in series")
    assert series.parameters[0].low == -p.run.parts.give_rad_Nm
    assert "less than computed" in series.words_of(np.array([-1e-6])).plain
    give, rubs = within_prior((p,))
    assert give.parameters[0].high == pytest.approx(2.0 * p.run.parts.give_sigma_rad_Nm)
    low, high = rubs.parameters[0].low, rubs.parameters[0].high
    m = p.run.parts.friction_Nm
    assert (m + high) / m == pytest.approx(m / (m + low)), "a factor, either way"
    bare = replace(p, run=replace(p.run, parts=None))
    assert within_prior((bare,)) == []


SOFT = {"effect": "shaft_compliance", "compliance_urad_Nm": 80.0}
WEAK = {"effect": "modulus", "share": -0.12}


def names(found: LoopResult) -> list[list[str]]:
    return [[one.name] for one in found.effects] + [[one.name for one in group] for group in found.one_of]


@pytest.mark.slow
@pytest.mark.parametrize(("effects", "form"), [([], ""), ([SOFT], "compliance in series"), ([WEAK], "modulus")])
def test_what_the_design_computes_is_named_by_nobody(effects: list[dict[str, Any]], form: str) -> None:
    found = close_loop(DRIVE, [logged(plan(effects), BOTH)])
    if not effects:
        assert found.verdict == "none" and names(found) == [], found.sentence
        return
    assert names(found) and all("stiffness_error" in group for group in names(found)), found.sentence
    members = (*found.effects, *(member for group in found.one_of for member in group))
    first = next(one for one in members if one.name == "stiffness_error")
    if not first.form.startswith(form):
        # Within the uncertainty of the structure a soft rope is not told from more give.
        assert any(other.startswith(form) for other in first.equivalent), found.sentence
        return
    value = next(iter(first.parameters.values())).value
    # The structure's compliance, within its uncertainty, takes or gives a part of a soft modulus.
    wanted, rel = (80e-6, 0.1) if form == "compliance in series" else (WEAK["share"], 0.25)
    assert value == pytest.approx(wanted, rel=rel), found.sentence


@pytest.mark.slow
def test_a_structure_softer_within_its_sigma_is_no_effect() -> None:
    found = close_loop(DRIVE, [logged(plan([SOFT | {"compliance_urad_Nm": 12.0}]), BOTH)])
    assert names(found) == [], found.sentence
    assert "figures of the design within their uncertainty: structure compliance" in found.sentence, found.sentence


@pytest.mark.slow
def test_the_same_run_on_rigid_parts_blames_the_drive() -> None:
    found = close_loop(DRIVE, [logged(plan([]), None)])
    assert any("stiffness_error" in group for group in names(found)), found.sentence


# What moves the cables to and fro, or slips on the guide, is not taken for less friction; nor is a load for a name.


def judged(name: str, duration_s: float, seed: int = 77, judge: Drive = DRIVE) -> LoopResult:
    experiment = read_experiment(ROOT / "params" / "experiments" / f"{name}.yaml")
    assert isinstance(experiment, Experiment)
    seen = simulate(DRIVE, experiment.model_copy(update={"seed": seed, "duration_s": duration_s}))
    sensors = experiment.sensors
    steps = Sensors(sensors.input_resolution_rad, sensors.output_resolution_rad, sensors.torque_noise_Nm)
    run = Run(seen.time_s, seen.measured_input_rad, seen.measured_output_rad, seen.measured_load_Nm, sensors=steps)
    return close_loop(judge, [run])


def test_a_fast_motion_of_one_input_is_no_noise() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.01)
    noise = 5e-5
    cogging = 3e-4 * np.sin(2.0 * np.pi * 7.3 * t)
    kept, _ = told_from_noise(cogging + noise * rng.standard_normal(t.size), noise, 0.01)
    assert np.std(kept - cogging) < 0.5 * noise, np.std(kept - cogging)
    faint, _ = told_from_noise(0.05 * cogging + noise * rng.standard_normal(t.size), noise, 0.01)
    assert np.std(faint) < 0.2 * noise, np.std(faint)


def test_a_load_that_was_not_measured_is_no_name() -> None:
    found = judged("null-no-torque", 100.0)
    assert found.verdict == "not_testable" and not found.effects and not found.one_of, found.sentence
    assert "No torque was measured" in found.sentence, found.sentence
    assert any("no torque was measured" in doubt for doubt in found.doubts), found.doubts


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration_s", "named"),
    [("ripple-mesh", 96.0, ["ripple"]), ("out-guide-slip", 80.0, ["passed_slip"]), ("none-cogging", 80.0, [])],
)
def test_what_eases_the_cables_is_not_taken_for_less_friction(name: str, duration_s: float, named: list[str]) -> None:
    found = judged(name, duration_s)
    assert [one.name for one in found.effects] == named and not found.one_of, found.sentence


@pytest.mark.slow
def test_slip_on_the_guide_that_the_design_counts_is_no_effect() -> None:
    """The run of a drive with slip on the guide, judged by a design that declares it."""
    assert isinstance(DRIVE, BevelDrive)
    found = judged("out-guide-slip", 80.0, judge=replace(DRIVE, guide_slips=True))
    assert found.verdict == "none" and not found.effects and not found.one_of, found.sentence
