"""Anchor slip: a terminal slips by ``slip_um`` within ``over_s``, and the rope of its short wrap slips with it.

On the real drum the wrap before the anchor is about 20 degrees, and its friction holds only some 6 % of the tension. So
the whole slip of the anchor reaches the tangent point, and the path changes by the whole slip.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class AnchorSlip(RigEffect):
    """Slip of a cable's anchor."""

    effect: Literal["anchor_slip"]
    cable: str
    at_s: Annotated[float, Field(ge=0.0, le=1e5)]
    slip_um: Annotated[float, Field(ge=0.0, le=5000.0)]
    over_s: Annotated[float, Field(gt=0.0, le=100.0)] = 0.05

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        shorter = np.zeros((len(bench.cables), bench.time_s.size))
        shorter[j] = -self.slip_um * 1e-6 * np.clip((bench.time_s - self.at_s) / self.over_s, 0.0, 1.0)
        bench.paths.append(lambda inputs, drum: shorter)
        bench.tell("slip_step", cables=[self.cable], parameters={"time_s": self.at_s, "slip_m": self.slip_um * 1e-6})
