"""SI figures, named with their unit, as people read them: angles in mrad, lengths in mm, torques in N m."""

from __future__ import annotations

_READABLE = {
    "_rad": ("mrad", 1e3),
    "_Nm": ("N m", 1.0),
    "_N": ("N", 1.0),
    "_m": ("mm", 1e3),
}


def readable_figure(name: str) -> tuple[str, str, float]:
    """(words, unit, factor) for a figure such as ``reversal_swing_rad``: ``reversal swing``, ``mrad``, 1000."""
    for suffix, (unit, factor) in _READABLE.items():
        if name.endswith(suffix):
            return name.removesuffix(suffix).replace("_", " "), unit, factor
    return name.replace("_", " "), "-", 1.0
