"""The sensors of the bench: place, resolution, noise and delay; and the bench file.

The bench file has the limits of a bench, within which ``mbcdm plan --within`` proposes runs.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.design.blocks import TORQUE_MAX_NM, TRAVEL_MAX_DEG
from mbcdm_cad.rig.block import ExperimentBlock, Friction
from mbcdm_cad.routes import Floats

# As a measurement file may state them.
Resolution = Annotated[float, Field(ge=0.0, le=1.0)]
Noise = Annotated[float, Field(ge=0.0, le=1.0)]
Delay = Annotated[float, Field(ge=0.0, le=1.0)]


class BenchSensors(ExperimentBlock):
    """Encoders and torque sensor. A resolution of 0 means no steps; ``*_delay_s`` is not declared to the loop.

    ``input_at`` says where the input encoders sit: on the pulleys, or behind the motors, read at the gearhead's output.
    """

    input_at: Literal["pulley", "motor"] = "pulley"
    input_resolution_rad: Resolution = 1.9175e-4
    input_noise_rad: Noise = 0.0
    output_resolution_rad: Resolution = 1.3635e-6
    output_noise_rad: Noise = 0.0
    torque_noise_Nm: Friction = 0.005
    torque_delay_s: Delay = 0.0
    temperature_noise_K: Annotated[float, Field(ge=0.0, le=5.0)] = 0.05
    log_torque: bool = True


def counted(angle_rad: Floats, resolution_rad: float, noise_rad: float, rng: np.random.Generator) -> Floats:
    """The angle as an encoder counts it: noise is added, then it is rounded to steps with an arbitrary offset."""
    offset, noise = rng.random(), rng.standard_normal(angle_rad.size)
    seen = angle_rad + noise_rad * noise
    if resolution_rad == 0.0:
        return seen
    return np.asarray((np.floor(seen / resolution_rad + offset) - np.floor(offset)) * resolution_rad)


def late(time_s: Floats, value: Floats, delay_s: float) -> Floats:
    """The value ``delay_s`` earlier; before the start it is constant."""
    return value if delay_s == 0.0 else np.interp(time_s - delay_s, time_s, value)


LoadKind = Literal["brake", "weight", "torque_motor"]


class MotorCurrent(ExperimentBlock):
    """Motors' currents in place of a torque sensor: spread of the torque constant, one standard deviation as a share,
    and noise of the load that follows from them, at the drum."""

    torque_constant_share: Annotated[float, Field(ge=0.0, le=0.25)] = 0.05
    noise_Nm: Friction = 0.02


# Longest run, s.
MOST_DURATION_S = 20000.0


class BenchLimits(ExperimentBlock):
    """Limits of a bench; defaults: the travel of the design, no load, no limit of the speed."""

    format: Literal["mbcdm-bench-1"] = "mbcdm-bench-1"
    half_travel_deg: Annotated[float, Field(ge=0.01, le=TRAVEL_MAX_DEG)] | None = None
    duration_s: Annotated[float, Field(ge=60.0, le=MOST_DURATION_S)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    drum_speed_max_deg_s: Annotated[float, Field(gt=0.0, le=1e5)] | None = None
    loads: Annotated[tuple[LoadKind, ...], Field(max_length=3, strict=False)] = ()
    torque_Nm: Annotated[float, Field(gt=0.0, le=TORQUE_MAX_NM)] | None = None
    sensors: BenchSensors = BenchSensors()
    motor_current: MotorCurrent | None = None
