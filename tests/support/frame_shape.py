"""Frame and top plate as point-inside tests: the shape for the finite elements, without a CAD kernel.

Rebuilt from the dimensions by booleans of half-spaces and cylinders, so that it is independent of
``mbcdm_cad.parts``; the finite-element test compares its volume with theirs.
"""

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.dims import FrameDims, TopPlateDims

COLUMN_WALL_MM = 1.2
Floats = NDArray[np.float64]
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
