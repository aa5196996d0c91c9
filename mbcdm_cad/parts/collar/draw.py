"""Clamp collar of an input pulley's coupling: slit on one side, one tangential screw, its head on a flat."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.collar.dims import HEAD_PLAY_MM, CollarDims
from mbcdm_cad.parts.shapes import block, cut, cylinder, turned


def create_collar(dims: CollarDims, screw_thread: float, screw_clearance: float, head_diameter: float) -> cq.Solid:
    """Collar about its own axis, heights as in the assembly; slit towards +X, screw along Y with its head at +Y."""
    ring = turned(
        [
            (dims.bore_radius, dims.bottom_z),
            (dims.radius, dims.bottom_z),
            (dims.radius, dims.top_z),
            (dims.bore_radius, dims.top_z),
        ],
        "collar",
    )
    z = (dims.bottom_z + dims.top_z) / 2
    x, reach = dims.screw_offset, dims.radius + 1.0
    slit = block((0.0, reach), (-dims.slit_width / 2, dims.slit_width / 2), (dims.bottom_z - 1, dims.top_z + 1))
    return cut(
        ring,
        [
            slit,
            cylinder(screw_clearance / 2, (x, 0.0, z), (0, 1, 0), reach),
            cylinder(screw_thread / 2, (x, 0.0, z), (0, -1, 0), reach),
            # An open flat, because a counterbore would leave walls of only a quarter of a millimetre.
            block(
                (x - head_diameter / 2 - HEAD_PLAY_MM, reach),
                (dims.head_seat, reach),
                (dims.bottom_z - 1, dims.top_z + 1),
            ),
        ],
        "collar",
    )
