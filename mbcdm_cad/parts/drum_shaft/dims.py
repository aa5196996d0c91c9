"""Dimensions of the drum's hollow shaft."""

from __future__ import annotations

from dataclasses import dataclass

# Depth of the flats for the hub's set screws: the burr of a screw then lies below the shaft's surface (estimate).
FLAT_DEPTH_MM = 0.3
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
    flat_y: float  # middle of the two flats
    flat_length: float
    flat_angles_deg: tuple[float, float]  # directions in which the flats face, from +Z towards +X

    @property
    def flat(self) -> float:
        """From the axis to each flat."""
        return self.radius - FLAT_DEPTH_MM


@dataclass(frozen=True)
class PreloadSpringDims:
    """Wave spring that presses the two bearings apart, so that neither has play; bought, drawn as a plain ring."""

    inner_radius: float
    outer_radius: float
    height: float  # pressed to its force
    start_y: float
    force_N: float
    source: str
