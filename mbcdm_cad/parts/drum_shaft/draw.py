"""Hollow shaft of the drum with the flange that holds it in its bearings."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.drum_shaft.dims import CHAMFER_MM, DrumShaftDims
from mbcdm_cad.parts.shapes import cut, turned_about_y


def create_drum_shaft(dims: DrumShaftDims) -> cq.Solid:
    """Drum shaft where it stands in the assembly, axis Y."""
    c, r = CHAMFER_MM, dims.radius
    body = turned_about_y(
        [
            (dims.bore_radius, dims.y_start),
            (dims.radius - c, dims.y_start),
            (dims.radius, dims.y_start + c),
            (dims.radius, dims.flange_start_y),
            (dims.flange_radius, dims.flange_start_y),
            (dims.flange_radius, dims.flange_end_y),
            (dims.radius, dims.flange_end_y),
            (dims.radius, dims.y_end - c),
            (dims.radius - c, dims.y_end),
            (dims.bore_radius, dims.y_end),
        ],
        0.0,
        360.0,
        "drum shaft",
    )
    box = cq.Solid.makeBox(2 * r, dims.flat_length, r, cq.Vector(-r, dims.flat_y - dims.flat_length / 2, dims.flat))
    origin, y = cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)
    return cut(body, [box.rotate(origin, y, deg) for deg in dims.flat_angles_deg], "drum shaft")
