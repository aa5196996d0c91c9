"""Plane stress on a mesh of quadrilaterals in rows: four-node elements with two bending modes, a direct solution.

The bending modes (incompatible modes with the gradients of the middle, Taylor, Beresford and Wilson 1976) let one
element across a spoke bend as a beam does. Units: mm, N, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]

_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
_GAUSS = _CORNERS / np.sqrt(3.0)


@dataclass(frozen=True, eq=False)
class Elements:
    """Stiffness (n, 8, 8), and the strains (n, 4, 3, 8) that the corners' displacements cause at the Gauss points."""

    stiffness: Floats
    strain: Floats
    law: Floats


def elements(node_mm: Floats, corner: Ints, thickness_mm: Floats, modulus_MPa: float, poisson: float) -> Elements:
    """Elements of a mesh: nodes (m, 2), corners (n, 4); a triangle repeats a corner. Freedoms (u, v) by corner."""
    law = np.array([[1.0, poisson, 0.0], [poisson, 1.0, 0.0], [0.0, 0.0, (1.0 - poisson) / 2.0]])
    law *= modulus_MPa / (1.0 - poisson**2)
    xy = node_mm[corner]
    count = len(corner)
    triangle = corner[:, 2] == corner[:, 3]
    _, centre = _jacobian(xy, (0.0, 0.0))
    centre_det = np.linalg.det(centre)
    inverse_centre = np.linalg.inv(centre)
    full = np.zeros((count, 12, 12))
    strains = np.zeros((count, 4, 3, 12))
    for k, (p, q) in enumerate(_GAUSS):
        shape, jacobian = _jacobian(xy, (p, q))
        det = np.linalg.det(jacobian)
        gradient = np.linalg.solve(jacobian, np.broadcast_to(shape, (count, 2, 4)))
        b = strains[:, k]
        b[:, 0, 0:8:2], b[:, 1, 1:8:2] = gradient[:, 0], gradient[:, 1]
        b[:, 2, 0:8:2], b[:, 2, 1:8:2] = gradient[:, 1], gradient[:, 0]
        for mode, by in enumerate(((-2.0 * p, 0.0), (0.0, -2.0 * q))):
            bow = (inverse_centre @ np.array(by)) * (centre_det / det)[:, None]
            bow[triangle] = 0.0
            at = 8 + 2 * mode
            b[:, 0, at], b[:, 1, at + 1] = bow[:, 0], bow[:, 1]
            b[:, 2, at], b[:, 2, at + 1] = bow[:, 1], bow[:, 0]
        full += b.transpose(0, 2, 1) @ (law @ b * (det * thickness_mm)[:, None, None])
    inner = full[:, 8:, 8:] + np.where(triangle, 1.0, 0.0)[:, None, None] * np.eye(4)
    follow = -np.linalg.solve(inner, full[:, 8:, :8])
    stiffness = full[:, :8, :8] + full[:, :8, 8:] @ follow
    return Elements(stiffness, strains[..., :8] + strains[..., 8:] @ follow[:, None], law)


def _jacobian(xy: Floats, at: tuple[float, float]) -> tuple[Floats, Floats]:
    """Derivatives (2, 4) of the shape functions, and d(x, y)/d(p, q) (n, 2, 2)."""
    (p, q), (s, t) = at, _CORNERS.T
    shape = np.stack([s * (1.0 + t * q), t * (1.0 + s * p)]) / 4.0
    return shape, shape @ xy


def solve(corner: Ints, row: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Displacements (2 m, k) under the loads (2 m, k). ``row`` (m,) of each node, ascending.

    Elements reach from one row to the next at most, so the matrix is block tridiagonal.
    Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    count = int(row[-1]) + 1
    start = np.searchsorted(row, np.arange(count + 1)) * 2
    size = np.diff(start)
    where = (2 * corner[:, :, None] + np.arange(2)).reshape(len(corner), 8)
    # One flat array holds, for each row, the block of its own freedoms beside that of the next row's.
    width = size + np.append(size[1:], 0)
    offset = np.concatenate([[0], np.cumsum(size * width)])
    of_row = np.repeat(np.arange(count), size)
    r, c = (np.broadcast_to(k, stiffness.shape).ravel() for k in (where[:, :, None], where[:, None, :]))
    upper = of_row[r] <= of_row[c]
    r, c, value = r[upper], c[upper], stiffness.ravel()[upper]
    own = of_row[r]
    flat = np.bincount(offset[own] + (r - start[own]) * width[own] + c - start[own], value, int(offset[-1]))
    answer = np.zeros_like(load)
    gains: list[Floats] = []
    rests: list[Floats] = []
    carried, carried_force = np.zeros((size[0], size[0])), np.zeros((size[0], load.shape[1]))
    for i in range(count):
        n = size[i]
        block = flat[offset[i] : offset[i + 1]].reshape(n, width[i])
        beside = block[:, n:]
        right = np.column_stack([beside, load[start[i] : start[i + 1]] + carried_force])
        solved = np.linalg.solve(block[:, :n] + carried, right)
        gain, rest = solved[:, : width[i] - n], solved[:, width[i] - n :]
        gains.append(gain)
        rests.append(rest)
        carried, carried_force = -beside.T @ gain, -beside.T @ rest
    following = np.zeros((0, load.shape[1]))
    for i in range(count - 1, -1, -1):
        following = rests[i] - gains[i] @ following
        answer[start[i] : start[i + 1]] = following
    return answer


def stresses_MPa(e: Elements, corner: Ints, displacement: Floats) -> Floats:
    """Stresses (n, 4, 3) as (x, y, shear) at the Gauss points under displacements (2 m,)."""
    local = displacement[(2 * corner[:, :, None] + np.arange(2)).reshape(len(corner), 8)]
    return np.asarray(np.einsum("ab,nkbc,nc->nka", e.law, e.strain, local))


def von_mises_MPa(stress_MPa: Floats) -> Floats:
    """Equivalent stress of stresses (..., 3)."""
    sx, sy, txy = np.moveaxis(stress_MPa, -1, 0)
    return np.asarray(np.sqrt(sx**2 - sx * sy + sy**2 + 3.0 * txy**2))
