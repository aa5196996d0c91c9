"""Dimensions of bought parts that the catalogue does not contain."""

from __future__ import annotations

from math import cos, pi, sin

# Width across the ring encoder's two flats over its diameter.
RING_ENCODER_FLATS = 22.0 / 24.0
# Screws of a flange begin at this angle from X. Y points to the front of the frame, where its shelves end: two screws
# lie along X, of three one is at the back, four lie on the diagonals.
_FIRST_SCREW_DEG = {2: 0.0, 3: -90.0, 4: 45.0}


def first_screw_rad(count: int) -> float:
    """Angle of a flange's first screw from X, seen along -Z."""
    return _FIRST_SCREW_DEG.get(count, 0.0) * pi / 180.0


def screw_places(count: int, radius_mm: float, turn_deg: float = 0.0) -> tuple[tuple[float, float], ...]:
    """(x, y) of the screws of a flange from its axis, mm, sorted; ``turn_deg``: how far it is turned from X to Y."""
    angles = [first_screw_rad(count) + turn_deg * pi / 180.0 + 2 * pi * k / count for k in range(count)]
    # Rounded to a picometre, so that a point on an axis has a coordinate of exactly 0.
    return tuple(sorted((round(radius_mm * cos(a), 9) + 0.0, round(radius_mm * sin(a), 9) + 0.0) for a in angles))
