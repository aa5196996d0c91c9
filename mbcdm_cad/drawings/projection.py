"""Views, sections and details of a solid by exact hidden-line removal, as strokes in the plane of the view, mm.

Strokes are lines, arcs and polylines; duplicates are joined, hidden ones under visible ones are removed.
"""

import itertools
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import atan2, cos, degrees, hypot, pi, radians, sin
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

from mbcdm_cad.parts.sheet import Vector, View

Point = tuple[float, float]
_SAME = 1e-4
_SHORT = 1e-3


@dataclass(frozen=True)
class LineStroke:
    """A straight line from ``start`` to ``end``."""

    start: Point
    end: Point


@dataclass(frozen=True)
class ArcStroke:
    """An arc anticlockwise about ``centre`` from ``start_deg`` to ``end_deg`` (end > start; 360 apart is a circle)."""

    centre: Point
    radius: float
    start_deg: float
    end_deg: float


@dataclass(frozen=True)
class PolyStroke:
    """A polyline through ``points``."""

    points: tuple[Point, ...]


Stroke = LineStroke | ArcStroke | PolyStroke


def points_of(stroke: Stroke) -> tuple[Point, ...]:
    """Points on the stroke, close enough together for its box and for tests of overlap."""
    if isinstance(stroke, LineStroke):
        return (stroke.start, stroke.end)
    if isinstance(stroke, PolyStroke):
        return stroke.points
    count = max(2, int((stroke.end_deg - stroke.start_deg) / 10.0) + 2)
    step = (stroke.end_deg - stroke.start_deg) / (count - 1)
    return tuple(on_circle(stroke.centre, stroke.radius, stroke.start_deg + k * step) for k in range(count))


def on_circle(centre: Point, radius: float, deg: float) -> Point:
    """Point of a circle at an angle from the right."""
    return centre[0] + radius * cos(radians(deg)), centre[1] + radius * sin(radians(deg))


def box(strokes: Iterable[Stroke]) -> tuple[float, float, float, float]:
    """(left, bottom, right, top). Raises ``ValueError`` if there are no strokes."""
    points = [p for stroke in strokes for p in points_of(stroke)]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs), min(ys), max(xs), max(ys)


def fitted(points: Sequence[Point]) -> Stroke | None:
    """The line or arc that sampled points lie on, else a polyline; None for a point."""
    first, last = points[0], points[-1]
    reach = max(hypot(p[0] - first[0], p[1] - first[1]) for p in points)
    if reach < _SHORT:
        return None
    chord = hypot(last[0] - first[0], last[1] - first[1])
    if chord > _SHORT:
        off = max(
            abs((p[0] - first[0]) * (last[1] - first[1]) - (p[1] - first[1]) * (last[0] - first[0])) / chord
            for p in points
        )
        if off < _SHORT:
            return LineStroke(first, last)
    return _fitted_arc(points) or PolyStroke(tuple(points))


def _fitted_arc(points: Sequence[Point]) -> ArcStroke | None:
    if len(points) < 5:
        return None
    a, b, c = points[0], points[len(points) // 3], points[2 * len(points) // 3]
    d = 2 * (a[0] * (b[1] - c[1]) + b[0] * (c[1] - a[1]) + c[0] * (a[1] - b[1]))
    if abs(d) < 1e-9:
        return None
    sa, sb, sc = (p[0] ** 2 + p[1] ** 2 for p in (a, b, c))
    centre = (
        (sa * (b[1] - c[1]) + sb * (c[1] - a[1]) + sc * (a[1] - b[1])) / d,
        (sa * (c[0] - b[0]) + sb * (a[0] - c[0]) + sc * (b[0] - a[0])) / d,
    )
    radius = hypot(a[0] - centre[0], a[1] - centre[1])
    if any(abs(hypot(p[0] - centre[0], p[1] - centre[1]) - radius) > _SHORT for p in points):
        return None
    angles = [atan2(p[1] - centre[1], p[0] - centre[0]) for p in points]
    turn = sum((q - p + pi) % (2 * pi) - pi for p, q in itertools.pairwise(angles))
    start, sweep = (angles[0], turn) if turn > 0 else (angles[-1], -turn)
    start_deg = degrees(start) % 360.0
    return ArcStroke(centre, radius, start_deg, start_deg + min(360.0, degrees(sweep)))


Interval = tuple[float, float]


def _union(spans: Iterable[Interval]) -> list[Interval]:
    joined: list[Interval] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + _SAME:
            joined[-1] = (joined[-1][0], max(joined[-1][1], high))
        else:
            joined.append((low, high))
    return joined


def _less(spans: list[Interval], taken: list[Interval]) -> list[Interval]:
    left: list[Interval] = []
    for low, high in spans:
        at = low
        for a, b in taken:
            if b <= at or a >= high:
                continue
            if a > at + _SHORT:
                left.append((at, a))
            at = max(at, b)
        if high > at + _SHORT:
            left.append((at, high))
    return left


Key = tuple[int, ...]


def _direction(start: Point, end: Point) -> Point:
    """Direction of the line through two points, to the right or up, whichever of the two comes first."""
    (ax, ay), (bx, by) = start, end
    length = hypot(bx - ax, by - ay)
    ux, uy = (bx - ax) / length, (by - ay) / length
    return (-ux, -uy) if ux < -1e-9 or (abs(ux) <= 1e-9 and uy < 0) else (ux, uy)


def cleaned(visible: Iterable[Stroke], hidden: Iterable[Stroke]) -> tuple[list[Stroke], list[Stroke]]:
    """Strokes with duplicates joined, in a fixed order; hidden ones only where no visible one covers them."""
    lines: tuple[dict[Key, list[Interval]], ...] = (defaultdict(list), defaultdict(list))
    arcs: tuple[dict[Key, list[Interval]], ...] = (defaultdict(list), defaultdict(list))
    exact: dict[Key, tuple[Point, float]] = {}
    directions: dict[Key, tuple[Point, Point]] = {}
    rest: tuple[list[Stroke], list[Stroke]] = ([], [])
    for n, strokes in enumerate((visible, hidden)):
        for stroke in strokes:
            if isinstance(stroke, LineStroke):
                # The infinite line of the stroke (direction, offset), and the interval of the stroke along it.
                (ax, ay), (bx, by), (ux, uy) = stroke.start, stroke.end, _direction(stroke.start, stroke.end)
                key: Key = (round(ux * 1e5), round(uy * 1e5), round((ax * -uy + ay * ux) * 1e3))
                directions.setdefault(key, (stroke.start, stroke.end))
                low, high = sorted((ax * ux + ay * uy, bx * ux + by * uy))
                lines[n][key].append((low, high))
            elif isinstance(stroke, ArcStroke):
                key = (round(stroke.centre[0] * 1e3), round(stroke.centre[1] * 1e3), round(stroke.radius * 1e3))
                exact.setdefault(key, (stroke.centre, stroke.radius))
                start = stroke.start_deg % 360.0
                end = start + stroke.end_deg - stroke.start_deg
                arcs[n][key] += [(start, end)] if end <= 360.0 + _SAME else [(start, 360.0), (0.0, end - 360.0)]
            elif stroke not in rest[n]:
                rest[n].append(stroke)
    out: tuple[list[Stroke], list[Stroke]] = ([], [])
    for n in (0, 1):
        for key in sorted(lines[n]):
            spans = _union(lines[n][key])
            kept = _less(spans, _union(lines[0].get(key, []))) if n else spans
            out[n].extend(_line_on(directions[key], span) for span in kept)
        for key in sorted(arcs[n]):
            spans = _union(arcs[n][key])
            kept = _less(spans, _union(arcs[0].get(key, []))) if n else spans
            out[n].extend(_arcs_on(*exact[key], kept))
        out[n].extend(sorted(rest[n], key=lambda s: points_of(s)))
    return out


def _line_on(through: tuple[Point, Point], span: Interval) -> LineStroke:
    (ax, ay), (ux, uy) = through[0], _direction(*through)
    at = ax * ux + ay * uy
    return LineStroke(
        (ax + (span[0] - at) * ux, ay + (span[0] - at) * uy), (ax + (span[1] - at) * ux, ay + (span[1] - at) * uy)
    )


def _arcs_on(centre: Point, radius: float, spans: list[Interval]) -> list[Stroke]:
    if len(spans) > 1 and spans[0][0] < _SAME and spans[-1][1] > 360.0 - _SAME:
        first = spans.pop(0)
        spans[-1] = (spans[-1][0], spans[-1][1] + first[1])
    return [ArcStroke(centre, radius, low, high) for low, high in spans]


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
        # The half space between the section plane and the reader.
        half = _HALF_SPACE_MM / 2
        corner = [a - half * r - half * u for a, r, u in zip(view.cut, view.right, view.up, strict=True)]
        axes = gp_Ax2(gp_Pnt(*corner), gp_Dir(*view.toward), gp_Dir(*view.right))
        space, cut = cq.Solid(BRepPrimAPI_MakeBox(axes, _HALF_SPACE_MM, _HALF_SPACE_MM, _HALF_SPACE_MM).Shape()), []
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
