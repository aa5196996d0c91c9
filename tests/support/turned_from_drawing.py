"""Volume of a turned part from its drawing alone: the view gives the order of the faces, the dimensions their sizes."""

from __future__ import annotations

from itertools import pairwise
from math import pi

from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, ReadDimension, ReadView

_PAPER = 0.05  # mm on paper within which two points are one
_SLIT = 0.08  # a slit along the axis makes a cylinder's outline look this much smaller, mm on paper


class _Stations:
    """Places along the axis, known through dimensions from one to another; a tree, or something is said twice."""

    def __init__(self) -> None:
        self.at: dict[float, float] = {}
        self.links: list[tuple[float, float, float]] = []

    def key(self, u: float) -> float:
        for known in self.at:
            if abs(known - u) < _PAPER:
                return known
        self.at[u] = float("nan")
        return u

    def link(self, a: float, b: float, value: float) -> None:
        low, high = sorted((self.key(a), self.key(b)))
        self.links.append((low, high, value))

    def solve(self) -> None:
        group = {u: u for u in self.at}

        def root(u: float) -> float:
            while group[u] != u:
                u = group[u]
            return u

        for a, b, value in self.links:
            if root(a) == root(b):
                raise DoubledDimensionError(f"length {value:g} follows from others")
            group[root(a)] = root(b)
        if not self.at:
            raise MissingDimensionError("no length at all")
        start = min(self.at)
        known, waiting = {start: 0.0}, [start]
        while waiting:
            u = waiting.pop()
            for a, b, value in self.links:
                for here, there, step in ((a, b, value), (b, a, -value)):
                    if here == u and there not in known:
                        known[there] = known[u] + step
                        waiting.append(there)
        self.known = known

    def z(self, u: float) -> float:
        for key, value in self.known.items():
            if abs(key - u) < _PAPER:
                return value
        raise MissingDimensionError(f"nothing says where the face at {u:.2f} on paper stands")


def _profile(seen: ReadView) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Generators above the axis: level or slanting lines, from left to right."""
    lines = []
    for a, b in seen.lines:
        (u1, v1), (u2, v2) = sorted((a, b))
        if u2 - u1 > _PAPER / 2 and v1 > _PAPER and v2 > _PAPER:
            lines.append(((u1, v1), (u2, v2)))
    return lines


def turned_volume(dims: list[ReadDimension], seen: ReadView) -> float:
    """Volume in mm^3; raises ``MissingDimensionError`` or ``DoubledDimensionError``."""
    radii: dict[float, float] = {}
    fits: dict[float, list[str]] = {}
    for d in dims:
        if not d.across and d.prefix in ("Ø", "M"):
            level = abs(d.start[1])
            same = next((other for other in radii if abs(level - other) < _PAPER), level)
            # A bore and a journal may be alike but for their fits.
            if d.suffix in fits.setdefault(same, []):
                raise DoubledDimensionError(f"diameter {d.value:g}{d.suffix}")
            fits[same].append(d.suffix)
            radii[same] = d.value / 2
    lengths = [d for d in dims if d.across and "45" not in d.suffix]
    chamfers = [d for d in dims if "45" in d.suffix]
    lines = _profile(seen)
    level = [(a, b) for a, b in lines if abs(a[1] - b[1]) < 1e-6]
    slanted = [(a, b) for a, b in lines if abs(a[1] - b[1]) >= 1e-6]
    if sum(d.count for d in chamfers) != len(slanted):
        raise MissingDimensionError(f"{len(slanted)} chamfers drawn, {sum(d.count for d in chamfers)} said")
    stations = _Stations()
    for d in lengths:
        stations.link(d.start[0], d.end[0], d.value)
    size = chamfers[0].value if chamfers else 0.0
    for (u1, _), (u2, _) in slanted:
        stations.link(u1, u2, size)
    stations.solve()

    def radius(v: float) -> float:
        near = min(radii, key=lambda other: abs(other - v), default=None)
        if near is None or abs(near - v) > _SLIT:
            raise MissingDimensionError(f"nothing says the diameter of the line at {v:.2f} on paper")
        return radii[near]

    # Outside: at each place the line furthest out.
    cuts = sorted({round(u, 3) for a, b in lines for u in (a[0], b[0])})
    edges = [u for n, u in enumerate(cuts) if n == 0 or u - cuts[n - 1] > _PAPER]
    volume = 0.0
    outside = set()
    for u1, u2 in pairwise(edges):
        over = [(max(a[1], b[1]), a, b) for a, b in lines if a[0] < u1 + _PAPER and b[0] > u2 - _PAPER]
        if not over:
            raise MissingDimensionError(f"no outline between {u1:.2f} and {u2:.2f}")
        _, a, b = max(over)
        outside.add((a, b))
        length = stations.z(u2) - stations.z(u1)
        if (a, b) in slanted:
            large = radius(max(a[1], b[1]))
            small = large - size
            volume += pi / 3 * length * (large**2 + large * small + small**2)
        else:
            volume += pi * radius(a[1]) ** 2 * length
    # Inside: lines that start at an end face are bores.
    for a, b in level:
        if (a, b) not in outside and (a[0] < edges[0] + _PAPER or b[0] > edges[-1] - _PAPER):
            volume -= pi * radius(a[1]) ** 2 * (stations.z(b[0]) - stations.z(a[0]))
    return volume
