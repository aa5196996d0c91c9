"""Effects between motor and input pulley: play, teeth, cogging, a soft shaft."""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.block import FrictionMilli, Stiffness
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage


class GearheadLash(RigEffect):
    """Lash (play) of the gearhead or coupling of an input.

    Play and softness between motor and input pulley.

    The gearhead's shaft drives the pulley with the torque s(phi - theta), zero within the play. The flank in contact
    follows from the torque of the cables on that input, including the bias of their preload; between the flanks the
    pulley floats at the angle at which the cables balance. Encoders on the pulleys measure this motion, so the effect
    shows only with ``sensors.input_at: motor``.
    """

    effect: Literal["gearhead_lash"]
    stage: Stage
    play_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    # A stiff shaft by default, so that only the lash has an effect.
    stiffness_Nm_rad: Stiffness = 5000.0

    def apply(self, bench: Bench) -> None:
        i = bench.input_index(self.stage)
        bench.gear_play_rad[i] += self.play_urad * 1e-6
        bench.gear_stiffness_Nm_rad[i] = 1.0 / (1.0 / bench.gear_stiffness_Nm_rad[i] + 1.0 / self.stiffness_Nm_rad)
        bench.tell(
            "lash",
            seen=bench.input_at == "motor",
            stage=self.stage,
            parameters={"play_rad": self.play_urad * 1e-6, "compliance_rad_Nm": 1.0 / self.stiffness_Nm_rad},
        )


class GearMesh(RigEffect):
    """Ripple from the tooth mesh of a gearhead.

    Unequal gear teeth: the gearhead's output leads and lags with every tooth.

    Error amplitude sin(cycles a + phase) at the gearhead's output, a its angle. Encoders on the pulleys see the motion,
    so it shows only with ``sensors.input_at: motor``.
    """

    effect: Literal["gear_mesh"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    cycles_per_input_rev: Annotated[float, Field(gt=0.0, le=1e6)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        i = bench.input_index(self.stage)
        amplitude, phase, cycles = self.amplitude_urad * 1e-6, radians(self.phase_deg), self.cycles_per_input_rev
        bench.gear_errors.append((i, lambda angle: np.asarray(amplitude * np.sin(cycles * angle + phase))))
        turns = bench.turns(i)
        bench.tell(
            "ripple",
            seen=bench.input_at == "motor",
            stage=self.stage,
            cause="gear_mesh",
            parameters={
                "cycles_per_output_rev": cycles * turns,
                "amplitude_rad": amplitude / turns / len(bench.drive.input_names),
            },
        )


class MotorCogging(RigEffect):
    """Cogging of a motor under its position loop.

    Cogging: the motor's torque ripples with its angle, and the position loop yields by torque over stiffness.

    Without dynamics the position loop is a static stiffness at the motor: error at the gearhead's output = torque /
    (loop stiffness x ratio), with ``cycles_per_motor_turn`` times ratio cycles a turn of the output. The encoders
    measure this motion wherever they sit, so nothing is left to explain; the motion is less smooth.
    """

    effect: Literal["motor_cogging"]
    stage: Stage
    torque_mNm: FrictionMilli
    cycles_per_motor_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 6.0
    loop_stiffness_mNm_rad: Annotated[float, Field(gt=0.0, le=1e7)] = 2.0

    def apply(self, bench: Bench) -> None:
        i, ratio = bench.input_index(self.stage), bench.drive.reduction.ratio
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


class SlowPart(RigEffect):
    """Creep of a printed or glued part under the load.

    A printed hub or a bond between the drum and its encoder gives way slowly: springs with dampers in series, one for
    each of ``per_decade_urad_Nm``, whose times are ten times apart from ``first_s`` on. No law of time is put in.
    """

    effect: Literal["slow_part"]
    per_decade_urad_Nm: Annotated[tuple[float, ...], Field(min_length=1, max_length=12, strict=False)]
    first_s: Annotated[float, Field(gt=0.0, le=1e6)] = 1.0

    def apply(self, bench: Bench) -> None:
        bench.slow_twist += [(1e-6 * give, self.first_s * 10.0**k) for k, give in enumerate(self.per_decade_urad_Nm)]
        total = 1e-6 * sum(self.per_decade_urad_Nm)
        bench.tell("creep", cause="slow_part", parameters={"give_rad_Nm": total, "first_s": self.first_s})


class ShaftCompliance(RigEffect):
    """Compliance of the output shaft.

    A soft shaft between the drum and its encoder: the encoder lags behind the drum by compliance times load torque.
    """

    effect: Literal["shaft_compliance"]
    compliance_urad_Nm: Annotated[float, Field(ge=0.0, le=1e8)]

    def apply(self, bench: Bench) -> None:
        bench.output_twist_rad_Nm += self.compliance_urad_Nm * 1e-6
        bench.tell(
            "stiffness_error",
            cause="shaft_compliance",
            parameters={"compliance_rad_Nm": self.compliance_urad_Nm * 1e-6},
        )
