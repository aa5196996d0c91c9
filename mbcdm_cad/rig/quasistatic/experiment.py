"""Experiment file of the quasi-static rig: motion, load, sensors and effects."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from mbcdm_cad.rig.block import ExperimentBlock, PhysicsBlock
from mbcdm_cad.rig.chain import DRUM_WRAP_RAD, INPUT_WRAP_RAD
from mbcdm_cad.rig.effects.registry import AnyEffect
from mbcdm_cad.rig.quasistatic.load import Load
from mbcdm_cad.rig.quasistatic.motion import Motion
from mbcdm_cad.rig.sensors import MOST_DURATION_S, BenchSensors
from mbcdm_cad.routes import Floats

MAX_SAMPLES = 2_000_000
# Wrap that is left on pulleys of many turns at the end of the motion.
LEFT_RAD = 0.1


class Physics(PhysicsBlock):
    """Choices of the physics. Wraps are those of rope on pulley at the centre, from anchor to tangent point."""

    substeps: Annotated[int, Field(ge=1, le=100)] = 1
    # Left out: 16 rad and 3 rad, or what a longer travel winds off and LEFT_RAD.
    input_wrap_rad: Annotated[float, Field(gt=0.0, le=1e4)] | None = None
    drum_wrap_rad: Annotated[float, Field(gt=0.0, le=25.0)] | None = None

    def wraps_rad(self, reach_rad: float, turns: float) -> tuple[float, float]:
        """Wraps of each cable on input and drum, in a run of this largest angle of the drum and this ratio."""
        wound = reach_rad * turns if self.cable_transport else 0.0
        usual = max(INPUT_WRAP_RAD, wound + LEFT_RAD), max(DRUM_WRAP_RAD, reach_rad + LEFT_RAD)
        return self.input_wrap_rad or usual[0], self.drum_wrap_rad or usual[1]


class Experiment(ExperimentBlock):
    """An experiment on the quasi-static bench. ``record``: every sample, or as by hand: a row where motion or
    load turns round, or readings at rest ever farther apart since each step of the load.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,79}$")]
    about: Annotated[str, Field(max_length=500)] = ""
    format: Literal["mbcdm-experiment-1"] = "mbcdm-experiment-1"
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    duration_s: Annotated[float, Field(gt=0.0, le=MOST_DURATION_S)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    motion: Motion
    load: Load = Load()
    sensors: BenchSensors = BenchSensors()
    physics: Physics = Physics()
    record: Literal["samples", "turning_points", "creep"] = "samples"
    effects: Annotated[tuple[AnyEffect, ...], Field(max_length=50, strict=False)] = ()

    def rows(self, time_s: Floats) -> NDArray[np.int64]:
        """The samples that are written: all, turning points of the motion or of the load at rest, or those at rest."""
        if self.record == "samples":
            return np.arange(time_s.size)
        if self.record == "creep":
            course = self.load.periods_per_level * self.motion.period_s if len(self.load.levels_Nm) > 1 else time_s[-1]
            since = np.geomspace(
                1.0 / self.sample_rate_Hz, 0.99 * course, round(6.0 * np.log10(course * self.sample_rate_Hz))
            )
            at = [begin + since for begin in np.arange(0.0, time_s[-1], course)]
            return np.unique(np.minimum(np.searchsorted(time_s, np.concatenate(at)), time_s.size - 1))
        held = self.motion.shape == "hold"
        period = self.load.wave_period_s if held else self.motion.period_s
        begins = 0.25 * self.motion.period_s if held else 0.0
        turns = 0.25 * period + 0.5 * period * np.arange(1 + int(2.0 * time_s[-1] / period))
        turns = turns[(turns >= begins) & (turns <= time_s[-1])]
        rows = np.searchsorted(time_s, turns - 1e-9)
        if held:
            return np.asarray(rows)
        # Where the load is made smaller it turns round: the sample before.
        course, levels = self.load.periods_per_level * period, np.abs(self.load.levels_Nm)
        number = np.arange(1, 1 + int(time_s[-1] / course))
        falls = levels[number % levels.size] < levels[(number - 1) % levels.size]
        before = np.searchsorted(time_s, course * number[falls] - 1e-9) - 1
        return np.unique(np.concatenate([rows, before[before > rows[0]]]))
