"""Frame: one block, milled from the front in three pockets, bored for drum and input."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layouts.siso_bevel.support.dims import ColumnDims
from mbcdm_cad.parts.boss.draw import boss_bodies, boss_tools
from mbcdm_cad.parts.shapes import block, cut, cylinder_y, cylinder_z, fuse, pocket_y


def _body(d: ColumnDims) -> cq.Solid:
    v = d.levels
    box = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (d.encoder_shelf_bottom_z, d.top_z))
    box = cq.Workplane(obj=box).edges("|Z").fillet(d.corner_radius).val()  # type: ignore[assignment]
    wide = d.column_half_width
    post = block((-wide, wide), (v.back_y, v.front_y), (d.post_bottom_z, d.encoder_shelf_bottom_z))
    foot = block((-d.boss.radius, d.boss.radius), (v.back_y, v.front_y), (0.0, d.post_bottom_z))
    return fuse([box, post, foot, *boss_bodies(d.boss)], "frame")


def _pockets(d: ColumnDims) -> list[cq.Shape]:
    v, r = d.levels, d.corner_radius
    y = (v.pocket_floor_y, v.front_y + 1.0)
    side, inner = v.side_inner_x, d.pocket_half_width
    beside = d.boss.radius + 1.0
    return [
        # Open at the top: the rounded corners there fall outside the block.
        pocket_y((-side, side), y, (d.encoder_shelf_top_z, d.top_z + 2 * r + 1.0), r),
        pocket_y((-inner, inner), y, (d.stop_shelf_top_z, d.encoder_shelf_bottom_z), r),
        pocket_y((-inner, inner), y, (d.low_pocket_bottom_z, d.stop_shelf_bottom_z), r),
        # Behind the boss, below the encoder's pocket, the column is removed.
        block((-beside, beside), (v.back_y - 1.0, d.boss.encoder_pocket_floor_y), (-1.0, d.column_start_z)),
    ]


def _input_holes(d: ColumnDims) -> list[cq.Shape]:
    low, high = d.encoder_shelf_bottom_z, d.encoder_shelf_top_z
    tools: list[cq.Shape] = [
        cylinder_z(d.seat_shoulder_radius, 0, 0, low - 1.0, high),
        cylinder_z(d.seat_radius, 0, 0, high - d.seat_depth, high + 1.0),
    ]
    for sign in (-1, 1):
        x = sign * d.encoder_circle_radius
        tools.append(cylinder_z(d.encoder_screw_clearance, x, 0, low - 1.0, high + 1.0))
        tools.append(cylinder_z(d.encoder_head_radius, x, 0, high - d.encoder_head_depth, high + 1.0))
    return tools


def _fixing_holes(d: ColumnDims) -> list[cq.Shape]:
    v, top = d.levels, d.top_z
    tools: list[cq.Shape] = [cylinder_y(d.stop_pin_radius, 0, d.stop_pin_z, d.stop_pin_start_y, v.front_y + 1.0)]
    for x, y in d.flange_screws:
        tools.append(cylinder_z(d.flange_screw_radius, x, y, top - d.flange_screw_depth, top + 1.0))
    tools += [cylinder_z(d.dowel_radius, x, y, top - d.dowel_depth, top + 1.0) for x, y in d.dowels]
    tools += [cylinder_y(d.mount_radius, x, z, v.back_y - 1.0, v.pocket_floor_y + 1.0) for x, z in d.mounts]
    return tools


def create_column(dims: ColumnDims) -> cq.Solid:
    """Frame in its position in the assembly."""
    return cut(_body(dims), _pockets(dims) + boss_tools(dims.boss) + _input_holes(dims) + _fixing_holes(dims), "frame")
