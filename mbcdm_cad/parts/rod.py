"""A rod along the centre line of a cable, and that line as edges, by the kernel without cadquery.

The interference run draws hundreds of rods in separate processes. Loading cadquery takes a second more than loading the
kernel, and these processes need nothing else of it.
"""

from collections.abc import Sequence
from math import hypot, inf

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire, BRepBuilderAPI_RightCorner
from OCP.BRepLib import BRepLib
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipeShell
from OCP.GC import GC_MakeArcOfCircle
from OCP.Geom import Geom_BezierCurve, Geom_CylindricalSurface
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax2, gp_Ax3, gp_Circ, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TColgp import TColgp_Array1OfPnt
from OCP.TopoDS import TopoDS_Edge, TopoDS_Shape, TopoDS_Wire
from OCP.TopTools import TopTools_ListOfShape

from mbcdm_cad.routes.curves import Coil, Helix, Line, Parabola, Piece, cut

# The kernel sweeps a winding as a single polynomial. Where it is longer than about 170 diameters of the rod, meshing it
# often did not end (14 of 30 random windings), and up to there a fine mesh takes ten times as long.
_LONGEST_DIAMETERS = 50


def edge_of(piece: Piece) -> TopoDS_Edge:
    """The exact curve of one piece of a centre line."""
    if isinstance(piece, Helix):
        axis = gp_Ax3(gp_Pnt(piece.centre[0], piece.centre[1], 0.0), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0))
        start, end = (piece.angle_start, piece.z_start), (piece.angle_end, piece.z_end)
        return _unrolled(axis, piece.radius_mm, start, end)
    if isinstance(piece, Coil):
        axis = gp_Ax3(gp_Pnt(*piece.centre), gp_Dir(*piece.axis), gp_Dir(*piece.first))
        start, end = (piece.angle_start, piece.along_start), (piece.angle_end, piece.along_end)
        return _unrolled(axis, piece.radius_mm, start, end)
    if isinstance(piece, Line):
        return BRepBuilderAPI_MakeEdge(gp_Pnt(*piece.start), gp_Pnt(*piece.end)).Edge()
    if isinstance(piece, Parabola):
        poles = TColgp_Array1OfPnt(1, 3)
        for number, point in enumerate((piece.start, piece.middle, piece.end), start=1):
            poles.SetValue(number, gp_Pnt(*point))
        return BRepBuilderAPI_MakeEdge(Geom_BezierCurve(poles)).Edge()
    start_point, middle, end_point = (_point(p) for p in piece.points(np.array([0.0, 0.5, 1.0])))
    return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(start_point, middle, end_point).Value()).Edge()


def swept_rod(pieces: Sequence[Piece], radius_mm: float) -> TopoDS_Shape:
    """The solid of a rod of ``radius_mm`` along ``pieces``, in their frame.

    Raises ``ValueError``, or one of the kernel's own errors, where there is no such solid.
    """
    tightest = min((p.radius_mm for p in pieces if not isinstance(p, Line | Parabola)), default=inf)
    if tightest <= radius_mm:
        # The kernel sweeps it, and takes what crosses itself for valid; a mesh of it then never ends.
        raise ValueError(f"a bend of {tightest:.4g} mm is too tight for a rod of {radius_mm:.4g} mm radius")
    first = pieces[0]
    direction = gp_Dir(*(float(c) for c in first.tangent(0.0)))
    circle = gp_Circ(gp_Ax2(_point(first.points(np.array([0.0]))[0]), direction), radius_mm)
    longest_mm = _LONGEST_DIAMETERS * 2 * radius_mm
    parts = [part for p in pieces for part in (cut(p, longest_mm) if isinstance(p, Coil | Helix) else [p])]
    pipe = BRepOffsetAPI_MakePipeShell(_wire([edge_of(part) for part in parts]))
    pipe.SetMode(True)  # the section follows the Frenet frame, so it does not turn over on a helix
    pipe.SetTransitionMode(BRepBuilderAPI_RightCorner)
    pipe.Add(_wire([BRepBuilderAPI_MakeEdge(circle).Edge()]), False, False)
    pipe.Build()
    if not pipe.MakeSolid():
        raise ValueError(f"no solid of radius {radius_mm:g} mm along {len(pieces)} pieces of a centre line")
    return pipe.Shape()


def _wire(edges: Sequence[TopoDS_Edge]) -> TopoDS_Wire:
    kept = TopTools_ListOfShape()
    for edge in edges:
        kept.Append(edge)
    builder = BRepBuilderAPI_MakeWire()
    builder.Add(kept)
    builder.Build()
    return builder.Wire()


def _point(place: Sequence[float]) -> gp_Pnt:
    return gp_Pnt(*(float(c) for c in place))


def _unrolled(axis: gp_Ax3, radius: float, start: tuple[float, float], end: tuple[float, float]) -> TopoDS_Edge:
    """A straight line on the unrolled cylinder, from one (angle, height) to another."""
    surface = Geom_CylindricalSurface(axis, radius)
    da, dz = end[0] - start[0], end[1] - start[1]
    length = hypot(da, dz)
    line = Geom2d_Line(gp_Pnt2d(*start), gp_Dir2d(da / length, dz / length))
    edge = BRepBuilderAPI_MakeEdge(line, surface, 0.0, length).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return edge
