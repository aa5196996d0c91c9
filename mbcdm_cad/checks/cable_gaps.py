"""Gaps between the centre lines of different cables over the travel, from points along them."""

from __future__ import annotations

from itertools import combinations
from math import sqrt

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, at_least, worst
from mbcdm_cad.layouts.sector import SectorLayout

# Gap between a cable's flank and a wall or another cable that it must not rub on (estimate).
CABLE_GAP_MM = 0.1
_SAMPLE_MM = 1.0
_MOST_SAMPLES = 500
# Samples in a piece of a line: pieces so short that only few of them are near each other.
_PIECE = 16


def step_mm(s: SectorLayout) -> float:
    """Sampling step along cables, mm: it grows with the design, so that a large design does not take long."""
    longest = max(path.length_mm for _, paths in s.extreme_paths for path in paths)
    return max(_SAMPLE_MM, longest / _MOST_SAMPLES)


def sampled(s: SectorLayout) -> list[tuple[float, list[np.ndarray]]]:
    """(drum angle in deg, points of every cable) at centre and both ends of travel."""
    step = step_mm(s)
    return [(float(np.degrees(angle)), [path.sample(step) for path in paths]) for angle, paths in s.extreme_paths]


def nearest_mm(a: np.ndarray, b: np.ndarray, step: float) -> float:
    """Lower bound of the distance, mm, between two lines sampled every ``step``, the parts between samples included."""
    return sqrt(max(_least_squared(a, b) - step**2 / 2, 0.0))


def _least_squared(a: np.ndarray, b: np.ndarray) -> float:
    """Least squared distance between two rows of points.

    Both are divided into short pieces. Only points of pieces whose enclosing spheres are near enough are compared: at
    most a twentieth of all pairs.
    """
    (pieces_a, centre_a, radius_a), (pieces_b, centre_b, radius_b) = _pieces(a), _pieces(b)
    between = np.linalg.norm(centre_a[:, None] - centre_b[None, :], axis=2)
    reach = radius_a[:, None] + radius_b[None, :]
    first, second = np.nonzero(between - reach <= (between + reach).min())
    apart = pieces_a[first][:, :, None, :] - pieces_b[second][:, None, :, :]
    return float(np.einsum("kijx,kijx->kij", apart, apart).min())


def _pieces(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pieces of equal length, the last filled up with its last point: (points, centre, radius) of each."""
    short = -len(points) % _PIECE
    pieces = np.concatenate([points, np.repeat(points[-1:], short, axis=0)]).reshape(-1, _PIECE, 3)
    centre = pieces.mean(axis=1)
    return pieces, centre, np.linalg.norm(pieces - centre[:, None], axis=2).max(axis=1)


def cables_apart(s: SectorLayout) -> Comparison:
    """Gap between different cables with the drum centred and at both ends of travel."""
    d, step, names, found = s.drive.cable.diameter_mm, step_mm(s), [c.name for c in s.drive.cables], []
    for angle, lines in s.once("sampled", sampled):
        for (i, first), (j, second) in combinations(enumerate(lines), 2):
            what = f"gap of {names[i]} and {names[j]} with the drum at {angle:+.4g} deg"
            found.append(at_least(what, nearest_mm(first, second, step) - d, CABLE_GAP_MM, "mm"))
    return worst(found)
