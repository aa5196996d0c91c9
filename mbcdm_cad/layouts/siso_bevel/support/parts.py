"""Volumes of frame and motor head in closed form, for the estimate of mass."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_bevel.support.dims import ColumnDims
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.volume import CORNER, pocket_mm3, ring_mm3, segment_mm2

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def column_mm3(d: ColumnDims) -> float:
    """Block, column and boss less pockets, bores and holes."""
    return _body_mm3(d) - _pockets_mm3(d) - _boss_bores_mm3(d) - _holes_mm3(d)


def _body_mm3(d: ColumnDims) -> float:
    v, boss, depth = d.levels, d.boss, d.levels.front_y - d.levels.back_y
    box = 2 * v.side_outer_x * depth - 4 * CORNER * d.corner_radius**2
    post = 2 * d.column_half_width * depth * (d.encoder_shelf_bottom_z - d.post_bottom_z)
    foot = 2 * boss.radius * depth * d.post_bottom_z
    disc = pi * boss.radius**2 / 2
    # Below the axis the ears stand out of the boss, above it out of the column.
    h = boss.ear_half_height
    chord = (boss.radius + sqrt(max(boss.radius**2 - h**2, 0.0))) / 2
    out = max(boss.ear_reach - boss.radius, 0.0) + max(boss.ear_reach - chord, 0.0)
    ears = 2 * out * h * max(boss.ear_front_y - boss.encoder_pocket_floor_y, 0.0)
    round_boss = disc * (boss.front_y - boss.encoder_pocket_floor_y) + disc * (boss.front_y - v.front_y)
    return box * (d.top_z - d.encoder_shelf_bottom_z) + post + foot + round_boss + ears


def _pockets_mm3(d: ColumnDims) -> float:
    v, r = d.levels, d.corner_radius
    depth, inner = v.front_y - v.pocket_floor_y, 2 * d.pocket_half_width
    return (
        pocket_mm3(2 * v.side_inner_x, depth, d.top_z - d.encoder_shelf_top_z, r, 2)
        + pocket_mm3(inner, depth, d.encoder_shelf_bottom_z - d.stop_shelf_top_z, r)
        + pocket_mm3(inner, depth, d.stop_shelf_bottom_z - d.low_pocket_bottom_z, r)
    )


def _boss_bores_mm3(d: ColumnDims) -> float:
    boss = d.boss
    behind = boss.encoder_pocket_floor_y - boss.back_y
    open_below = 2 * boss.radius * d.column_start_z + segment_mm2(boss.encoder_pocket_radius, d.column_start_z)
    seats = boss.rear_seat_end_y - boss.encoder_pocket_floor_y + boss.front_y - boss.front_seat_start_y
    return (
        open_below * behind
        + ring_mm3(boss.seat_radius, 0.0, seats)
        + ring_mm3(boss.shoulder_radius, 0.0, boss.front_seat_start_y - boss.rear_seat_end_y)
        + ring_mm3(boss.screw_radius, 0.0, 2 * boss.screw_depth)
    )


def _holes_mm3(d: ColumnDims) -> float:
    v, shelf = d.levels, d.encoder_shelf_top_z - d.encoder_shelf_bottom_z
    encoder = ring_mm3(d.encoder_screw_clearance, 0.0, shelf - d.encoder_head_depth)
    encoder += ring_mm3(d.encoder_head_radius, 0.0, d.encoder_head_depth)
    return (
        ring_mm3(d.seat_shoulder_radius, 0.0, shelf - d.seat_depth)
        + ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        + 2 * encoder
        + ring_mm3(d.stop_pin_radius, 0.0, v.front_y - d.stop_pin_start_y)
        + len(d.flange_screws) * ring_mm3(d.flange_screw_radius, 0.0, d.flange_screw_depth)
        + len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, d.dowel_depth)
        + len(d.mounts) * ring_mm3(d.mount_radius, 0.0, v.pocket_floor_y - v.back_y)
    )


@dataclass(frozen=True)
class ColumnFrame(MadePart):
    """Frame where it stands in the assembly."""

    dims: ColumnDims

    def solid(self) -> cq.Solid:
        """Drawn by ``frame.py`` beside this module."""
        from mbcdm_cad.layouts.siso_bevel.support.frame import create_column

        return create_column(self.dims)

    def volume_mm3(self) -> float:
        """Closed form, mm^3."""
        return column_mm3(self.dims)

    def sheet(self, part: str) -> Sheet:
        """Described by ``frame_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.siso_bevel.support.frame_sheet import column_sheet

        return column_sheet(part, self.dims)
