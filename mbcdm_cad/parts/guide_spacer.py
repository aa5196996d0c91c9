"""Spacer on the guide axle between the upper bearing's inner ring and the top plate."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layout.pulleys import AxleDims
from mbcdm_cad.parts.shapes import turned


def create_guide_spacer(dims: AxleDims) -> cq.Solid:
    """Ring where it stands in the assembly, axis Z."""
    low, high = dims.spacer_bottom_z, dims.spacer_top_z
    return turned(
        [(dims.radius, low), (dims.collar_radius, low), (dims.collar_radius, high), (dims.radius, high)],
        "guide spacer",
    )
