"""The results of an interference run, and its test of cables against each other, which needs no kernel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.routes.cable_path import CablePath

Points = NDArray[np.float64]
Place = tuple[float, float, float]

_COARSE_MM = 0.2
_FINE_MM = 0.01
# Points of one cable less than this many diameters apart along it belong to the same stretch, not to another turn.
_OWN_STRETCH_DIAMETERS = 4.0


@dataclass(frozen=True)
class Clash:
    """Two bodies that overlap at one drum angle: ``volume_mm3`` for solids, ``overlap_mm`` for two cables."""

    first: str
    second: str
    kind: Literal["solids", "cable and solid", "cables"]
    drum_angle_deg: float
    place_mm: Place
    volume_mm3: float = 0.0
    overlap_mm: float = 0.0

    def __str__(self) -> str:
        x, y, z = self.place_mm
        size = f"{self.overlap_mm:.4f} mm deep" if self.kind == "cables" else f"{self.volume_mm3:.4f} mm^3"
        where = f"at ({x:.2f}, {y:.2f}, {z:.2f}) mm, drum at {self.drum_angle_deg:+.2f} deg"
        return f"{self.first} and {self.second} overlap: {size} {where}"


def _squared(first: Points, second: Points) -> Points:
    # |a - b|^2 = |a|^2 + |b|^2 - 2 a.b: one matrix product instead of a three-dimensional array of differences.
    middle = first.mean(axis=0)
    a, b = first - middle, second - middle
    squared: Points = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None, :] - 2.0 * (a @ b.T)
    return squared


def _along(points: Points) -> NDArray[np.float64]:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _refined(first: Points, second: Points, i: int, j: int) -> tuple[float, Points]:
    """Least distance, mm, between the stretches around two sample points, sampled finely between their neighbours."""

    def fine(points: Points, k: int) -> Points:
        low, high = max(0, k - 2), min(len(points) - 1, k + 2)
        stretch = points[low : high + 1]
        s = _along(stretch)
        at = np.arange(0.0, s[-1], _FINE_MM)
        return np.stack([np.interp(at, s, stretch[:, axis]) for axis in range(3)], axis=1)

    a, b = fine(first, i), fine(second, j)
    m, n = divmod(int(np.argmin(_squared(a, b))), len(b))
    return float(np.linalg.norm(a[m] - b[n])), (a[m] + b[n]) / 2


def centre_line_distance(first: CablePath, second: CablePath, diameter_mm: float) -> tuple[float, Points]:
    """Least distance (mm) between two centre lines, or between the turns of one; and its place.

    Exact to 1e-4 mm if it is under ``diameter_mm``; above that only the nearest of the coarse samples is refined, with
    an error up to 0.01 mm.
    """
    a = first.sample(_COARSE_MM)
    b = a if first is second else second.sample(_COARSE_MM)
    squared = _squared(a, b)
    if first is second:
        s = _along(a)
        squared[np.abs(s[:, None] - s[None, :]) <= _OWN_STRETCH_DIAMETERS * diameter_mm] = np.inf
    i, j = divmod(int(np.argmin(squared)), len(b))
    best = _refined(a, b, i, j)
    # Two samples half a step from the closest points are further apart by up to this, so others may be nearer.
    rows, columns = np.nonzero(squared < diameter_mm**2 + _COARSE_MM**2 / 2)
    done = np.zeros_like(squared, dtype=bool) if len(rows) else None
    for k in np.argsort(squared[rows, columns], kind="stable"):
        i, j = int(rows[k]), int(columns[k])
        assert done is not None
        if not done[i, j]:
            best = min(best, _refined(a, b, i, j), key=lambda found: found[0])
            done[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2] = True
    return best


def cable_overlaps(paths: Sequence[CablePath], diameter_mm: float) -> Iterator[tuple[int, int, float, Place]]:
    """Cables whose centre lines come nearer than their diameter, each pair and each cable with its own turns.

    ``diameter_mm``: of cables that state none; of two cables half the sum of both counts.

    Returns the indices of both, the overlap (mm), and its place.
    """
    count = len(paths)
    for i, j in (*combinations(range(count), 2), *((k, k) for k in range(count))):
        wide = sum(paths[k].diameter_mm or diameter_mm for k in (i, j)) / 2.0
        distance, place = centre_line_distance(paths[i], paths[j], wide)
        if distance < wide - 1e-6:
            yield i, j, wide - distance, (float(place[0]), float(place[1]), float(place[2]))
