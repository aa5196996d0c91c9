"""The drum's reference angle over time, from the block ``motion`` of the experiment file."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.block import ExperimentBlock
from mbcdm_cad.routes import Floats

# Widest motion of a drum from its centre, mrad: the three turns that a whole drum may have.
WIDEST_MRAD = 19000.0
# Longest period of a motion.
LONGEST_PERIOD_S = 1e4


class Motion(ExperimentBlock):
    """Triangle or sine about the centre, or a hold after a quarter of a period. Angles are the drum's."""

    shape: Literal["triangle", "sine", "hold"] = "triangle"
    amplitude_mrad: Annotated[float, Field(gt=0.0, le=WIDEST_MRAD)]
    period_s: Annotated[float, Field(gt=0.0, le=LONGEST_PERIOD_S)]
    # Time over which a corner of the triangle is rounded: a position loop cannot reverse instantly.
    corner_s: Annotated[float, Field(ge=0.0, le=10.0)] = 0.2
    # Slow difference (30 to 90 s) between left and right position loops, at the input pulleys.
    stray_urad: Annotated[float, Field(ge=0.0, le=1e4)] = 20.0

    def drum_rad(self, time_s: Floats) -> Floats:
        """The drum's angle over time, starting at zero; shape of ``time_s``."""
        phase = time_s / self.period_s
        amplitude = self.amplitude_mrad * 1e-3
        if self.shape == "hold":
            return amplitude * np.sin(0.5 * pi * np.minimum(4.0 * phase, 1.0))
        if self.shape == "sine":
            return amplitude * np.sin(2.0 * pi * phase)
        # The moving mean of the triangle over the corner's time, from its closed integral; the corner becomes a
        # parabola.
        half = 0.5 * min(self.corner_s / self.period_s, 0.5)
        if half == 0.0:
            return amplitude * _triangle(phase)
        wave = (_triangle_integral(phase + half) - _triangle_integral(phase - half)) / (2.0 * half)
        return amplitude * wave

    def strays_rad(self, time_s: Floats, n_inputs: int, rng: np.random.Generator) -> Floats:
        """Deviation of each input from its command, rad (n_inputs, n): three slow sines of random period and phase."""
        total = np.zeros((n_inputs, time_s.size))
        for i in range(n_inputs):
            for period, phase in zip(rng.uniform(30.0, 90.0, 3), rng.uniform(0.0, 2.0 * pi, 3), strict=True):
                total[i] += self.stray_urad * 1e-6 * np.sin(2.0 * pi * time_s / period + phase) / np.sqrt(3.0)
        return total


def _triangle(phase: Floats) -> Floats:
    """Triangle wave of period 1 through (0, 0), (1/4, 1), (3/4, -1)."""
    return np.asarray(1.0 - 4.0 * np.abs((phase + 0.25) % 1.0 - 0.5))


def _triangle_integral(phase: Floats) -> Floats:
    """Integral of the triangle wave, periodic since its mean is zero."""
    p = (phase + 0.25) % 1.0
    return np.asarray(np.where(p < 0.5, 2.0 * p * p - p, -2.0 * (p - 1.0) ** 2 + (1.0 - p)))
