"""Direct solution of a mesh whose elements reach from one row of freedoms to the next at most: planes of a grid."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv
from threadpoolctl import ThreadpoolController

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]


@cache
def _linear_algebra() -> ThreadpoolController:
    """The libraries of linear algebra that are loaded: numpy and scipy have one each."""
    return ThreadpoolController()


def solve_mesh(where: Ints, stiffness: Floats, load: Floats, ground: Floats | None = None) -> Floats:
    """Displacements (m, k) under the loads (m, k), by LAPACK's Cholesky factors of a banded matrix.

    ``where`` (n, f): the freedoms of each element, numbered row by row, below zero for those that are held;
    ``stiffness`` (n, f, f); ``ground`` (m,): springs to the base. Raises ``numpy.linalg.LinAlgError`` if the mesh is
    not held.
    """
    size = len(load)
    r, c = where[:, :, None], where[:, None, :]
    lower = (r >= c) & (c >= 0)
    below = (r - c)[lower]
    width = int(below.max()) + 1
    column = np.broadcast_to(c, lower.shape)[lower]
    band = np.asarray(np.bincount(below + column * width, stiffness[lower], size * width), float).reshape(size, width)
    if ground is not None:
        band[:, 0] += ground
    # On two threads the last digits differ, and meshes this small take several times the processor time.
    with _linear_algebra().limit(limits=1, user_api="blas"):
        _, moved, info = dpbsv(band.T, load, lower=1, overwrite_ab=1)
    if info:
        raise np.linalg.LinAlgError("the mesh is not held")
    return np.asarray(moved)
