"""The drum angles at which interference is looked for."""

from __future__ import annotations

import numpy as np


def travel_poses(half_travel_deg: float, count: int) -> tuple[float, ...]:
    """Drum angles (deg), evenly over the travel, both ends included, and the centre for odd ``count``."""
    return tuple(float(a) for a in np.linspace(-half_travel_deg, half_travel_deg, count))
