"""Rope on pulley rougher or slicker than declared (dirt, oil): mu of every cable times 1 + share."""

from __future__ import annotations

from typing import Literal

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect, Share


class RopeFriction(RigEffect):
    """Friction of the rope on the pulleys differs from the declared one."""

    effect: Literal["rope_friction"]
    share: Share

    def apply(self, bench: Bench) -> None:
        bench.change(bench.which(()), friction=1.0 + self.share)
        bench.tell("cable_friction", parameters={"share": self.share})
