"""Dimensions of the axle of an idler and of the spacer above it."""

from __future__ import annotations

from dataclasses import dataclass

# At 45 degrees, on both ends of the axle.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class AxleDims:
    """Guide axle: held by a set screw in the bearing shelf, located in the top plate; collar below the bearing."""

    radius: float
    bottom_z: float
    top_z: float
    collar_radius: float
    collar_bottom_z: float
    collar_top_z: float
    spacer_bottom_z: float
    spacer_top_z: float
