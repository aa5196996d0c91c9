"""An encoder whose disc is not centred: at the shaft angle a its error is amplitude cos(a + phase)."""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage


class EccentricEncoder(RigEffect):
    """Eccentric encoder on the drum's or an input's shaft."""

    effect: Literal["eccentric_encoder"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase = self.amplitude_urad * 1e-6, radians(self.phase_deg)
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.cos(angle + phase)))
        bench.tell(
            "once_per_rev",
            stage=self.stage,
            cause="eccentric_encoder",
            parameters={"amplitude_rad": amplitude, "phase_rad": phase},
        )
