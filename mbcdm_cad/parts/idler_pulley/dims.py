"""Dimensions of an idler: a stepped pulley that cables pass, with a bearing in each end."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class IdlerDims:
    """Idler pulley: smooth steps, a bearing in each end."""

    bottom_z: float
    top_z: float
    surface_radii: tuple[float, ...]
    walls_z: tuple[float, ...]
    seat_radius: float
    seat_depth: float
    shoulder_radius: float
