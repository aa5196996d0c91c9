"""Frame and top plate as flat panels on a coarse grid: what the module ``stiffness`` beside this one computes with.

Only the half x >= 0 is meshed. Panels stand at mid-thickness and meet at their middle planes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.configurations.miso_bevel.layout import Layout
from mbcdm_cad.configurations.miso_bevel.support.dims import MOUNT_SCREW_HEAD_MM
from mbcdm_cad.configurations.miso_bevel.support.folded_plates import Ints, Plates
from mbcdm_cad.routes import Floats

# Elements longer than this are split. Elements of 3 mm raise the reference frame's windup by 3 % and cost five times as
# long.
CELL_MM = 12.0
# Grid lines closer than this are one.
MERGED_MM = 1.0
# Factor on the thickness of a wall where it runs inside or along another, so that the column's walls are free only
# between the faces. The metal there is about this many times as deep as the wall; with 3 the windup of the reference
# frame rises by 4 %, with 10 it falls by 6 %.
EMBEDDED = 5.0
# What a hole leaves of a cell that is less than this share counts as nothing.
EMPTY = 0.05
X, Y, Z = 0, 1, 2


@dataclass(frozen=True)
class Hole:
    """A hole in a panel: its middle on the two in-plane axes (in the order x, y, z) and its volume."""

    u: float
    v: float
    volume_mm3: float


@dataclass(frozen=True)
class Wall:
    """A wall: axis of its normal, where it stands on it, its box on the other two axes (order x, y, z), thickness."""

    name: str
    normal: int
    at: float
    box: tuple[tuple[float, float], tuple[float, float]]
    thickness_mm: float
    holes: tuple[Hole, ...] = ()
    embedded: tuple[tuple[int, float, float], ...] = ()  # (axis, from, to): inside another wall
    share: float = 1.0  # 0.5 for a panel that the mirror plane halves

    @property
    def axes(self) -> tuple[int, int]:
        """The two in-plane axes in the order x, y, z."""
        u, v = (a for a in (X, Y, Z) if a != self.normal)
        return u, v

    def half_side_mm(self, hole: Hole) -> float:
        """Half the side of the square that has the hole's mean area."""
        return sqrt(hole.volume_mm3 / self.thickness_mm) / 2.0


@dataclass(frozen=True, eq=False)
class SupportMesh:
    """Plates with their grid. ``names`` are the panels, ``weight`` (n,) is 0.5 for halved elements."""

    plates: Plates
    names: tuple[str, ...]
    weight: Floats
    mounted: tuple[Ints, ...]  # nodes under the head of each mounting screw of this half
    middle: NDArray[np.bool_]  # (m,) nodes in the mirror plane

    def near(self, panel: str, point: Iterable[float], reach: tuple[float, float, float]) -> Ints:
        """Nodes of a panel within ``reach`` of ``point`` on each axis."""
        own = np.unique(self.plates.corner[self.plates.panel == self.names.index(panel)])
        off = np.abs(self.plates.node_mm[own] - np.array(tuple(point)))
        found = own[(off <= np.array(reach) + 1e-6).all(axis=1)]
        if not found.size:
            raise ValueError(
                f"frame: the {panel} has no metal at {tuple(round(float(c), 2) for c in point)} mm to carry its load"
            )
        return np.asarray(found)


def panels(layout: Layout) -> list[Wall]:
    """The walls of the half x >= 0."""
    v, f, t = layout.levels, layout.frame, layout.top_plate
    x_wall, x_rib = (v.side_inner_x + v.side_outer_x) / 2, f.boss_radius - f.rib_thickness / 2
    y_back, y_front = (v.back_y + v.pocket_floor_y) / 2, v.front_y
    z_end = f.column_pocket_bottom_z - f.rib_thickness / 2
    z_motor = (v.motor_shelf_bottom_z + v.motor_shelf_top_z) / 2
    z_bearing = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    z_top = (v.top_plate_bottom_z + v.top_plate_top_z) / 2
    at = max(f.input_x)
    motor_t = v.motor_shelf_top_z - v.motor_shelf_bottom_z
    bearing_t = v.bearing_shelf_top_z - v.bearing_shelf_bottom_z
    top_t = v.top_plate_top_z - v.top_plate_bottom_z
    back_t, upper_t = v.pocket_floor_y - v.back_y, f.upper_floor_y - v.back_y
    pilot = Hole(at, f.input_y, pi * f.pilot_radius**2 * motor_t)
    depth = min(f.seat_depth, bearing_t)
    seat = Hole(at, f.input_y, pi * (f.seat_radius**2 * depth + f.seat_shoulder_radius**2 * (bearing_t - depth)))
    depth = min(t.seat_depth, top_t)
    upper_seat = Hole(at, f.input_y, pi * (t.seat_radius**2 * depth + t.shoulder_radius**2 * (top_t - depth)))
    deep, wide, narrow = (y_back, y_front), (0.0, x_wall), (0.0, x_rib)
    # Above the drum's bearings the boss is solid from the seat to the column's pocket.
    block_t = f.column_pocket_bottom_z - f.drum_seat_radius
    ends = ((Z, z_end, f.column_pocket_bottom_z), (Z, v.motor_shelf_bottom_z, z_motor))
    in_rib = (X, f.boss_radius - f.rib_thickness, x_rib)
    on_rib = (X, f.boss_radius - f.rib_thickness, f.boss_radius)
    wall_t = v.side_outer_x - v.side_inner_x
    return [
        Wall("column ribs", X, x_rib, (deep, (z_end, z_motor)), f.rib_thickness, embedded=ends),
        Wall("column back", Y, y_back, (narrow, (z_end, z_motor)), back_t, embedded=(*ends, in_rib)),
        Wall("boss end wall", Z, z_end, (narrow, (y_back, f.encoder_pocket_floor_y)), f.rib_thickness),
        Wall("boss block", Z, z_end, (narrow, (f.encoder_pocket_floor_y, y_front)), block_t),
        Wall("motor shelf", Z, z_motor, (wide, deep), motor_t, (pilot,), (on_rib,)),
        Wall("bearing shelf", Z, z_bearing, (wide, deep), bearing_t, (seat,)),
        Wall("top plate", Z, z_top, (wide, deep), top_t, (upper_seat,)),
        Wall("back plate between shelves", Y, y_back, (wide, (z_motor, z_bearing)), back_t),
        Wall("back plate above", Y, y_back, (wide, (z_bearing, z_top)), upper_t),
        Wall("side walls", X, x_wall, (deep, (z_motor, z_top)), wall_t),
        Wall("stop web", X, 0.0, (deep, (z_motor, z_bearing)), 2 * f.web_half_width, share=0.5),
    ]


def _pad_mm(layout: Layout) -> float:
    """Half the side of the square whose corners stand for the ring under a mounting screw's head.

    That is the ring's radius of gyration about a diameter, sqrt(R^2 + r^2) / 2: four points there have its area and
    its second moment.
    """
    return sqrt((MOUNT_SCREW_HEAD_MM / 2) ** 2 + layout.frame.mount_radius**2) / 2.0


def _lines(wished: Iterable[float], low: float, high: float) -> Floats:
    """Lines through ``wished`` (earlier ones win where two are close), the ends and as many between as CELL_MM asks."""
    kept = [low, high]
    for p in wished:
        if low < p < high and min(abs(p - q) for q in kept) > MERGED_MM:
            kept.append(p)
    kept.sort()
    pieces = [np.linspace(a, b, max(1, round((b - a) / CELL_MM)) + 1)[1:] for a, b in pairwise(kept)]
    return np.concatenate([[kept[0]], *pieces])


def _wished(layout: Layout, walls: list[Wall]) -> Iterator[tuple[int, float]]:
    for wall in walls:
        yield wall.normal, wall.at
        for axis, span in zip(wall.axes, wall.box, strict=True):
            yield axis, span[0]
            yield axis, span[1]
    pad = _pad_mm(layout)
    for x, z in layout.frame.mounts:
        for d in (-pad, pad):
            yield X, x + d
            yield Z, z + d
    for wall in walls:
        for axis, low, high in wall.embedded:
            yield axis, low
            yield axis, high
    for wall in walls:
        for hole in wall.holes:
            half = wall.half_side_mm(hole)
            for d in (-half, half):
                yield wall.axes[0], hole.u + d
                yield wall.axes[1], hole.v + d
    yield Y, 0.0


def _thickness(wall: Wall, u: Floats, v: Floats) -> Floats:
    """Thickness (n_u, n_v) of the cells between the lines ``u`` and ``v``."""
    middle = ((u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2)
    thickness = np.full((len(u) - 1, len(v) - 1), wall.thickness_mm)
    for axis, low, high in wall.embedded:
        inside = (middle[wall.axes.index(axis)] > low) & (middle[wall.axes.index(axis)] < high)
        thickness[inside if axis == wall.axes[0] else (slice(None), inside)] = EMBEDDED * wall.thickness_mm
    area = np.outer(np.diff(u), np.diff(v))
    for hole in wall.holes:
        half = wall.half_side_mm(hole)
        cells = np.ix_(np.abs(middle[0] - hole.u) < half, np.abs(middle[1] - hole.v) < half)
        if area[cells].size:
            thickness[cells] = np.maximum(0.0, thickness[cells] - hole.volume_mm3 / area[cells].sum())
    return thickness


def support_mesh(layout: Layout) -> SupportMesh:
    """Panels cut into elements along one common grid. Panels without extent in this design are left out.

    Raises ``ValueError`` if a wall has no thickness, the column no length, or a mounting screw no back plate.
    """
    walls = panels(layout)
    thin = [f"{wall.name} {wall.thickness_mm:.3g} mm" for wall in walls if not wall.thickness_mm > 0.0]
    if thin:
        raise ValueError(f"frame: walls must have a thickness above 0, got {', '.join(thin)}")
    f, v = layout.frame, layout.levels
    if not v.motor_shelf_bottom_z > f.column_pocket_bottom_z:
        raise ValueError(
            f"frame: the motor shelf at z = {v.motor_shelf_bottom_z:.4g} mm must stand above the boss, which ends at "
            f"z = {f.column_pocket_bottom_z:.4g} mm"
        )
    found = list(_wished(layout, walls))
    own = [[p for a, p in found[: 5 * len(walls)] if a == k] for k in (X, Y, Z)]
    lines = tuple(_lines((p for a, p in found if a == k), min(own[k]), max(own[k])) for k in (X, Y, Z))

    def index(axis: int, at: float) -> int:
        return int(np.argmin(np.abs(lines[axis] - at)))

    corners, normals, thicknesses, owners, weights = [], [], [], [], []
    shape = tuple(len(line) for line in lines)
    for number, wall in enumerate(walls):
        a, b = wall.axes
        span = [(index(axis, low), index(axis, high)) for axis, (low, high) in zip(wall.axes, wall.box, strict=True)]
        (a0, a1), (b0, b1) = span
        if a1 <= a0 or b1 <= b0:
            continue
        thickness = _thickness(wall, lines[a][a0 : a1 + 1], lines[b][b0 : b1 + 1])
        i, j = np.nonzero(thickness > EMPTY * wall.thickness_mm)
        # Element axes are the cyclic successors of the normal: for a normal along y that is (z, x).
        turn = ((0, 0), (1, 0), (1, 1), (0, 1)) if wall.normal != Y else ((0, 0), (0, 1), (1, 1), (1, 0))
        grid = np.empty((3, len(i), 4), dtype=np.int64)
        grid[wall.normal] = index(wall.normal, wall.at)
        grid[a] = a0 + i[:, None] + np.array([p for p, _ in turn])
        grid[b] = b0 + j[:, None] + np.array([q for _, q in turn])
        corners.append(np.ravel_multi_index(tuple(grid), shape))
        thicknesses.append(thickness[i, j])
        normals.append(np.full(len(i), wall.normal))
        owners.append(np.full(len(i), number))
        weights.append(np.full(len(i), wall.share))
    used, corner = np.unique(np.concatenate(corners), return_inverse=True)
    where = np.unravel_index(used, shape)
    node = np.stack([lines[k][where[k]] for k in (X, Y, Z)], axis=1)
    back = where[Y] == 0
    mounted = []
    pad = _pad_mm(layout)
    for x, z in layout.frame.mounts:
        if x > -pad:
            columns = [index(X, p) for p in (x - pad, x + pad) if p > 0.0]
            levels = [index(Z, p) for p in (z - pad, z + pad)]
            mounted.append(np.flatnonzero(back & np.isin(where[X], columns) & np.isin(where[Z], levels)))
            if not mounted[-1].size:
                raise ValueError(f"frame: no back plate under the mounting screw at x {x:.3g}, z {z:.3g} mm")
    plates = Plates(
        node, corner.reshape(-1, 4), np.concatenate(normals), np.concatenate(thicknesses), np.concatenate(owners)
    )
    return SupportMesh(plates, tuple(w.name for w in walls), np.concatenate(weights), tuple(mounted), where[X] == 0)
