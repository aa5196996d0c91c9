"""Volumes of frame and top plate in closed form, for the estimate of mass."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.miso_bevel.support.dims import EncoderHoles, FrameDims, TopPlateDims
from mbcdm_cad.parts.motor_head.part import coupling_box_mm3
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.volume import CORNER, pocket_mm3, ring_mm3, segment_mm2

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def frame_mm3(d: FrameDims) -> float:
    """Block, column and boss less pockets, bores and holes."""
    return _body_mm3(d) - _pockets_mm3(d) - _drum_bores_mm3(d) - _holes_mm3(d)


def _body_mm3(d: FrameDims) -> float:
    v, depth = d.levels, d.levels.front_y - d.levels.back_y
    upper = 2 * v.side_outer_x * depth - 4 * CORNER * d.corner_radius**2
    column = 2 * d.boss_radius * depth * v.shelf_bottom_z
    disc = pi * d.boss_radius**2 / 2
    boss = disc * (v.boss_front_y - d.encoder_pocket_floor_y) + disc * (v.boss_front_y - v.front_y)
    h = d.ear_half_height
    # Below the axis the ears stand out of the boss, above it out of the column.
    chord = (d.boss_radius + sqrt(max(d.boss_radius**2 - h**2, 0.0))) / 2
    out = max(d.ear_reach - d.boss_radius, 0.0) + max(d.ear_reach - chord, 0.0)
    ears = 2 * out * h * max(d.ear_front_y - d.encoder_pocket_floor_y, 0.0)
    return upper * (v.top_plate_bottom_z - v.shelf_bottom_z) + column + boss + ears


def _pockets_mm3(d: FrameDims) -> float:
    v, r, side = d.levels, d.corner_radius, d.levels.side_inner_x
    depth = v.front_y - v.pocket_floor_y
    coupling = v.bearing_shelf_bottom_z - v.shelf_top_z
    inner = d.boss_radius - d.rib_thickness
    column = v.shelf_bottom_z - d.column_pocket_bottom_z
    return (
        pocket_mm3(2 * side, v.front_y - d.upper_floor_y, v.top_plate_bottom_z - v.bearing_shelf_top_z, r, 2)
        + 2 * pocket_mm3(side - d.web_half_width, depth, coupling, r)
        + (pocket_mm3(2 * inner, depth, column, r) if d.has_column_pocket else 0.0)
    )


def _drum_bores_mm3(d: FrameDims) -> float:
    v, behind = d.levels, d.encoder_pocket_floor_y - d.levels.back_y
    open_below = 2 * d.boss_radius * d.column_start_z + segment_mm2(d.encoder_pocket_radius, d.column_start_z)
    seats = d.rear_seat_end_y - d.encoder_pocket_floor_y + v.boss_front_y - d.front_seat_start_y
    return (
        open_below * behind
        + ring_mm3(d.drum_seat_radius, 0.0, seats)
        + ring_mm3(d.drum_shoulder_radius, 0.0, d.front_seat_start_y - d.rear_seat_end_y)
        + ring_mm3(d.encoder_screw_radius, 0.0, 2 * d.encoder_screw_depth)
    )


def _holes_mm3(d: FrameDims) -> float:
    v = d.levels
    lowest, bearing = v.shelf_top_z - v.shelf_bottom_z, v.bearing_shelf_top_z - v.bearing_shelf_bottom_z
    back = v.pocket_floor_y - v.back_y
    if d.encoder_holes is None:
        at_input = (
            ring_mm3(d.pilot_radius, 0.0, lowest)
            + d.gear_screw_count * ring_mm3(d.gear_screw_clearance, 0.0, lowest)
            + ring_mm3(d.seat_radius, 0.0, d.seat_depth)
            + ring_mm3(d.seat_shoulder_radius, 0.0, bearing - d.seat_depth)
            # About half of each key hole lies outside the shoulder's bore.
            + d.gear_screw_count * ring_mm3(d.key_hole_radius, 0.0, bearing - d.seat_depth) / 2
        )
    else:
        at_input = (
            ring_mm3(d.seat_radius, 0.0, d.seat_depth)
            + ring_mm3(d.seat_shoulder_radius, 0.0, bearing - d.seat_depth)
            + len(d.encoder_holes.places(0.0)) * _sunk_mm3(d.encoder_holes, bearing)
        )
    return (
        len(d.input_x) * at_input
        + ring_mm3(d.axle_radius, 0.0, bearing)
        + ring_mm3(d.axle_screw_radius, 0.0, v.front_y - d.axle_radius)
        + ring_mm3(d.stop_pin_radius, 0.0, v.front_y - d.stop_pin_start_y)
        + len(d.plate_screws) * ring_mm3(d.plate_screw_radius, 0.0, d.plate_screw_depth)
        + len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, d.dowel_depth)
        + len(d.mounts) * ring_mm3(d.mount_radius, 0.0, back)
        + len(d.mounts) * ring_mm3(d.mount_head_radius, d.mount_radius, v.pocket_floor_y - d.mount_seat_y)
    )


def _sunk_mm3(d: EncoderHoles, thick: float) -> float:
    """One hole of an encoder's screw with its counterbore."""
    return ring_mm3(d.clearance, 0.0, thick) + ring_mm3(d.head_radius, d.clearance, d.head_depth)


def top_plate_mm3(d: TopPlateDims, encoder_head_radius: float, encoder_head_depth: float) -> float:
    """Plate less seats and holes, with the coupling boxes on it."""
    v = d.levels
    t = v.top_plate_top_z - v.top_plate_bottom_z
    area = 2 * v.side_outer_x * (v.front_y - v.back_y) - 4 * CORNER * d.corner_radius**2
    at_input = ring_mm3(d.shoulder_radius, 0.0, t) + ring_mm3(d.seat_radius, d.shoulder_radius, d.seat_depth)
    encoder = ring_mm3(d.encoder_screw_clearance, 0.0, t)
    encoder += ring_mm3(encoder_head_radius, d.encoder_screw_clearance, encoder_head_depth)
    screw = ring_mm3(d.screw_clearance, 0.0, t) + ring_mm3(d.screw_head_radius, d.screw_clearance, d.screw_head_depth)
    if d.box is not None:
        at_input = -coupling_box_mm3(d.box)
    return (
        area * t
        - ring_mm3(d.axle_radius, 0.0, t)
        - len(d.input_x) * (at_input + d.encoder_screw_count * encoder)
        - len(d.screws) * screw
        - len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, t)
    )


@dataclass(frozen=True)
class Frame(MadePart):
    """Frame where it stands in the assembly."""

    dims: FrameDims

    def solid(self) -> cq.Solid:
        """Drawn by ``frame.py`` beside this module."""
        from mbcdm_cad.layouts.miso_bevel.support.frame import create_frame

        return create_frame(self.dims)

    def volume_mm3(self) -> float:
        """Closed form, mm^3."""
        return frame_mm3(self.dims)

    def sheet(self, part: str) -> Sheet:
        """Described by ``frame_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.miso_bevel.support.frame_sheet import frame_sheet

        return frame_sheet(part, self.dims)


@dataclass(frozen=True)
class TopPlate(MadePart):
    """Top plate where it stands in the assembly; counterbores of the encoders' screws in mm."""

    dims: TopPlateDims
    encoder_head_radius: float
    encoder_head_depth: float

    def solid(self) -> cq.Solid:
        """Drawn by ``top_plate.py`` beside this module."""
        from mbcdm_cad.layouts.miso_bevel.support.top_plate import create_top_plate

        return create_top_plate(self.dims, self.encoder_head_radius, self.encoder_head_depth)

    def volume_mm3(self) -> float:
        """Closed form, mm^3."""
        return top_plate_mm3(self.dims, self.encoder_head_radius, self.encoder_head_depth)

    def sheet(self, part: str) -> Sheet:
        """Described by ``top_plate_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.miso_bevel.support.top_plate_sheet import top_plate_sheet

        return top_plate_sheet(part, self.dims, self.encoder_head_radius, self.encoder_head_depth)
