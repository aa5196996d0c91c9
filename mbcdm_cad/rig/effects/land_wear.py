"""A worn land of the drum: its radius is smaller by up to ``depth_um`` between two surface angles.

Surface angle x = -sigma theta_o counts from the tangent point at the centre, growing as rope is wound on; the wrap's
length is the integral of the radius, so the path changes by -depth times the integral of the hollow's shape.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect
from mbcdm_cad.rig.effects.shapes import hump_integral
from mbcdm_cad.routes import Floats


class LandWear(RigEffect):
    """Uneven wear of a drum land, the surface that carries a cable."""

    effect: Literal["land_wear"]
    cable: str
    depth_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    from_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    to_deg: Annotated[float, Field(ge=-180.0, le=180.0)]

    @model_validator(mode="after")
    def _in_order(self) -> LandWear:
        if not self.to_deg > self.from_deg:
            raise ValueError("to_deg must lie above from_deg")
        return self

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        begin, end, sigma = radians(self.from_deg), radians(self.to_deg), bench.cables[j].sigma

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            longer[j] = (
                -self.depth_um
                * 1e-6
                * (hump_integral(-sigma * drum, begin, end) - hump_integral(np.zeros(1), begin, end))
            )
            return longer

        bench.paths.append(path)
        bench.tell(
            "land_wear",
            in_vocabulary=False,
            cables=[self.cable],
            parameters={"depth_m": self.depth_um * 1e-6, "from_rad": begin, "to_rad": end},
        )
