"""Folded plates: rectangular flat shell elements on a coarse grid, solved plane by plane.

Each element is a four-node plate parallel to two axes: in its plane bilinear with two bending modes condensed out, out
of it Reissner-Mindlin with assumed shear strains, so that neither thin nor stubby plates lock. Six freedoms a node,
shared by all plates that meet there. Units: mm, N, MPa, rad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.model.block_rows import Ints, solve_mesh
from mbcdm_cad.model.structure.quadrilateral import AT_GAUSS, CORNERS, GAUSS, elements, jacobian, plate_elements
from mbcdm_cad.routes import Floats

# Couples the rotation about a plate's normal to its in-plane rotation: a share of G that keeps the matrix regular.
# Between 0.001 and 1 the windup of the reference frame changes by less than 2 %.
_DRILLING = 0.1


@dataclass(frozen=True, eq=False)
class Plates:
    """Elements: corner nodes (n, 4) counted from the lower corner anticlockwise in (u, v), axis of the normal,
    thickness and the panel each belongs to. All panels share the planes of one grid."""

    node_mm: Floats
    corner: Ints
    normal: Ints
    thickness_mm: Floats
    panel: Ints


def stiffness(sides_mm: Floats, thickness_mm: Floats, modulus_MPa: float, poisson: float) -> Floats:
    """Stiffness (n, 24, 24) of plates with sides (n, 2), freedoms of a corner in the order (u, v, n, turn u, v, n).

    The rotation about the normal is coupled to that of the plate in its own plane.
    """
    count = len(sides_mm)
    corner = np.arange(4 * count).reshape(count, 4)
    node = (sides_mm[:, None] * (CORNERS + 1.0) / 2.0).reshape(-1, 2)
    body = node, corner, thickness_mm, modulus_MPa, poisson
    freedom = np.arange(24).reshape(4, 6)
    in_plane = freedom[:, :2].ravel()
    # Fibres lean with the corner: u moves by + turn v, v by - turn u, for each mm along the normal.
    leaning, sign = freedom[:, [2, 4, 3]].ravel(), np.tile([1.0, 1.0, -1.0], 4)
    whole = np.zeros((count, 24, 24))
    whole[:, in_plane[:, None], in_plane] = elements(*body).stiffness
    whole[:, leaning[:, None], leaning] = plate_elements(*body).stiffness * np.outer(sign, sign)
    at = jacobian(node[corner], GAUSS)
    turn = np.zeros((count, 4, 24))
    turn[:, :, 1::6], turn[:, :, 0::6], turn[:, :, 5::6] = at.gradient_x / 2.0, -at.gradient_y / 2.0, -AT_GAUSS
    drilling = modulus_MPa / (2.0 * (1.0 + poisson)) * _DRILLING * thickness_mm[:, None] * at.det
    return np.asarray(whole + turn.transpose(0, 2, 1) @ (turn * drilling[:, :, None]))


def freedoms(plates: Plates) -> Ints:
    """Global freedoms (n, 24) of each element: 6 node + (x, y, z, turn x, y, z)."""
    # (u, v, n) is a cyclic turn of (x, y, z).
    axes = (plates.normal[:, None] + np.array([1, 2, 0])) % 3
    local = np.concatenate([axes, axes + 3], axis=1)
    return np.asarray((6 * plates.corner[:, :, None] + local[:, None, :]).reshape(len(axes), 24))


def sides(plates: Plates) -> Floats:
    """Lengths (n, 2) of each element along its u and v."""
    diagonal = plates.node_mm[plates.corner[:, 2]] - plates.node_mm[plates.corner[:, 0]]
    axes = (plates.normal[:, None] + np.array([1, 2])) % 3
    return np.take_along_axis(diagonal, axes, axis=1)


def solve(plates: Plates, element: Floats, held: NDArray[np.bool_], ground: Floats, load: Floats) -> Floats:
    """Displacements (6 m,) under ``load`` (6 m,); ``held`` freedoms stay zero, ``ground`` are springs to the base.

    Nodes are numbered by their planes across an axis, which gives a narrow band. Raises ``numpy.linalg.LinAlgError`` if
    the plates are not held.
    """
    row = np.repeat(_planes(plates), 6)
    free = np.flatnonzero(~held)
    free = free[np.argsort(row[free], kind="stable")]
    number = np.full(len(load), -1)
    number[free] = np.arange(len(free))
    displacement = np.zeros(len(load))
    moved = solve_mesh(number[freedoms(plates)], element, load[free, None], ground[free])
    displacement[free] = moved[:, 0]
    return displacement


def _planes(plates: Plates) -> Ints:
    """The plane (m,) of each node across the axis whose planes are solved with the least work.

    Elements reach from one plane to the next at most.
    """
    best, least = np.zeros(0, dtype=np.int64), np.inf
    for at in plates.node_mm.T:
        _, plane = np.unique(at.round(9), return_inverse=True)
        reach = plane[plates.corner]
        size = np.bincount(plane).astype(float)
        work = float((size * (size + np.append(size[1:], 0.0)) ** 2).sum())
        if work < least and (reach.max(axis=1) - reach.min(axis=1) <= 1).all():
            best, least = plane, work
    return best
