"""Plane stress on a mesh of quadrilaterals in rows: four-node elements with two bending modes, a direct solution.

The bending modes (incompatible modes with the gradients of the middle, Taylor, Beresford and Wilson 1976) let one
element across a spoke bend as a beam does. Units: mm, N, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.model.block_rows import Ints, solve_by_rows
from mbcdm_cad.routes import Floats

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
    inverse_centre, centre_det = _inverse(centre)
    strains = np.zeros((count, 4, 3, 12))
    weight = np.empty((count, 4))
    for k, (p, q) in enumerate(_GAUSS):
        shape, jacobian = _jacobian(xy, (p, q))
        inverse, det = _inverse(jacobian)
        weight[:, k] = det * thickness_mm
        gradient = inverse @ shape
        b = strains[:, k]
        b[:, 0, 0:8:2], b[:, 1, 1:8:2] = gradient[:, 0], gradient[:, 1]
        b[:, 2, 0:8:2], b[:, 2, 1:8:2] = gradient[:, 1], gradient[:, 0]
        for mode, by in enumerate(((-2.0 * p, 0.0), (0.0, -2.0 * q))):
            bow = (inverse_centre @ np.array(by)) * (centre_det / det)[:, None]
            bow[triangle] = 0.0
            at = 8 + 2 * mode
            b[:, 0, at], b[:, 1, at + 1] = bow[:, 0], bow[:, 1]
            b[:, 2, at], b[:, 2, at + 1] = bow[:, 1], bow[:, 0]
    # All four points in one product: many small ones take longer.
    stressed = (law @ strains * weight[:, :, None, None]).reshape(count, 12, 12)
    full = strains.reshape(count, 12, 12).transpose(0, 2, 1) @ stressed
    inner = full[:, 8:, 8:] + np.where(triangle, 1.0, 0.0)[:, None, None] * np.eye(4)
    follow = -np.linalg.solve(inner, full[:, 8:, :8])
    stiffness = full[:, :8, :8] + full[:, :8, 8:] @ follow
    strain = strains.reshape(count, 12, 12)
    return Elements(stiffness, (strain[:, :, :8] + strain[:, :, 8:] @ follow).reshape(count, 4, 3, 8), law)


def _inverse(jacobian: Floats) -> tuple[Floats, Floats]:
    """Inverses (n, 2, 2) and determinants (n,)."""
    (a, b), (c, d) = jacobian[:, 0].T, jacobian[:, 1].T
    det = a * d - b * c
    return np.stack([d, -b, -c, a], axis=1).reshape(-1, 2, 2) / det[:, None, None], det


def _jacobian(xy: Floats, at: tuple[float, float]) -> tuple[Floats, Floats]:
    """Derivatives (2, 4) of the shape functions, and d(x, y)/d(p, q) (n, 2, 2)."""
    (p, q), (s, t) = at, _CORNERS.T
    shape = np.stack([s * (1.0 + t * q), t * (1.0 + s * p)]) / 4.0
    return shape, shape @ xy


def solve(corner: Ints, row: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Displacements (2 m, k) under the loads (2 m, k). ``row`` (m,) of each node, ascending.

    Elements reach from one row to the next at most. Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    return solve_by_rows(np.repeat(row, 2), _freedoms(corner), stiffness, load)


def _freedoms(corner: Ints) -> Ints:
    """Freedoms (n, 8) of the corners."""
    return (2 * corner[:, :, None] + np.arange(2)).reshape(len(corner), 8)


def stresses_MPa(e: Elements, corner: Ints, displacement: Floats) -> Floats:
    """Stresses (n, 4, 3) as (x, y, shear) at the Gauss points under displacements (2 m,)."""
    local = displacement[_freedoms(corner)]
    strain = e.strain.reshape(len(local), 12, 8) @ local[:, :, None]
    return np.asarray(strain.reshape(len(local), 4, 3) @ e.law)


def von_mises_MPa(stress_MPa: Floats) -> Floats:
    """Equivalent stress of stresses (..., 3)."""
    sx, sy, txy = np.moveaxis(stress_MPa, -1, 0)
    return np.asarray(np.sqrt(sx**2 - sx * sy + sy**2 + 3.0 * txy**2))
