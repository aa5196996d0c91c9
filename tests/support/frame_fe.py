"""Finite elements of frame and top plate: graded bricks with incompatible modes, solved directly.

The planes of the grid follow the flat faces; the modulus of cells that a round face cuts is scaled by their share of
metal. The bricks have 8 nodes and nine internal bending modes, which are condensed out, so that one cell through a wall
bends as a wall does. Screw joints are treated as bonded. Units: mm, N, MPa.

The shape is rebuilt from the dimensions by booleans of half-spaces and cylinders, so that it is independent of
``mbcdm_cad.parts``; the test compares its volume with theirs.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support import FrameDims, TopPlateDims

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
SAMPLES = 4
EMPTY = 0.05
# Radius of the mounting screws' heads, under which the back face is held.
MOUNT_PAD_MM = 2.75
CORNERS = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])


@dataclass(frozen=True)
class Seat:
    """A round seat: its middle, the direction of its axis (1: y, 2: z), its radius and width, mm."""

    name: str
    centre: tuple[float, float, float]
    axis: int
    radius: float
    width: float


def seats(layout: BevelLayout) -> tuple[Seat, ...]:
    """Where bearings and axle press on the support."""
    v, f, t, s = layout.levels, layout.frame, layout.top_plate, layout.drum_shaft
    width = layout.drive.bearings.drum.width_mm
    shelf, plate = v.bearing_shelf_top_z - v.bearing_shelf_bottom_z, v.top_plate_top_z - v.top_plate_bottom_z
    found = [
        Seat("drum_rear", (0.0, s.rear_bearing_y + width / 2, 0.0), 1, f.boss.seat_radius, width),
        Seat("drum_front", (0.0, s.front_bearing_y + width / 2, 0.0), 1, f.boss.seat_radius, width),
        Seat("axle_lower", (0.0, 0.0, v.bearing_shelf_bottom_z + shelf / 2), 2, f.axle_radius, shelf),
        Seat("axle_upper", (0.0, 0.0, v.top_plate_bottom_z + plate / 2), 2, t.axle_radius, plate),
    ]
    for pulley in layout.inputs:
        low = (pulley.x, pulley.y, v.bearing_shelf_top_z - f.seat_depth / 2)
        high = (pulley.x, pulley.y, v.top_plate_bottom_z + t.seat_depth / 2)
        found.append(Seat(f"{pulley.name}_lower", low, 2, f.seat_radius, f.seat_depth))
        found.append(Seat(f"{pulley.name}_upper", high, 2, t.seat_radius, t.seat_depth))
    return tuple(found)


def _lines(faces: list[float], wished: list[float], cell: float, least: dict[tuple[float, float], int]) -> Floats:
    """Grid lines through all ``faces`` and those of ``wished`` that lie apart, no further apart than ``cell``.

    ``least`` gives the number of cells between two given planes.
    """
    kept: list[float] = []
    for p in sorted(faces):
        if not kept or p - kept[-1] > 0.1:
            kept.append(p)
    kept += [p for p in wished if kept[0] < p < kept[-1] and min(abs(p - q) for q in kept) > 0.3 * cell]
    kept = sorted(set(kept))
    out = [kept[0]]
    for a, b in pairwise(kept):
        n = max(1, int(np.ceil((b - a) / cell - 0.2)))
        for (low, high), number in least.items():
            if a > low - 1e-6 and b < high + 1e-6:
                n = max(n, int(np.ceil(number * (b - a) / (high - low) - 1e-6)))
        out.extend(np.linspace(a, b, n + 1)[1:])
    return np.array(out)


def grid(layout: BevelLayout, cell_mm: float) -> tuple[Floats, Floats, Floats]:
    """Grid lines in x, y, z through all flat faces; three cells through the back plate, two through the shelves."""
    v, f = layout.levels, layout.frame
    inner = f.boss.radius - f.rib_thickness
    pads = [(x + s * r, z + s * r) for x, z in f.mounts for r in (f.mount_radius, MOUNT_PAD_MM) for s in (-1, 1)]
    xs = [v.side_inner_x, v.side_outer_x, f.boss.radius, inner, f.web_half_width, f.boss.ear_reach]
    boxes = layout.top_plate.boxes
    xs += [at + s * w for at, box in boxes for w in (box.inner_x, box.outer_x) for s in (-1, 1) if at > 0.0]
    x = _lines(
        [0.0, *xs, *(-p for p in xs)],
        [p for p, _ in pads],
        cell_mm,
        {(inner, f.boss.radius): 2, (-f.boss.radius, -inner): 2},
    )
    ys = [v.back_y, f.upper_floor_y, v.pocket_floor_y, f.boss.encoder_pocket_floor_y, f.boss.rear_seat_end_y, 0.0]
    ys += [f.boss.front_seat_start_y, v.front_y, v.boss_front_y, f.boss.ear_front_y]
    ys += [f.input_y + to for _, box in boxes for to in (box.back_y, -box.inner_x, box.front_y)]
    y = _lines(ys, [f.mount_seat_y], cell_mm, {(v.back_y, v.pocket_floor_y): 3})
    zs = [-f.boss.radius, 0.0, f.column_pocket_bottom_z, v.shelf_bottom_z, v.shelf_top_z]
    zs += [v.bearing_shelf_bottom_z]
    zs += [v.bearing_shelf_top_z, v.top_plate_bottom_z, v.top_plate_top_z, v.bearing_shelf_top_z - f.seat_depth]
    zs += [v.top_plate_bottom_z + layout.top_plate.seat_depth, -f.boss.ear_half_height, f.boss.ear_half_height]
    zs += [z for _, box in boxes for z in (box.shelf_bottom_z, box.top_z)]
    shelves = {
        (v.shelf_bottom_z, v.shelf_top_z): 2,
        (v.bearing_shelf_bottom_z, v.bearing_shelf_top_z): 2,
        (v.top_plate_bottom_z, v.top_plate_top_z): 2,
    }
    return x, y, _lines(zs, [p for _, p in pads], cell_mm, shelves)


def metal_share(layout: BevelLayout, x: Floats, y: Floats, z: Floats) -> Floats:
    """Share of each cell (nx, ny, nz) that is metal, from a lattice of points inside it."""
    at = (np.arange(SAMPLES) + 0.5) / SAMPLES

    def points(lines: Floats) -> Floats:
        return (lines[:-1, None] + np.diff(lines)[:, None] * at).ravel()

    px, pz = points(x), points(z)
    share = np.empty((len(x) - 1, len(y) - 1, len(z) - 1))
    for j in range(len(y) - 1):
        py = y[j] + (y[j + 1] - y[j]) * at
        inside = in_support(layout, px[:, None, None], py[None, :, None], pz[None, None, :])
        share[:, j, :] = inside.reshape(len(x) - 1, SAMPLES, SAMPLES, len(z) - 1, SAMPLES).mean(axis=(1, 2, 4))
    return share


def brick_stiffness(sides: Floats, poisson: float) -> Floats:
    """Stiffness (24, 24) of a rectangular brick of modulus 1 with condensed incompatible modes."""
    lam = poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = 1 / (2 * (1 + poisson))
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lam
    volume = float(np.prod(sides))
    signs = 2.0 * CORNERS - 1.0
    gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0)

    def strain(gradients: Floats) -> Floats:
        b = np.zeros((6, 3 * len(gradients)))
        for n, (gx, gy, gz) in enumerate(gradients):
            b[:, 3 * n : 3 * n + 3] = [(gx, 0, 0), (0, gy, 0), (0, 0, gz), (gy, gx, 0), (0, gz, gy), (gz, 0, gx)]
        return b

    full = np.zeros((33, 33))
    for p in np.array(np.meshgrid(gauss, gauss, gauss)).reshape(3, -1).T:
        factor = 1 + signs * p
        grad = np.empty((11, 3))
        for a in range(3):
            other = [i for i in range(3) if i != a]
            grad[:8, a] = signs[:, a] * factor[:, other[0]] * factor[:, other[1]] / 8 * 2 / sides[a]
        # Modes 1 - xi^2, one for each direction: they let the brick bend without parasitic shear.
        grad[8:] = np.diag(-2 * p * 2 / sides)
        b = strain(grad)
        full += b.T @ law @ b * volume / 8
    return full[:24, :24] - full[:24, 24:] @ np.linalg.solve(full[24:, 24:], full[24:, :24])


def _dissected(where: Ints, chosen: Ints) -> list[Ints]:
    """Nested dissection of grid nodes: halves first, the plane between them last."""
    if len(chosen) < 60:
        return [chosen]
    spread = [len(np.unique(where[chosen, a])) for a in range(3)]
    axis = int(np.argmax(spread))
    if spread[axis] < 3:
        return [chosen]
    middle = int(np.median(where[chosen, axis]))
    middle = max(middle, int(where[chosen, axis].min()) + 1)
    column = where[chosen, axis]
    parts = [chosen[column < middle], chosen[column > middle]]
    return [*(q for p in parts if len(p) for q in _dissected(where, p)), chosen[column == middle]]


class SupportFE:
    """Frame and top plate on their mounting screws, factorised once."""

    def __init__(self, layout: BevelLayout, cell_mm: float = 1.6) -> None:
        self.layout = layout
        material = layout.drive.frame_material
        x, y, z = grid(layout, cell_mm)
        share = metal_share(layout, x, y, z)
        cells = np.argwhere(share > EMPTY)
        self.volume_mm3 = float((share * np.einsum("i,j,k->ijk", np.diff(x), np.diff(y), np.diff(z))).sum())
        shape = (len(x), len(y), len(z))
        corner = (cells[:, None, :] + CORNERS).reshape(-1, 3)
        used, node = np.unique(np.ravel_multi_index(tuple(corner.T), shape), return_inverse=True)
        node = node.reshape(-1, 8)
        where = np.stack(np.unravel_index(used, shape), axis=1)
        self.points = np.stack([x[where[:, 0]], y[where[:, 1]], z[where[:, 2]]], axis=1)
        self.weight = np.bincount(node.ravel(), np.repeat(share[tuple(cells.T)], 8), len(used))

        order = np.concatenate(_dissected(where, np.arange(len(used))))
        fixed = self._mounted()
        free = order[~fixed[order]]
        self.number = np.full(len(used), -1)
        self.number[free] = np.arange(len(free))
        modulus = material.youngs_modulus_GPa * 1e3 * share[tuple(cells.T)]
        self.stiffness = self._assembled(
            node,
            np.stack([np.diff(x)[cells[:, 0]], np.diff(y)[cells[:, 1]], np.diff(z)[cells[:, 2]]], axis=1),
            modulus,
            material.poisson_ratio,
        )
        self.solver = spla.splu(
            self.stiffness, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )

    def _mounted(self) -> NDArray[np.bool_]:
        """Nodes on the back face under the mounting screws' bearing area."""
        f, v = self.layout.frame, self.layout.levels
        back = np.abs(self.points[:, 1] - v.back_y) < 1e-6
        held = np.zeros(len(back), dtype=bool)
        for x, z in f.mounts:
            reach = np.hypot(self.points[:, 0] - x, self.points[:, 2] - z)
            held |= back & (reach < MOUNT_PAD_MM + 1e-6)
        return held

    def _assembled(self, node: Ints, sides: Floats, modulus: Floats, poisson: float) -> sp.csc_matrix:
        kinds, kind = np.unique(np.round(sides, 9), axis=0, return_inverse=True)
        unit = np.array([brick_stiffness(s, poisson) for s in kinds])
        number = self.number[node]
        dof = np.where(number[:, :, None] < 0, -1, 3 * number[:, :, None] + np.arange(3)).reshape(len(node), 24)
        rows, columns = np.repeat(dof, 24, axis=1).ravel(), np.tile(dof, (1, 24)).ravel()
        values = (unit[kind.ravel()] * modulus[:, None, None]).ravel()
        keep = (rows >= 0) & (columns >= 0)
        size = 3 * int(self.number.max() + 1)
        return sp.coo_matrix((values[keep], (rows[keep], columns[keep])), shape=(size, size)).tocsc()

    def pressed(self, seat: Seat, axis: int) -> tuple[Ints, Floats]:
        """Nodes round a seat and forces (n, 3) on them: unit resultant along ``axis`` through the seat's middle.

        Across the seat's own axis it is a radial pressure with the cosine of the angle, as a bearing puts it on.
        """
        off = self.points - np.array(seat.centre)
        radial = off.copy()
        radial[:, seat.axis] = 0.0
        across = np.linalg.norm(radial, axis=1)
        near = (np.abs(off[:, seat.axis]) <= seat.width / 2 + 1e-6) & (np.abs(across - seat.radius - 0.4) < 1.2)
        nodes = np.flatnonzero(near & (self.number >= 0))
        outward = radial[nodes] / across[nodes, None]
        along = np.eye(3)[axis]
        shape = np.tile(along, (len(nodes), 1)) if axis == seat.axis else outward * outward[:, [axis]]
        start = shape * self.weight[nodes, None]
        # Least change of this start that makes force and moment right.
        wrench = np.zeros((6, len(nodes), 3))
        wrench[:3] = np.eye(3)[:, None, :]
        for k in range(3):
            wrench[3 + k] = np.cross(np.eye(3)[k], off[nodes])
        rows = wrench.reshape(6, -1)
        start /= (start @ along).sum()
        wrong = np.concatenate([along, np.zeros(3)]) - rows @ start.ravel()
        return nodes, start + np.linalg.lstsq(rows, wrong, rcond=None)[0].reshape(-1, 3)

    def _twisted(self, x: float, y: float) -> tuple[Ints, Floats]:
        """Nodes of the motor shelf under a gearhead's face and forces (x, y) on them: a couple of 1 about Z."""
        v = self.layout.levels
        off = self.points[:, :2] - (x, y)
        level = (self.points[:, 2] > v.motor_shelf_bottom_z - 1e-6) & (self.points[:, 2] < v.motor_shelf_top_z + 1e-6)
        near = np.hypot(*off.T) < self.layout.drive.gearhead.diameter_mm / 2
        nodes = np.flatnonzero(level & near & (self.number >= 0))
        # Rotation without net force: offsets from the weighted middle.
        weight = self.weight[nodes, None]
        off = off[nodes] - (weight * off[nodes]).sum(axis=0) / weight.sum()
        turn = np.stack([-off[:, 1], off[:, 0]], axis=1) * weight
        return nodes, turn / (turn * turn / weight).sum()

    def load_matrix(self) -> sp.csc_matrix:
        """Columns 3 s + a: a unit force on seat s along axis a; then one couple about Z (N mm) for each gearhead."""
        rows, columns, values = [], [], []
        found = seats(self.layout)
        for s, seat in enumerate(found):
            for axis in range(3):
                nodes, force = self.pressed(seat, axis)
                rows.append((3 * self.number[nodes, None] + np.arange(3)).ravel())
                columns.append(np.full(3 * len(nodes), 3 * s + axis))
                values.append(force.ravel())
        for i, pulley in enumerate(self.layout.inputs):
            nodes, push = self._twisted(pulley.x, pulley.y)
            rows.append((3 * self.number[nodes, None] + [0, 1]).ravel())
            columns.append(np.full(2 * len(nodes), 3 * len(found) + i))
            values.append(push.ravel())
        size = (self.stiffness.shape[0], 3 * len(found) + len(self.layout.inputs))
        return sp.coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), size).tocsc()

    def compliance(self) -> Floats:
        """Displacements of the seats (mm) and turns of the gearheads (rad) by unit loads, as :meth:`load_matrix`."""
        loads = self.load_matrix().toarray()
        return np.asarray(loads.T @ self.solver.solve(loads))

    def windup_urad_Nm(self, force_N: Floats, gearhead_torque_Nm: Floats) -> float:
        """f . u of the loads that 1 N m on the drum puts on the seats (n, 3) and on the motor shelf (n_inputs,)."""
        load = self.load_matrix() @ np.concatenate([force_N.ravel(), 1e3 * gearhead_torque_Nm])
        return float(load @ self.solver.solve(load)) * 1e3


COLUMN_WALL_MM = 1.2
Mask = NDArray[np.bool_]


def _between(value: Floats, low: float, high: float) -> Mask:
    return (value >= low) & (value <= high)


def _disc(u: Floats, v: Floats, at_u: float, at_v: float, radius: float) -> Mask:
    return (u - at_u) ** 2 + (v - at_v) ** 2 <= radius**2


def _rounded_box(u: Floats, v: Floats, box: tuple[float, float, float, float], radius: float) -> Mask:
    """Rectangle (u low, u high, v low, v high) whose corners have ``radius``."""
    u0, u1, v0, v1 = box
    r = min(radius, 0.49 * min(u1 - u0, v1 - v0))
    du = np.maximum(np.maximum(u0 + r - u, u - u1 + r), 0.0)
    dv = np.maximum(np.maximum(v0 + r - v, v - v1 + r), 0.0)
    return _between(u, u0, u1) & _between(v, v0, v1) & (du**2 + dv**2 <= r**2)


def in_frame(d: FrameDims, x: Floats, y: Floats, z: Floats) -> Mask:
    """Whether points (mm, arrays that broadcast) lie in the frame."""
    v = d.levels
    outline = (-v.side_outer_x, v.side_outer_x, v.back_y, v.front_y)
    solid = _rounded_box(x, y, outline, d.corner_radius) & _between(z, v.shelf_bottom_z, v.top_plate_bottom_z)
    depth = _between(y, v.back_y, v.front_y)
    solid = solid | (_between(x, -d.boss.radius, d.boss.radius) & depth & _between(z, 0.0, v.shelf_bottom_z))
    solid = solid | (_disc(x, z, 0, 0, d.boss.radius) & _between(y, d.boss.encoder_pocket_floor_y, v.boss_front_y))
    ears = _between(x, -d.boss.ear_reach, d.boss.ear_reach) & _between(
        z, -d.boss.ear_half_height, d.boss.ear_half_height
    )
    solid = solid | (ears & _between(y, d.boss.encoder_pocket_floor_y, d.boss.ear_front_y))

    r, side, web = d.corner_radius, v.side_inner_x, d.web_half_width
    inner = d.boss.radius - d.rib_thickness
    pockets = [
        (-side, side, v.bearing_shelf_top_z, v.top_plate_bottom_z + 2 * r + 1.0, d.upper_floor_y),
        (web, side, v.shelf_top_z, v.bearing_shelf_bottom_z, v.pocket_floor_y),
        (-side, -web, v.shelf_top_z, v.bearing_shelf_bottom_z, v.pocket_floor_y),
        (-inner, inner, d.column_pocket_bottom_z, v.shelf_bottom_z, v.pocket_floor_y),
    ]
    for x0, x1, z0, z1, floor in pockets:
        solid = solid & ~((y > floor) & _rounded_box(x, z, (x0, x1, z0, z1), r))

    # Beside the encoder's pocket the column starts where it is a wall thick.
    low = max(0.0, d.boss.encoder_pocket_radius**2 - (d.boss.radius - COLUMN_WALL_MM) ** 2) ** 0.5
    solid = solid & ~((y < d.boss.encoder_pocket_floor_y) & (z < low))
    for radius, low, high in (
        (d.boss.encoder_pocket_radius, v.back_y, d.boss.encoder_pocket_floor_y),
        (d.boss.seat_radius, v.back_y, d.boss.rear_seat_end_y),
        (d.boss.shoulder_radius, d.boss.rear_seat_end_y, d.boss.front_seat_start_y),
        (d.boss.seat_radius, d.boss.front_seat_start_y, v.boss_front_y),
    ):
        solid = solid & ~(_disc(x, z, 0, 0, radius) & _between(y, low, high))
    shelf = _between(z, v.bearing_shelf_bottom_z, v.bearing_shelf_top_z)
    lower = _between(z, v.shelf_bottom_z, v.shelf_top_z)
    seat = _between(z, v.bearing_shelf_top_z - d.seat_depth, v.bearing_shelf_top_z)
    for at in d.input_x:
        if d.carries_drives:
            solid = solid & ~(_disc(x, y, at, d.input_y, d.pilot_radius) & lower)
        solid = solid & ~(_disc(x, y, at, d.input_y, d.seat_shoulder_radius) & shelf)
        solid = solid & ~(_disc(x, y, at, d.input_y, d.seat_radius) & seat)
    for at_x, at_z in d.mounts:
        solid = solid & ~(_disc(x, z, at_x, at_z, d.mount_radius) & (y < v.pocket_floor_y))
        sunk = (y > d.mount_seat_y) & (y < v.pocket_floor_y)
        solid = solid & ~(_disc(x, z, at_x, at_z, d.mount_head_radius) & sunk)
    return np.asarray(solid & ~(_disc(x, y, 0, 0, d.axle_radius) & shelf))


def in_top_plate(d: TopPlateDims, x: Floats, y: Floats, z: Floats) -> Mask:
    """Whether points lie in the top plate."""
    v = d.levels
    low, high = v.top_plate_bottom_z, v.top_plate_top_z
    outline = (-v.side_outer_x, v.side_outer_x, v.back_y, v.front_y)
    solid = _rounded_box(x, y, outline, d.corner_radius) & _between(z, low, high)
    solid = solid & ~_disc(x, y, 0, 0, d.axle_radius)
    for at, box in d.boxes:
        outline = (at - box.outer_x, at + box.outer_x, d.input_y + box.back_y, d.input_y + box.front_y)
        solid = solid | (_rounded_box(x, y, outline, box.corner_radius) & _between(z, high, box.top_z))
        pocket = (at - box.inner_x, at + box.inner_x, box.flange_top_z, box.shelf_bottom_z)
        solid = solid & ~((y > d.input_y - box.inner_x) & _rounded_box(x, z, pocket, box.corner_radius))
        solid = solid & ~(_disc(x, y, at, d.input_y, box.pilot_radius) & (z > box.shelf_bottom_z))
    for at in d.input_x:
        solid = solid & ~(_disc(x, y, at, d.input_y, d.seat_radius) & (z < low + d.seat_depth))
        solid = solid & ~(_disc(x, y, at, d.input_y, d.shoulder_radius) & (z < high + 1e-6))
    return np.asarray(solid)


def in_support(layout: BevelLayout, x: Floats, y: Floats, z: Floats) -> Mask:
    """Whether points lie in frame or top plate. Threaded and dowel holes count as full: steel sits in them."""
    return in_frame(layout.frame, x, y, z) | in_top_plate(layout.top_plate, x, y, z)
