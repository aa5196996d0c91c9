"""Axle of an idler, with the collar that carries the lower bearing's inner ring, and its spacer."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.axle.dims import CHAMFER_MM, AxleDims
from mbcdm_cad.parts.shapes import turned


def create_axle(dims: AxleDims) -> cq.Solid:
    """Axle where it stands in the assembly, axis Z."""
    c = CHAMFER_MM
    return turned(
        [
            (0.0, dims.bottom_z),
            (dims.radius - c, dims.bottom_z),
            (dims.radius, dims.bottom_z + c),
            (dims.radius, dims.collar_bottom_z),
            (dims.collar_radius, dims.collar_bottom_z),
            (dims.collar_radius, dims.collar_top_z),
            (dims.radius, dims.collar_top_z),
            (dims.radius, dims.top_z - c),
            (dims.radius - c, dims.top_z),
            (0.0, dims.top_z),
        ],
        "axle",
    )


def create_spacer(dims: AxleDims) -> cq.Solid:
    """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""
    low, high = dims.spacer_bottom_z, dims.spacer_top_z
    return turned(
        [(dims.radius, low), (dims.collar_radius, low), (dims.collar_radius, high), (dims.radius, high)],
        "spacer",
    )
