"""Place short texts in a view: at the nearest position where a text covers no line and no other text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import cos, radians, sin

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.drawings.strokes import Point, Stroke, points_of

_DIRECTIONS = (45, 135, 315, 225, 0, 90, 180, 270, 22, 67, 112, 157, 202, 247, 292, 337)
_AROUND_MM = 0.5
# The farthest place is some 70 mm away: a small part has many dimensions around it.
_STEPS = 60
Box = tuple[float, float, float, float]


class Room:
    """The space that is used on the paper, as segments and boxes; each placed text is added."""

    def __init__(self, within: Box) -> None:
        self._within = within
        self._segments: list[NDArray[np.float64]] = []
        self._together: NDArray[np.float64] | None = None
        self._boxes: list[Box] = []
        self._faces: list[list[NDArray[np.float64]]] = []

    def add_strokes(self, strokes: Iterable[Stroke], origin: Point, scale: float) -> None:
        """Add lines of a view, which texts must not cover."""
        for stroke in strokes:
            points = np.array(points_of(stroke)) * scale + np.array(origin)
            self.add_line(points)

    def add_line(self, points: NDArray[np.float64]) -> None:
        """Add a polyline on paper, (n, 2)."""
        self._segments.append(np.concatenate([points[:-1], points[1:]], axis=1))
        self._together = None

    def add_face(self, loops: Iterable[tuple[Point, ...]], origin: Point, scale: float) -> None:
        """Add a hatched face of a view."""
        self._faces.append([np.array(loop) * scale + np.array(origin) for loop in loops])

    def add_box(self, taken: Box) -> None:
        """Add a text or table on paper."""
        self._boxes.append(taken)

    def is_free(self, wanted: Box) -> bool:
        """Whether a box lies on the sheet and on nothing else."""
        left, bottom, right, top = wanted
        if left < self._within[0] or bottom < self._within[1] or right > self._within[2] or top > self._within[3]:
            return False
        if any(left < b[2] and right > b[0] and bottom < b[3] and top > b[1] for b in self._boxes):
            return False
        if any(_inside(((left + right) / 2, (bottom + top) / 2), loops) for loops in self._faces):
            return False
        if self._together is None:
            self._together = np.concatenate(self._segments) if self._segments else np.zeros((0, 4))
        return not crossed(self._together, wanted)

    def _over_text(self, start: Point, end: Point) -> bool:
        line = np.array([(*start, *end)])
        return any(crossed(line, taken) for taken in self._boxes)

    def place(
        self,
        at: Point,
        width: float,
        height: float,
        clear: float,
        beside: bool = False,
        leader: Callable[[Point], Point] | None = None,
    ) -> Point:
        """Middle of a text near ``at``, at least ``clear`` away from it; its box is added to the used space.

        ``beside``: the whole text is to the left or to the right of ``at``. ``leader``: where the line to ``at`` begins
        for a middle; it crosses no other text, if there is such a place.
        """
        best: tuple[Point, Box] | None = None
        for step in range(_STEPS):
            for deg in _DIRECTIONS:
                away = clear + 0.6 + 1.2 * step
                dx, dy = cos(radians(deg)), sin(radians(deg))
                x = at[0] + dx * (away + width / 2)
                y = at[1] + dy * (away + height / 2)
                if beside and abs(x - at[0]) < width / 2:
                    continue
                wanted = (
                    x - width / 2 - _AROUND_MM,
                    y - height / 2 - _AROUND_MM,
                    x + width / 2 + _AROUND_MM,
                    y + height / 2 + _AROUND_MM,
                )
                if not self.is_free(wanted):
                    continue
                best = best or ((x, y), wanted)
                if leader is None or not self._over_text(leader((x, y)), at):
                    self.add_box(wanted)
                    return x, y
        if best is not None:
            self.add_box(best[1])
            return best[0]
        # No free place: a test of the sheet finds the overlap, the text is drawn anyway.
        return at[0] + clear + width, at[1] + clear + height


def crossed(segments: NDArray[np.float64], wanted: Box) -> bool:
    """Whether any segment (n, 4) meets the box (separating axes: x, y and the segment's normal)."""
    left, bottom, right, top = wanted
    ax, ay, bx, by = segments.T
    near = (np.maximum(ax, bx) >= left) & (np.minimum(ax, bx) <= right)
    near &= (np.maximum(ay, by) >= bottom) & (np.minimum(ay, by) <= top)
    if not near.any():
        return False
    ax, ay, bx, by = segments[near].T
    nx, ny = ay - by, bx - ax
    corners = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
    side = np.outer(nx, corners[:, 0]) + np.outer(ny, corners[:, 1]) - (nx * ax + ny * ay)[:, None]
    return bool(((side.min(axis=1) <= 0) & (side.max(axis=1) >= 0)).any())


def _inside(point: Point, loops: list[NDArray[np.float64]]) -> bool:
    """Whether a point lies in a face with holes, by an odd number of edges to its right."""
    odd = False
    for loop in loops:
        (ax, ay), (bx, by) = loop.T, np.roll(loop, -1, axis=0).T
        spans = (ay > point[1]) != (by > point[1])
        rise = np.where(spans, by - ay, 1.0)
        right = ax + (point[1] - ay) * (bx - ax) / rise > point[0]
        odd ^= bool(np.count_nonzero(spans & right) % 2)
    return odd
