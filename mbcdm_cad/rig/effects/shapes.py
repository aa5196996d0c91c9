"""Integrals of local shapes along an angle or a length: the change of a path by a radius that is not constant."""

from __future__ import annotations

from math import pi

import numpy as np

from mbcdm_cad.routes import Floats


def hump_integral(x: Floats, begin: float, end: float) -> Floats:
    """Integral up to x of a raised cosine of height 1 between ``begin`` and ``end``."""
    width = end - begin
    u = np.clip((x - begin) / width, 0.0, 1.0)
    return np.asarray(width * (0.5 * u - np.sin(2.0 * pi * u) / (4.0 * pi)))


def rise_integral(x: Floats, begin: float, over: float) -> Floats:
    """Integral up to x of a cosine ramp from 0 at ``begin`` to 1 at ``begin + over`` and on."""
    u = np.clip((x - begin) / over, 0.0, 1.0)
    ramp = over * (0.5 * u - np.sin(pi * u) / (2.0 * pi))
    return np.asarray(ramp + np.maximum(x - begin - over, 0.0))
