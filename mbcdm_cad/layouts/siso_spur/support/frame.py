"""Frame: plate with boss and yoke, milled from one block, with bores from behind for drum and input."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.boss.draw import boss_bodies, boss_tools
from mbcdm_cad.parts.shapes import block, cut, cylinder_y, fuse


def yoke_bodies(d: YokeDims) -> list[cq.Shape]:
    """Plate from the drum's axis past the input, and the yoke on it."""
    v, x, shelf = d.levels, d.half_width, d.shelf_half_width
    plate = block((-x, x), (v.plate_back_y, v.front_y), (0.0, d.top_z))
    plate = cq.Workplane(obj=plate).edges("|Y and >Z").fillet(d.corner_radius).val()  # type: ignore[assignment]
    bridge = block((-shelf, shelf), (v.plate_back_y, v.top_plate_top_z), (d.bridge_bottom_z, d.top_z))
    bearing = block((-shelf, shelf), (v.top_plate_bottom_z, v.top_plate_top_z), (d.shelf_bottom_z, d.top_z))
    rounded = cq.Workplane(obj=fuse([bridge, bearing], "yoke")).edges("|Y").edges("<Z or >Z")
    return [plate, rounded.fillet(d.corner_radius).val()]  # type: ignore[list-item]


def centre_bodies(d: YokeDims) -> list[cq.Shape]:
    """Rounded end of the plate about the drum's axis, and the boss."""
    return [cylinder_y(d.half_width, 0.0, 0.0, d.levels.plate_back_y, d.levels.front_y), *boss_bodies(d.boss)]


def _input_holes(d: YokeDims) -> list[cq.Shape]:
    v, z = d.levels, d.axis_z
    near, far = v.top_plate_bottom_z, v.top_plate_top_z
    tools: list[cq.Shape] = [
        cylinder_y(d.opening_radius, 0, z, v.plate_back_y - 1.0, v.front_y + 1.0),
        cylinder_y(d.seat_shoulder_radius, 0, z, near, far + 1.0),
        cylinder_y(d.seat_radius, 0, z, near - 1.0, near + d.seat_depth),
    ]
    for sign in (-1, 1):
        x = sign * d.encoder_circle_radius
        tools.append(cylinder_y(d.encoder_screw_clearance, x, z, near, far + 1.0))
        tools.append(cylinder_y(d.encoder_head_radius, x, z, near - 1.0, near + d.encoder_head_depth))
    return tools


def yoke_tools(d: YokeDims) -> list[cq.Shape]:
    """Bores for the input, and holes of the parts that are screwed on."""
    back, front = d.levels.plate_back_y - 1.0, d.levels.front_y + 1.0
    tools = _input_holes(d)
    tools += [cylinder_y(d.flange_screw_radius, x, z, back, front) for x, z in d.flange_screws]
    tools += [cylinder_y(d.dowel_radius, x, z, back, back + 1.0 + d.dowel_depth) for x, z in d.dowels]
    tools += [cylinder_y(d.mount_radius, x, z, back, front) for x, z in d.mounts]
    return tools


def centre_tools(d: YokeDims) -> list[cq.Shape]:
    """Bores of the boss, and the stop pin's hole."""
    pin = cylinder_y(d.stop_pin_radius, 0, d.stop_pin_z, d.levels.plate_back_y - 1.0, d.levels.front_y + 1.0)
    return [*boss_tools(d.boss), pin]


def create_yoke(dims: YokeDims) -> cq.Solid:
    """Frame in its position in the assembly."""
    return cut(
        fuse([*yoke_bodies(dims), *centre_bodies(dims)], "frame"), [*centre_tools(dims), *yoke_tools(dims)], "frame"
    )
