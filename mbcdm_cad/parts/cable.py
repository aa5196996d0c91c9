"""A cable as a round rod swept along its true centre line, one piece after the other, tangent everywhere."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.rod import swept_rod
from mbcdm_cad.parts.shapes import one_solid
from mbcdm_cad.routes.curves import Piece


def create_cable(pieces: tuple[Piece, ...], radius: float) -> cq.Solid:
    """Rod of ``radius`` along ``pieces`` of a centre line, in the frame of the assembly at the path's drum angle."""
    return one_solid(cq.Shape.cast(swept_rod(pieces, radius)), "cable")
