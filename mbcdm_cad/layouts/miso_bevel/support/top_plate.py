"""Top plate: upper bearings of the input pulleys from below, located by dowels.

On top are the encoders or, with motors above, a coupling box for each gearhead, in one piece with the plate.
"""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layouts.miso_bevel.support.dims import TopPlateDims
from mbcdm_cad.parts.motor_head.draw import box_body, box_tools, rounded
from mbcdm_cad.parts.shapes import block, cut, cylinder_z, fuse


def create_top_plate(dims: TopPlateDims, encoder_head_radius: float, encoder_head_depth: float) -> cq.Solid:
    """Top plate where it stands in the assembly; the encoders' screws are sunk in its underside."""
    v = dims.levels
    low, high = v.top_plate_bottom_z, v.top_plate_top_z
    plate = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (low, high))
    body = rounded(plate, dims.corner_radius)
    tools: list[cq.Shape] = [cylinder_z(dims.axle_radius, 0, 0, low - 1.0, high + 1.0)]
    if dims.boxes:
        body = fuse([body, *(box_body(box).translate((x, dims.input_y, 0.0)) for x, box in dims.boxes)], "top plate")
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
