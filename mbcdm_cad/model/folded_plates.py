"""Folded plates: rectangular flat shell elements on a coarse grid, solved plane by plane along x. Numpy only.

Each element is a four-node plate parallel to two axes: in its plane bilinear with two bending modes condensed out, out
of it Reissner-Mindlin with assumed shear strains, so that neither thin nor stubby plates lock. Six freedoms a node,
shared by all plates that meet there. Units: mm, N, MPa, rad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.routes import Floats

Ints = NDArray[np.int64]

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
    thickness and the panel each belongs to. ``node_mm`` (m, 3) must be sorted by x."""

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
    area = a * b / 4.0
    full = np.zeros((count, 28, 28))
    su, sv = _CORNERS.T

    def add(strain: Floats, law: Floats, thickness: Floats) -> None:
        full[:] += strain.transpose(0, 2, 1) @ (law @ strain * (area * thickness)[:, None, None])

    for p, q in _GAUSS:
        du = (su * (1 + sv * q) / 4.0)[None, :] * 2.0 / a[:, None]
        dv = (sv * (1 + su * p) / 4.0)[None, :] * 2.0 / b[:, None]
        shape = (1 + su * p) * (1 + sv * q) / 4.0
        membrane = np.zeros((count, 3, 28))
        membrane[:, 0, 0:24:6], membrane[:, 1, 1:24:6] = du, dv
        membrane[:, 2, 0:24:6], membrane[:, 2, 1:24:6] = dv, du
        bow_u, bow_v = -4.0 * p / a, -4.0 * q / b
        membrane[:, 0, 24] = membrane[:, 2, 25] = bow_u
        membrane[:, 1, 27] = membrane[:, 2, 26] = bow_v
        add(membrane, plane, thickness_mm)
        # Fibres rotate with the corner: u moves by + turn v, v by - turn u, for each mm along the normal.
        bending = np.zeros((count, 3, 28))
        bending[:, 0, 4:24:6], bending[:, 1, 3:24:6] = du, -dv
        bending[:, 2, 4:24:6], bending[:, 2, 3:24:6] = dv, -du
        add(bending, plane, thickness_mm**3 / 12.0)
        across = np.zeros((count, 2, 28))
        across[:, 0, 2:24:6] = (su * (1 + sv * q) / 4.0)[None, :] * 2.0 / a[:, None]
        across[:, 0, 4:24:6] = (1 + sv * q) / 4.0
        across[:, 1, 2:24:6] = (sv * (1 + su * p) / 4.0)[None, :] * 2.0 / b[:, None]
        across[:, 1, 3:24:6] = -(1 + su * p) / 4.0
        add(across, shear * np.eye(2), _SHEAR_FACTOR * thickness_mm)
        drilling = np.zeros((count, 1, 28))
        drilling[:, 0, 1:24:6], drilling[:, 0, 0:24:6] = du / 2.0, -dv / 2.0
        drilling[:, 0, 5:24:6] = -shape
        add(drilling, _DRILLING * shear * np.eye(1), thickness_mm)
    bow = full[:, 24:, 24:]
    return full[:, :24, :24] - full[:, :24, 24:] @ np.linalg.solve(bow, full[:, 24:, :24])


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

    Elements reach from one plane of nodes to the next at most, so the matrix is block tridiagonal along x.
    Raises ``numpy.linalg.LinAlgError`` if the plates are not held.
    """
    x = plates.node_mm[:, 0]
    plane = np.concatenate([[0], np.cumsum(np.diff(x) > 1e-9)])
    last = int(plane[-1])
    start = np.searchsorted(plane, np.arange(last + 2)) * 6
    size = np.diff(start)
    where = freedoms(plates)
    first = plane[plates.corner].min(axis=1)
    displacement = np.zeros(len(load))
    force = np.where(held, 0.0, load)
    steps: list[tuple[Floats, Floats]] = []
    carried, carried_load = np.zeros((size[0], size[0])), np.zeros(size[0])
    for i in range(last + 1):
        own = size[i] + (size[i + 1] if i < last else 0)
        block = np.zeros((own, own))
        chosen = first == i
        local = where[chosen] - start[i]
        np.add.at(block, (local[:, :, None], local[:, None, :]), element[chosen])
        free = ~held[start[i] : start[i] + own]
        block *= free[:, None] & free[None, :]
        n = size[i]
        own_block = block[:n, :n] + carried + np.diag(ground[start[i] : start[i + 1]] + ~free[:n])
        right = force[start[i] : start[i + 1]] + carried_load
        answer = np.linalg.solve(own_block, np.column_stack([block[:n, n:], right]))
        gain, rest = answer[:, :-1], answer[:, -1]
        steps.append((gain, rest))
        carried = block[n:, n:] - block[n:, :n] @ gain
        carried_load = -block[n:, :n] @ rest
    for i in range(last, -1, -1):
        gain, rest = steps[i]
        following = displacement[start[i + 1] : start[i + 1] + gain.shape[1]]
        displacement[start[i] : start[i + 1]] = rest - gain @ following
    return displacement
