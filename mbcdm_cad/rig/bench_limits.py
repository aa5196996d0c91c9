"""The bench file: the limits of a bench, within which ``mbcdm plan --within`` proposes runs."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.block import ExperimentBlock
from mbcdm_cad.rig.sensors import BenchSensors

LoadKind = Literal["brake", "weight", "torque_motor"]


class MotorCurrent(ExperimentBlock):
    """Motors' currents in place of a torque sensor: spread of the torque constant, one standard deviation as a share,
    and noise of the load that follows from them, at the drum."""

    torque_constant_share: Annotated[float, Field(ge=0.0, le=0.25)] = 0.05
    noise_Nm: Annotated[float, Field(ge=0.0, le=5.0)] = 0.02


class BenchLimits(ExperimentBlock):
    """Limits of a bench; defaults: the travel of the design, no load, no limit of the speed."""

    format: Literal["mbcdm-bench-1"] = "mbcdm-bench-1"
    half_travel_deg: Annotated[float, Field(gt=0.0, le=1080.0)] | None = None
    duration_s: Annotated[float, Field(ge=60.0, le=20000.0)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    drum_speed_max_deg_s: Annotated[float, Field(gt=0.0, le=1e5)] | None = None
    loads: Annotated[tuple[LoadKind, ...], Field(max_length=3, strict=False)] = ()
    torque_Nm: Annotated[float, Field(gt=0.0, le=50.0)] | None = None
    sensors: BenchSensors = BenchSensors()
    motor_current: MotorCurrent | None = None
