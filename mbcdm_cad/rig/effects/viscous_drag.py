"""Grease and eddy currents between drum and torque sensor: a torque proportional to the drum's speed."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class ViscousDrag(RigEffect):
    """Viscous drag at the drum."""

    effect: Literal["viscous_drag"]
    drag_Nms: Annotated[float, Field(ge=0.0, le=100.0)]

    def apply(self, bench: Bench) -> None:
        bench.hidden_Nm.append(self.drag_Nms * np.gradient(bench.drum_rad, bench.time_s))
        bench.tell("delay", cause="viscous_drag", parameters={"drag_Nms": self.drag_Nms})
