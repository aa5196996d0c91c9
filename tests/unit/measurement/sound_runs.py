"""A run of the declared drive with sensors of a bench and without mistakes; logs as loggers write them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from tests.support.reference import DRIVE

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


RATIO = 9.0
Write = Callable[..., Path]


def signals(samples: int = 400) -> dict[str, np.ndarray]:
    """A drive of ratio 9 swept up and down at 100 Hz."""
    t = np.arange(samples) * 0.01
    drum = 0.4 * np.sin(2.0 * np.pi * 0.5 * t)
    return {"t": t, "left": RATIO * drum, "right": RATIO * drum, "drum": drum, "tau": 0.9 * np.sign(np.cos(np.pi * t))}


def table(columns: dict[str, np.ndarray], sign: str = ",", digits: str = "%.9g") -> str:
    """The signals as a logger would write them."""
    head = sign.join(columns)
    rows = zip(*columns.values(), strict=True)
    return "\n".join([head, *(sign.join(digits % value for value in row) for row in rows)]) + "\n"


def mapping(**changed: Any) -> dict[str, Any]:
    """A measurement file's content; a field of None is left out."""
    content = {
        "data": "run.csv",
        "columns": {
            "time": {"column": "t", "unit": "s"},
            "input_left": {"column": "left", "unit": "rad"},
            "input_right": {"column": "right", "unit": "rad"},
            "output": {"column": "drum", "unit": "rad"},
            "load_torque": {"column": "tau", "unit": "N*m"},
        },
    }
    return {key: value for key, value in (content | changed).items() if value is not None}


def writer(folder: Path) -> Write:
    """Writes run.csv (text or bytes) and run.yaml into ``folder``, and gives the path of the latter."""

    def made(data: str | bytes, content: dict[str, Any] | None = None) -> Path:
        (folder / "run.csv").write_bytes(data.encode() if isinstance(data, str) else data)
        path = folder / "run.yaml"
        path.write_text(yaml.safe_dump(mapping() if content is None else content, sort_keys=False))
        return path

    return made
