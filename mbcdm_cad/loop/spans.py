"""Changes of the cable paths by an eccentric pulley."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.displaced import path_slope


def path_change(d: DriveSI, stage: str, x: Floats, y: Floats) -> Floats:
    """Change of each cable's path, m, (n_cables, n), when the centre of the body ``stage`` is displaced by (x, y), m.

    x is along the body's reference, y at a right angle to it about the body's axis. KeyError if the drive has no such
    body.
    """
    body = d.routes.body(stage)
    along, across = np.array(body.reference), np.cross(body.axis, body.reference)
    slopes = np.array([path_slope(route, stage) for route in d.routes.cables])
    return np.asarray((slopes @ along)[:, None] * x + (slopes @ across)[:, None] * y)
