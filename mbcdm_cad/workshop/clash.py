"""The results of an interference run, and its test of cables against each other, which needs no kernel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from math import inf
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
    m, n = divmod(int(np.argmin(np.linalg.norm(a[:, None] - b, axis=2))), len(b))
    return float(np.linalg.norm(a[m] - b[n])), (a[m] + b[n]) / 2


def centre_line_distance(first: CablePath, second: CablePath, diameter_mm: float) -> tuple[float, Points]:
    """Least distance (mm) between two centre lines, or between the turns of one; and its place.

    Exact to 1e-4 mm if it is under ``diameter_mm``; above that only the nearest of the coarse samples is refined, with
    an error up to 0.01 mm.
    """
    a = first.sample(_COARSE_MM)
    b = a if first is second else second.sample(_COARSE_MM)
    # Two samples half a step from the closest points are further apart by up to this, so others may be nearer.
    near = (diameter_mm**2 + _COARSE_MM**2 / 2) ** 0.5
    pairs = _own_turns(a, diameter_mm, near) if first is second else _between(a, b, near)
    best, done = (inf, a[0]), set[tuple[int, int]]()
    for i, j in pairs.tolist():
        if (i, j) not in done:
            best = min(best, _refined(a, b, i, j), key=lambda found: found[0])
            done.update(product(range(i - 1, i + 2), range(j - 1, j + 2)))
    return best


def _between(a: Points, b: Points, near_mm: float) -> NDArray[np.int64]:
    """Indices (n, 2) of the samples of two cables nearer than this, the nearest first; without one, the nearest two.

    By trees: a table of all distances takes gigabytes for cables with some turns.
    """
    from scipy.spatial import cKDTree  # its import takes longer than reading answers that are known

    tree = cKDTree(b)
    distance, nearest = tree.query(a)
    if distance.min() >= near_mm:
        return np.array([[k := int(np.argmin(distance)), nearest[k]]])
    found = cKDTree(a).sparse_distance_matrix(tree, near_mm, output_type="ndarray")
    order = np.lexsort((found["j"], found["i"], found["v"]))
    return np.column_stack((found["i"], found["j"]))[order]


def _own_turns(a: Points, diameter_mm: float, near_mm: float) -> NDArray[np.int64]:
    """As :func:`_between`, of one cable's stretches that do not follow each other; none of a cable without them."""
    from scipy.spatial import cKDTree

    tree, s, own_mm = cKDTree(a), _along(a), _OWN_STRETCH_DIAMETERS * diameter_mm
    # The stretches next to the own one are no further away than along the cable.
    for within_mm, count in ((near_mm, None), (own_mm + 2.0 * _COARSE_MM, 1)):
        pairs: NDArray[np.int64] = tree.query_pairs(within_mm, output_type="ndarray")
        pairs = pairs[s[pairs[:, 1]] - s[pairs[:, 0]] > own_mm]
        if len(pairs):
            distance = np.linalg.norm(a[pairs[:, 0]] - a[pairs[:, 1]], axis=1)
            pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0], distance))][:count]
            break
    return pairs


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
