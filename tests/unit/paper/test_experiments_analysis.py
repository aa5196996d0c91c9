"""The evaluation of the paper's experiments, on synthetic runs with known results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.studies.paper_experiments import (
    angle_spectrum,
    first_saturated_Nm,
    given_way_Nm,
    highest_peak,
    reversal_swings_rad,
)
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic.run import DynamicRun

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


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
