"""A pulley whose groove is not centred on its axis.

The centre of the groove turns with the shaft, at the distance e from the axis and at the angle a + phase from the
body's reference, a the shaft's angle. Each cable's path changes with its tangents (:mod:`mbcdm_cad.routes.displaced`),
which changes tensions and friction. The preload was set with the shaft at zero.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.displaced import offset_m, path_change_m


class EccentricPulley(RigEffect):
    """Eccentric groove of a body that cables run on."""

    effect: Literal["eccentric_pulley"]
    stage: Stage
    eccentricity_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        phase, e = radians(self.phase_deg), self.eccentricity_um * 1e-6
        body = bench.body(self.stage)

        def path(inputs: Floats, drum: Floats) -> Floats:
            moved = {body.name: offset_m(body, e, bench.body_rad(body, inputs, drum) + phase)}
            return np.stack([path_change_m(bench.routes, c.route, moved) for c in bench.cables])

        zero = path(np.zeros((len(bench.drive.input_names), 1)), np.zeros(1))
        bench.paths.append(lambda inputs, drum: path(inputs, drum) - zero)
        bench.tell(
            "once_per_rev",
            stage=self.stage,
            cause="eccentric_pulley",
            parameters={"eccentricity_m": e, "phase_rad": phase},
        )
