"""A run of the declared drive with sensors of a bench and without mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
D = layout_of(DRIVE).si
SENSORS = Sensors(1.9175e-4, 1.3635e-6, 0.005)


def sound_run(amplitude_rad: float = 0.3, half_sweeps: int = 12, load: str = "bias") -> Run:
    """A run of the declared drive with both encoders' steps and a noisy torque."""
    rng = np.random.default_rng(5)
    time = np.arange(0.0, half_sweeps * 5.0, 0.01)
    drum = amplitude_rad * np.sin(2.0 * np.pi * time / 10.0 - 0.5 * np.pi)
    sense = np.tanh(np.gradient(drum, time) / 0.005)
    torque = {"bias": 0.5 + 0.4 * sense, "brake": 0.9 * sense, "constant": 0.5 + 0.0 * sense}[load]
    inputs = np.tile(drum * float(D.total_ratio.mean()), (2, 1))
    output = simulate(D, inputs, torque).drum_angle_rad
    step = SENSORS.input_resolution_rad
    return Run(
        time,
        np.floor(inputs / step + rng.random((2, 1))) * step,
        output,
        torque + rng.normal(0.0, 0.005, time.size),
        sensors=SENSORS,
    )
