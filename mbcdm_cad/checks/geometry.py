"""Small plane geometry that several checks share."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
# Metal between two drilled holes in solid plate, or between a hole and the part's edge (estimate).
HOLE_WEB_MM = 0.5


def corner_gap(x: float, z: float, wall_x: float, floor_z: float, radius: float) -> float:
    """Gap of the point (x, z) to a wall at ``wall_x`` and a floor at ``floor_z`` that meet in a corner of ``radius``.

    The pocket lies at smaller x and larger z. Negative: the point is inside the metal.
    """
    centre_x, centre_z = wall_x - radius, floor_z + radius
    if x > centre_x and z < centre_z:
        return radius - hypot(x - centre_x, z - centre_z)
    return min(wall_x - x, z - floor_z)


def inside_rounded_rectangle(u: float, v: float, half_width: float, low: float, high: float, radius: float) -> float:
    """Distance from (u, v) to the edge of the rectangle |u| <= half_width, low <= v <= high; negative outside."""
    u = abs(u)
    nearest_v = min(v - low, high - v)
    across, along = half_width - u, nearest_v
    if across < radius and along < radius:
        return radius - hypot(radius - across, radius - along)
    return min(across, along)


def box_gap(first: Points, second: Points) -> float:
    """Distance between the boxes of two polygons (n, 2): no less than theirs, and quickly computed."""
    apart = np.maximum(first.min(axis=0) - second.max(axis=0), second.min(axis=0) - first.max(axis=0))
    return float(np.hypot(*np.maximum(apart, 0.0)))


def polygon_gap(first: Points, second: Points) -> float:
    """Distance between two convex polygons (n, 2); 0 where they overlap or touch."""
    for polygon in (first, second):
        edges = np.roll(polygon, -1, axis=0) - polygon
        for edge in edges:
            normal = np.array([edge[1], -edge[0]])
            a, b = first @ normal, second @ normal
            if a.max() < b.min() or b.max() < a.min():
                return min(_vertex_gap(first, second), _vertex_gap(second, first))
    return 0.0


def _vertex_gap(points: Points, polygon: Points) -> float:
    best = np.inf
    for start, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        along = end - start
        t = np.clip((points - start) @ along / max(float(along @ along), 1e-30), 0.0, 1.0)
        best = min(best, float(np.linalg.norm(points - start - t[:, None] * along, axis=1).min()))
    return best


def web_between(holes: Sequence[tuple[str, float, float, float, float, float]]) -> list[tuple[str, float]]:
    """Wall between round holes (name, u, v, radius, from, to) whose depths overlap, for every pair."""
    found = []
    for i, (name, u, v, r, low, high) in enumerate(holes):
        for other, ou, ov, other_r, other_low, other_high in holes[i + 1 :]:
            if min(high, other_high) > max(low, other_low) and (u, v) != (ou, ov):
                found.append((f"{name} to {other}", hypot(u - ou, v - ov) - r - other_r))
    return found
