"""Experiment files of the dynamic rig: they run as written; files that cannot run are refused with a message."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.command import simulate_command
from mbcdm_cad.rig.dynamic.simulate import simulate_dynamic, truth_of
from mbcdm_cad.rig.experiment import DynamicExperiment, RigError, read_experiment

ROOT = Path(__file__).parents[3]
DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
SHORT = """
rig: dynamic
name: short
duration_s: 2.0
motion: {shape: sine, amplitude_mrad: 20.0, frequency_Hz: 0.5}
load: {brake_Nm: 0.5}
"""


def read(text: str, folder: Path) -> DynamicExperiment:
    path = folder / "experiment.yaml"
    path.write_text(text)
    experiment = read_experiment(path)
    assert isinstance(experiment, DynamicExperiment)
    return experiment


def test_files_of_a_run_are_a_measurement_with_its_truth_apart(tmp_path: Path) -> None:
    said = simulate_command(DRIVE, read(SHORT, tmp_path), tmp_path / "out")
    folder = tmp_path / "out" / "short"
    assert sorted(p.name for p in folder.iterdir()) == ["short.csv", "short.png", "short.truth.yaml", "short.yaml"]
    rows = np.genfromtxt(folder / "short.csv", delimiter=",", names=True)
    assert rows.dtype.names == ("t", "q_left", "q_right", "q_out", "tau") and rows.size == 200
    assert np.abs(rows["tau"]).max() == pytest.approx(0.5, abs=0.03)
    measurement = yaml.safe_load((folder / "short.yaml").read_text())
    assert measurement["columns"]["load_torque"] == {"column": "tau", "unit": "N*m"}
    assert [e["name"] for e in yaml.safe_load((folder / "short.truth.yaml").read_text())["effects"]] == [
        "winding_history"
    ]
    assert "200 samples" in said
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    simulate_command(DRIVE, read(SHORT, tmp_path), tmp_path / "out")
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before, "the same file gave other bytes"


@pytest.mark.slow
def test_every_cause_is_in_the_truth_and_changes_the_run(tmp_path: Path) -> None:
    plain, _, _ = simulate_dynamic(DRIVE, read(SHORT, tmp_path))
    changes = {
        "drives: {cogging_share: 0.05}": "ripple",
        "drives: {mesh_error_urad: 100.0}": "ripple",
        "drives: {lash_mrad: 5.0}": "lash",
        "bearings: {drum_Nm: 0.05}": "friction",
        "bearings: {guide_Nm: 0.005}": "friction",
        "sensors: {output_delay_s: 0.01}": "delay",
        "physics: {guide_slip: true}": "passed_slip",
        "effects: [{effect: preload, share: -0.2}]": "preload_error",
        "effects: [{effect: eccentric_pulley, stage: guide, eccentricity_um: 20.0}]": "once_per_rev",
    }
    for line, name in changes.items():
        experiment = read(SHORT + line, tmp_path)
        run, bench, _ = simulate_dynamic(DRIVE, experiment)
        assert name in [entry["name"] for entry in truth_of(experiment, bench)], line
        moved = np.abs(run.measured_drum_rad - plain.measured_drum_rad).max()
        assert moved > 2e-6, f"{line}: the output moved by {moved:.2e} rad"


def test_brake_that_sticks_is_told(tmp_path: Path) -> None:
    experiment = read(SHORT.replace("brake_Nm: 0.5", "brake_Nm: 0.5, static_ratio: 1.3"), tmp_path)
    assert experiment.load.static_ratio == 1.3
    _, bench, _ = simulate_dynamic(DRIVE, experiment)
    assert "brake_stick_slip" in [entry["name"] for entry in truth_of(experiment, bench)]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (SHORT + "drives: {lash: 3}\n", "lash"),
        (SHORT.replace("duration_s: 2.0", "duration_s: -1"), "duration_s"),
        (SHORT.replace("dynamic", "static"), "rig"),
        (SHORT + "effects: [{effect: nothing}]\n", "unknown effect"),
    ],
)
def test_bad_files_are_refused_with_their_line(text: str, word: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=word) as caught:
        read(text, tmp_path)
    assert all(problem.line > 0 for problem in caught.value.problems)


def test_what_the_rig_cannot_do_is_said(tmp_path: Path) -> None:
    for effect in ("temperature, rise_K: 5.0", "motor_cogging, stage: input_left, torque_mNm: 0.1"):
        with pytest.raises(RigError, match="not on the dynamic rig"):
            simulate_dynamic(DRIVE, read(SHORT + f"effects: [{{effect: {effect}}}]\n", tmp_path))
    with pytest.raises(RigError, match="cable_9"):
        simulate_dynamic(DRIVE, read(SHORT + "effects: [{effect: preload, share: 0.1, cables: [cable_9]}]\n", tmp_path))
