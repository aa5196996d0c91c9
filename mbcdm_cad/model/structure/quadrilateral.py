"""Quadrilaterals of plane stress and of plates in bending, and the solution of a mesh of them in rows.

In the plane four-node elements with two bending modes (incompatible modes with the gradients of the middle, Taylor,
Beresford and Wilson 1976), which let one element across a spoke bend as a beam does. Out of it Reissner-Mindlin with
shear strains assumed from the middles of the edges (Bathe and Dvorkin 1985), so that neither thin nor stubby plates
lock. A triangle repeats a corner. Freedoms of a node: (u, v) in the plane, the deflection w along the normal, and how
fast its fibres lean (a, b): a point at the height h above the plane moves in it by (u, v) + h (a, b). Units: mm, N,
MPa.
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpbsv
from threadpoolctl import ThreadpoolController

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]


@cache
def linear_algebra() -> ThreadpoolController:
    """The libraries of linear algebra that are loaded: numpy and scipy have one each."""
    return ThreadpoolController()


def solve_mesh(where: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Displacements (m, k) under the loads (m, k), by LAPACK's Cholesky factors of a banded matrix.

    ``where`` (n, f): the freedoms of each element, numbered row by row, below zero for those that are held;
    ``stiffness`` (n, f, f). Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    size = len(load)
    r, c = where[:, :, None], where[:, None, :]
    lower = (r >= c) & (c >= 0)
    below = (r - c)[lower]
    width = int(below.max()) + 1
    column = np.broadcast_to(c, lower.shape)[lower]
    band = np.asarray(np.bincount(below + column * width, stiffness[lower], size * width), float).reshape(size, width)
    # On two threads the last digits differ, and meshes this small take several times the processor time.
    with linear_algebra().limit(limits=1, user_api="blas"):
        _, moved, info = dpbsv(band.T, load, lower=1, overwrite_ab=1)
    if info:
        raise np.linalg.LinAlgError("the mesh is not held")
    return np.asarray(moved)


# Elements that are set up together: with more the arrays leave the processor's cache and take twice the time.
AT_ONCE = 1000
CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
GAUSS = CORNERS / np.sqrt(3.0)
# Weights of the corners (4 points, 4 corners) at the Gauss points.
AT_GAUSS = (1.0 + CORNERS * GAUSS[:, None]).prod(axis=2) / 4.0
_SHEAR_FACTOR = 5.0 / 6.0
# Freedoms of a node (u, v, w, a, b); the first that leans; those that lean of an element's (n, 20).
FREEDOMS, LEAN = 5, 3
LEANS = 8 + np.array([1, 2, 4, 5, 7, 8, 10, 11])


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


def solve(corner: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Freedoms (f m, k) under the loads (f m, k) of elements (n, 4 f, 4 f), whose nodes are numbered row by row.

    Elements reach from one row to the next at most. Raises ``numpy.linalg.LinAlgError`` if the mesh is not held.
    """
    return solve_mesh(freedoms(corner, stiffness.shape[1] // 4), stiffness, load)


def freedoms(corner: Ints, each: int) -> Ints:
    """Freedoms (n, 4 ``each``) of elements whose nodes have two in the plane, or five: the eight in the plane first."""
    first = each * corner[:, :, None]
    groups = (np.arange(LEAN - 1), np.arange(LEAN - 1, each))
    return np.concatenate([(first + own).reshape(len(corner), -1) for own in groups], axis=1)


def stresses_MPa(e: Elements, moved_mm: Floats) -> Floats:
    """Stresses (n, 4, 3) as (x, y, shear) at the Gauss points, the corners moved by ``moved_mm`` (n, 8)."""
    strain = e.strain.reshape(len(moved_mm), 12, 8) @ moved_mm[:, :, None]
    return np.asarray(strain.reshape(len(moved_mm), 4, 3) @ e.law)


def von_mises_MPa(stress_MPa: Floats) -> Floats:
    """Equivalent stress of stresses (..., 3)."""
    sx, sy, txy = np.moveaxis(stress_MPa, -1, 0)
    return np.asarray(np.sqrt(sx**2 - sx * sy + sy**2 + 3.0 * txy**2))


@dataclass(frozen=True, eq=False)
class PlateElements:
    """Stiffness (n, 12, 12), and curvatures (n, 4, 3, 12) at the Gauss points, by the freedoms of an element."""

    stiffness: Floats
    curvature: Floats


def plate_elements(
    node_mm: Floats, corner: Ints, thickness_mm: Floats, modulus_MPa: float, poisson: float
) -> PlateElements:
    """Elements of a mesh: nodes (m, 2), corners (n, 4), thickness (n,). Freedoms (w, a, b) by corner."""
    count, xy = len(corner), node_mm[corner]
    at = jacobian(xy, GAUSS)
    curvature = np.zeros((count, 4, 3, 12))
    curvature[:, :, 0, 1::3] = curvature[:, :, 2, 2::3] = at.gradient_x
    curvature[:, :, 1, 2::3] = curvature[:, :, 2, 1::3] = at.gradient_y
    # Shear along each edge from its first corner to its second, in the parent's coordinates.
    edges = {}
    for one, other in ((0, 1), (3, 2), (0, 3), (1, 2)):
        edge = np.zeros((count, 12))
        edge[:, 3 * one] += -0.5
        edge[:, 3 * other] += 0.5
        step = (xy[:, other] - xy[:, one]) / 4.0
        for k in (one, other):
            edge[:, 3 * k + 1 : 3 * k + 3] += step
        edges[one, other] = edge
    p, q = GAUSS.T[:, None, :, None]
    along = (1.0 - q) / 2.0 * edges[0, 1][:, None] + (1.0 + q) / 2.0 * edges[3, 2][:, None]
    across = (1.0 - p) / 2.0 * edges[0, 3][:, None] + (1.0 + p) / 2.0 * edges[1, 2][:, None]
    xp, yp, xq, yq = ((k / at.det)[:, :, None] for k in (at.xp, at.yp, at.xq, at.yq))
    shear = np.stack([yq * along - yp * across, xp * across - xq * along], axis=2)
    bends = plane_law(modulus_MPa, poisson) * (thickness_mm**3 / 12.0)[:, None, None]
    shears = _SHEAR_FACTOR * modulus_MPa / (2.0 * (1.0 + poisson)) * thickness_mm
    stiffness = _product(curvature, bends[:, None] @ curvature * at.det[:, :, None, None])
    stiffness += _product(shear, shear * (shears[:, None] * at.det)[:, :, None, None])
    return PlateElements(stiffness, curvature)


def _product(left: Floats, right: Floats) -> Floats:
    """Sum over points and strains of left (n, 4, s, 12) times right."""
    count = len(left)
    return np.asarray(left.reshape(count, -1, 12).transpose(0, 2, 1) @ right.reshape(count, -1, 12))


def eccentric(flat: Floats, plate: Floats, height_mm: Floats) -> Floats:
    """Stiffness (n, 20, 20) of elements whose middles lie ``height_mm`` (n,) above the plane of the freedoms.

    From their own in the plane (n, 8, 8) and as plates (n, 12, 12): their middles move by (u, v) + height (a, b).
    """
    whole = np.zeros((len(flat), 20, 20))
    whole[:, :8, :8], whole[:, 8:, 8:] = flat, plate
    beside = flat * height_mm[:, None, None]
    whole[:, :8, LEANS], whole[:, LEANS, :8] = beside, beside
    whole[:, LEANS[:, None], LEANS] += beside * height_mm[:, None, None]
    return whole
