"""The result of every rig: truth and readings of a run, or the error that says why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.routes import Floats


class RigError(MbcdmError):
    """An experiment that cannot be run, though its file is well formed."""


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """Truth and readings of a run, SI, arrays over n samples.

    ``input_rad`` (n_inputs, n) are the pulleys, ``tension_N`` (n_cables, n); ``load_Nm`` is the torque at the sensor.
    ``drum_rad`` is the drum's angle at its encoder, ``payload_rad`` that of the payload; ``excitation_rad`` (n,) the
    command, on the dynamic rig.
    """

    time_s: Floats
    input_rad: Floats
    drum_rad: Floats
    payload_rad: Floats
    load_Nm: Floats
    tension_N: Floats
    measured_input_rad: Floats
    measured_output_rad: Floats
    measured_load_Nm: Floats | None
    measured_temperature_C: Floats | None
    truth: list[dict[str, Any]]
    excitation_rad: Floats | None = None
