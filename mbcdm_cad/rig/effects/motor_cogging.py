"""Cogging: the motor's torque ripples with its angle, and the position loop yields by torque over stiffness.

Without dynamics the position loop is a static stiffness at the motor: error at the gearhead's output = torque / (loop
stiffness x ratio), with ``cycles_per_motor_turn`` times ratio cycles a turn of the output. The encoders measure this
motion wherever they sit, so nothing is left to explain; the motion is less smooth.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect, Stage


class MotorCogging(RigEffect):
    """Cogging of a motor under its position loop."""

    effect: Literal["motor_cogging"]
    stage: Stage
    torque_mNm: Annotated[float, Field(ge=0.0, le=100.0)]
    cycles_per_motor_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 6.0
    loop_stiffness_mNm_rad: Annotated[float, Field(gt=0.0, le=1e5)] = 2.0

    def apply(self, bench: Bench) -> None:
        i, ratio = bench.input_index(self.stage), bench.drive.gearhead.ratio
        amplitude = self.torque_mNm / self.loop_stiffness_mNm_rad / ratio
        order = self.cycles_per_motor_turn * ratio
        bench.command_rad[i] += amplitude * np.sin(order * bench.command_rad[i])
        bench.tell(
            "motor_cogging",
            in_vocabulary=False,
            seen=False,
            stage=self.stage,
            parameters={"motion_amplitude_rad": amplitude, "cycles_per_input_rev": order},
        )
