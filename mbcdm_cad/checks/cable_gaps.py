"""Gaps between the centre lines of different cables over the travel, from points along them."""

from __future__ import annotations

from itertools import combinations
from math import sqrt

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, at_least, worst
from mbcdm_cad.checks.sector_under_test import SectorUnderTest

# Gap between a cable's flank and a wall or another cable that it must not rub on (estimate).
CABLE_GAP_MM = 0.1
_SAMPLE_MM = 1.0
_MOST_SAMPLES = 500


def step_mm(s: SectorUnderTest) -> float:
    """Sampling step along cables: coarse enough that no design, however large, takes long."""
    longest = max(path.length_mm for _, paths in s.extreme_paths for path in paths)
    return max(_SAMPLE_MM, longest / _MOST_SAMPLES)


def sampled(s: SectorUnderTest) -> list[tuple[float, list[np.ndarray]]]:
    """(drum angle in deg, points of every cable) at centre and both ends of travel."""
    step = step_mm(s)
    return [(float(np.degrees(angle)), [path.sample(step) for path in paths]) for angle, paths in s.extreme_paths]


def nearest_mm(a: np.ndarray, b: np.ndarray, step: float) -> float:
    """Least distance between two lines sampled every ``step``, from below: what lies between samples is allowed for."""
    squared = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None, :] - 2.0 * (a @ b.T)
    return sqrt(max(float(squared.min()) - step**2 / 2, 0.0))


def cables_apart(s: SectorUnderTest) -> Comparison:
    """Centre lines of different cables stay apart, at centre and both ends of travel."""
    d, step, names, found = s.drive.cable.diameter_mm, step_mm(s), [c.name for c in s.drive.cables], []
    for angle, lines in s.once("sampled", sampled):
        for (i, first), (j, second) in combinations(enumerate(lines), 2):
            what = f"gap of {names[i]} and {names[j]} with the drum at {angle:+.4g} deg"
            found.append(at_least(what, nearest_mm(first, second, step) - d, CABLE_GAP_MM, "mm"))
    return worst(found)
