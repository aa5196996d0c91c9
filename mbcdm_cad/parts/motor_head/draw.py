"""Motor head: bearing shelf as a flange, a box above it for the coupling, open to the front, the motor shelf on top."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims
from mbcdm_cad.parts.shapes import block, cut, cylinder_z, fuse, pocket_y


def box_body(d: CouplingBox, into_plate_mm: float = 0.0) -> cq.Shape:
    """The box without its pocket and holes, reaching this far into its plate."""
    box = block((-d.outer_x, d.outer_x), (d.back_y, d.front_y), (d.flange_top_z - into_plate_mm, d.top_z))
    return rounded(box, d.corner_radius)


def box_tools(d: CouplingBox) -> list[cq.Shape]:
    """Pocket, pilot, bearing seat, and the holes for the gearhead's screws and their key."""
    inner = d.inner_x
    tools: list[cq.Shape] = [
        pocket_y((-inner, inner), (-inner, d.front_y + 1.0), (d.flange_top_z, d.shelf_bottom_z), d.corner_radius),
        cylinder_z(d.pilot_radius, 0, 0, d.shelf_bottom_z - 1.0, d.top_z + 1.0),
        cylinder_z(d.shoulder_radius, 0, 0, d.bottom_z, d.flange_top_z + 1.0),
        cylinder_z(d.seat_radius, 0, 0, d.bottom_z - 1.0, d.bottom_z + d.seat_depth),
    ]
    for x, y in d.gear_screws:
        tools.append(cylinder_z(d.gear_screw_clearance, x, y, d.shelf_bottom_z - 1.0, d.top_z + 1.0))
        tools.append(cylinder_z(d.key_hole_radius, x, y, d.bottom_z, d.flange_top_z + 1.0))
    return tools


def rounded(body: cq.Solid, radius: float) -> cq.Shape:
    """The body with its edges along Z rounded."""
    return cq.Workplane(obj=body).edges("|Z").fillet(radius).val()  # type: ignore[return-value]


def create_motor_head(dims: HeadDims) -> cq.Solid:
    """Motor head, its axis Z."""
    d, f = dims, dims.flange
    flange = block((-f.half_x, f.half_x), (f.back_y, f.front_y), (d.bottom_z, d.flange_top_z))
    bodies = [rounded(flange, d.corner_radius), box_body(d, 0.5)]
    tools = box_tools(d)
    tools += [cylinder_z(d.screw_clearance, x, y, d.bottom_z - 1.0, d.flange_top_z + 1.0) for x, y in f.screws]
    tools += [cylinder_z(d.dowel_radius, x, y, d.bottom_z - 1.0, d.flange_top_z + 1.0) for x, y in f.dowels]
    return cut(fuse(bodies, "motor head"), tools, "motor head")
