"""Threaded terminal of a cable: swage with a bore and two flats, stud behind it. Axis Z, the cable comes from -Z."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.shapes import cut, turned
from mbcdm_cad.parts.terminal.dims import CHAMFER_MM, TerminalDims


def create_terminal(dims: TerminalDims) -> cq.Solid:
    """Terminal along Z, its flats at +-y: one slides along the wall of its pocket and keeps the rope from twisting."""
    c = CHAMFER_MM
    body = turned(
        [
            (0.0, dims.cable_end),
            (dims.bore_radius, dims.cable_end),
            (dims.bore_radius, dims.swage_start),
            (dims.swage_radius - c, dims.swage_start),
            (dims.swage_radius, dims.swage_start + c),
            (dims.swage_radius, dims.swage_end),
            (dims.stud_radius, dims.swage_end),
            (dims.stud_radius, dims.tip - c),
            (dims.stud_radius - c, dims.tip),
            (0.0, dims.tip),
        ],
        "terminal",
    )
    length = dims.swage_end - dims.swage_start
    sides = [
        cq.Solid.makeBox(
            2.0 * dims.swage_radius, dims.swage_radius, length, cq.Vector(-dims.swage_radius, y, dims.swage_start)
        )
        for y in (dims.flat, -dims.flat - dims.swage_radius)
    ]
    return cut(body, sides, "terminal")
