"""A broken wire: the rope is thicker by ``height_um`` over ``length_mm`` at one place.

Where the thick place lies on a pulley of radius r, the centre line lies further out by its height: the path grows by
the integral of the height over the angle that it covers there, i.e. by height x covered length / r. In the free span it
has no effect. ``position_mm`` is its middle, measured along the rope from the tangent point on the input with the drum
at zero (so the first wrap that it passes begins after the first span); it moves with the rope.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect
from mbcdm_cad.rig.effects.shapes import hump_integral
from mbcdm_cad.routes import Floats


class StrandDamage(RigEffect):
    """Damaged strand: a local bump on a rope."""

    effect: Literal["strand_damage"]
    cable: str
    height_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    length_mm: Annotated[float, Field(gt=0.0, le=50.0)] = 2.0
    position_mm: Annotated[float, Field(ge=-500.0, le=500.0)]

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        c = bench.cables[j]
        half = 0.5e-3 * self.length_mm
        begin, passed = 0.0, []
        for span, wrap in zip(c.route.spans, c.passed, strict=False):
            begin += span.length_m
            end = begin + wrap.angle_rad * wrap.radius_m
            passed.append((begin, end, wrap.radius_m))
            begin = end
        drum_begin = begin + c.route.spans[-1].length_m

        def before(end_m: float, middle: Floats) -> Floats:
            """Integral of the height over the part of the rope on this side of ``end_m``."""
            return hump_integral(end_m - middle, -half, half)

        def extra(drum: Floats) -> Floats:
            middle = self.position_mm * 1e-3 - c.sigma * c.drum_radius_m * drum
            on_input = before(0.0, middle)
            covered = on_input / c.input_radius_m
            for begin, end, radius_m in passed:
                covered = covered + (before(end, middle) - before(begin, middle)) / radius_m
            on_drum = half - before(drum_begin, middle)
            covered = covered + on_drum / c.drum_radius_m
            return np.asarray(self.height_um * 1e-6 * covered)

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            longer[j] = extra(drum) - extra(np.zeros(1))[0]
            return longer

        bench.paths.append(path)
        bench.tell(
            "strand_damage",
            in_vocabulary=False,
            cables=[self.cable],
            parameters={"height_m": self.height_um * 1e-6, "position_m": self.position_mm * 1e-3},
        )
