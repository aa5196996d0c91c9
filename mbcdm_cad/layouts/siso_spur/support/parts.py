"""Volume of the frame in closed form, for the estimate of mass."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.volume import CORNER, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def yoke_mm3(d: YokeDims) -> float:
    """Plate, boss and yoke less bores and holes."""
    thick = d.levels.front_y - d.levels.plate_back_y
    return arm_mm3(d) + pi * d.half_width**2 / 2 * thick + boss_mm3(d)


def arm_mm3(d: YokeDims) -> float:
    """Plate from the drum's axis upwards, and the yoke on it, less their bores and holes."""
    v = d.levels
    plate = (2 * d.half_width * d.top_z - 2 * CORNER * d.corner_radius**2) * (v.front_y - v.plate_back_y)
    return plate + _yoke_mm3(d) - _holes_mm3(d)


def _yoke_mm3(d: YokeDims) -> float:
    """Volume in front of the plate: the bridge, and the shelf under it."""
    v, wide = d.levels, 2 * d.shelf_half_width
    rounded = 2 * CORNER * d.corner_radius**2
    bridge = (wide * (d.top_z - d.bridge_bottom_z) - rounded) * (v.top_plate_top_z - v.front_y)
    shelf = (wide * (d.bridge_bottom_z - d.shelf_bottom_z) - rounded) * (v.top_plate_top_z - v.top_plate_bottom_z)
    return bridge + shelf


def boss_mm3(d: YokeDims) -> float:
    """Boss outside the plate, less the bores of both and the hole of the stop pin."""
    v, b = d.levels, d.boss
    disc = pi * b.radius**2
    behind, before = v.plate_back_y - b.encoder_pocket_floor_y, b.front_y - v.front_y
    seats = b.rear_seat_end_y - b.encoder_pocket_floor_y + b.front_y - b.front_seat_start_y
    ears = 4 * max(b.ear_reach - b.radius, 0.0) * b.ear_half_height
    return (
        disc * (behind + before)
        + ears * max(min(b.ear_front_y, v.plate_back_y) - b.encoder_pocket_floor_y, 0.0)
        - ring_mm3(b.seat_radius, 0.0, seats)
        - ring_mm3(b.shoulder_radius, 0.0, b.front_seat_start_y - b.rear_seat_end_y)
        - 2 * ring_mm3(b.screw_radius, 0.0, b.screw_depth)
        - ring_mm3(d.stop_pin_radius, 0.0, v.front_y - v.plate_back_y)
    )


def _holes_mm3(d: YokeDims) -> float:
    v, plate = d.levels, d.levels.front_y - d.levels.plate_back_y
    shelf = v.top_plate_top_z - v.top_plate_bottom_z
    encoder = ring_mm3(d.encoder_screw_clearance, 0.0, shelf - d.encoder_head_depth)
    encoder += ring_mm3(d.encoder_head_radius, 0.0, d.encoder_head_depth)
    return (
        ring_mm3(d.opening_radius, 0.0, plate)
        + ring_mm3(d.seat_shoulder_radius, 0.0, shelf - d.seat_depth)
        + ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        + 2 * encoder
        + len(d.flange_screws) * ring_mm3(d.flange_screw_radius, 0.0, plate)
        + len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, d.dowel_depth)
        + len(d.mounts) * ring_mm3(d.mount_radius, 0.0, plate)
    )


@dataclass(frozen=True)
class Yoke(MadePart):
    """Frame where it stands in the assembly."""

    dims: YokeDims

    def solid(self) -> cq.Solid:
        """Drawn by ``frame.py`` beside this module."""
        from mbcdm_cad.layouts.siso_spur.support.frame import create_yoke

        return create_yoke(self.dims)

    def volume_mm3(self) -> float:
        """Closed form, mm^3."""
        return yoke_mm3(self.dims)

    def sheet(self, part: str) -> Sheet:
        """Described by ``frame_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.siso_spur.support.frame_sheet import yoke_sheet

        return yoke_sheet(part, self.dims)
