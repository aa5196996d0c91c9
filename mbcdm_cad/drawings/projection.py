"""Views, sections and details of a solid by exact hidden-line removal, as strokes in the plane of the view, mm."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
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

from mbcdm_cad.drawings.strokes import LineStroke, Point, PolyStroke, Stroke, cleaned, fitted, points_of
from mbcdm_cad.parts.sheet import Vector, View

# Largest distance of a polyline from the curve that it approximates, mm on the part.
_DEFLECTION_MM = 0.005
_HALF_SPACE_MM = 2000.0
# The box of a body is larger than the body by the kernel's tolerance.
_AT_PLANE_MM = 0.01
Loops = tuple[tuple[Point, ...], ...]


@dataclass(frozen=True)
class Picture:
    """Content of a view: visible strokes, hidden strokes, and the loops of each cut face (outer loop first).

    ``bodies``: the number of the body that each face cuts.
    """

    visible: tuple[Stroke, ...]
    hidden: tuple[Stroke, ...]
    faces: tuple[Loops, ...]
    bodies: tuple[int, ...] = ()


def picture(solid: cq.Shape, view: View, whole: cq.Shape | None = None) -> Picture:
    """Project ``solid``, of one or more bodies; for a section with its cut faces.

    Bodies of ``whole`` are not cut; those whose middle lies before the section plane are left out.
    """
    bodies: list[cq.Shape] = [*solid.Solids()] or [solid]
    uncut: list[cq.Shape] = [*whole.Solids()] if whole is not None else []
    faces: list[tuple[Loops, int]] = []
    if view.cut is not None:
        plane = cq.Vector(*view.cut).dot(cq.Vector(*view.toward))
        space, cut = _half_space(view, view.cut), []
        for number, body in enumerate(bodies):
            low, high = _depths(body, view)
            if low < plane - _AT_PLANE_MM:
                # Few bodies of an assembly reach through the plane; a boolean of the others takes time for nothing.
                through = high > plane + _AT_PLANE_MM
                cut.append(body.cut(space) if through else body)
                if through:
                    faces += [(loops, number) for loops in _section(body, view, view.cut)]
        bodies, uncut = cut, [b for b in uncut if sum(_depths(b, view)) / 2 < plane + _AT_PLANE_MM]
    algorithm = HLRBRep_Algo()
    # As one shape: the kernel takes many times as long for bodies one by one.
    together = [*bodies, *uncut]
    algorithm.Add((together[0] if len(together) == 1 else cq.Compound.makeCompound(together)).wrapped)
    algorithm.Projector(HLRAlgo_Projector(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(*view.toward), gp_Dir(*view.right))))
    algorithm.Update()
    algorithm.Hide()
    shapes = HLRBRep_HLRToShape(algorithm)
    visible = [*_strokes(shapes.VCompound()), *_strokes(shapes.OutLineVCompound())]
    hidden = [*_strokes(shapes.HCompound()), *_strokes(shapes.OutLineHCompound())] if view.hidden else []
    seen, behind = cleaned(visible, hidden)
    faces.sort()
    return Picture(tuple(seen), tuple(behind), tuple(f for f, _ in faces), tuple(n for _, n in faces))


def _depths(body: cq.Shape, view: View) -> tuple[float, float]:
    """Least and greatest distance of a body's box towards the reader, mm from the origin."""
    box = body.BoundingBox()
    sides = zip((box.xmin, box.ymin, box.zmin), (box.xmax, box.ymax, box.zmax), view.toward, strict=True)
    ends = [sorted((low * t, high * t)) for low, high, t in sides]
    return sum(e[0] for e in ends), sum(e[1] for e in ends)


def _half_space(view: View, at: Vector) -> cq.Solid:
    """The half space between the section plane and the reader."""
    half = _HALF_SPACE_MM / 2
    corner = [a - half * r - half * u for a, r, u in zip(at, view.right, view.up, strict=True)]
    axes = gp_Ax2(gp_Pnt(*corner), gp_Dir(*view.toward), gp_Dir(*view.right))
    return cq.Solid(BRepPrimAPI_MakeBox(axes, _HALF_SPACE_MM, _HALF_SPACE_MM, _HALF_SPACE_MM).Shape())


def _section(solid: cq.Shape, view: View, at: Vector) -> tuple[Loops, ...]:
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


def clipped(picture: Picture, view: View) -> Picture:
    """Strokes and cut faces inside the view's window."""
    assert view.window is not None
    centre, half_width, half_height = view.window
    u, v = view.project(centre)
    low, high = (u - half_width, v - half_height), (u + half_width, v + half_height)
    visible = tuple(s for stroke in picture.visible for s in _in_window(stroke, low, high))
    hidden = tuple(s for stroke in picture.hidden for s in _in_window(stroke, low, high))
    faces, bodies = [], []
    for loops, body in zip(picture.faces, picture.bodies, strict=True):
        kept = [_polygon(loop, low, high) for loop in loops]
        if len(kept[0]) > 2:
            faces.append(tuple(loop for loop in kept if len(loop) > 2))
            bodies.append(body)
    return replace(picture, visible=visible, hidden=hidden, faces=tuple(faces), bodies=tuple(bodies))


def _in_window(stroke: Stroke, low: Point, high: Point) -> list[Stroke]:
    points = points_of(stroke)
    if all(low[0] <= p[0] <= high[0] and low[1] <= p[1] <= high[1] for p in points):
        return [stroke]
    pieces: list[Stroke] = []
    for a, b in itertools.pairwise(points):
        piece = _segment(a, b, low, high)
        if piece is not None:
            pieces.append(piece)
    if len(pieces) > 1 and not isinstance(stroke, LineStroke):
        return _joined(pieces)
    return pieces


def _joined(pieces: list[Stroke]) -> list[Stroke]:
    runs: list[list[Point]] = []
    for piece in pieces:
        assert isinstance(piece, LineStroke)
        if runs and runs[-1][-1] == piece.start:
            runs[-1].append(piece.end)
        else:
            runs.append([piece.start, piece.end])
    return [PolyStroke(tuple(run)) for run in runs]


def _segment(a: Point, b: Point, low: Point, high: Point) -> LineStroke | None:
    """The part of a segment inside a box (Liang and Barsky)."""
    start, end = 0.0, 1.0
    for k in (0, 1):
        d = b[k] - a[k]
        for p, q in ((-d, a[k] - low[k]), (d, high[k] - a[k])):
            if p == 0.0:
                if q < 0.0:
                    return None
            elif p < 0.0:
                start = max(start, q / p)
            else:
                end = min(end, q / p)
    if start >= end:
        return None

    def at(t: float) -> Point:
        return a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])

    return LineStroke(a if start == 0.0 else at(start), b if end == 1.0 else at(end))


def _polygon(points: tuple[Point, ...], low: Point, high: Point) -> tuple[Point, ...]:
    """A polygon clipped side by side (Sutherland and Hodgman)."""
    kept = list(points)
    for k in (0, 1):
        for limit, sign in ((low[k], 1.0), (high[k], -1.0)):
            out: list[Point] = []
            for a, b in zip(kept[-1:] + kept[:-1], kept, strict=True):
                da, db = sign * (a[k] - limit), sign * (b[k] - limit)
                if (da < 0.0) != (db < 0.0):
                    t = da / (da - db)
                    out.append((a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])))
                if db >= 0.0:
                    out.append(b)
            kept = out
            if not kept:
                return ()
    return tuple(kept)
