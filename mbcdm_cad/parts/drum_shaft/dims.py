"""Dimensions of the drum's hollow shaft."""

from __future__ import annotations

from dataclasses import dataclass

# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class DrumShaftDims:
    """Hollow shaft: flange behind the rear bearing, hub clamped in front, encoder at the back."""

    radius: float
    bore_radius: float
    y_start: float
    y_end: float
    flange_radius: float
    flange_start_y: float
    flange_end_y: float
    rear_bearing_y: float
    front_bearing_y: float
