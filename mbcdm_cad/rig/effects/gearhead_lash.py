"""Play and softness between motor and input pulley.

The gearhead's shaft drives the pulley with the torque s(phi - theta), zero within the play. The flank in contact
follows from the torque of the cables on that input, including the bias of their preload; between the flanks the pulley
floats at the angle at which the cables balance. Encoders on the pulleys measure this motion, so the effect shows only
with ``sensors.input_at: motor``.
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
    # A stiff shaft by default, so that only the lash has an effect.
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
