"""Plane stress on a mesh of quadrilaterals in rows: four-node elements with two bending modes, a direct solution.

The bending modes (incompatible modes with the gradients of the middle, Taylor, Beresford and Wilson 1976) let one
element across a spoke bend as a beam does. Units: mm, N, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbcdm_cad.model.block_rows import Ints, solve_mesh
from mbcdm_cad.routes import Floats

# Elements that are set up together: with more the arrays leave the processor's cache and take twice the time.
AT_ONCE = 1000
CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
GAUSS = CORNERS / np.sqrt(3.0)
# Weights of the corners (4 points, 4 corners) at the Gauss points.
AT_GAUSS = (1.0 + CORNERS * GAUSS[:, None]).prod(axis=2) / 4.0


@dataclass(frozen=True, eq=False)
class Elements:
    """Stiffness (n, 8, 8); at the Gauss points the strains (n, 4, 3, 8) that the corners' displacements cause, and the
    area (n, 4) that each stands for."""

    stiffness: Floats
    strain: Floats
    law: Floats
    area_mm2: Floats


def elements(node_mm: Floats, corner: Ints, thickness_mm: Floats, modulus_MPa: float, poisson: float) -> Elements:
    """Elements of a mesh: nodes (m, 2), corners (n, 4); a triangle repeats a corner. Freedoms (u, v) by corner."""
    law = plane_law(modulus_MPa, poisson)
    some = range(0, len(corner), AT_ONCE)
    found = [_some(node_mm, corner[k : k + AT_ONCE], thickness_mm[k : k + AT_ONCE], law) for k in some]
    stiffness, strain, area = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Elements(stiffness, strain, law, area)


def _some(node_mm: Floats, corner: Ints, thickness_mm: Floats, law: Floats) -> tuple[Floats, Floats, Floats]:
    """Stiffness, strain and area of some elements."""
    count = len(corner)
    triangle = corner[:, 2] == corner[:, 3]
    xy = node_mm[corner]
    middle = jacobian(xy, np.zeros((1, 2)))
    at = jacobian(xy, GAUSS)
    strains = np.zeros((count, 4, 3, 12))
    strains[:, :, 0, 0:8:2] = strains[:, :, 2, 1:8:2] = at.gradient_x
    strains[:, :, 1, 1:8:2] = strains[:, :, 2, 0:8:2] = at.gradient_y
    # The modes 1 - p^2 and 1 - q^2 with the gradients of the middle.
    p, q = -2.0 * GAUSS[:, 0] / at.det, -2.0 * GAUSS[:, 1] / at.det
    modes = ((8, middle.yq * p, -middle.xq * p), (10, -middle.yp * q, middle.xp * q))
    for k, bow_x, bow_y in modes:
        bow_x[triangle] = bow_y[triangle] = 0.0
        strains[:, :, 0, k] = strains[:, :, 2, k + 1] = bow_x
        strains[:, :, 1, k + 1] = strains[:, :, 2, k] = bow_y
    weight = at.det * thickness_mm[:, None]
    # All four points in one product: many small ones take longer.
    stressed = (law @ strains * weight[:, :, None, None]).reshape(count, 12, 12)
    full = strains.reshape(count, 12, 12).transpose(0, 2, 1) @ stressed
    inner = full[:, 8:, 8:] + np.where(triangle, 1.0, 0.0)[:, None, None] * np.eye(4)
    follow = -np.linalg.solve(inner, full[:, 8:, :8])
    stiffness = full[:, :8, :8] + full[:, :8, 8:] @ follow
    strain = strains.reshape(count, 12, 12)
    return stiffness, (strain[:, :, :8] + strain[:, :, 8:] @ follow).reshape(count, 4, 3, 8), at.det


def plane_law(modulus_MPa: float, poisson: float) -> Floats:
    """Stresses (x, y, shear) over strains (3, 3) of a thin body."""
    law = np.array([[1.0, poisson, 0.0], [poisson, 1.0, 0.0], [0.0, 0.0, (1.0 - poisson) / 2.0]])
    return np.asarray(law * modulus_MPa / (1.0 - poisson**2))


class Jacobian(NamedTuple):
    """At k points of each element: derivatives of x and y by p and q and their determinant (n, k); gradients (n, k, 4)
    of the corners' shape functions."""

    xp: Floats
    yp: Floats
    xq: Floats
    yq: Floats
    det: Floats
    gradient_x: Floats
    gradient_y: Floats


def jacobian(xy: Floats, points: Floats) -> Jacobian:
    """Of elements with corners (n, 4, 2) at ``points`` (k, 2) in (p, q)."""
    (p, q), (s, t) = points.T[:, :, None], CORNERS.T
    by_p, by_q = s * (1.0 + t * q) / 4.0, t * (1.0 + s * p) / 4.0
    xp, yp, xq, yq = (xy[:, :, axis] @ by.T for by in (by_p, by_q) for axis in (0, 1))
    det = xp * yq - yp * xq
    a, b, c, d = (part[:, :, None] for part in (xp / det, yp / det, xq / det, yq / det))
    return Jacobian(xp, yp, xq, yq, det, d * by_p - b * by_q, a * by_q - c * by_p)


def solve(corner: Ints, row: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Displacements (2 m, k) under the loads (2 m, k). ``row`` (m,) of each node, ascending.

    Elements reach from one row to the next at most. Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    return solve_mesh(np.repeat(row, 2), freedoms(corner), stiffness, load)


def freedoms(corner: Ints) -> Ints:
    """Freedoms (n, 8) of the corners."""
    return (2 * corner[:, :, None] + np.arange(2)).reshape(len(corner), 8)


def stresses_MPa(e: Elements, moved_mm: Floats) -> Floats:
    """Stresses (n, 4, 3) as (x, y, shear) at the Gauss points, the corners moved by ``moved_mm`` (n, 8)."""
    strain = e.strain.reshape(len(moved_mm), 12, 8) @ moved_mm[:, :, None]
    return np.asarray(strain.reshape(len(moved_mm), 4, 3) @ e.law)


def von_mises_MPa(stress_MPa: Floats) -> Floats:
    """Equivalent stress of stresses (..., 3)."""
    sx, sy, txy = np.moveaxis(stress_MPa, -1, 0)
    return np.asarray(np.sqrt(sx**2 - sx * sy + sy**2 + 3.0 * txy**2))
