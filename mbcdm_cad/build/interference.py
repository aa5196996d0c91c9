"""Does anything overlap anything, over the whole travel? Solids by booleans, cables by a rod a hair thinner.

What moves together is tested once; what moves apart at every pose. Cable against cable, and against its own turns, by
the distance of centre lines, since rods that touch make booleans fail. No list of exceptions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations
from math import radians
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS_Shape
from threadpoolctl import threadpool_limits

from mbcdm_cad.build.clash import Clash, cable_clashes
from mbcdm_cad.build.kernel import kernel_shape, location
from mbcdm_cad.configurations.interface import Layout
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.parts.bill import CABLE, cable_item
from mbcdm_cad.parts.cable import create_cable
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.storage.parallel import fork_map

# Two bodies that share less than this touch; they do not overlap.
VOLUME_LIMIT_MM3 = 0.01
# The rod tested against solids is thinner by this, or surfaces that touch along a line give nonsense.
CABLE_UNDERSIZE_MM = 0.005
_CULL_STEP_MM = 0.5

Box = NDArray[np.float64]  # (2, 3): lowest and highest corner


class _Body(NamedTuple):
    name: str
    group: str
    shape: TopoDS_Shape
    box: Box


def _box(shape: TopoDS_Shape) -> Box:
    bounds = Bnd_Box()
    BRepBndLib.Add_s(shape, bounds, False)
    x0, y0, z0, x1, y1, z1 = bounds.Get()
    return np.array([[x0, y0, z0], [x1, y1, z1]])


def _common(first: TopoDS_Shape, second: TopoDS_Shape) -> tuple[float, tuple[float, float, float]]:
    """Volume two solids share, mm^3, and its centre."""
    operation = BRepAlgoAPI_Common(first, second)
    properties = GProp_GProps()
    if not operation.IsDone() or operation.Shape().IsNull():
        return 0.0, (0.0, 0.0, 0.0)
    BRepGProp.VolumeProperties_s(operation.Shape(), properties)
    centre = properties.CentreOfMass()
    return properties.Mass(), (centre.X(), centre.Y(), centre.Z())


def _bodies(layout: Layout, solids: Mapping[str, Any], angle_deg: float) -> list[_Body]:
    placed = []
    for item in configuration(layout.drive.configuration).bill(layout, angle_deg).items:
        if not item.name.startswith(CABLE) and item.part in solids:
            shape = kernel_shape(solids[item.part]).Moved(location(item.location))
            placed.append(_Body(item.name, item.group, shape, _box(shape)))
    return placed


def _boxes_meet(first: Box, second: Box) -> bool:
    return bool(np.all(first[0] < second[1]) and np.all(second[0] < first[1]))


def _solid_clashes(bodies: Sequence[_Body], angle_deg: float, same_group: bool) -> Iterator[Clash]:
    for a, b in combinations(bodies, 2):
        if (a.group == b.group) == same_group and _boxes_meet(a.box, b.box):
            volume, place = _common(a.shape, b.shape)
            if abs(volume) >= VOLUME_LIMIT_MM3:
                yield Clash(a.name, b.name, "solids", angle_deg, place, volume_mm3=volume)


def _near(points: NDArray[np.float64], box: Box, margin: float) -> bool:
    return bool(np.any(np.all((points > box[0] - margin) & (points < box[1] + margin), axis=1)))


def _rod_clashes(layout: Layout, path: CablePath, bodies: Sequence[_Body], angle_deg: float) -> Iterator[Clash]:
    radius = layout.drive.cable.diameter_mm / 2
    points = path.sample(_CULL_STEP_MM)
    near = [b for b in bodies if _near(points, b.box, radius + _CULL_STEP_MM)]
    if near:
        rod = create_cable(path.line, radius - CABLE_UNDERSIZE_MM).wrapped
        for body in near:
            volume, place = _common(rod, body.shape)
            if abs(volume) >= VOLUME_LIMIT_MM3:
                yield Clash(
                    cable_item(path.cable.name), body.name, "cable and solid", angle_deg, place, volume_mm3=volume
                )


def _pose_clashes(layout: Layout, solids: Mapping[str, Any], angle_deg: float) -> list[Clash]:
    """What can only be seen at this pose. What a cable shares with the pulley it is wound on, or with the drum, is not:
    there less of it lies in the same place than at the end of travel where it is longest."""
    bodies = _bodies(layout, solids, angle_deg)
    found = list(_solid_clashes(bodies, angle_deg, same_group=False))
    paths = layout.cable_paths(radians(angle_deg))
    # Poses run side by side: threads of the linear algebra besides wait for each other more than they work.
    with threadpool_limits(1, "blas"):
        found += cable_clashes(paths, layout.drive.cable.diameter_mm, angle_deg)
    for path in paths:
        for stretch in path.stretches:
            others = [b for b in bodies if b.group != stretch.body]
            found += _rod_clashes(layout, path.only(stretch.pieces), others, angle_deg)
    return found


def _static_clashes(layout: Layout, solids: Mapping[str, Any]) -> list[Clash]:
    """Bodies that move together, and each cable with what it is fixed to, where most of it lies there."""
    found = list(_solid_clashes(_bodies(layout, solids, 0.0), 0.0, same_group=True))
    half = layout.drive.half_travel_deg
    for angle in (-half, half):
        bodies = _bodies(layout, solids, angle)
        paths, opposite = layout.cable_paths(radians(angle)), layout.cable_paths(radians(-angle))
        for path, other in zip(paths, opposite, strict=True):
            for stretch in (s for s in path.stretches if s.body is not None):
                here = path.only(stretch.pieces)
                if here.length_mm >= other.only(stretch.pieces).length_mm:
                    own = [b for b in bodies if b.group == stretch.body]
                    found += _rod_clashes(layout, here, own, angle)
    return found


def interference_tasks(
    layout: Layout, solids: Mapping[str, Any], poses_deg: Sequence[float]
) -> list[Callable[[], list[Clash]]]:
    """The run as independent pieces of work, one a pose and one for what moves together; their results in order."""
    return [
        partial(_static_clashes, layout, solids),
        *(partial(_pose_clashes, layout, solids, angle_deg) for angle_deg in poses_deg),
    ]


def interferences(
    layout: Layout, solids: Mapping[str, Any], poses_deg: Sequence[float], jobs: int = 1
) -> tuple[Clash, ...]:
    """All overlaps at the given drum angles. ``solids``: part name to solid in the part's own frame.

    Order of the result does not depend on ``jobs``. Parts without a solid in the mapping are left out.
    """
    tasks = interference_tasks(layout, solids, poses_deg)
    return tuple(clash for found in fork_map(lambda task: task(), tasks, jobs) for clash in found)
