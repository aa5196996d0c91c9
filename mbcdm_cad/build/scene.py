"""Positions at one drum angle: bodies with their placements, cables with their centre lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import radians

import numpy as np

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.parts.bill import CABLE
from mbcdm_cad.parts.item import Item
from mbcdm_cad.routes.cable_path import CablePath, Stretch


@dataclass(frozen=True)
class Pose:
    """Items that are not cables, and the paths of all cables, with the drum at ``drum_angle_deg``."""

    drum_angle_deg: float
    bodies: tuple[Item, ...]
    cables: tuple[CablePath, ...]


def scenes(layout: Layout, drum_angles_deg: Iterable[float]) -> dict[float, Pose]:
    """The scenes of a design by drum angle."""
    return {
        angle: Pose(
            angle,
            tuple(item for item in layout.bill(angle).items if not item.name.startswith(CABLE)),
            layout.all_cable_paths(radians(angle)),
        )
        for angle in dict.fromkeys(drum_angles_deg)
    }


def travel_poses(half_travel_deg: float, count: int) -> tuple[float, ...]:
    """Drum angles (deg), evenly over the travel, both ends included, and the centre for odd ``count``."""
    return tuple(float(a) for a in np.linspace(-half_travel_deg, half_travel_deg, count))


def is_longest(path: CablePath, stretch: Stretch, others: Sequence[CablePath]) -> bool:
    """Whether none of the other paths of the same cable has more of it in the stretch."""
    length_mm = path.only(stretch.pieces).length_mm
    return all(length_mm >= other.only(stretch.pieces).length_mm for other in others)
