"""A triangle mesh as plain arrays, with the sums and tests that need no kernel."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.parts.placement import Placement

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


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
        np.savez(
            buffer,
            points_mm=self.points_mm,
            normals=self.normals,
            triangles=self.triangles,
            edges=self.edges,
            deviation_mm=self.deviation_mm,
        )
        return buffer.getvalue()

    @classmethod
    def empty(cls) -> TriangleMesh:
        """An empty mesh, for a part that is not shown."""
        none = np.empty((0, 3))
        return cls(none, none, np.empty((0, 3), np.int32), np.empty((0, 2), np.int32), 0.0)

    @classmethod
    def from_bytes(cls, data: bytes) -> TriangleMesh:
        """The mesh from :meth:`to_bytes`."""
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            return cls(
                stored["points_mm"],
                stored["normals"],
                stored["triangles"],
                stored["edges"],
                float(stored["deviation_mm"]),
            )


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
