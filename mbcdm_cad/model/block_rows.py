"""Direct solution of a mesh whose elements reach from one row of freedoms to the next at most.

Rows are planes of nodes of a grid. ``check`` solves row by row with numpy alone, because it must start fast; a program
that solves hundreds of meshes takes a third of the time with scipy's banded solver (:func:`many_meshes`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]
_many = ContextVar("many meshes", default=False)


@cache
def _linear_algebra(bands: bool) -> ThreadpoolController:
    """The libraries of linear algebra that are loaded, with ``bands`` that of scipy too: it has one of its own."""
    if bands:
        import scipy.linalg.lapack  # noqa: F401  see solve_by_bands
    return ThreadpoolController()


@contextmanager
def many_meshes() -> Iterator[None]:
    """Solve by bands within the block: loading scipy pays from the third mesh on. Results differ by rounding alone."""
    before = _many.set(True)
    try:
        yield
    finally:
        _many.reset(before)


def by_bands() -> bool:
    """Whether this is within :func:`many_meshes`."""
    return _many.get()


def solve_mesh(row: Ints, where: Ints, stiffness: Floats, load: Floats, ground: Floats | None = None) -> Floats:
    """Displacements (m, k) under the loads (m, k) of freedoms in the order of their ``row`` (m,).

    ``where`` (n, f): the freedoms of each element, below zero for those that are held; ``stiffness`` (n, f, f);
    ``ground`` (m,): springs to the base. Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    bands = by_bands()
    # On two threads the last digits differ, and meshes this small take several times the processor time.
    with _linear_algebra(bands).limit(limits=1, user_api="blas"):
        if bands:
            return solve_by_bands(where, stiffness, load, ground)
        return solve_by_rows(row, where, stiffness, load, ground)


def solve_by_bands(where: Ints, stiffness: Floats, load: Floats, ground: Floats | None = None) -> Floats:
    """As :func:`solve_mesh`, by LAPACK's Cholesky factors of a banded matrix."""
    from scipy.linalg.lapack import dpbsv  # takes longer to import than both meshes of a check to solve

    size = len(load)
    r, c = where[:, :, None], where[:, None, :]
    lower = (r >= c) & (c >= 0)
    below = (r - c)[lower]
    width = int(below.max()) + 1
    column = np.broadcast_to(c, lower.shape)[lower]
    band = np.asarray(np.bincount(below + column * width, stiffness[lower], size * width), float).reshape(size, width)
    if ground is not None:
        band[:, 0] += ground
    _, moved, info = dpbsv(band.T, load, lower=1, overwrite_ab=1)
    if info:
        raise np.linalg.LinAlgError("the mesh is not held")
    return np.asarray(moved)


def solve_by_rows(row: Ints, where: Ints, stiffness: Floats, load: Floats, ground: Floats | None = None) -> Floats:
    """As :func:`solve_mesh`, by eliminating row after row of a block tridiagonal matrix."""
    count = int(row[-1]) + 1
    start = np.searchsorted(row, np.arange(count + 1))
    size = np.diff(start)
    # One flat array holds, for each row, the block of its own freedoms beside that of the next row's.
    width = size + np.append(size[1:], 0)
    offset = np.concatenate([[0], np.cumsum(size * width)])
    place, entry = _entries(row, where, stiffness, offset[row] - start[row] * (width[row] + 1), width[row])
    flat = np.bincount(place, entry, offset[-1])
    if ground is not None:
        flat[offset[row] + (np.arange(len(row)) - start[row]) * (width[row] + 1)] += ground
    gains: list[Floats] = []
    rests: list[Floats] = []
    carried, carried_force = np.zeros((size[0], size[0])), np.zeros((size[0], load.shape[1]))
    for i in range(count):
        n = size[i]
        block = flat[offset[i] : offset[i + 1]].reshape(n, width[i])
        beside = block[:, n:]
        right = np.concatenate([beside, load[start[i] : start[i + 1]] + carried_force], axis=1)
        solved = np.linalg.solve(block[:, :n] + carried, right)
        gain, rest = solved[:, : width[i] - n], solved[:, width[i] - n :]
        gains.append(gain)
        rests.append(rest)
        carried, carried_force = -beside.T @ gain, -beside.T @ rest
    answer = np.zeros_like(load)
    following = np.zeros((0, load.shape[1]))
    for i in range(count - 1, -1, -1):
        following = rests[i] - gains[i] @ following
        answer[start[i] : start[i + 1]] = following
    return answer


def _entries(row: Ints, where: Ints, stiffness: Floats, shift: Ints, width: Ints) -> tuple[Ints, Floats]:
    """Flat places of the entries in a row's own block and in that beside it, and the entries.

    Entry (r, c) of a row lies at offset + (r - start) width + (c - start), that is ``shift`` + r ``width`` + c.
    """
    # Held freedoms are the last of all rows from the left, and the first from above: their entries fall away.
    held = where < 0
    of_row = row[where]
    kept = (of_row[:, :, None] <= of_row[:, None, :]) & ~held[:, :, None] & ~held[:, None, :]
    first = shift[where] + where * width[where]
    return (first[:, :, None] + where[:, None, :])[kept], stiffness[kept]
