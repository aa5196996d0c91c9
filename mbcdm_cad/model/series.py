"""Result and argument checks that all time-series forms of the model share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats


@dataclass(frozen=True, eq=False)
class Response:
    """Drum angle (rad, shape (n,)) and free-span tensions (N, shape (n_cables, n)) at each sample."""

    drum_angle_rad: Floats
    tension_N: Floats

    def input_torque_Nm(self, d: DriveSI) -> Floats:
        """Torque that holds each input at each sample, shape (n_inputs, n)."""
        pull = (d.sigma * d.input_radius_m)[:, None] * self.tension_N
        return np.stack([pull[[j for j, k in enumerate(d.input_of) if k == i]].sum(axis=0) for i in range(d.n_inputs)])


def checked_series(d: DriveSI, input_angle_rad: Any, load_Nm: Any) -> tuple[Floats, Floats]:
    """Input angles (n_inputs, n) and load (n,) as contiguous arrays; errors as in :func:`simulate`."""
    angle = np.ascontiguousarray(np.atleast_2d(np.asarray(input_angle_rad, dtype=float)))
    if d.batch_shape:
        raise ModelError(f"a series runs on one design, got a batch of shape {d.batch_shape}; loop over the designs")
    if angle.shape[0] != d.n_inputs or angle.ndim != 2:
        raise ModelError(
            f"input_angle_rad has shape {angle.shape}, the drive needs ({d.n_inputs}, n): one row an input"
        )
    load = np.asarray(load_Nm, dtype=float)
    if load.ndim > 1 or (load.ndim == 1 and load.size != angle.shape[1]):
        raise ModelError(f"load_Nm has shape {load.shape} for {angle.shape[1]} samples; give one value or one a sample")
    if not (np.isfinite(angle).all() and np.isfinite(load).all()):
        raise ModelError("input_angle_rad or load_Nm holds NaN or infinity; clean the series first")
    if not float(d.friction_coefficient) > 0.0:
        friction = float(d.friction_coefficient)
        raise ModelError(f"friction_coefficient {friction:g}: slip zones have no end; give it > 0")
    return angle, np.ascontiguousarray(np.broadcast_to(load, (angle.shape[1],)))


def path_offset_m(d: DriveSI, path_m: Any, samples: int) -> Floats:
    """``path_m`` as an array (n_cables, samples), zeros for None. Errors: ``ModelError`` for a wrong shape or NaN."""
    shape = (d.n_cables, samples)
    if path_m is None:
        return np.zeros(shape)
    path = np.asarray(path_m, dtype=float)
    if path.shape != shape or not np.isfinite(path).all():
        raise ModelError(f"path_m has shape {path.shape} or holds NaN; give finite numbers of shape {shape}")
    return path
