"""A rope softer or stiffer than declared: E A of every cable times 1 + share."""

from __future__ import annotations

from typing import Literal

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect, Share


class Modulus(RigEffect):
    """Modulus of the rope differs from the declared one."""

    effect: Literal["modulus"]
    share: Share

    def apply(self, bench: Bench) -> None:
        bench.change(bench.which(()), stiffness_N=1.0 + self.share)
        bench.tell("stiffness_error", parameters={"share": self.share})
