"""Sub-division error: sine and cosine of an encoder's lines differ, which causes an error periodic in the lines.

Unequal amplitudes give two periods a line, offsets one: ``cycles_per_rev`` is lines times that. Angle error
amplitude sin(cycles a + phase) on the encoder's shaft.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage


class EncoderSubdivision(RigEffect):
    """Sub-division error of an encoder."""

    effect: Literal["encoder_subdivision"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    cycles_per_rev: Annotated[float, Field(gt=0.0, le=1e6)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase, cycles = self.amplitude_urad * 1e-6, radians(self.phase_deg), self.cycles_per_rev
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.sin(cycles * angle + phase)))
        turns, part = 1.0, 1.0
        if self.stage != bench.routes.drum.name:
            turns, part = bench.turns(bench.input_index(self.stage)), 1.0 / len(bench.drive.input_names)
        # At the output the error of an input is divided by its ratio and by the number of inputs, which share about
        # equally.
        bench.tell(
            "ripple",
            stage=self.stage,
            cause="encoder_subdivision",
            parameters={"cycles_per_output_rev": cycles * turns, "amplitude_rad": amplitude / turns * part},
        )
