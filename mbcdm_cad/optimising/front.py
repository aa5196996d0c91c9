"""Designs of which none is better than another in every aim, and the volume that they dominate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbcdm_cad.routes import Floats

# The reference point of the hypervolume lies beyond the worst of each aim by this share of its spread.
BEYOND = 0.1


def front_of(points: Floats) -> list[int]:
    """Rows of ``points`` (n, k), less is better, that no other dominates, in order; of equal ones the first."""
    kept: list[int] = []
    for k in np.lexsort(points.T[::-1]):
        # Sorted by the first aim, then the next: only rows before can dominate this one.
        if not any((points[other] <= points[k]).all() for other in kept):
            kept.append(int(k))
    return sorted(kept)


def reference_of(points: Floats) -> tuple[Floats, Floats]:
    """(reference point, scale) of the hypervolume of points (n, k): beyond the worst, and the spread of each aim."""
    least, most = points.min(axis=0), points.max(axis=0)
    spread = np.where(most > least, most - least, np.maximum(np.abs(most), 1.0))
    return np.asarray(most + BEYOND * spread), np.asarray(spread)


def hypervolume(points: Floats | Sequence[Floats], reference: Floats, scale: Floats) -> float:
    """Volume that the points (n, k) dominate up to the reference point, each aim over its scale."""
    from pymoo.indicators.hv import HV

    given = np.asarray(points, dtype=float)
    if not given.size:
        return 0.0
    return float(HV(ref_point=reference / scale)(given / scale))
