"""A cable as a round rod swept along its true centre line, one piece after the other, tangent everywhere."""

from __future__ import annotations

from math import hypot

import cadquery as cq
import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_CylindricalSurface
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d

from mbcdm_cad.parts.shapes import one_solid
from mbcdm_cad.routes.curves import Helix, Line, Parabola, Piece


def _helix_edge(piece: Helix) -> cq.Edge:
    """A straight line on the unrolled cylinder: the exact helix, from any angle to any other."""
    axis = gp_Ax3(gp_Pnt(piece.centre[0], piece.centre[1], 0.0), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0))
    surface = Geom_CylindricalSurface(axis, piece.radius_mm)
    da, dz = piece.angle_end - piece.angle_start, piece.z_end - piece.z_start
    length = hypot(da, dz)
    line = Geom2d_Line(gp_Pnt2d(piece.angle_start, piece.z_start), gp_Dir2d(da / length, dz / length))
    edge = BRepBuilderAPI_MakeEdge(line, surface, 0.0, length).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return cq.Edge(edge)


def _edge(piece: Piece) -> cq.Edge:
    if isinstance(piece, Helix):
        return _helix_edge(piece)
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
