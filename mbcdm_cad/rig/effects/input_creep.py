"""Creep of a cable over an input on which nothing anchors it: the rig's :mod:`mbcdm_cad.rig.through` on its true wrap.

Without this effect each side of the cable counts as anchored on the input. With it the wrap has its built length, and
where the travel carries off the part that sticks, the cable creeps under load as a belt does. ``wrap_deg`` is for a
cable with fewer turns than designed; the effect ``rope_friction`` added to it, for one with less friction.
"""

from __future__ import annotations

from dataclasses import replace
from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class InputCreep(RigEffect):
    """A cable that creeps over its input; its wrap is that of the design unless given."""

    effect: Literal["input_creep"]
    wrap_deg: Annotated[float, Field(ge=90.0, le=20000.0)] | None = None

    def apply(self, bench: Bench) -> None:
        free = [c.route.wraps[0].may_slip_through for c in bench.cables]
        if not any(free):
            raise KeyError("cable that friction alone holds on its input")
        found = bench.drive.layout.routed
        wraps = np.asarray(found.geometry.through_wrap_rad(found.parameters), dtype=float)
        if self.wrap_deg is not None:
            wraps[:] = radians(self.wrap_deg)
        bench.cables = tuple(
            replace(c, own_wrap_rad=float(wraps[c.input_index]) / 2.0) if slips else c
            for c, slips in zip(bench.cables, free, strict=True)
        )
        bench.tell("input_creep", parameters={"wrap_rad": float(wraps.min())})
