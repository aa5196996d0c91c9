"""Gaps between the centre lines of different cables over the travel, from points along them."""

from __future__ import annotations

from itertools import combinations
from math import sqrt
from typing import NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, at_least, worst
from mbcdm_cad.layouts.sector import SectorLayout

# Gap between a cable's flank and a wall or another cable that it must not rub on (estimate).
CABLE_GAP_MM = 0.1
_SAMPLE_MM = 1.0
_MOST_SAMPLES = 500
# Samples in a piece of a line: pieces so short that only few of them are near each other.
_PIECE = 8


def step_mm(s: SectorLayout) -> float:
    """Sampling step along cables, mm: it grows with the design, so that a large design does not take long."""
    longest = max(path.length_mm for _, paths in s.extreme_paths for path in paths)
    return max(_SAMPLE_MM, longest / _MOST_SAMPLES)


def sampled(s: SectorLayout) -> list[tuple[float, list[np.ndarray]]]:
    """(drum angle in deg, points of every cable) at centre and both ends of travel."""
    step = step_mm(s)
    return [(float(np.degrees(angle)), [path.sample(step) for path in paths]) for angle, paths in s.extreme_paths]


class Sampled(NamedTuple):
    """Points (n, 3) of a line in short pieces of equal length (the last filled up with its last point), and of each
    piece the sphere that encloses it."""

    pieces: np.ndarray
    centre: np.ndarray
    radius: np.ndarray


def in_pieces(points: np.ndarray) -> Sampled:
    """The points of a line, ready for :func:`nearest_mm`."""
    short = -len(points) % _PIECE
    pieces = np.concatenate([points, np.repeat(points[-1:], short, axis=0)]).reshape(-1, _PIECE, 3)
    centre = pieces.mean(axis=1)
    return Sampled(pieces, centre, np.sqrt(_squared(pieces - centre[:, None]).max(axis=1)))


def nearest_mm(a: Sampled, b: Sampled, step: float) -> float:
    """Lower bound of the distance, mm, between two lines sampled every ``step``, the parts between samples included."""
    return sqrt(max(_least_squared(a, b) - step**2 / 2, 0.0))


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("...x,...x->...", vectors, vectors))


def _least_squared(a: Sampled, b: Sampled) -> float:
    """Least squared distance between two rows of points.

    Only points of pieces whose enclosing spheres are near enough are compared: at most a twentieth of all pairs.
    """
    between = np.sqrt(_squared(a.centre[:, None] - b.centre[None, :]))
    reach = a.radius[:, None] + b.radius[None, :]
    # The small share is for rounding.
    first, second = np.nonzero(between - reach <= (between + reach).min() * (1.0 + 1e-9))
    return float(_squared(a.pieces[first][:, :, None, :] - b.pieces[second][:, None, :, :]).min())


def cables_apart(s: SectorLayout) -> Comparison:
    """Gap between different cables with the drum centred and at both ends of travel."""
    d, step, names, found = s.drive.cable.diameter_mm, step_mm(s), [c.name for c in s.drive.cables], []
    for angle, lines in s.once("sampled", sampled):
        for (i, first), (j, second) in combinations(enumerate(map(in_pieces, lines)), 2):
            what = f"gap of {names[i]} and {names[j]} with the drum at {angle:+.4g} deg"
            found.append(at_least(what, nearest_mm(first, second, step) - d, CABLE_GAP_MM, "mm"))
    return worst(found)
