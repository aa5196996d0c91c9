"""Curves as edges of the kernel, shared by cables and the grooves that carry them."""

from __future__ import annotations

from math import hypot

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_CylindricalSurface
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d

from mbcdm_cad.routes.curves import Coil, Helix


def helix_edge(piece: Helix) -> cq.Edge:
    """The exact helix, from any angle to any other."""
    axis = gp_Ax3(gp_Pnt(piece.centre[0], piece.centre[1], 0.0), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0))
    start, end = (piece.angle_start, piece.z_start), (piece.angle_end, piece.z_end)
    return _unrolled(axis, piece.radius_mm, start, end)


def coil_edge(piece: Coil) -> cq.Edge:
    """The exact coil, from any angle to any other."""
    axis = gp_Ax3(gp_Pnt(*piece.centre), gp_Dir(*piece.axis), gp_Dir(*piece.first))
    start, end = (piece.angle_start, piece.along_start), (piece.angle_end, piece.along_end)
    return _unrolled(axis, piece.radius_mm, start, end)


def _unrolled(axis: gp_Ax3, radius: float, start: tuple[float, float], end: tuple[float, float]) -> cq.Edge:
    """A straight line on the unrolled cylinder, from one (angle, height) to another."""
    surface = Geom_CylindricalSurface(axis, radius)
    da, dz = end[0] - start[0], end[1] - start[1]
    length = hypot(da, dz)
    line = Geom2d_Line(gp_Pnt2d(*start), gp_Dir2d(da / length, dz / length))
    edge = BRepBuilderAPI_MakeEdge(line, surface, 0.0, length).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return cq.Edge(edge)
