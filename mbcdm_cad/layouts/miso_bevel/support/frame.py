"""Frame of the support: one block, milled from the front in four pockets, bored for the drum's shaft along Y."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layouts.miso_bevel.support.dims import EncoderHoles, FrameDims
from mbcdm_cad.parts.shapes import block, cut, cylinder, cylinder_y, cylinder_z, fuse, pocket_y


def _body(d: FrameDims) -> cq.Solid:
    v = d.levels
    upper = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (v.shelf_bottom_z, v.top_plate_bottom_z))
    upper = cq.Workplane(obj=upper).edges("|Z").fillet(d.corner_radius).val()  # type: ignore[assignment]
    column = block((-d.boss_radius, d.boss_radius), (v.back_y, v.front_y), (0.0, v.shelf_bottom_z))
    boss = cylinder_y(d.boss_radius, 0.0, 0.0, d.encoder_pocket_floor_y, v.boss_front_y)
    ears = block(
        (-d.ear_reach, d.ear_reach),
        (d.encoder_pocket_floor_y, d.ear_front_y),
        (-d.ear_half_height, d.ear_half_height),
    )
    return fuse([upper, column, boss, ears], "frame")


def _pockets(d: FrameDims) -> list[cq.Shape]:
    v = d.levels
    y = (v.pocket_floor_y, v.front_y + 1.0)
    r = d.corner_radius
    side = v.side_inner_x
    tools: list[cq.Shape] = [
        # Open at the top: the rounded corners there fall outside the block.
        pocket_y(
            (-side, side), (d.upper_floor_y, y[1]), (v.bearing_shelf_top_z, v.top_plate_bottom_z + 2 * r + 1.0), r
        ),
        pocket_y((d.web_half_width, side), y, (v.shelf_top_z, v.bearing_shelf_bottom_z), r),
        pocket_y((-side, -d.web_half_width), y, (v.shelf_top_z, v.bearing_shelf_bottom_z), r),
    ]
    if d.has_column_pocket:
        inner = d.boss_radius - d.rib_thickness
        tools.append(pocket_y((-inner, inner), y, (d.column_pocket_bottom_z, v.shelf_bottom_z), r))
    return tools


def _drum_bores(d: FrameDims) -> list[cq.Shape]:
    v = d.levels
    across = d.boss_radius + 1.0
    tools: list[cq.Shape] = [
        block((-across, across), (v.back_y - 1.0, d.encoder_pocket_floor_y), (-across, d.column_start_z)),
        cylinder_y(d.encoder_pocket_radius, 0, 0, v.back_y - 1.0, d.encoder_pocket_floor_y),
        cylinder_y(d.drum_seat_radius, 0, 0, v.back_y - 1.0, d.rear_seat_end_y),
        cylinder_y(d.drum_shoulder_radius, 0, 0, d.rear_seat_end_y - 1.0, d.front_seat_start_y + 1.0),
        cylinder_y(d.drum_seat_radius, 0, 0, d.front_seat_start_y, v.boss_front_y + 1.0),
    ]
    for sign in (-1, 1):
        x = sign * d.encoder_screw_circle
        start = d.encoder_pocket_floor_y - 1.0
        tools.append(cylinder_y(d.encoder_screw_radius, x, 0, start, start + 1.0 + d.encoder_screw_depth))
    return tools


def _input_holes(d: FrameDims) -> list[cq.Shape]:
    v = d.levels
    tools: list[cq.Shape] = []
    below, above = v.shelf_bottom_z - 1.0, v.shelf_top_z + 1.0
    for x in d.input_x:
        y = d.input_y
        if d.carries_drives:
            tools.append(cylinder_z(d.pilot_radius, x, y, below, above))
        tools.append(cylinder_z(d.seat_shoulder_radius, x, y, v.bearing_shelf_bottom_z - 1.0, v.bearing_shelf_top_z))
        tools.append(cylinder_z(d.seat_radius, x, y, v.bearing_shelf_top_z - d.seat_depth, v.bearing_shelf_top_z + 1.0))
        if d.encoder_holes is not None:
            tools += _encoder_holes(d, d.encoder_holes, x)
            continue
        for at in d.gear_screws_at(x):
            tools.append(cylinder_z(d.gear_screw_clearance, *at, below, above))
            tools.append(cylinder_z(d.key_hole_radius, *at, v.bearing_shelf_bottom_z - 1.0, v.bearing_shelf_top_z))
    return tools


def _encoder_holes(d: FrameDims, holes: EncoderHoles, x: float) -> list[cq.Shape]:
    """In the bearing shelf, heads sunk from above."""
    low, high = d.levels.bearing_shelf_bottom_z - 1.0, d.levels.bearing_shelf_top_z
    tools: list[cq.Shape] = []
    for at in holes.places(x):
        tools.append(cylinder_z(holes.clearance, at, d.input_y, low, high + 1.0))
        tools.append(cylinder_z(holes.head_radius, at, d.input_y, high - holes.head_depth, high + 1.0))
    return tools


def _fixing_holes(d: FrameDims) -> list[cq.Shape]:
    v = d.levels
    shelf_z = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    tools: list[cq.Shape] = [
        cylinder_z(d.axle_radius, 0, 0, v.bearing_shelf_bottom_z, v.bearing_shelf_top_z + 1.0),
        cylinder(d.axle_screw_radius, (0, 0, shelf_z), (0, 1, 0), v.front_y + 1.0),
        cylinder_y(d.stop_pin_radius, 0, d.stop_pin_z, d.stop_pin_start_y, v.front_y + 1.0),
    ]
    top = v.top_plate_bottom_z
    tools += [cylinder_z(d.plate_screw_radius, x, y, top - d.plate_screw_depth, top + 1.0) for x, y in d.plate_screws]
    tools += [cylinder_z(d.dowel_radius, x, y, top - d.dowel_depth, top + 1.0) for x, y in d.dowels]
    for x, z in d.mounts:
        tools.append(cylinder_y(d.mount_radius, x, z, v.back_y - 1.0, v.pocket_floor_y + 1.0))
        tools.append(cylinder_y(d.mount_head_radius, x, z, d.mount_seat_y, v.pocket_floor_y + 1.0))
    return tools


def create_frame(dims: FrameDims) -> cq.Solid:
    """Frame in its position in the assembly."""
    return cut(_body(dims), _pockets(dims) + _drum_bores(dims) + _input_holes(dims) + _fixing_holes(dims), "frame")
