"""A cable climbs the edge of its land: from a given surface angle on it lies higher by ``height_um``.

Surface angle x = -sigma theta_o as in :mod:`mbcdm_cad.rig.effects.land_wear`; the radius rises over ``over_deg`` and
stays up, so that from there on the cable winds faster than its partners and its tension grows with the travel.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect
from mbcdm_cad.rig.effects.shapes import rise_integral
from mbcdm_cad.routes import Floats


class StepClimb(RigEffect):
    """A cable that climbs up the flank of its step."""

    effect: Literal["step_climb"]
    cable: str
    height_um: Annotated[float, Field(ge=0.0, le=2000.0)]
    from_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    over_deg: Annotated[float, Field(gt=0.0, le=90.0)] = 2.0

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        begin, over, sigma = radians(self.from_deg), radians(self.over_deg), bench.cables[j].sigma

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            longer[j] = (
                self.height_um
                * 1e-6
                * (rise_integral(-sigma * drum, begin, over) - rise_integral(np.zeros(1), begin, over))
            )
            return longer

        bench.paths.append(path)
        bench.tell(
            "step_climb",
            in_vocabulary=False,
            cables=[self.cable],
            parameters={"height_m": self.height_um * 1e-6, "from_rad": begin},
        )
