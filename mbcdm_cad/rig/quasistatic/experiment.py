"""Experiment file of the quasi-static rig: motion, load, sensors and effects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.block import ExperimentBlock, PhysicsBlock
from mbcdm_cad.rig.effects.registry import AnyEffect
from mbcdm_cad.rig.quasistatic.load import Load
from mbcdm_cad.rig.quasistatic.motion import Motion
from mbcdm_cad.rig.sensors import BenchSensors

MAX_SAMPLES = 2_000_000


class Physics(PhysicsBlock):
    """Choices of the physics. Wraps are those of rope on pulley at the centre, from anchor to tangent point."""

    substeps: Annotated[int, Field(ge=1, le=100)] = 1
    input_wrap_rad: Annotated[float, Field(gt=0.0, le=200.0)] = 16.0
    drum_wrap_rad: Annotated[float, Field(gt=0.0, le=6.3)] = 3.0


class Experiment(ExperimentBlock):
    """An experiment on the quasi-static bench."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,79}$")]
    about: Annotated[str, Field(max_length=500)] = ""
    format: Literal["mbcdm-experiment-1"] = "mbcdm-experiment-1"
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    duration_s: Annotated[float, Field(gt=0.0, le=20000.0)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    motion: Motion
    load: Load = Load()
    sensors: BenchSensors = BenchSensors()
    physics: Physics = Physics()
    effects: Annotated[tuple[AnyEffect, ...], Field(max_length=50, strict=False)] = ()
