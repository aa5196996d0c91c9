"""Guide axle with the collar that carries the lower bearing's inner ring."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layout.pulleys import AxleDims
from mbcdm_cad.parts.shapes import turned


def create_guide_axle(dims: AxleDims) -> cq.Solid:
    """Guide axle where it stands in the assembly, axis Z."""
    return turned(
        [
            (0.0, dims.bottom_z),
            (dims.radius, dims.bottom_z),
            (dims.radius, dims.collar_bottom_z),
            (dims.collar_radius, dims.collar_bottom_z),
            (dims.collar_radius, dims.collar_top_z),
            (dims.radius, dims.collar_top_z),
            (dims.radius, dims.top_z),
            (0.0, dims.top_z),
        ],
        "guide axle",
    )
