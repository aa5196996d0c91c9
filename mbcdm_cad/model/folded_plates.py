"""Folded plates: rectangular flat shell elements on a coarse grid, solved plane by plane. Numpy only.

Each element is a four-node plate parallel to two axes: in its plane bilinear with two bending modes condensed out, out
of it Reissner-Mindlin with assumed shear strains, so that neither thin nor stubby plates lock. Six freedoms a node,
shared by all plates that meet there. Units: mm, N, MPa, rad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.model.block_rows import Ints, by_bands, solve_mesh
from mbcdm_cad.routes import Floats

# Corners of an element in its own (u, v), and the Gauss points.
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
_GAUSS = _CORNERS / np.sqrt(3.0)
# Couples the rotation about a plate's normal to its in-plane rotation: a share of G that keeps the matrix regular.
# Between 0.001 and 1 the windup of the reference frame changes by less than 2 %.
_DRILLING = 0.1
_SHEAR_FACTOR = 5.0 / 6.0


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
    """Stiffness (n, 24, 24) of plates with sides (n, 2), freedoms of a corner in the order (u, v, n, turn u, v, n)."""
    a, b = sides_mm.T
    count = len(a)
    shear = modulus_MPa / (2.0 * (1.0 + poisson))
    plane = modulus_MPa / (1.0 - poisson**2) * np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    su, sv = _CORNERS.T
    # Nine strains at each Gauss point: three in the plane, three of bending, two across, one of drilling.
    strain = np.zeros((count, len(_GAUSS), 9, 28))
    for k, (p, q) in enumerate(_GAUSS):
        du = (su * (1 + sv * q) / 4.0)[None, :] * 2.0 / a[:, None]
        dv = (sv * (1 + su * p) / 4.0)[None, :] * 2.0 / b[:, None]
        at = strain[:, k]
        at[:, 0, 0:24:6] = at[:, 2, 1:24:6] = du
        at[:, 1, 1:24:6] = at[:, 2, 0:24:6] = dv
        at[:, 0, 24] = at[:, 2, 25] = -4.0 * p / a
        at[:, 1, 27] = at[:, 2, 26] = -4.0 * q / b
        # Fibres rotate with the corner: u moves by + turn v, v by - turn u, for each mm along the normal.
        at[:, 3, 4:24:6], at[:, 5, 3:24:6] = du, -du
        at[:, 5, 4:24:6], at[:, 4, 3:24:6] = dv, -dv
        at[:, 6, 2:24:6], at[:, 6, 4:24:6] = (su * (1 + sv * q) / 4.0)[None, :] * 2.0 / a[:, None], (1 + sv * q) / 4.0
        at[:, 7, 2:24:6], at[:, 7, 3:24:6] = (sv * (1 + su * p) / 4.0)[None, :] * 2.0 / b[:, None], -(1 + su * p) / 4.0
        at[:, 8, 1:24:6], at[:, 8, 0:24:6] = du / 2.0, -dv / 2.0
        at[:, 8, 5:24:6] = -(1 + su * p) * (1 + sv * q) / 4.0
    law = np.zeros((count, 1, 9, 9))
    law[:, 0, 0:3, 0:3] = plane * thickness_mm[:, None, None]
    law[:, 0, 3:6, 3:6] = plane * (thickness_mm**3 / 12.0)[:, None, None]
    law[:, 0, 6, 6] = law[:, 0, 7, 7] = shear * _SHEAR_FACTOR * thickness_mm
    law[:, 0, 8, 8] = shear * _DRILLING * thickness_mm
    stress = (law * (a * b / 4.0)[:, None, None, None]) @ strain
    full = strain.reshape(count, -1, 28).transpose(0, 2, 1) @ stress.reshape(count, -1, 28)
    bow = full[:, 24:, 24:]
    return np.asarray(full[:, :24, :24] - full[:, :24, 24:] @ np.linalg.solve(bow, full[:, 24:, :24]))


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

    Planes of nodes across an axis are the rows of a block tridiagonal matrix. Raises ``numpy.linalg.LinAlgError`` if
    the plates are not held.
    """
    plane = _planes(plates)
    row = np.repeat(_ranks(plates, plane) if by_bands() else plane, 6)
    free = np.flatnonzero(~held)
    free = free[np.argsort(row[free], kind="stable")]
    number = np.full(len(load), -1)
    number[free] = np.arange(len(free))
    displacement = np.zeros(len(load))
    moved = solve_mesh(row[free], number[freedoms(plates)], element, load[free, None], ground[free])
    displacement[free] = moved[:, 0]
    return displacement


def _ranks(plates: Plates, plane: Ints) -> Ints:
    """Place (m,) of each node in the narrower band: in the order of its plane, or in that of Cuthill and McKee."""
    from scipy.sparse import coo_array  # only a search solves by bands, see solve_by_bands
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    corner, count = plates.corner, len(plane)
    one, other = (np.broadcast_to(c, (len(corner), 4, 4)).ravel() for c in (corner[:, :, None], corner[:, None, :]))
    joined = coo_array((np.ones(len(one), dtype=np.int8), (one, other)), shape=(count, count)).tocsr()
    orders = np.argsort(plane, kind="stable"), reverse_cuthill_mckee(joined, symmetric_mode=True)
    ranks = [np.argsort(order) for order in orders]
    return min(ranks, key=lambda rank: int(np.ptp(rank[corner], axis=1).max()))


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
