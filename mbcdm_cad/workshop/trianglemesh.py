"""A triangle mesh as plain arrays, with the sums and tests that need no kernel."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, ceil, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Placement
from mbcdm_cad.routes.curves import Piece

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
# Distance of points on a rod's line, from which its bends are measured, over its radius.
_DENSE_RADII = 0.2


@dataclass(frozen=True)
class TriangleMesh:
    """The surface of a solid in triangles, anticlockwise as seen from outside. Lengths in mm.

    Points are not shared between faces of the solid, so that each has its own normal; on a common edge they are equal
    to the last bit. ``edges`` are the solid's edges as pairs of indices into ``points_mm``. ``deviation_mm`` is the
    greatest distance found between mesh and solid.
    """

    points_mm: FloatArray  # (n, 3)
    normals: FloatArray  # (n, 3), outward unit vectors of the true surface
    triangles: IntArray  # (m, 3)
    edges: IntArray  # (k, 2)
    deviation_mm: float

    @property
    def is_empty(self) -> bool:
        """Whether it has no triangle."""
        return not len(self.triangles)

    @property
    def corners_mm(self) -> FloatArray:
        """The corners of every triangle, (m, 3, 3)."""
        corners: FloatArray = self.points_mm[self.triangles]
        return corners

    @property
    def volume_mm3(self) -> float:
        """Volume enclosed (divergence theorem); meaningful only for a watertight mesh."""
        first, second, third = np.moveaxis(self.corners_mm - self.points_mm.mean(axis=0), 1, 0)
        return float(np.einsum("ij,ij->", first, np.cross(second, third)) / 6.0)

    def box_mm(self, placement: Placement) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of the mesh at a placement; at most ``deviation_mm`` inside the solid's own box."""
        points = placement.apply(self.points_mm)
        return points.min(axis=0), points.max(axis=0)

    def open_edges_mm(self) -> FloatArray:
        """Middles (k, 3) of the directed edges that have not exactly one opposite; none if the mesh is watertight.

        Points that are equal in single precision count as one, as for a reader of the files.
        """
        points, index = np.unique(single(self.points_mm), axis=0, return_inverse=True)
        corners = index.reshape(-1).astype(np.int64)[self.triangles]
        start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
        edges, times = np.unique(start * len(points) + end, return_counts=True)
        first, second = np.divmod(edges, len(points))
        open_ = (times > 1) | np.isin(second * len(points) + first, edges, invert=True)
        middles: FloatArray = (points[first[open_]] + points[second[open_]]).astype(np.float64) / 2.0
        return middles

    def to_bytes(self) -> bytes:
        """The mesh as stored in the cache."""
        buffer = io.BytesIO()
        np.savez(buffer, **vars(self))
        return buffer.getvalue()

    @classmethod
    def empty(cls) -> "TriangleMesh":
        """An empty mesh, for a part that is not shown."""
        none = np.empty((0, 3))
        return cls(none, none, np.empty((0, 3), np.int32), np.empty((0, 2), np.int32), 0.0)

    @classmethod
    def from_bytes(cls, data: bytes) -> "TriangleMesh":
        """The mesh from :meth:`to_bytes`."""
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            arrays = dict(stored)
        return cls(**arrays | {"deviation_mm": float(arrays["deviation_mm"])})


def rod_mesh(pieces: Sequence[Piece], radius_mm: float, tolerance_mm: float) -> TriangleMesh:
    """A rod round a centre line without corners, as rings of one polygon each, closed at both ends.

    Half of the tolerance is for the polygon, half for the chords along the line. The kernel's mesh of such a sweep has
    ten times as many triangles and takes seconds. ``deviation_mm`` is measured between the corners. Raises
    ``GeometryError`` if it is beyond the tolerance.
    """
    from scipy.spatial import cKDTree

    line: list[FloatArray] = []
    tangents: list[FloatArray] = []
    dense: list[FloatArray] = []
    for piece in pieces:
        fine = max(2, ceil(piece.length_mm / (_DENSE_RADII * radius_mm)))
        points = piece.points(np.linspace(0.0, 1.0, 2 * fine + 1))
        dense.append(points)
        start, middle, end = points[:-1:2], points[1::2], points[2::2]
        sagitta = np.linalg.norm(middle - (start + end) / 2.0, axis=1)
        # At the outer side of a bend the chords are longer than on the line.
        outside = sagitta * (1.0 + 8.0 * radius_mm * sagitta / ((end - start) ** 2).sum(axis=1))
        count = max(1, ceil(fine * sqrt(2.0 * float(outside.max()) / tolerance_mm)))
        at = np.linspace(0.0, 1.0, count + 1)[0 if not line else 1 :]
        line.append(piece.points(at))
        tangents += [piece.tangent(float(fraction)) for fraction in at]
    centres = np.concatenate(line)
    sides = max(6, ceil(pi / acos(1.0 - tolerance_mm / 2.0 / radius_mm)))
    turn = np.arange(sides) * (2.0 * pi / sides)
    across = np.eye(3)[int(np.abs(tangents[0]).argmin())]
    normals = np.empty((len(centres), sides, 3))
    for k, tangent in enumerate(np.asarray(tangents)):
        along = tangent / np.linalg.norm(tangent)
        # The ring before, without its turn about the line.
        across = across - (across @ along) * along
        across /= np.linalg.norm(across)
        normals[k] = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * np.cross(along, across)
    rings = centres[:, None] + radius_mm * normals
    first = np.arange((len(centres) - 1) * sides).reshape(-1, sides)
    a, b = first, np.roll(first, -1, axis=1)
    quads = np.stack([np.stack([a, b, b + sides], axis=2), np.stack([a, b + sides, a + sides], axis=2)]).reshape(-1, 3)
    count = len(centres) * sides
    fan = np.column_stack([np.zeros(sides - 2, int), np.arange(1, sides - 1), np.arange(2, sides)])
    ends = np.concatenate([count + fan[:, ::-1], count + sides + fan])
    points = np.concatenate([rings.reshape(-1, 3), rings[0], rings[-1]])
    flat = [np.tile(sign * t / np.linalg.norm(t), (sides, 1)) for sign, t in ((-1.0, tangents[0]), (1.0, tangents[-1]))]
    circle = np.column_stack([np.arange(sides), np.roll(np.arange(sides), -1)])
    corners = points[quads]
    # Middles of triangles and of their sides.
    between = np.concatenate([corners.mean(axis=1), *((corners[:, k] + corners[:, k - 1]) / 2 for k in range(3))])
    nearest, _ = cKDTree(np.concatenate(dense)).query(between)
    deviation = float(np.abs(nearest - radius_mm).max())
    if deviation > tolerance_mm:
        raise GeometryError(f"cable: mesh deviates by {deviation:.4g} mm, limit {tolerance_mm:g} mm")
    return TriangleMesh(
        points,
        np.concatenate([normals.reshape(-1, 3), *flat]),
        np.concatenate([quads, ends]).astype(np.int32),
        np.concatenate([count + circle, count + sides + circle]).astype(np.int32),
        deviation,
    )


def faces(corners_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Areas (m,) in mm^2 and unit normals (m, 3) of triangles (m, 3, 3); the normal of one without area is zero."""
    across = np.cross(corners_mm[:, 1] - corners_mm[:, 0], corners_mm[:, 2] - corners_mm[:, 0])
    double = np.linalg.norm(across, axis=1)
    return double / 2.0, across / np.maximum(double, 1e-30)[:, None]


def single(points_mm: FloatArray) -> NDArray[np.float32]:
    """Points in single precision, as in the files; adding zero makes -0.0 equal to 0.0."""
    return np.asarray(points_mm, dtype=np.float32) + np.float32(0.0)


def without_collapsed(points_mm: FloatArray, triangles: IntArray) -> IntArray:
    """The triangles whose three corners differ in single precision.

    The others (for example at the pole of a sphere) have no area, and without them their neighbours share an edge.
    """
    corners = single(points_mm)[triangles]
    apart = [(corners[:, a] != corners[:, b]).any(axis=1) for a, b in ((0, 1), (1, 2), (2, 0))]
    kept: IntArray = triangles[np.logical_and.reduce(apart)]
    return kept
