"""Enlarge the round holes of a solid, because a 3D printer makes them too narrow."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import cadquery as cq
from OCP.BRepAdaptor import BRepAdaptor_Surface

from mbcdm_cad.parts.milled import one_solid
from mbcdm_cad.workshop.kernel import Shape

# A bore counts as a hole if at least this share of its wall exists: slits and crossing holes may remove the rest.
LEAST_WALL = 0.75
# Coordinates, directions and radii that differ by less than this count as equal.
_DIGITS = 4


class RoundHole(NamedTuple):
    """A round bore from ``low_mm`` to ``high_mm`` along its axis, which passes through ``foot_mm``."""

    foot_mm: tuple[float, float, float]
    direction: tuple[float, float, float]
    radius_mm: float
    low_mm: float
    high_mm: float


def round_holes(solid: Shape, least_wall: float = LEAST_WALL) -> list[RoundHole]:
    """Round bores with at least this share of their wall, in a fixed order."""
    walls: dict[tuple[float, ...], list[tuple[float, float, float]]] = {}
    for face in cq.Shape.cast(solid).Faces():
        if face.geomType() != "CYLINDER":
            continue
        surface = BRepAdaptor_Surface(face.wrapped)
        cylinder, reversed_ = surface.Cylinder(), face.wrapped.Orientation().name.endswith("REVERSED")
        # The normal of a wall points to the axis; that of a left-handed surface is reversed.
        if cylinder.Position().Direct() != reversed_:
            continue
        axis = cylinder.Axis()
        d = cq.Vector(axis.Direction())
        if (round(d.x, _DIGITS), round(d.y, _DIGITS), round(d.z, _DIGITS)) < (0.0, 0.0, 0.0):
            d = -d
        at = cq.Vector(axis.Location())
        foot = at - d * at.dot(d)
        # A wall that ends in a curved face extends beyond its vertices along the axis.
        *_, low, high = face._uvBounds()
        ends = sorted((at + cq.Vector(axis.Direction()) * v).dot(d) for v in (low, high))
        key = tuple(round(v, _DIGITS) + 0.0 for v in (*foot.toTuple(), *d.toTuple(), cylinder.Radius()))
        walls.setdefault(key, []).append((ends[0], ends[1], face.Area()))
    holes = []
    for key in sorted(walls):
        radius = key[6]
        for low, high, area in _together(walls[key]):
            if area > least_wall * 2 * pi * radius * (high - low):
                holes.append(RoundHole((key[0], key[1], key[2]), (key[3], key[4], key[5]), radius, low, high))
    return holes


def _together(pieces: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Pieces of one bore's wall whose stretches of the axis overlap, their areas added."""
    whole: list[tuple[float, float, float]] = []
    for low, high, area in sorted(pieces):
        if whole and low < whole[-1][1] - 1e-6:
            before = whole.pop()
            low, high, area = before[0], max(high, before[1]), area + before[2]
        whole.append((low, high, area))
    return whole


def with_wider_holes(name: str, solid: Shape, allowance_mm: float) -> Shape:
    """The solid with all its round holes wider by ``allowance_mm`` on the diameter. Raises ``ValueError`` naming it."""
    body = cq.Shape.cast(solid)
    for hole in round_holes(solid):
        start = cq.Vector(*hole.foot_mm) + cq.Vector(*hole.direction) * hole.low_mm
        length, along = hole.high_mm - hole.low_mm, cq.Vector(*hole.direction)
        outer = cq.Solid.makeCylinder(hole.radius_mm + allowance_mm / 2, length, start, along)
        # A ring-shaped tool, so that a solid inside the bore that does not touch its wall remains.
        inner = cq.Solid.makeCylinder(hole.radius_mm * 0.95, length, start, along)
        body = body.cut(outer.cut(inner))
    return one_solid(body, name).wrapped
