"""Grooves cut too deep or too shallow: pitch radii of drum or inputs off by ``error_um``, of all cables or some.

If only one cable is concerned, its ratio differs from that of the others, and its tension changes with the angle.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, RigEffect


class RadiusError(RigEffect):
    """Pitch radius differs from the declared one."""

    effect: Literal["radius_error"]
    stage: Literal["drum", "inputs"]
    error_um: Annotated[float, Field(ge=-1000.0, le=1000.0)]
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which = bench.which(self.cables)
        share = 0.0
        for j in which:
            cable = bench.cables[j]
            radius = cable.drum_radius_m if self.stage == "drum" else cable.input_radius_m
            factor = 1.0 + self.error_um * 1e-6 / radius
            bench.change([j], **{"drum_radius_m" if self.stage == "drum" else "input_radius_m": factor})
            share += (1.0 / factor if self.stage == "drum" else factor) - 1.0
        names = [bench.cables[j].name for j in which]
        bench.tell(
            "ratio_error",
            stage=self.stage,
            cause="radius_error",
            cables=names,
            parameters={"share": share / len(bench.cables)},
        )
