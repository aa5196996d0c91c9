"""The bodies that move as one and how each turns with the drum, found from the bill at two drum angles.

Nothing here knows a configuration: a body is a group of the bill, and its axis and ratio follow from where its items
stand at the two angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, degrees
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.parts.item import Item
from mbcdm_cad.parts.placement import Placement, Vector

# A turn of 180 deg hides its sense, so ratios up to 180 / PROBE_DEG can be told.
PROBE_DEG = 1.0
_STILL_RAD = 1e-9


class Bill(Protocol):
    """What is read of a configuration's bill: every part's maker and every item at one drum angle."""

    @property
    def drum_angle_deg(self) -> float: ...

    @property
    def parts(self) -> Mapping[str, Any]: ...

    @property
    def items(self) -> tuple[Item, ...]: ...


def is_cable(bill: Bill, item: Item) -> bool:
    """Whether an item is a cable: bent anew at every angle, so part of no body."""
    module: str = bill.parts[item.part].maker.partition(":")[0]
    return module.rpartition(".")[2] == "cable"


@dataclass(frozen=True)
class Body:
    """What moves as one. It turns by ``ratio`` times the drum's angle about ``axis`` through ``point_mm``.

    ``axis`` is a unit vector whose largest component is positive; ``ratio`` carries the sense and is 0 for a body that
    stands still. ``items`` are the names of its items.
    """

    name: str
    axis: Vector
    point_mm: Vector
    ratio: float
    items: tuple[str, ...]

    def at(self, drum_angle_deg: float) -> Placement:
        """Motion of the body from the centred drum to ``drum_angle_deg``."""
        return Placement.about(self.axis, self.ratio * drum_angle_deg, self.point_mm)


def bodies(centred: Bill, probed: Bill) -> tuple[Body, ...]:
    """The bodies of an assembly, those that stand still first, then by name; cables belong to none.

    ``centred`` is the bill with the drum at 0 deg, ``probed`` the one at a small angle other than 0 (``PROBE_DEG``).
    Raises ``ValueError`` if the items of a group do not move as one, or if a body shifts along its axis.
    """
    after = {item.name: item.location for item in probed.items}
    groups: dict[str, list[str]] = {}
    motions: dict[str, Placement] = {}
    for item in centred.items:
        if is_cable(centred, item):
            continue
        motion = after[item.name] @ item.location.inverse
        first = motions.setdefault(item.group, motion)
        error = float(np.abs(np.array(first.rows) - np.array(motion.rows)).max())
        if error > 1e-6:
            raise ValueError(f"{item.name} does not move with its group {item.group}: {error:.3g} mm apart")
        groups.setdefault(item.group, []).append(item.name)
    turn = probed.drum_angle_deg - centred.drum_angle_deg
    found = [_body(name, motions[name], turn, tuple(sorted(items))) for name, items in groups.items()]
    return tuple(sorted(found, key=lambda body: (body.ratio != 0.0, body.name)))


def _body(name: str, motion: Placement, drum_deg: float, items: tuple[str, ...]) -> Body:
    rotation, shift = motion.rotation, motion.shift_mm
    twist = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine = float(np.linalg.norm(twist)) / 2.0
    angle = atan2(sine, (float(np.trace(rotation)) - 1.0) / 2.0)
    if angle < _STILL_RAD:
        if float(np.abs(shift).max()) > 1e-6:
            raise ValueError(f"{name} slides by {np.abs(shift).max():.3g} mm and does not turn; bodies only turn")
        return Body(name, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0, items)
    axis = twist / (2.0 * sine)
    if axis[np.argmax(np.abs(axis))] < 0.0:
        axis, angle = -axis, -angle
    if abs(float(axis @ shift)) > 1e-6:
        raise ValueError(f"{name} moves by {axis @ shift:.3g} mm along its axis; bodies only turn")
    # (1 - R) p = t leaves the place along the axis open; the least-squares answer is the point nearest the origin.
    point = np.linalg.lstsq(np.eye(3) - rotation, shift, rcond=1e-6)[0]
    return Body(name, _vector(axis), _vector(point), round(degrees(angle) / drum_deg, 9), items)


def _vector(values: NDArray[Any]) -> Vector:
    x, y, z = (round(float(value), 9) + 0.0 for value in values)
    return x, y, z
