"""Temperature: rope, frame and pulleys expand, each with its own coefficient.

The temperature of the named ropes rises by rise (1 - e^(-t/tau)) from ``start_s`` on, and falls with the same tau from
``cool_s`` on; that of frame and pulleys changes by ``body_share`` of it. The free span expands with the frame, its rope
with its own coefficient; rope that sticks to a pulley is strained by the difference of the expansions. The radii of
drum and inputs grow by different shares, which changes the ratio. If all ropes warm alike, hardly anything but the
preload changes; if one rope warms alone, the drum turns.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, RigEffect
from mbcdm_cad.routes import Floats

Expansion = Annotated[float, Field(ge=0.0, le=100.0)]


class Temperature(RigEffect):
    """Thermal expansion of cables relative to frame and pulleys."""

    effect: Literal["temperature"]
    rise_K: Annotated[float, Field(ge=-100.0, le=100.0)]
    time_constant_s: Annotated[float, Field(gt=0.0, le=1e5)] = 60.0
    start_s: Annotated[float, Field(ge=0.0, le=1e5)] = 0.0
    cool_s: Annotated[float, Field(ge=0.0, le=1e5)] = 1e5
    cables: CableNames = ()
    body_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    rope_ppm_K: Expansion = 16.0
    frame_ppm_K: Expansion = 23.4
    drum_ppm_K: Expansion = 23.4
    input_ppm_K: Expansion = 12.0
    ambient_degC: Annotated[float, Field(ge=-50.0, le=100.0)] = 22.0
    log: bool = True

    def apply(self, bench: Bench) -> None:
        warm = self._since(bench.time_s, self.start_s) - self._since(bench.time_s, max(self.cool_s, self.start_s))
        rope, body = warm * self.rope_ppm_K * 1e-6, warm * self.body_share * 1e-6
        which = bench.which(self.cables)
        for j in range(len(bench.cables)):
            own = rope if j in which else np.zeros_like(rope)
            bench.add_strain(
                [j],
                own - body * self.frame_ppm_K,
                (own - body * self.input_ppm_K, own - body * self.frame_ppm_K, own - body * self.drum_ppm_K),
            )

        def grown(inputs: Floats, drum: Floats) -> Floats:
            return np.stack(
                [
                    c.sigma
                    * body
                    * (
                        self.input_ppm_K * c.input_radius_m * inputs[c.input_index]
                        - self.drum_ppm_K * c.drum_radius_m * drum
                    )
                    for c in bench.cables
                ]
            )

        bench.paths.append(grown)
        if self.log:
            bench.temperature_C = self.ambient_degC + warm
        bench.tell(
            "thermal_drift",
            cables=[bench.cables[j].name for j in which],
            parameters={"rise_K": self.rise_K, "time_constant_s": self.time_constant_s},
        )

    def _since(self, time_s: Floats, begin_s: float) -> Floats:
        return np.asarray(self.rise_K * -np.expm1(-np.maximum(time_s - begin_s, 0.0) / self.time_constant_s))
