"""What moves the cables to and fro, or slips on the guide, is not taken for less friction; nor is a load for a name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.loop.prepare.quiet import told_from_noise
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.quasistatic.simulate import simulate
from mbcdm_cad.rig.reading import read_experiment

ROOT = Path(__file__).parents[3]
DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive


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
