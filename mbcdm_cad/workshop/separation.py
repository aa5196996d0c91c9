"""Prove from triangle meshes that two bodies do not touch, in a hundredth of the time of a boolean.

Two surfaces within known distances of their meshes cannot touch if the meshes are further apart than the sum of these
distances. The proof works in one direction only: bodies that are not proven apart need not overlap. Triangles are
sorted into a tree of bounding boxes, and two trees are traversed together (Ericson, Real-Time Collision Detection,
2005, chapters 5 and 6, for the distances and the traversal).
"""

from collections.abc import Sequence
from functools import cached_property
from math import ceil, log2

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.parts.bill import Placement, Vector
from mbcdm_cad.routes.curves import Piece
from mbcdm_cad.storage.compiled import COMPILED, compiled
from mbcdm_cad.workshop.trianglemesh import FloatArray, TriangleMesh

Triangle = tuple[Vector, Vector, Vector]

# The deviation of a mesh is sampled; samples miss up to 1.5 % of the greatest error.
_DEVIATION_FACTOR = 1.05
_ROUNDING_MM = 1e-4
LEAF = 4
_WIRE_STEP_MM = 0.1


class Surface:
    """A triangle mesh or a line of short pieces, with the distance within which the true surface or line lies.

    ``corners_mm`` (m, 3, 3): of a line, the second and third corner are one point.
    """

    def __init__(self, corners_mm: FloatArray, within_mm: float, wire: bool = False) -> None:
        self.corners_mm = np.ascontiguousarray(corners_mm)
        self.within_mm = within_mm
        self.wire = wire

    @classmethod
    def of_mesh(cls, mesh: TriangleMesh) -> "Surface":
        """The surface of a solid."""
        return cls(mesh.corners_mm, _DEVIATION_FACTOR * mesh.deviation_mm + _ROUNDING_MM)

    @classmethod
    def of_rod(cls, pieces: Sequence[Piece], radius_mm: float) -> "Surface":
        """A rod of ``radius_mm`` along ``pieces`` of a centre line: the line in chords, all within the radius."""
        chords, sagitta = [], 0.0
        for piece in pieces:
            count = max(1, ceil(piece.length_mm / _WIRE_STEP_MM))
            # Every second point is the middle of a chord, from which a circle, helix or parabola is farthest there.
            points = piece.points(np.linspace(0.0, 1.0, 2 * count + 1))
            start, middle, end = points[:-1:2], points[1::2], points[2::2]
            chords.append(np.stack([start, end, end], axis=1))
            sagitta = max(sagitta, float(np.linalg.norm(middle - (start + end) / 2.0, axis=1).max()))
        return cls(np.concatenate(chords), radius_mm + sagitta + _ROUNDING_MM, wire=True)

    @cached_property
    def tree(self) -> tuple[FloatArray, FloatArray]:
        """Corners in the order of the tree, and the boxes (low, high) of its nodes, (n, 2, 3).

        A full binary tree as in a heap: the children of node k are 2 k + 1 and 2 k + 2, and each node of the last level
        holds ``LEAF`` consecutive triangles. The last triangle is repeated to fill the level.
        """
        low, high = self.corners_mm.min(axis=1), self.corners_mm.max(axis=1)
        order = np.argsort(_morton_code(low + high), kind="stable")
        leaves = 1 << max(0, ceil(log2(len(order) / LEAF)))
        order = np.pad(order, (0, leaves * LEAF - len(order)), mode="edge")
        rows = [np.stack([low[order].reshape(leaves, LEAF, 3).min(1), high[order].reshape(leaves, LEAF, 3).max(1)], 1)]
        while len(rows[0]) > 1:
            pairs = rows[0].reshape(-1, 2, 2, 3)
            rows.insert(0, np.stack([pairs[:, :, 0].min(axis=1), pairs[:, :, 1].max(axis=1)], axis=1))
        return np.ascontiguousarray(self.corners_mm[order]), np.concatenate(rows)


def prepare() -> None:
    """Load the compiled code, or compile it, once before processes are forked and not in each of them."""
    box = Surface(np.eye(3)[None], 0.0)
    apart(box, box, Placement.translation(9.0, 0.0, 0.0))


def _morton_code(middles: FloatArray) -> NDArray[np.int64]:
    """Morton codes of points (n, 3), the interleaved bits of x, y, z: near points have near codes."""
    low = middles.min(axis=0)
    span = float((middles.max(axis=0) - low).max())
    cells = ((middles - low) * (1023.0 / span if span > 0.0 else 0.0)).astype(np.int64)
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        cells = (cells | (cells << shift)) & mask
    code: NDArray[np.int64] = cells[:, 0] | (cells[:, 1] << 1) | (cells[:, 2] << 2)
    return code


def apart(first: Surface, second: Surface, placement: Placement, crossed_only: bool = False) -> bool:
    """Whether the two bodies are proven not to touch; ``placement`` leads from the second's frame to the first's.

    ``second`` must be the mesh of a closed surface; ``first`` may be a rod. False also where nothing is proven. With
    ``crossed_only`` one may lie inside the other.
    """
    if not COMPILED:  # in plain Python the proof takes longer than the boolean that it avoids
        return False
    corners, boxes = first.tree
    others, other_boxes = second.tree
    rotation, shift = np.ascontiguousarray(placement.rotation), placement.shift_mm
    limit = first.within_mm + second.within_mm
    if _near(corners, boxes, others, other_boxes, rotation, shift, limit, first.wire):
        return False
    if crossed_only:
        return True
    # The surfaces are apart: one body lies completely outside or completely inside the other, as any point of it shows.
    if _winds_round(second.corners_mm, rotation.T @ (first.corners_mm[0, 0] - shift)):
        return False
    return first.wire or not _winds_round(first.corners_mm, rotation @ others[0, 0] + shift)


@compiled
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _less(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def _plus(a: Vector, b: Vector, factor: float) -> Vector:
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@compiled
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def _clamped(value: float) -> float:
    return min(max(value, 0.0), 1.0)


@compiled
def _segments_squared(p1: Vector, q1: Vector, p2: Vector, q2: Vector) -> float:
    """Squared distance of two segments, either of which may be a point."""
    d1, d2, r = _less(q1, p1), _less(q2, p2), _less(p1, p2)
    a, e, f, c = _dot(d1, d1), _dot(d2, d2), _dot(d2, r), _dot(d1, r)
    s = t = 0.0
    if a > 0.0 and e > 0.0:
        b = _dot(d1, d2)
        denominator = a * e - b * b
        # Parallel segments have no unique nearest pair; any start is valid, since both ends are clamped below.
        s = _clamped((b * f - c * e) / denominator) if denominator > 1e-12 * a * e else 0.0
        t = (b * s + f) / e
        if t < 0.0:
            t, s = 0.0, _clamped(-c / a)
        elif t > 1.0:
            t, s = 1.0, _clamped((b - c) / a)
    elif a > 0.0:
        s = _clamped(-c / a)
    elif e > 0.0:
        t = _clamped(f / e)
    gap = _less(_plus(p1, d1, s), _plus(p2, d2, t))
    return _dot(gap, gap)


@compiled
def _segment_triangle_near(p: Vector, q: Vector, triangle: Triangle, normal: Vector, squared: float) -> bool:
    """Whether a segment crosses the interior of a triangle, edges excluded, or has an end nearer to it than the limit.

    ``normal`` is that of the triangle, of any length, not zero; ``squared`` the square of the distance.
    """
    size = _dot(normal, normal)
    high, low = _dot(_less(p, triangle[0]), normal), _dot(_less(q, triangle[0]), normal)
    crossed = high != low and min(high, low) <= 0.0 <= max(high, low)  # their product may vanish beside zero
    if crossed and _over(_plus(p, _less(q, p), high / (high - low)), triangle, normal):
        return True
    # The foot of the perpendicular is within the triangle; nearest points on edges are found edge by edge.
    if high * high <= squared * size and _over(p, triangle, normal):
        return True
    return low * low <= squared * size and _over(q, triangle, normal)


@compiled
def _over(p: Vector, triangle: Triangle, normal: Vector) -> bool:
    """Whether the foot of the perpendicular from ``p`` lies within the triangle."""
    a, b, c = triangle
    return (
        _dot(_cross(_less(b, a), _less(p, a)), normal) >= 0.0
        and _dot(_cross(_less(c, b), _less(p, b)), normal) >= 0.0
        and _dot(_cross(_less(a, c), _less(p, c)), normal) >= 0.0
    )


@compiled
def _beyond(normal: Vector, origin: Vector, triangle: Triangle, limit: float) -> bool:
    """Whether three points lie on one side of a plane, further from it than ``limit``."""
    a, b, c = triangle
    reach = limit * _dot(normal, normal) ** 0.5
    x, y, z = _dot(_less(a, origin), normal), _dot(_less(b, origin), normal), _dot(_less(c, origin), normal)
    return bool(min(x, y, z) > reach or max(x, y, z) < -reach)


@compiled
def _corner(triangle: FloatArray, k: int) -> Vector:
    return triangle[k, 0], triangle[k, 1], triangle[k, 2]


@compiled
def _triangles_near(first: FloatArray, second: FloatArray, limit: float, wire: bool) -> bool:
    """Whether two triangles, or a segment (first and second corner) and a triangle, are nearer than ``limit``."""
    a, b, c = _corner(first, 0), _corner(first, 1), _corner(first, 2)
    u, v, w = _corner(second, 0), _corner(second, 1), _corner(second, 2)
    other_normal = _cross(_less(v, u), _less(w, u))
    if _dot(other_normal, other_normal) > 0.0 and _beyond(other_normal, u, (a, b, c), limit):
        return False
    normal = _cross(_less(b, a), _less(c, a))
    flat = _dot(normal, normal) == 0.0
    if not flat and _beyond(normal, a, (u, v, w), limit):
        return False
    squared = limit * limit
    edges = ((a, b), (b, c), (c, a))
    other_edges = ((u, v), (v, w), (w, u))
    for p, q in edges:
        for r, s in other_edges:
            if _segments_squared(p, q, r, s) <= squared:
                return True
        if _segment_triangle_near(p, q, (u, v, w), other_normal, squared):
            return True
        if wire:
            return False
    if not flat:
        for r, s in other_edges:
            if _segment_triangle_near(r, s, (a, b, c), normal, squared):
                return True
    return False


@compiled
def _winds_round(corners: FloatArray, point: FloatArray) -> bool:
    """Whether a point not on the surface lies inside a closed mesh, by the solid angle of the mesh (Van Oosterom)."""
    total = 0.0
    for k in range(len(corners)):
        a = (corners[k, 0, 0] - point[0], corners[k, 0, 1] - point[1], corners[k, 0, 2] - point[2])
        b = (corners[k, 1, 0] - point[0], corners[k, 1, 1] - point[1], corners[k, 1, 2] - point[2])
        c = (corners[k, 2, 0] - point[0], corners[k, 2, 1] - point[1], corners[k, 2, 2] - point[2])
        x, y, z = _dot(a, a) ** 0.5, _dot(b, b) ** 0.5, _dot(c, c) ** 0.5
        total += np.arctan2(_dot(a, _cross(b, c)), x * y * z + _dot(a, b) * z + _dot(b, c) * x + _dot(c, a) * y)
    # Twice the sum is the solid angle: 4 pi inside, 0 outside.
    return bool(abs(total) > np.pi)


@compiled
def _width(boxes: FloatArray, k: int) -> float:
    return float(boxes[k, 1, 0] - boxes[k, 0, 0] + boxes[k, 1, 1] - boxes[k, 0, 1] + boxes[k, 1, 2] - boxes[k, 0, 2])


@compiled
def _near(
    corners: FloatArray,
    boxes: FloatArray,
    others: FloatArray,
    other_boxes: FloatArray,
    rotation: FloatArray,
    shift: FloatArray,
    limit: float,
    wire: bool,
) -> bool:
    """Whether any two triangles come nearer than ``limit``. ``others`` and ``other_boxes`` are in their own frame.

    Only what the traversal meets is moved, so that a short rod beside a large mesh takes no longer than beside a small.
    """
    inner, other_inner = len(boxes) // 2, len(other_boxes) // 2
    moved, low, high = np.empty((LEAF, 3, 3)), np.empty(3), np.empty(3)
    stack = np.empty((512, 2), np.int64)
    stack[0, 0], stack[0, 1] = 0, 0
    size = 1
    while size:
        size -= 1
        i, j = stack[size, 0], stack[size, 1]
        # The other's box as middle and half width in the first's frame: an axis-parallel box around the rotated one.
        for axis in range(3):
            middle, half = shift[axis], limit
            for m in range(3):
                middle += rotation[axis, m] * (other_boxes[j, 0, m] + other_boxes[j, 1, m]) / 2.0
                half += abs(rotation[axis, m]) * (other_boxes[j, 1, m] - other_boxes[j, 0, m]) / 2.0
            low[axis], high[axis] = middle - half, middle + half
        if (
            boxes[i, 0, 0] > high[0]
            or boxes[i, 1, 0] < low[0]
            or boxes[i, 0, 1] > high[1]
            or boxes[i, 1, 1] < low[1]
            or boxes[i, 0, 2] > high[2]
            or boxes[i, 1, 2] < low[2]
        ):
            continue
        leaf, other_leaf = i >= inner, j >= other_inner
        if leaf and other_leaf:
            for n in range(LEAF):
                for k in range(3):
                    for axis in range(3):
                        moved[n, k, axis] = shift[axis]
                        for m in range(3):
                            moved[n, k, axis] += rotation[axis, m] * others[(j - other_inner) * LEAF + n, k, m]
            for m in range((i - inner) * LEAF, (i - inner + 1) * LEAF):
                for n in range(LEAF):
                    if _triangles_near(corners[m], moved[n], limit, wire):
                        return True
            continue
        wider = _width(boxes, i) >= _width(other_boxes, j)
        if other_leaf or (wider and not leaf):
            stack[size, 0], stack[size, 1] = 2 * i + 1, j
            stack[size + 1, 0], stack[size + 1, 1] = 2 * i + 2, j
        else:
            stack[size, 0], stack[size, 1] = i, 2 * j + 1
            stack[size + 1, 0], stack[size + 1, 1] = i, 2 * j + 2
        size += 2
    return False
