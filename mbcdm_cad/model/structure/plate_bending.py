"""Bending of a plate on a mesh of quadrilaterals: four-node elements, also beside the plane of their freedoms.

Reissner-Mindlin with shear strains assumed from the middles of the edges (Bathe and Dvorkin 1985), so that neither thin
nor stubby plates lock; a triangle repeats a corner. Freedoms of a node: deflection w along the normal, and how fast its
fibres lean (a, b): a point at the height h above the plane moves in it by (u, v) + h (a, b). Units: mm, N, MPa.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbcdm_cad.model.block_rows import Ints, solve_mesh
from mbcdm_cad.model.structure.plane_stress import GAUSS, jacobian, plane_law
from mbcdm_cad.routes import Floats

_SHEAR_FACTOR = 5.0 / 6.0
# Freedoms of a node (u, v, w, a, b); the first that leans; those that lean of an element's (n, 20).
FREEDOMS, LEAN = 5, 3
LEANS = 8 + np.array([1, 2, 4, 5, 7, 8, 10, 11])


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


class Freedoms(NamedTuple):
    """Freedoms of the corners of n elements: in the plane (n, 8), of the plates (n, 12), both (n, 20)."""

    in_plane: Ints
    of_plate: Ints
    all: Ints


def freedoms(corner: Ints) -> Freedoms:
    """Of nodes that move in the plane and lean: (u, v, w, a, b)."""
    first = FREEDOMS * corner[:, :, None]
    flat, plate = ((first + k).reshape(len(corner), -1) for k in (np.arange(LEAN - 1), np.arange(LEAN - 1, FREEDOMS)))
    return Freedoms(flat, plate, np.concatenate([flat, plate], axis=1))


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


def bend(corner: Ints, row: Ints, stiffness: Floats, load: Floats) -> Floats:
    """Freedoms (5 m, k) under the loads (5 m, k); as :func:`~mbcdm_cad.model.structure.plane_stress.solve`."""
    return solve_mesh(np.repeat(row, FREEDOMS), freedoms(corner).all, stiffness, load)
