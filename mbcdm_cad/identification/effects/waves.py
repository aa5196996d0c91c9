"""A cosine and a sine that vanish at zero angle: the two coordinates of every once-per-turn error."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.identification.effects.base import Figure, Parameter
from mbcdm_cad.measurement.run import Floats


def wave(values: Floats, angle_rad: Floats) -> tuple[Floats, Floats]:
    """(x, y) of a point at ``values`` in the turning frame, from where it stands at angle zero; same unit as values."""
    c, s = np.cos(angle_rad) - 1.0, np.sin(angle_rad)
    return values[0] * c - values[1] * s, values[0] * s + values[1] * c


def pair(size: float, unit: str) -> tuple[Parameter, Parameter]:
    """The two coordinates as parameters."""
    return Parameter(f"cosine_{unit}", size), Parameter(f"sine_{unit}", size)


def length(values: Floats) -> float:
    """Size of the wave."""
    return float(np.hypot(values[0], values[1]))


def phase(values: Floats) -> float:
    """Shaft angle at which the wave is highest is minus this; rad."""
    return float(np.arctan2(values[1], values[0]))


PHASE = Figure("phase_rad", phase)
