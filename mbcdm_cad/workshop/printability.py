"""Printability of a part, from its mesh: thinnest wall, overhanging faces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbcdm_cad.parts.placement import Vector
from mbcdm_cad.workshop.export.threemf import lying
from mbcdm_cad.workshop.trianglemesh import FloatArray, TriangleMesh

# Distance of the rays that find walls, and least number of rays that must find the same wall.
RAYS_MM, RAYS = 0.25, 4
# Both faces of a wall must be nearly perpendicular to the ray through it (cosine of the angle).
_SQUARE = 0.9
# A face that overhangs by more than this angle from the vertical needs a support (usual rule for filament).
OVERHANG_DEG = 45.0
# A face counts as lying on the bed within this height.
_ON_BED_MM = 0.01


class ThinWall(NamedTuple):
    """The thinnest wall found, and the place of its middle, mm."""

    thickness_mm: float
    at_mm: Vector


def thinnest_wall(mesh: TriangleMesh) -> ThinWall | None:
    """Thinnest wall that is square to an axis of the part, by rays along all three; None if there is none.

    An oblique wall is found only where its faces are perpendicular to an axis, as on a cylinder.
    """
    found: list[ThinWall] = []
    normals = _normals(mesh.corners_mm)
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        hits = [
            _hits(mesh.corners_mm[sign * normals[:, axis] > _SQUARE][:, :, (first, second, axis)]) for sign in (-1, 1)
        ]
        enters, leaves = hits
        thickness, rays, start = _pairs(enters, leaves)
        order = np.argsort(thickness, kind="stable")
        if len(order) >= RAYS:
            n = order[RAYS - 1]
            at = np.zeros(3)
            at[first], at[second] = rays[n] * RAYS_MM
            at[axis] = start[n] + thickness[n] / 2
            found.append(ThinWall(float(thickness[n]), (float(at[0]), float(at[1]), float(at[2]))))
    return min(found, default=None)


def overhang_mm2(mesh: TriangleMesh) -> float:
    """Area, mm^2, that overhangs by more than ``OVERHANG_DEG`` from the vertical, with the part on the bed."""
    corners = mesh.corners_mm @ lying(mesh).T
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1) / 2.0
    down = _normals(corners)[:, 2] < -np.sin(np.radians(OVERHANG_DEG)) - 1e-6
    on_bed = corners[:, :, 2].max(axis=1) < corners[:, :, 2].min() + _ON_BED_MM
    return float(area[down & ~on_bed].sum())


def _normals(corners: FloatArray) -> FloatArray:
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1), 1e-30)[:, None])


def _hits(triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rays (n, 2) as whole numbers of the grid, and the depth at which each meets one of the triangles (m, 3, 3)."""
    rays, depths = [np.empty((0, 2))], [np.empty(0)]
    for triangle in triangles:
        flat = triangle[:, :2] / RAYS_MM
        low, high = np.ceil(flat.min(axis=0)), np.floor(flat.max(axis=0))
        if (high < low).any():
            continue
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
        a, b, c = flat
        e, f, p = b - a, c - a, np.stack([u.ravel(), v.ravel()], axis=1) - a
        area = e[0] * f[1] - e[1] * f[0]
        if abs(area) < 1e-12:
            continue
        s = (p[:, 0] * f[1] - p[:, 1] * f[0]) / area
        t = (e[0] * p[:, 1] - e[1] * p[:, 0]) / area
        inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
        rays.append((p + a)[inside])
        start, one, other = triangle[:, 2]
        depths.append((start + s * (one - start) + t * (other - start))[inside])
    grid: FloatArray = np.rint(np.concatenate(rays))
    return grid, np.concatenate(depths)


def _pairs(
    enters: tuple[FloatArray, FloatArray], leaves: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Thickness, ray and start of each stretch of a ray from the face where it enters to that where it leaves."""
    rays = np.concatenate([enters[0], leaves[0]])
    depth = np.concatenate([enters[1], leaves[1]])
    into = np.concatenate([np.ones(len(enters[1]), bool), np.zeros(len(leaves[1]), bool)])
    order = np.lexsort((depth, rays[:, 1], rays[:, 0]))
    rays, depth, into = rays[order], depth[order], into[order]
    wall = into[:-1] & ~into[1:] & (rays[:-1] == rays[1:]).all(axis=1)
    thickness = (depth[1:] - depth[:-1])[wall]
    # If an edge of the solid lies on the ray, the two faces that meet there have no wall between them.
    real = thickness > 1e-3
    return thickness[real], rays[:-1][wall][real], depth[:-1][wall][real]
