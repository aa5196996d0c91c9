"""Lines, arcs and polylines in a plane, and their cleaning: join duplicates, remove hidden ones under visible ones."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, pi, radians, sin

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


def _carrier(stroke: LineStroke) -> tuple[Key, Interval]:
    """The infinite line of a stroke (direction, offset), and the interval of the stroke along it."""
    (ax, ay), (bx, by) = stroke.start, stroke.end
    ux, uy = _direction(stroke.start, stroke.end)
    offset = ax * -uy + ay * ux
    along = sorted((ax * ux + ay * uy, bx * ux + by * uy))
    return (round(ux * 1e5), round(uy * 1e5), round(offset * 1e3)), (along[0], along[1])


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
                key, span = _carrier(stroke)
                directions.setdefault(key, (stroke.start, stroke.end))
                lines[n][key].append(span)
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
