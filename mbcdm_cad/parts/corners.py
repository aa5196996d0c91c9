"""Corners of milled pockets."""

from __future__ import annotations

# A pocket's end mill is a little thinner than the pocket, so that a straight stretch is left on its shorter side.
_SHARE = 0.49


def pocket_corner_mm(radius_mm: float, width_mm: float, height_mm: float) -> float:
    """Corner radius of a pocket: as asked, or what a narrow one leaves."""
    return min(radius_mm, _SHARE * min(width_mm, height_mm))
