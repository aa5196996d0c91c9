"""Friction in bearings of the drum and of passed bodies: the cables carry it, the torque sensor does not see it.

Coulomb torque against the motion, with a short elastic start (``presliding_urad`` of drum angle from side to side). A
passed body turns r_o/r times as fast as the drum, so its drag counts that many times at the drum.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import AliasChoices, Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect
from mbcdm_cad.rig.quasistatic.load import brake

PASSED = AliasChoices("passed_mNm", "guide_mNm")


class BearingFriction(RigEffect):
    """Friction torque of bearings."""

    effect: Literal["bearing_friction"]
    drum_mNm: Annotated[float, Field(ge=0.0, le=5000.0)] = 0.0
    passed_mNm: Annotated[float, Field(ge=0.0, le=500.0, validation_alias=PASSED)] = 0.0
    presliding_urad: Annotated[float, Field(gt=0.0, le=1e4)] = 100.0

    def apply(self, bench: Bench) -> None:
        turns = sum(abs(body.turns_per_drum) for body in bench.routes.passed)
        torque = (self.drum_mNm + self.passed_mNm * turns) * 1e-3
        bench.hidden_Nm.append(brake(bench.drum_rad, np.full(bench.time_s.size, torque), self.presliding_urad * 1e-6))
        bench.tell("friction", parameters={"torque_Nm": torque})
