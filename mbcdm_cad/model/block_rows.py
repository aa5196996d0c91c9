"""Direct solution of a mesh whose elements reach from one row of freedoms to the next at most: planes of a grid."""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]


def _lapack() -> Any:
    """LAPACK as scipy.linalg has it, without that package, whose import takes as long as twenty meshes."""
    name = "scipy.linalg._flapack"
    spec = PathFinder.find_spec(name, [str(Path(scipy.__file__).with_name("linalg"))])
    if name in sys.modules or spec is None or spec.loader is None:
        return import_module("scipy.linalg.lapack")
    found = sys.modules[name] = module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


dpbsv = _lapack().dpbsv


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
