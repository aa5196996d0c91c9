"""Idler pulley: smooth steps without flanges, a bearing seat in each end."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.idler_pulley.dims import IdlerDims
from mbcdm_cad.parts.shapes import Point2, turned


def create_idler_pulley(dims: IdlerDims) -> cq.Solid:
    """Idler pulley where it stands in the assembly, axis Z."""
    levels = [dims.bottom_z, *dims.walls_z, dims.top_z]
    outside: list[Point2] = []
    for radius, low, high in zip(dims.surface_radii, levels[:-1], levels[1:], strict=True):
        outside += [(radius, low), (radius, high)]
    inside: list[Point2] = [
        (dims.seat_radius, dims.top_z),
        (dims.seat_radius, dims.top_z - dims.seat_depth),
        (dims.shoulder_radius, dims.top_z - dims.seat_depth),
        (dims.shoulder_radius, dims.bottom_z + dims.seat_depth),
        (dims.seat_radius, dims.bottom_z + dims.seat_depth),
        (dims.seat_radius, dims.bottom_z),
    ]
    return turned(outside + inside, "idler pulley")
