"""Unit vectors of the spans of each cable, for what an eccentric pulley does to their lengths."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.measurement.run import Floats
from mbcdm_cad.model.si import DriveSI


def to_input(d: DriveSI) -> Floats:
    """Unit vector in the x-y plane from the guide's tangent point to the input's, shape (n_cables, 2); derived."""
    side = np.array([d.input_side[i] for i in d.input_of], dtype=float)
    lean = np.arccos((d.guide_radius_m + d.input_radius_m) / d.centre_distance_m)
    landing = np.where(side > 0, 0.0, np.pi) + d.sigma * lean
    normal = np.stack([np.cos(landing), np.sin(landing)], axis=1)
    centre = np.stack([side * d.centre_distance_m, np.zeros_like(side)], axis=1)
    reach = centre - (d.guide_radius_m + d.input_radius_m)[:, None] * normal
    return np.asarray(reach / np.linalg.norm(reach, axis=1)[:, None])


def path_change(d: DriveSI, stage: str, x: Floats, y: Floats) -> Floats:
    """Change of each cable's path, m, (n_cables, n), when a pulley's centre stands off by (x, y)."""
    u = to_input(d)
    # Where a cable leaves the guide, and lies on the drum: its sense along x.
    along = -d.sigma
    rows = np.zeros((d.n_cables, x.size))
    for j in range(d.n_cables):
        if stage == "drum":
            rows[j] = along[j] * x
        elif stage == "guide":
            rows[j] = -(u[j, 0] + along[j]) * x - u[j, 1] * y
        elif stage == "input_" + d.input_names[d.input_of[j]]:
            rows[j] = u[j, 0] * x + u[j, 1] * y
    return rows
