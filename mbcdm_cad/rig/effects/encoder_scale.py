"""An encoder that counts too many or too few lines a turn: it reads its shaft's angle times 1 + share."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect, Stage


class EncoderScale(RigEffect):
    """Scale error of an encoder."""

    effect: Literal["encoder_scale"]
    stage: Stage
    share_ppm: Annotated[float, Field(ge=-1e5, le=1e5)]

    def apply(self, bench: Bench) -> None:
        share = self.share_ppm * 1e-6
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(share * angle))
        # Error of the ratio of output to inputs; one input counts with its share.
        inputs = len(bench.drive.input_names)
        ratio = share if self.stage == bench.routes.drum.name else -share / inputs
        bench.tell(
            "ratio_error", stage=self.stage, cause="encoder_scale", parameters={"share": ratio, "encoder_share": share}
        )
