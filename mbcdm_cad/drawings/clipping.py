"""The part of a picture that a detail's window shows."""

from __future__ import annotations

import itertools
from dataclasses import replace

from mbcdm_cad.drawings.projection import Picture
from mbcdm_cad.drawings.strokes import LineStroke, Point, PolyStroke, Stroke, points_of
from mbcdm_cad.parts.sheet import View


def clipped(picture: Picture, view: View) -> Picture:
    """Strokes and cut faces inside the view's window."""
    assert view.window is not None
    centre, half_width, half_height = view.window
    u, v = view.project(centre)
    low, high = (u - half_width, v - half_height), (u + half_width, v + half_height)
    visible = tuple(s for stroke in picture.visible for s in _strokes(stroke, low, high))
    hidden = tuple(s for stroke in picture.hidden for s in _strokes(stroke, low, high))
    faces, bodies = [], []
    for loops, body in zip(picture.faces, picture.bodies, strict=True):
        kept = [_polygon(loop, low, high) for loop in loops]
        if len(kept[0]) > 2:
            faces.append(tuple(loop for loop in kept if len(loop) > 2))
            bodies.append(body)
    return replace(picture, visible=visible, hidden=hidden, faces=tuple(faces), bodies=tuple(bodies))


def _strokes(stroke: Stroke, low: Point, high: Point) -> list[Stroke]:
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
