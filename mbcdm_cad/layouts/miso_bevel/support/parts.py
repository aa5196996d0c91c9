"""Frame and top plate of the support.

The frame is one block, milled from the front in four pockets, bored for the drum's shaft along Y. The plate holds the
upper bearings of the input pulleys from below, located by dowels; on it are the encoders or, with motors above, a
coupling box for each gearhead, in one piece with the plate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.miso_bevel.support.dims import EncoderHoles, FrameDims, TopPlateDims
from mbcdm_cad.parts.boss import boss_below_column_mm3, boss_bodies, boss_tools, column_bores_mm3
from mbcdm_cad.parts.motor_head.part import box_body, box_tools, coupling_box_mm3, rounded
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import block, cut, cylinder, cylinder_y, cylinder_z, fuse, pocket_y
from mbcdm_cad.parts.volume import CORNER, pocket_mm3, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def _body_mm3(d: FrameDims) -> float:
    v, depth = d.levels, d.levels.front_y - d.levels.back_y
    upper = 2 * v.side_outer_x * depth - 4 * CORNER * d.corner_radius**2
    column = 2 * d.boss.radius * depth * v.shelf_bottom_z
    return upper * (v.top_plate_bottom_z - v.shelf_bottom_z) + column + boss_below_column_mm3(d.boss, v.front_y)


def _pockets_mm3(d: FrameDims) -> float:
    v, r, side = d.levels, d.corner_radius, d.levels.side_inner_x
    depth = v.front_y - v.pocket_floor_y
    coupling = v.bearing_shelf_bottom_z - v.shelf_top_z
    inner = d.boss.radius - d.rib_thickness
    column = v.shelf_bottom_z - d.column_pocket_bottom_z
    return (
        pocket_mm3(2 * side, v.front_y - d.upper_floor_y, v.top_plate_bottom_z - v.bearing_shelf_top_z, r, 2)
        + 2 * pocket_mm3(side - d.web_half_width, depth, coupling, r)
        + (pocket_mm3(2 * inner, depth, column, r) if d.has_column_pocket else 0.0)
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


def _body(d: FrameDims) -> cq.Solid:
    v = d.levels
    upper = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (v.shelf_bottom_z, v.top_plate_bottom_z))
    column = block((-d.boss.radius, d.boss.radius), (v.back_y, v.front_y), (0.0, v.shelf_bottom_z))
    return fuse([rounded(upper, d.corner_radius), column, *boss_bodies(d.boss)], "frame")


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
        inner = d.boss.radius - d.rib_thickness
        tools.append(pocket_y((-inner, inner), y, (d.column_pocket_bottom_z, v.shelf_bottom_z), r))
    return tools


def _drum_bores(d: FrameDims) -> list[cq.Shape]:
    across = d.boss.radius + 1.0
    below = block(
        (-across, across), (d.levels.back_y - 1.0, d.boss.encoder_pocket_floor_y), (-across, d.column_start_z)
    )
    return [below, *boss_tools(d.boss)]


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


@dataclass(frozen=True)
class Frame(MadePart):
    """Frame where it stands in the assembly."""

    dims: FrameDims

    def solid(self) -> cq.Solid:
        """Frame in its position in the assembly."""
        dims = self.dims
        return cut(_body(dims), _pockets(dims) + _drum_bores(dims) + _input_holes(dims) + _fixing_holes(dims), "frame")

    def volume_mm3(self) -> float:
        """Block, column and boss less pockets, bores and holes."""
        d = self.dims
        return _body_mm3(d) - _pockets_mm3(d) - column_bores_mm3(d.boss) - _holes_mm3(d)

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
        """Top plate where it stands in the assembly; the encoders' screws are sunk in its underside."""
        dims, encoder_head_radius, encoder_head_depth = self.dims, self.encoder_head_radius, self.encoder_head_depth
        v = dims.levels
        low, high = v.top_plate_bottom_z, v.top_plate_top_z
        plate = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (low, high))
        body = rounded(plate, dims.corner_radius)
        tools: list[cq.Shape] = [cylinder_z(dims.axle_radius, 0, 0, low - 1.0, high + 1.0)]
        if dims.boxes:
            body = fuse(
                [body, *(box_body(box).translate((x, dims.input_y, 0.0)) for x, box in dims.boxes)], "top plate"
            )
            tools += [tool.translate((x, dims.input_y, 0.0)) for x, box in dims.boxes for tool in box_tools(box)]
        for x in dims.input_x if dims.box is None else ():
            tools.append(cylinder_z(dims.seat_radius, x, dims.input_y, low - 1.0, low + dims.seat_depth))
            tools.append(cylinder_z(dims.shoulder_radius, x, dims.input_y, low, high + 1.0))
            for sign in (-1, 1):
                hole_x = x + sign * dims.encoder_circle_radius
                tools.append(cylinder_z(dims.encoder_screw_clearance, hole_x, dims.input_y, low - 1.0, high + 1.0))
                tools.append(cylinder_z(encoder_head_radius, hole_x, dims.input_y, low - 1.0, low + encoder_head_depth))
        for x, y in dims.screws:
            tools.append(cylinder_z(dims.screw_clearance, x, y, low - 1.0, high + 1.0))
            tools.append(cylinder_z(dims.screw_head_radius, x, y, high - dims.screw_head_depth, high + 1.0))
        tools += [cylinder_z(dims.dowel_radius, x, y, low - 1.0, high + 1.0) for x, y in dims.dowels]
        return cut(body, tools, "top plate")

    def volume_mm3(self) -> float:
        """Plate less seats and holes, with the coupling boxes on it."""
        d, encoder_head_radius, encoder_head_depth = self.dims, self.encoder_head_radius, self.encoder_head_depth
        v = d.levels
        t = v.top_plate_top_z - v.top_plate_bottom_z
        area = 2 * v.side_outer_x * (v.front_y - v.back_y) - 4 * CORNER * d.corner_radius**2
        at_input = ring_mm3(d.shoulder_radius, 0.0, t) + ring_mm3(d.seat_radius, d.shoulder_radius, d.seat_depth)
        encoder = ring_mm3(d.encoder_screw_clearance, 0.0, t)
        encoder += ring_mm3(encoder_head_radius, d.encoder_screw_clearance, encoder_head_depth)
        screw = ring_mm3(d.screw_clearance, 0.0, t) + ring_mm3(
            d.screw_head_radius, d.screw_clearance, d.screw_head_depth
        )
        if d.box is not None:
            at_input = -coupling_box_mm3(d.box)
        return (
            area * t
            - ring_mm3(d.axle_radius, 0.0, t)
            - len(d.input_x) * (at_input + d.encoder_screw_count * encoder)
            - len(d.screws) * screw
            - len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, t)
        )

    def sheet(self, part: str) -> Sheet:
        """Described by ``top_plate_sheet.py`` beside this module."""
        from mbcdm_cad.layouts.miso_bevel.support.top_plate_sheet import top_plate_sheet

        return top_plate_sheet(part, self.dims, self.encoder_head_radius, self.encoder_head_depth)
