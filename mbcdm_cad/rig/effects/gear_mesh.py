"""Unequal gear teeth: the gearhead's output leads and lags with every tooth.

Error amplitude sin(cycles a + phase) at the gearhead's output, a its angle. Encoders on the pulleys see the motion, so
it shows only with ``sensors.input_at: motor``.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage


class GearMesh(RigEffect):
    """Ripple from the tooth mesh of a gearhead."""

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
