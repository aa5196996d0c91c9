"""A pulley whose groove is not centred on its axis.

The centre of the groove goes round the axis with the shaft: e (cos(a + phase), sin(a + phase)) for input and guide, a
the shaft's angle about +z. For the drum a is about +y, and along x, its rope's direction at the transfer point, the
centre moves by e cos(a + phase). Each cable's path changes as its tangents do (:mod:`mbcdm_cad.rig.geometry`), so that
tensions and friction work. Preload was set with the shaft at zero.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.compiled import Floats
from mbcdm_cad.rig.effects.base import Effect, Phase


class EccentricPulley(Effect):
    """Eccentric groove of drum, guide or an input pulley."""

    effect: Literal["eccentric_pulley"]
    stage: Literal["drum", "guide", "input_left", "input_right", "input_input"]
    eccentricity_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        phase, e = radians(self.phase_deg), self.eccentricity_um * 1e-6
        index = bench.input_index(self.stage) if self.stage.startswith("input_") else -1

        def centre(angle: Floats) -> Floats:
            return np.stack([e * np.cos(angle + phase), e * np.sin(angle + phase)])

        def path(inputs: Floats, drum: Floats) -> Floats:
            still = np.zeros((2, drum.size))
            changed = np.zeros((len(bench.cables), drum.size))
            for j, c in enumerate(bench.cables):
                if self.stage == "drum":
                    changed[j] = c.path.moved_m(still, still, centre(drum)[0])
                elif self.stage == "guide":
                    changed[j] = c.path.moved_m(centre(bench.guide_rad(drum)), still, still[0])
                elif c.input_index == index:
                    changed[j] = c.path.moved_m(still, centre(inputs[index]), still[0])
            return changed

        zero = path(np.zeros((len(bench.drive.input_names), 1)), np.zeros(1))
        bench.paths.append(lambda inputs, drum: path(inputs, drum) - zero)
        bench.tell("once_per_rev", stage=self.stage, cause="eccentric_pulley",
                   parameters={"eccentricity_m": e, "phase_rad": phase})  # fmt: skip
