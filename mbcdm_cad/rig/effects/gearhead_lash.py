"""Play and softness between motor and input pulley.

The pulley hangs on the gearhead's shaft: torque s(phi - theta), zero within the play. Which flank is in contact follows
from the torque the cables ask of that input, their preload's bias included; in between the pulley floats where cables
balance. Encoders on the pulleys see it all, so it shows only with ``sensors.input_at: motor``.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect, Stage


class GearheadLash(RigEffect):
    """Lash (play) of the gearhead or coupling of an input."""

    effect: Literal["gearhead_lash"]
    stage: Stage
    play_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    # A stiff shaft by default, so that lash alone shows.
    stiffness_Nm_rad: Annotated[float, Field(ge=1.0, le=1e6)] = 5000.0

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
