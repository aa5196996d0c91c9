"""The paper's experiments on the rig: their figures, the paper's figures, and complete files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.studies.paper_experiments import (
    EXPERIMENTS,
    Compared,
    PaperResult,
    angle_spectrum,
    first_saturated_Nm,
    given_way_Nm,
    highest_peak,
    reversal_swings_rad,
)
from benchmarks.studies.paper_plots import result_files, result_json, result_text
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic.run import DynamicRun

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def figures(result: PaperResult) -> dict[str, float]:
    return {f"{c.quantity}, {c.unit}": c.rig for c in result.compared}


def checked_files(result: PaperResult) -> None:
    files = result_files(result, DRIVE)
    assert sorted(files) == [f"{result.name}.png", f"{result.name}.result.json", f"{result.name}.txt"]
    assert files[f"{result.name}.png"].startswith(b"\x89PNG") and len(files[f"{result.name}.png"]) > 20_000
    assert len(json.loads(files[f"{result.name}.result.json"])["compared"]) == len(result.compared)
    assert files == result_files(result, DRIVE), "the same result gave other bytes"


@pytest.mark.slow
def test_backlash_is_the_paper_s_within_what_carried_rope_explains() -> None:
    result = EXPERIMENTS["backlash"](DRIVE, 0)
    (swing,) = figures(result).values()
    assert 0.33 < swing < 0.33 * 1.12, f"{swing:.4f} mrad; the paper 0.33"
    checked_files(result)


@pytest.mark.slow
def test_positioning_error_and_the_motor_s_line() -> None:
    result = EXPERIMENTS["positioning"](DRIVE, 0)
    found = figures(result)
    assert found["largest tracking error, mrad"] == pytest.approx(0.3, rel=0.1)
    # The motor turns 76 x 9 times for one turn of the drum.
    assert found["highest peak, where, cycle/turn"] == pytest.approx(76 * 9, rel=0.002)
    assert found["ripple that would give the paper's peak, mN m"] < 0.1 * DRIVE.motor.rated_torque_mNm
    checked_files(result)


@pytest.mark.slow
def test_driving_capability_both_ways_and_with_a_lossy_gearhead() -> None:
    result = EXPERIMENTS["driving-capability"](DRIVE, 0)
    found = figures(result)
    assert found["first input at its limit: lossless, +, N m"] == pytest.approx(3.747, rel=0.01)
    assert found["first input at its limit: lossless, -, N m"] == pytest.approx(3.194, rel=0.01)
    for way in "+-":
        lossless = found[f"drum is off by 20 mrad: lossless, {way}, N m"]
        lossy = found[f"drum is off by 20 mrad: efficiency 0.68, {way}, N m"]
        # Driven backward the motor holds only 2 - 1/efficiency of the load, and its brushes and lag add some percent.
        assert lossy == pytest.approx(lossless / (2.0 - 1.0 / 0.68), rel=0.06), f"{lossless} and {lossy} N m"
    checked_files(result)


@pytest.mark.parametrize("name", ["backlash", "positioning"])
@pytest.mark.slow
def test_a_drive_too_weak_for_the_experiment_is_told(name: str) -> None:
    weak = replace(DRIVE, motor=replace(DRIVE.motor, rated_torque_mNm=0.05))
    with pytest.raises(ValueError, match=r"ended|whole sweep|reversed"):
        EXPERIMENTS[name](weak, 0)


def test_paper_s_figures_stand_beside_the_rig_s() -> None:
    rows = (Compared("torque", "N m", 3.2, 3.3), Compared("never seen", "N m", float("nan"), None, "a note"))
    result = PaperResult("driving-capability", "Fig. 7", rows, {}, {"ramp_Nm_s": 0.2})
    content = json.loads(result_json(result, DRIVE))
    assert [(row["rig"], row["paper"]) for row in content["compared"]] == [(3.2, 3.3), (None, None)]
    text = result_text(result)
    assert "3.2" in text and "3.3" in text and "never  " in text and "ramp_Nm_s 0.2" in text


# The evaluation of the paper's experiments, on synthetic runs with known results.


def made_up(time: np.ndarray, **known: np.ndarray) -> DynamicRun:
    nothing = {
        "reference_rad": np.zeros(time.size),
        "drum_rad": np.zeros(time.size),
        "payload_rad": np.zeros(time.size),
        "torque_Nm": np.zeros(time.size),
        "input_rad": np.zeros((2, time.size)),
        "motor_Nm": np.zeros((2, time.size)),
        "rotor_rad": np.zeros((2, time.size)),
        "tension_N": np.zeros((4, time.size)),
        "measured_drum_rad": np.zeros(time.size),
        "measured_input_rad": np.zeros((2, time.size)),
        "measured_torque_Nm": np.zeros(time.size),
    }
    return DynamicRun(time_s=time, energy_J={}, **{**nothing, **known})


@pytest.mark.parametrize("cycles_per_rad", [108.9, 694.3])
def test_spectrum_over_angle_finds_a_line_and_its_height(cycles_per_rad: float) -> None:
    time = np.arange(0.0, 60.0, 1e-3)
    angle = 0.1 * np.sin(2 * np.pi * 0.05 * time)
    error = 24.67e-6 * np.sin(2 * np.pi * cycles_per_rad * angle + 0.4) + 1e-4 * np.sign(
        np.cos(2 * np.pi * 0.05 * time)
    )
    at, height = highest_peak(*angle_spectrum(angle, error))
    assert abs(at - cycles_per_rad) < 0.5, f"line at {at:.2f}, put in at {cycles_per_rad}"
    assert height == pytest.approx(24.67e-6, rel=0.03), f"{height * 1e6:.2f} urad, put in 24.67"


def test_spectrum_needs_a_whole_sweep() -> None:
    with pytest.raises(ValueError, match="whole sweep"):
        angle_spectrum(np.zeros(50), np.zeros(50))


def test_swing_at_each_reversal() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    side = np.clip(np.cos(2 * np.pi * 0.1 * time) * 20.0, -1.0, 1.0)
    run = made_up(time, torque_Nm=0.91 * side, measured_drum_rad=-165e-6 * side)
    assert reversal_swings_rad(run, DRIVE) == pytest.approx(np.full(4, 330e-6), rel=1e-6)


def test_saturation_and_giving_way_are_told_apart() -> None:
    time = np.arange(0.0, 50.0, 0.01)
    load = 0.1 * time
    motor = np.stack([np.minimum(0.05 * load, 0.22), np.minimum(0.07 * load, 0.22)])
    run = made_up(time, torque_Nm=load, motor_Nm=motor, drum_rad=np.where(load > 4.4, -0.1, 0.0))
    assert first_saturated_Nm(run, [0.22, 0.22]) == pytest.approx(0.22 / 0.07, rel=0.012)
    assert given_way_Nm(run) == pytest.approx(4.4, abs=0.01)
    assert np.isnan(first_saturated_Nm(run, [0.5, 0.5]))
    assert np.isnan(given_way_Nm(made_up(time, torque_Nm=load)))
