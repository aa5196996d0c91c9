"""A cable as a round rod swept along its true centre line, one piece after the other, tangent everywhere."""

from __future__ import annotations

import cadquery as cq
import numpy as np

from mbcdm_cad.parts.curve_edges import coil_edge, helix_edge
from mbcdm_cad.parts.shapes import one_solid
from mbcdm_cad.routes.curves import Coil, Helix, Line, Parabola, Piece


def _edge(piece: Piece) -> cq.Edge:
    if isinstance(piece, Helix):
        return helix_edge(piece)
    if isinstance(piece, Coil):
        return coil_edge(piece)
    if isinstance(piece, Line):
        return cq.Edge.makeLine(cq.Vector(*piece.start), cq.Vector(*piece.end))
    if isinstance(piece, Parabola):
        return cq.Edge.makeBezier([cq.Vector(*p) for p in (piece.start, piece.middle, piece.end)])
    start, middle, end = (cq.Vector(*(float(c) for c in p)) for p in piece.points(np.array([0.0, 0.5, 1.0])))
    return cq.Edge.makeThreePointArc(start, middle, end)


def create_cable(pieces: tuple[Piece, ...], radius: float) -> cq.Solid:
    """Rod of ``radius`` along ``pieces`` of a centre line, in the frame of the assembly at the path's drum angle."""
    wire = cq.Wire.assembleEdges([_edge(piece) for piece in pieces])
    first = pieces[0]
    origin = cq.Vector(*(float(c) for c in first.points(np.array([0.0]))[0]))
    profile = cq.Wire.makeCircle(radius, origin, cq.Vector(*(float(c) for c in first.tangent(0.0))))
    return one_solid(cq.Solid.sweep(profile, [], wire, True, True, None, "right"), "cable")
