"""A brake that sticks: it winds up through its own stiffness to a static torque, then drops (rig/load.py).

The torque sensor measures all of it, so nothing is left to explain; but it drives the friction of the cables.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class BrakeStickSlip(RigEffect):
    """Stick-slip of the brake."""

    effect: Literal["brake_stick_slip"]
    static_share: Annotated[float, Field(gt=1.0, lt=2.0)] = 1.2
    scatter: Annotated[float, Field(ge=0.0, le=0.2)] = 0.03
    stiffness_Nm_rad: Annotated[float, Field(gt=0.0, le=1e5)] = 500.0

    def apply(self, bench: Bench) -> None:
        n = bench.time_s.size
        share = self.static_share * (1.0 + self.scatter * bench.rng.uniform(-1.0, 1.0, n))
        bench.stick_slip = np.stack([np.maximum(share, 1.0), np.full(n, self.stiffness_Nm_rad)], axis=1)
        bench.tell("brake_stick_slip", in_vocabulary=False, seen=False, parameters={"static_share": self.static_share})
