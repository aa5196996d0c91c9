"""The rope's strands: its centre line rides higher where a strand's crown lies on the pulley, once for each lay length.

Rope lies on each pulley in the same places whenever it is wound, so the pitch radius there is r + a sin(2 pi s /
lay), s the length along the pulley from the tangent point at the centre. Wound angle x then takes the integral of
that, on the input (x = sigma theta_i) and on the drum (x = -sigma theta_o).
"""

from __future__ import annotations

from math import pi, radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, Phase, RigEffect
from mbcdm_cad.routes import Floats


class RopeLay(RigEffect):
    """Ripple from the twist (lay) of the strands of a rope."""

    effect: Literal["rope_lay"]
    amplitude_um: Annotated[float, Field(ge=0.0, le=500.0)]
    lay_mm: Annotated[float, Field(gt=0.1, le=100.0)] = 6.5
    phase_deg: Phase = 0.0
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which, phase, wave = bench.which(self.cables), radians(self.phase_deg), 2.0 * pi / (self.lay_mm * 1e-3)
        height = self.amplitude_um * 1e-6

        def wound(x: Floats, radius: float) -> Floats:
            return np.asarray(height / (wave * radius) * (np.cos(phase) - np.cos(wave * radius * x + phase)))

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            for j in which:
                c = bench.cables[j]
                longer[j] = wound(c.sigma * inputs[c.input_index], c.input_radius_m) + wound(
                    -c.sigma * drum, c.drum_radius_m
                )
            return longer

        bench.paths.append(path)
        for j in which:
            c = bench.cables[j]
            bench.tell(
                "ripple",
                cause="rope_lay",
                cables=[c.name],
                parameters={"cycles_per_output_rev": wave * c.drum_radius_m},
            )
