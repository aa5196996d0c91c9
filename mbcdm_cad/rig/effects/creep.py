"""A new rope settles: its strands bed in and it grows by ``strain_ppm`` for each unit of ln(1 + t / t0)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, RigEffect


class Creep(RigEffect):
    """Creep of ropes: they grow longer under tension."""

    effect: Literal["creep"]
    strain_ppm: Annotated[float, Field(ge=0.0, le=5000.0)]
    t0_s: Annotated[float, Field(gt=0.0, le=1e5)] = 5.0
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        grown = self.strain_ppm * 1e-6 * np.log1p(bench.time_s / self.t0_s)
        which = bench.which(self.cables)
        bench.add_strain(which, grown, (grown, grown, grown))
        bench.tell(
            "creep",
            cables=[bench.cables[j].name for j in which],
            parameters={"strain": self.strain_ppm * 1e-6, "t0_s": self.t0_s},
        )
