"""Views and sections of a solid by the kernel's exact hidden-line removal, as strokes in the plane of the view, mm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cadquery as cq
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepLib import BRepLib
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from OCP.BRepTools import BRepTools_WireExplorer
from OCP.GCPnts import GCPnts_QuasiUniformDeflection
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.HLRAlgo import HLRAlgo_Projector
from OCP.HLRBRep import HLRBRep_Algo, HLRBRep_HLRToShape
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

from mbcdm_cad.drawings.strokes import Point, Stroke, cleaned, fitted
from mbcdm_cad.parts.sheets.description import Vector, View

# Largest distance of a polyline from the curve that it approximates, mm on the part.
_DEFLECTION_MM = 0.005
_HALF_SPACE_MM = 2000.0


@dataclass(frozen=True)
class Picture:
    """Content of a view: visible strokes, hidden strokes, and the loops of each cut face (outer loop first)."""

    visible: tuple[Stroke, ...]
    hidden: tuple[Stroke, ...]
    faces: tuple[tuple[tuple[Point, ...], ...], ...]


def picture(solid: cq.Shape, view: View) -> Picture:
    """Project ``solid``; for a section with its cut faces."""
    shape = solid
    faces: tuple[tuple[tuple[Point, ...], ...], ...] = ()
    if view.cut is not None:
        shape = solid.cut(_half_space(view, view.cut))
        faces = _section(solid, view, view.cut)
    algorithm = HLRBRep_Algo()
    algorithm.Add(shape.wrapped)
    algorithm.Projector(HLRAlgo_Projector(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(*view.toward), gp_Dir(*view.right))))
    algorithm.Update()
    algorithm.Hide()
    shapes = HLRBRep_HLRToShape(algorithm)
    visible = [*_strokes(shapes.VCompound()), *_strokes(shapes.OutLineVCompound())]
    hidden = [*_strokes(shapes.HCompound()), *_strokes(shapes.OutLineHCompound())] if view.hidden else []
    seen, behind = cleaned(visible, hidden)
    return Picture(tuple(seen), tuple(behind), faces)


def _half_space(view: View, at: Vector) -> cq.Solid:
    """The half space between the section plane and the reader."""
    half = _HALF_SPACE_MM / 2
    corner = [a - half * r - half * u for a, r, u in zip(at, view.right, view.up, strict=True)]
    axes = gp_Ax2(gp_Pnt(*corner), gp_Dir(*view.toward), gp_Dir(*view.right))
    return cq.Solid(BRepPrimAPI_MakeBox(axes, _HALF_SPACE_MM, _HALF_SPACE_MM, _HALF_SPACE_MM).Shape())


def _section(solid: cq.Shape, view: View, at: Vector) -> tuple[tuple[tuple[Point, ...], ...], ...]:
    plane = cq.Face.makePlane(_HALF_SPACE_MM, _HALF_SPACE_MM, cq.Vector(*at), cq.Vector(*view.toward))
    found = []
    for face in plane.intersect(solid).Faces():
        loops = [_loop(face.outerWire(), view)] + [_loop(wire, view) for wire in face.innerWires()]
        found.append(tuple(loops))
    return tuple(sorted(found))


def _loop(wire: cq.Wire, view: View) -> tuple[Point, ...]:
    explorer = BRepTools_WireExplorer(wire.wrapped)
    points: list[Point] = []
    while explorer.More():
        edge = explorer.Current()
        samples = [view.project(p) for p in _samples(BRepAdaptor_Curve(edge))]
        if edge.Orientation().name.endswith("REVERSED"):
            samples.reverse()
        points += samples[:-1]
        explorer.Next()
    start = min(range(len(points)), key=lambda i: (round(points[i][0], 6), round(points[i][1], 6)))
    return tuple(points[start:] + points[:start])


def _strokes(compound: Any) -> Iterator[Stroke]:
    if compound is None or compound.IsNull():
        return
    BRepLib.BuildCurves3d_s(compound)
    explorer = TopExp_Explorer(compound, TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        curve = BRepAdaptor_Curve(TopoDS.Edge_s(explorer.Current()))
        stroke = fitted([(x, y) for x, y, _ in _samples(curve)])
        if stroke is not None:
            yield stroke
        explorer.Next()


def _samples(curve: BRepAdaptor_Curve) -> list[Vector]:
    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() == GeomAbs_CurveType.GeomAbs_Line:
        values = [first, last]
    elif curve.GetType() == GeomAbs_CurveType.GeomAbs_Circle:
        values = [first + (last - first) * k / 36 for k in range(37)]
    else:
        spread = GCPnts_QuasiUniformDeflection(curve, _DEFLECTION_MM, first, last)
        if spread.IsDone() and spread.NbPoints() >= 9:
            return [_vector(spread.Value(k + 1)) for k in range(spread.NbPoints())]
        values = [first + (last - first) * k / 16 for k in range(17)]
    return [_vector(curve.Value(v)) for v in values]


def _vector(p: gp_Pnt) -> Vector:
    return (p.X(), p.Y(), p.Z())
