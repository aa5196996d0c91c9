"""A rope wound on a pulley as a helix: axial walk of its tangent point, and fleet angle of its span.

Units: m and rad; all arguments broadcast.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.routes import Floats


def axial_walk_m(turned_rad: Any, lead_m: Any) -> Floats:
    """Walk of the tangent point along the axis when the pulley turns by ``turned_rad``: lead a turn."""
    return np.asarray(turned_rad * lead_m / (2 * np.pi))


def fleet_angle_rad(walk_m: Any, span_m: Any) -> Floats:
    """Angle of the span to the plane of the pulley for a walk at one of its ends."""
    return np.asarray(np.arctan(walk_m / span_m))
