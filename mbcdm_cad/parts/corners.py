"""Corners of milled pockets."""

from __future__ import annotations

# The end mill is a little thinner than the pocket, so that the shorter side of the pocket has a straight part.
_SHARE = 0.49


def pocket_corner_mm(radius_mm: float, width_mm: float, height_mm: float) -> float:
    """Corner radius of a pocket, mm: ``radius_mm``, or less if the pocket is narrow."""
    return min(radius_mm, _SHARE * min(width_mm, height_mm))
