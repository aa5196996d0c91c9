"""Pieces of a cable's centre line: straight, circular, helical, and the short parabola that joins two slopes.

All lengths in mm, angles in rad, points in the frame of the mechanism (drum axis Y, guide axis Z).
Every piece is parametrised by a fraction 0..1, knows its exact length and its end tangents.

A cable's path joins them to its true centre line at one drum angle; it is drawn and measured.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, dist, hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import CableRun
from mbcdm_cad.routes import Floats

Vector = NDArray[np.float64]
Triple = tuple[float, float, float]

# The positive half of the 12 Gauss-Legendre nodes on -1..1, and their weights: numpy's function for them is in
# numpy.polynomial, whose import would slow every start down.
_GAUSS_NODES = (
    0.1252334085114689,
    0.3678314989981802,
    0.5873179542866175,
    0.7699026741943047,
    0.9041172563704748,
    0.9815606342467192,
)
_GAUSS_WEIGHTS = (
    0.2491470458134027,
    0.2334925365383546,
    0.20316742672306573,
    0.16007832854334642,
    0.10693932599531907,
    0.04717533638651141,
)


def _v(a: Sequence[float]) -> Vector:
    return np.asarray(a, dtype=np.float64)


def _linear(start: float, end: float, fraction: Vector) -> Vector:
    """Values that run linearly from one to another."""
    return np.asarray(start + fraction * (end - start))


@dataclass(frozen=True)
class Line:
    """Straight piece from ``start`` to ``end``."""

    start: Triple
    end: Triple

    @property
    def length_mm(self) -> float:
        return dist(self.start, self.end)

    def points(self, fraction: Vector) -> Vector:
        """Points, shape (n, 3), at ``fraction`` (n,) of the piece."""
        return _v(self.start) + np.multiply.outer(fraction, _v(self.end) - _v(self.start))

    def tangent(self, fraction: float) -> Vector:
        """Unit tangent, the same everywhere."""
        d = _v(self.end) - _v(self.start)
        return d / np.linalg.norm(d)


@dataclass(frozen=True)
class Arc:
    """Circular piece: centre + r (cos a e1 + sin a e2), ``a`` running from ``angle_start`` to ``angle_end`` (rad)."""

    centre: Triple
    e1: Triple
    e2: Triple
    radius_mm: float
    angle_start: float
    angle_end: float

    @property
    def length_mm(self) -> float:
        return self.radius_mm * abs(self.angle_end - self.angle_start)

    def points(self, fraction: Vector) -> Vector:
        """Points, shape (n, 3), at ``fraction`` (n,) of the piece."""
        a = self.angle_start + np.asarray(fraction) * (self.angle_end - self.angle_start)
        ring = np.multiply.outer(np.cos(a), _v(self.e1)) + np.multiply.outer(np.sin(a), _v(self.e2))
        return _v(self.centre) + self.radius_mm * ring

    def tangent(self, fraction: float) -> Vector:
        """Unit tangent at ``fraction``."""
        a = self.angle_start + fraction * (self.angle_end - self.angle_start)
        sign = np.sign(self.angle_end - self.angle_start)
        return np.asarray(sign * (-np.sin(a) * _v(self.e1) + np.cos(a) * _v(self.e2)))


@dataclass(frozen=True)
class Helix:
    """Turns about a line parallel to Z: angle and height run linearly together.

    ``centre`` (x, y) of the axis; ``angle_start`` -> ``angle_end`` (rad, anticlockwise positive);
    ``z_start`` -> ``z_end``. Lead = |dz| 2 pi / |da|.
    """

    centre: tuple[float, float]
    radius_mm: float
    angle_start: float
    angle_end: float
    z_start: float
    z_end: float

    @property
    def length_mm(self) -> float:
        return hypot(self.radius_mm * (self.angle_end - self.angle_start), self.z_end - self.z_start)

    def points(self, fraction: Vector) -> Vector:
        """Points, shape (n, 3), at ``fraction`` (n,) of the piece."""
        f = np.asarray(fraction, dtype=np.float64)
        a, z = _linear(self.angle_start, self.angle_end, f), _linear(self.z_start, self.z_end, f)
        return np.stack(
            [self.centre[0] + self.radius_mm * np.cos(a), self.centre[1] + self.radius_mm * np.sin(a), z], axis=-1
        )

    def tangent(self, fraction: float) -> Vector:
        """Unit tangent at ``fraction``."""
        da = self.angle_end - self.angle_start
        a = self.angle_start + fraction * da
        t = _v([-self.radius_mm * np.sin(a) * da, self.radius_mm * np.cos(a) * da, self.z_end - self.z_start])
        return t / np.linalg.norm(t)


@dataclass(frozen=True)
class Coil:
    """Turns about any line: the axis through ``centre``, angles right-handed about it from ``first`` (unit vectors).

    Angle and the way ``along`` the axis run linearly together, as in :class:`Helix`.
    """

    centre: Triple
    axis: Triple
    first: Triple
    radius_mm: float
    angle_start: float
    angle_end: float
    along_start: float
    along_end: float

    @property
    def length_mm(self) -> float:
        turned = self.radius_mm * (self.angle_end - self.angle_start)
        return float(np.hypot(turned, self.along_end - self.along_start))

    def points(self, fraction: Vector) -> Vector:
        """Points, shape (n, 3), at ``fraction`` (n,) of the piece."""
        f = np.asarray(fraction, dtype=np.float64)
        a, along = _linear(self.angle_start, self.angle_end, f), _linear(self.along_start, self.along_end, f)
        second = np.cross(self.axis, self.first)
        ring = np.multiply.outer(np.cos(a), _v(self.first)) + np.multiply.outer(np.sin(a), second)
        return np.asarray(_v(self.centre) + self.radius_mm * ring + np.multiply.outer(along, _v(self.axis)))

    def tangent(self, fraction: float) -> Vector:
        """Unit tangent at ``fraction``."""
        da = self.angle_end - self.angle_start
        a = self.angle_start + fraction * da
        around = np.cos(a) * np.cross(self.axis, self.first) - np.sin(a) * _v(self.first)
        t = self.radius_mm * da * around + (self.along_end - self.along_start) * _v(self.axis)
        return np.asarray(t / np.linalg.norm(t))


# (Node on 0..1, weight; their sum is 2) of a quadrature that is exact here to rounding.
_GAUSS = tuple(
    ((sign * x + 1.0) / 2.0, w) for sign in (-1.0, 1.0) for x, w in zip(_GAUSS_NODES, _GAUSS_WEIGHTS, strict=True)
)


@dataclass(frozen=True)
class Parabola:
    """Quadratic Bezier: tangent to ``start -> middle`` at its start and to ``middle -> end`` at its end."""

    start: Triple
    middle: Triple
    end: Triple

    @property
    def length_mm(self) -> float:
        # Plain numbers: lengths are asked for by the thousand, and numpy's calls take longer for a few points.
        (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = self.start, self.middle, self.end
        a, b, c = x1 - x0, y1 - y0, z1 - z0
        p, q, r = x2 - x1 - a, y2 - y1 - b, z2 - z1 - c
        return sum(w * hypot(a + f * p, b + f * q, c + f * r) for f, w in _GAUSS)

    def points(self, fraction: Vector) -> Vector:
        """Points, shape (n, 3), at ``fraction`` (n,) of the piece."""
        f = np.asarray(fraction, dtype=np.float64)
        p0, p1, p2 = _v(self.start), _v(self.middle), _v(self.end)
        return (
            np.multiply.outer((1 - f) ** 2, p0) + np.multiply.outer(2 * f * (1 - f), p1) + np.multiply.outer(f**2, p2)
        )

    def tangent(self, fraction: float) -> Vector:
        """Unit tangent at ``fraction``."""
        p0, p1, p2 = _v(self.start), _v(self.middle), _v(self.end)
        t = (1 - fraction) * (p1 - p0) + fraction * (p2 - p1)
        return t / np.linalg.norm(t)


Piece = Line | Arc | Helix | Coil | Parabola


def turned_about_y(piece: Line | Arc | Coil | Parabola, angle_rad: float) -> Piece:
    """The piece turned about the Y axis by ``angle_rad``, from +Z towards +X."""
    cosine, sine = float(np.cos(angle_rad)), float(np.sin(angle_rad))

    def turned(v: Triple) -> Triple:
        return (cosine * v[0] + sine * v[2], v[1], cosine * v[2] - sine * v[0])

    return _mapped(piece, turned, turned)


def carried(piece: Line | Arc | Coil | Parabola, rotation: Vector, shift_mm: Vector) -> Piece:
    """The piece turned by a rotation (3, 3) and then moved by a shift (3,)."""

    def turned(v: Triple) -> Triple:
        return triple(rotation @ np.array(v) + 0.0)

    def moved(v: Triple) -> Triple:
        return triple(rotation @ np.array(v) + shift_mm)

    return _mapped(piece, moved, turned)


def _mapped(
    piece: Line | Arc | Coil | Parabola, point: Callable[[Triple], Triple], along: Callable[[Triple], Triple]
) -> Piece:
    """The piece with its points and its directions mapped."""
    match piece:
        case Line():
            return replace(piece, start=point(piece.start), end=point(piece.end))
        case Arc():
            return replace(piece, centre=point(piece.centre), e1=along(piece.e1), e2=along(piece.e2))
        case Coil():
            return replace(piece, centre=point(piece.centre), axis=along(piece.axis), first=along(piece.first))
        case Parabola():
            return replace(piece, start=point(piece.start), middle=point(piece.middle), end=point(piece.end))


def reverse(piece: Piece) -> Piece:
    """The piece in the opposite direction."""
    if isinstance(piece, Line | Parabola):
        return replace(piece, start=piece.end, end=piece.start)
    turned = replace(piece, angle_start=piece.angle_end, angle_end=piece.angle_start)
    if isinstance(turned, Helix):
        return replace(turned, z_start=turned.z_end, z_end=turned.z_start)
    if isinstance(turned, Coil):
        return replace(turned, along_start=turned.along_end, along_end=turned.along_start)
    return turned


def between(piece: Piece, start: float, end: float) -> Piece:
    """The part of a piece from fraction ``start`` to ``end`` of its parameter (of a parabola not of its length)."""

    def at(first: float, last: float) -> tuple[float, float]:
        return first + start * (last - first), first + end * (last - first)

    if isinstance(piece, Line | Parabola):
        first, last = (triple(point) for point in piece.points(np.array([start, end])))
        if isinstance(piece, Line):
            return Line(first, last)
        # The tangents at both ends of a parabola meet at its middle point.
        p0, p1, p2 = _v(piece.start), _v(piece.middle), _v(piece.end)
        middle = (1 - start) * ((1 - end) * p0 + end * p1) + start * ((1 - end) * p1 + end * p2)
        return Parabola(first, triple(middle), last)
    angle_start, angle_end = at(piece.angle_start, piece.angle_end)
    turned = replace(piece, angle_start=angle_start, angle_end=angle_end)
    if isinstance(turned, Helix):
        z_start, z_end = at(turned.z_start, turned.z_end)
        return replace(turned, z_start=z_start, z_end=z_end)
    if isinstance(turned, Coil):
        along_start, along_end = at(turned.along_start, turned.along_end)
        return replace(turned, along_start=along_start, along_end=along_end)
    return turned


def cut(piece: Piece, length_mm: float) -> list[Piece]:
    """The piece in equal parts, none longer than ``length_mm`` where length runs evenly with the parameter."""
    count = max(1, ceil(piece.length_mm / length_mm))
    return [between(piece, k / count, (k + 1) / count) for k in range(count)]


def triple(point: Vector) -> Triple:
    """A point or direction as plain numbers."""
    x, y, z = (float(value) for value in point)
    return x, y, z


def axial_walk_m(turned_rad: Any, lead_m: Any) -> Floats:
    """Walk of the tangent point along the axis when the pulley turns by ``turned_rad``: lead a turn."""
    return np.asarray(turned_rad * lead_m / (2 * np.pi))


def fleet_angle_rad(walk_m: Any, span_m: Any) -> Floats:
    """Angle of the span to the plane of the pulley for a walk at one of its ends."""
    return np.asarray(np.arctan(walk_m / span_m))


# Drum angles over the travel at which paths have figures.
STATIONS = 9


@dataclass(frozen=True)
class Stretch:
    """Neighbouring pieces of a cable that move together with ``body``; None: they are free, or slide over a body."""

    body: str | None
    pieces: tuple[str, ...]


@dataclass(frozen=True)
class EndOfTravel:
    """A drum angle (deg, either sign) at which the travel ends, and the reason."""

    angle_deg: float
    cause: str


@dataclass(frozen=True)
class CableWraps:
    """One cable without a guide, or one side of a continuous one, over the travel: tuples over drum angles.

    ``length_um`` is the change of the whole cable's length from the centred drum: 0 except for rounding, since the
    length that leaves the drum on one side is wound on the input, or on the drum's other side.
    """

    name: str
    length_mm: float
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]
    length_um: tuple[float, ...]


def wrap_lines(c: dict[str, Any]) -> Iterator[str]:
    """:class:`CableWraps` as a dict, for a terminal."""
    middle = len(c["drum_wrap_deg"]) // 2
    wound, on_drum = c["input_wrap_deg"], c["drum_wrap_deg"]
    yield (
        f"  {c['name']:<10} length {c['length_mm']:.2f} mm; wrap on the input {wound[middle]:.0f} "
        f"({wound[0]:.0f}, {wound[-1]:.0f}), on the drum {on_drum[middle]:.1f} "
        f"({on_drum[0]:.1f}, {on_drum[-1]:.1f}) deg"
    )


@dataclass(frozen=True)
class CablePath:
    """Pieces of one cable's centre line, each under its own name, from its end on the input to its end on the drum.

    ``stretches`` says what carries them and names every piece once. ``diameter_mm``: of a cable that is not the
    design's own, as those of a first stage.
    """

    cable: CableRun
    drum_angle_rad: float
    pieces: tuple[tuple[str, Piece], ...]
    stretches: tuple[Stretch, ...] = ()
    diameter_mm: float | None = None

    def piece(self, name: str) -> Piece:
        """The piece called ``name``."""
        return dict(self.pieces)[name]

    @property
    def line(self) -> tuple[Piece, ...]:
        """The pieces without their names: all that a rod along the path depends on."""
        return tuple(p for _, p in self.pieces)

    @cached_property
    def length_mm(self) -> float:
        """Length of the whole centre line."""
        return sum(p.length_mm for _, p in self.pieces)

    def only(self, names: tuple[str, ...]) -> "CablePath":
        """The path made of the pieces called ``names`` alone."""
        kept = tuple(p for p in self.pieces if p[0] in names)
        return CablePath(self.cable, self.drum_angle_rad, kept, diameter_mm=self.diameter_mm)

    def each(self, change: Callable[[Any], Piece]) -> "CablePath":
        """The path with each of its pieces changed."""
        return replace(self, pieces=tuple((name, change(piece)) for name, piece in self.pieces))

    def sample(self, step_mm: float) -> Vector:
        """Points (n, 3) along the pieces, no further apart than ``step_mm``."""
        counts = [max(2, ceil(piece.length_mm / step_mm) + 1) for _, piece in self.pieces]
        return np.concatenate(
            [p.points(np.linspace(0.0, 1.0, n)) for (_, p), n in zip(self.pieces, counts, strict=True)]
        )


def over_travel(
    paths_at: Callable[[float], tuple[CablePath, ...]], half_travel_deg: float
) -> tuple[tuple[float, ...], list[tuple[CablePath, ...]]]:
    """``STATIONS`` drum angles (deg) evenly over the travel, and all cables at each; ``paths_at`` gets it in rad."""
    angles = np.linspace(-half_travel_deg, half_travel_deg, STATIONS)
    return tuple(angles.tolist()), [paths_at(float(angle)) for angle in np.radians(angles)]


def by_sense(ends: Iterable[EndOfTravel]) -> tuple[tuple[EndOfTravel, ...], tuple[EndOfTravel, ...]]:
    """Ends of the travel at positive drum angles, and at the others, the nearest first."""
    nearest = sorted(ends, key=lambda end: abs(end.angle_deg))
    return tuple(e for e in nearest if e.angle_deg > 0.0), tuple(e for e in nearest if e.angle_deg <= 0.0)
