"""The bodies of an assembly: the fixed body and the turning bodies, each with its items and its ratio to the drum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from mbcdm_cad.parts.bill import CABLE, FIXED, Bill, MovingBody
from mbcdm_cad.parts.item import Item
from mbcdm_cad.parts.placement import Placement, Vector


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
