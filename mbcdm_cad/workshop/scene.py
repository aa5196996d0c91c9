"""Positions at one drum angle: bodies with their placements, cables with their centre lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import radians
from typing import Literal

import numpy as np

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.parts.bill import CABLE, FIXED, Bill, Item, MovingBody
from mbcdm_cad.parts.placement import Placement, Vector
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


@dataclass(frozen=True)
class MovingGroup:
    """Items that move as one body. It turns by ``ratio`` times the drum's angle about ``axis`` through ``point_mm``.

    ``ratio`` has the sign of the rotation and is 0 for fixed items. ``items`` are the names of its items, sorted.
    """

    name: str
    kind: Literal["fixed", "drum", "passed", "input", "stage"]
    axis: Vector
    point_mm: Vector
    ratio: float
    items: tuple[str, ...]

    def at(self, drum_angle_deg: float) -> Placement:
        """Motion of the body from the centred drum to ``drum_angle_deg``."""
        return Placement.about(self.axis, self.ratio * drum_angle_deg, self.point_mm)


def is_cable(item: Item) -> bool:
    """Whether an item is a cable. A cable has another shape at every angle, so it belongs to no body."""
    return item.name.startswith(CABLE)


def bodies(moving: Sequence[MovingBody], centred: Bill) -> tuple[MovingGroup, ...]:
    """The fixed body, then the moving bodies in their order; ``centred`` is the bill with the drum at 0 deg."""
    members: dict[str, list[str]] = {FIXED: [], **{body.name: [] for body in moving}}
    for item in centred.items:
        if not is_cable(item):
            members[item.group].append(item.name)
    still = MovingGroup(FIXED, "fixed", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0, tuple(sorted(members[FIXED])))
    return (
        still,
        *(
            MovingGroup(b.name, b.kind, b.axis, b.origin_mm, b.turns_per_drum, tuple(sorted(members[b.name])))
            for b in moving
        ),
    )
