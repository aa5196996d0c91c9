"""Tensioners set to another preload than declared: T_pre of all cables, or of those named, times 1 + share."""

from __future__ import annotations

from typing import Literal

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, RigEffect, Share


class Preload(RigEffect):
    """Preload differs from the declared one."""

    effect: Literal["preload"]
    share: Share
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which = bench.which(self.cables)
        bench.change(which, preload_N=1.0 + self.share)
        bench.tell("preload_error", cables=[bench.cables[j].name for j in which], parameters={"share": self.share})
