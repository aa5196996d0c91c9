"""Primitives of solids; a turned part as a list of steps, a milled one as lists of features.

Each says once what solid, volume and sheet need."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import cos, pi, radians, sin
from typing import ClassVar, Protocol, Self

from mbcdm_cad.parts import part
from mbcdm_cad.parts.fits import thread
from mbcdm_cad.parts.part import cq
from mbcdm_cad.parts.sheet import Holes, Linear, Radius, Side, Table, Vector, mm

Point2 = tuple[float, float]
Point3 = tuple[float, float, float]


def one_solid(shape: cq.Shape, name: str) -> cq.Solid:
    """The single solid inside ``shape``. Raises ValueError with the part's name if there is none or more than one."""
    solids = shape.Solids()
    if len(solids) != 1:
        volumes = ", ".join(f"{s.Volume():.3g}" for s in solids)
        raise ValueError(f"{name}: drawing gave {len(solids)} bodies ({volumes} mm^3) instead of one")
    return solids[0]


def _distinct(profile: Sequence[Point2]) -> list[Point2]:
    """The profile without repeated points: between two equal steps there is no wall."""
    return [p for before, p in zip([None, *profile], profile, strict=False) if p != before]


def turned(profile: Sequence[Point2], name: str) -> cq.Solid:
    """Solid of revolution about Z of a closed polygon of (radius, z) points, mm."""
    wire = cq.Wire.makePolygon([cq.Vector(r, 0, z) for r, z in _distinct(profile)], close=True)
    return one_solid(cq.Solid.revolve(wire, [], 360.0, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1)), name)


def turned_about_y(profile: Sequence[Point2], start_deg: float, sweep_deg: float, name: str) -> cq.Solid:
    """Solid of revolution about Y of (radius, y) points, from ``start_deg`` (0 at +Z, positive towards +X)."""
    wire = cq.Wire.makePolygon([cq.Vector(r, y, 0) for r, y in _distinct(profile)], close=True)
    # The profile stands on the +X axis, which is 90 degrees from +Z.
    placed = wire.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 1, 0), start_deg - 90.0)
    return one_solid(cq.Solid.revolve(placed, [], sweep_deg, cq.Vector(0, 0, 0), cq.Vector(0, 1, 0)), name)


def cylinder(radius: float, start: Point3, direction: Point3, length: float) -> cq.Solid:
    """Cylinder of ``length`` from ``start`` along ``direction``."""
    return cq.Solid.makeCylinder(radius, length, cq.Vector(*start), cq.Vector(*direction))


def cylinder_y(radius: float, x: float, z: float, y_start: float, y_end: float) -> cq.Solid:
    """Cylinder parallel to Y between two depths."""
    return cylinder(radius, (x, y_start, z), (0, 1, 0), y_end - y_start)


def cylinder_z(radius: float, x: float, y: float, z_start: float, z_end: float) -> cq.Solid:
    """Cylinder parallel to Z between two heights."""
    return cylinder(radius, (x, y, z_start), (0, 0, 1), z_end - z_start)


def block(x: Point2, y: Point2, z: Point2) -> cq.Solid:
    """Box between the given limits."""
    return cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], z[1] - z[0], cq.Vector(x[0], y[0], z[0]))


def extruded_y(outline: cq.Wire, length: float, holes: Sequence[cq.Wire] = ()) -> cq.Solid:
    """Prism along Y of ``length`` over a flat outline less its ``holes``, which lie inside it."""
    return cq.Solid.extrudeLinear(outline, list(holes), cq.Vector(0, length, 0))


def prism_y(points: Sequence[Point2], y_start: float, y_end: float, radius: float = 0.0) -> cq.Solid:
    """Prism along Y over a closed polygon of (x, z) points, its edges parallel to Y rounded by ``radius``."""
    outline = cq.Wire.makePolygon([cq.Vector(x, y_start, z) for x, z in points], close=True)
    return extruded_y(_rounded(outline, radius), y_end - y_start)


def pocket_y(x: Point2, y: Point2, z: Point2, radius: float) -> cq.Solid:
    """Tool of a pocket milled along Y: a box, its edges parallel to Y rounded by ``radius``, or less if narrow."""
    corners = [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])]
    return prism_y(corners, *y, part.pocket_corner_mm(radius, x[1] - x[0], z[1] - z[0]))


def _rounded(outline: cq.Wire, radius: float) -> cq.Wire:
    """The flat outline with all corners rounded, which is far faster than to round the edges of a prism."""
    if radius <= 0.0:
        return outline
    face = cq.Face.makeFromWires(outline)
    return face.fillet2D(radius, face.Vertices()).outerWire()


def sector_outline(
    r_inner: float, r_outer: float, start_deg: float, end_deg: float, y: float, radius: float = 0.0
) -> cq.Wire:
    """Outline of an annular sector about the Y axis at ``y`` (angles from +Z towards +X), its four corners rounded."""

    def at(r: float, deg: float) -> cq.Vector:
        return cq.Vector(r * sin(radians(deg)), y, r * cos(radians(deg)))

    middle = (start_deg + end_deg) / 2
    outline = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(at(r_outer, start_deg), at(r_outer, middle), at(r_outer, end_deg)),
            cq.Edge.makeLine(at(r_outer, end_deg), at(r_inner, end_deg)),
            cq.Edge.makeThreePointArc(at(r_inner, end_deg), at(r_inner, middle), at(r_inner, start_deg)),
            cq.Edge.makeLine(at(r_inner, start_deg), at(r_outer, start_deg)),
        ]
    )
    return _rounded(outline, radius)


def ring_y(r_inner: float, r_outer: float, y: float, length: float, holes: Sequence[cq.Wire] = ()) -> cq.Solid:
    """Ring about the Y axis of ``length`` from ``y``, less its ``holes``, which lie inside it at ``y``."""
    inner, outer = (cq.Wire.makeCircle(r, cq.Vector(0, y, 0), cq.Vector(0, 1, 0)) for r in (r_inner, r_outer))
    return extruded_y(outer, length, [inner, *holes])


def hexagon_z(across_flats: float, z_start: float, z_end: float) -> cq.Solid:
    """Hexagonal prism along Z."""
    r = across_flats / 3**0.5
    points = [cq.Vector(r * cos(pi / 3 * k), r * sin(pi / 3 * k), z_start) for k in range(6)]
    return cq.Solid.extrudeLinear(cq.Wire.makePolygon(points, close=True), [], cq.Vector(0, 0, z_end - z_start))


def cut(body: cq.Shape, tools: Iterable[cq.Shape], name: str) -> cq.Solid:
    """``body`` less all ``tools`` in one boolean, as one solid."""
    kept = list(tools)
    return one_solid(body.cut(*kept), name) if kept else one_solid(body, name)


def fuse(bodies: Sequence[cq.Shape], name: str) -> cq.Solid:
    """Union of ``bodies``, faces that lie in one surface joined, as one solid."""
    return one_solid(bodies[0].fuse(*bodies[1:]).clean(), name)


# How far a tool reaches beyond the metal, mm.
BEYOND_MM = 1.0


class Feature(Protocol):
    """Metal that is there, or is taken away."""

    def shapes(self) -> Sequence[cq.Shape]:
        """Its solids; of one that is taken the tools."""

    def volume_mm3(self) -> float:
        """What it adds to the part, or takes from it."""


@dataclass(frozen=True)
class Form:
    """A feature of any form with the volume, mm3, that it has of its own."""

    own_mm3: float
    drawn: Callable[[], Sequence[cq.Shape]]

    def shapes(self) -> Sequence[cq.Shape]:
        """As drawn."""
        return self.drawn()

    def volume_mm3(self) -> float:
        """Its own."""
        return self.own_mm3


@dataclass(frozen=True)
class Slab:
    """A box whose edges along Z, or along Y, are rounded, mm; from its lower end there ``into_mm`` lie in another."""

    x: Point2
    y: Point2
    z: Point2
    radius: float = 0.0
    along: str = "Z"
    into_mm: float = 0.0

    def shapes(self) -> Sequence[cq.Shape]:
        """The box, its edges rounded."""
        body = block(self.x, self.y, self.z)
        return [rounded(body, self.radius, f"|{self.along}") if self.radius else body]

    def volume_mm3(self) -> float:
        """All that does not lie in another."""
        wide, deep, high = (end - start for start, end in (self.x, self.y, self.z))
        across, length = (wide * deep, high) if self.along == "Z" else (wide * high, deep)
        return (across - 4 * part.CORNER * self.radius**2) * (length - self.into_mm)


def rounded(body: cq.Shape, radius: float, edges: str = "|Z", *of_these: str) -> cq.Shape:
    """The body with these edges rounded, those along Z if not given; each selector chooses among those before it."""
    found = cq.Workplane(obj=body).edges(edges)
    for selector in of_these:
        found = found.edges(selector)
    return found.fillet(radius).val()  # type: ignore[return-value]


@dataclass(frozen=True, kw_only=True)
class Bores(Holes):
    """Equal holes with the direction in which they go into the metal; without a letter no line of the sheet's table.

    ``metal``: how far they go through it, where ``depth`` does not say it; the tool then goes ``beyond`` it; mm.
    ``share`` of their volume is not taken by others.
    """

    into: Vector
    metal: float = 0.0
    beyond: float = BEYOND_MM
    share: float = 1.0

    def _lengths(self) -> tuple[tuple[float, float, float], ...]:
        """Radius, length, and what the tool needs besides, of the hole and of its counterbore."""
        through = isinstance(self.depth, str)
        hole = self.diameter / 2, self.metal if through else float(self.depth), self.beyond if through else 0.0
        return (hole,) if self.counterbore is None else (hole, (self.counterbore[0] / 2, self.counterbore[1], 0.0))

    def shapes(self) -> list[cq.Shape]:
        """Cylinders that begin before the face."""
        return [
            cylinder(
                radius,
                tuple(at - BEYOND_MM * way for at, way in zip(place, self.into, strict=True)),  # type: ignore[arg-type]
                self.into,
                BEYOND_MM + length + over,
            )
            for place in self.places
            for radius, length, over in self._lengths()
        ]

    def volume_mm3(self) -> float:
        """All of them, their counterbores included."""
        (radius, length, _), *wide = self._lengths()
        taken = part.ring_mm3(radius, 0.0, length - sum(max(deep, 0.0) for _, deep, _ in wide))
        return len(self.places) * self.share * (taken + sum(part.ring_mm3(r, 0.0, deep) for r, deep, _ in wide))

    def tapped(self) -> Bores:
        """As drilled for tapping, where they are threads."""
        if not self.threaded:
            return self
        return replace(self, diameter=thread(self.diameter).tap_drill_mm, threaded=False)


@dataclass(frozen=True, kw_only=True)
class MilledPocket:
    """Pocket milled along Y between two depths, mm; one that is open at the top keeps its two lower corners."""

    name: str
    x: Point2
    y: Point2
    z: Point2
    radius: float
    open_top: bool = False

    def shapes(self) -> Sequence[cq.Shape]:
        """Its cutter's way, which begins before the face at the larger y; upper corners of an open one lie outside."""
        high = self.z[1] + (2 * self.radius + BEYOND_MM if self.open_top else 0.0)
        return [pocket_y(self.x, (self.y[0], self.y[1] + BEYOND_MM), (self.z[0], high), self.radius)]

    def volume_mm3(self) -> float:
        """What it takes of the block."""
        wide, deep, high = (end - start for start, end in (self.x, self.y, self.z))
        return part.pocket_mm3(wide, deep, high, self.radius, 2 if self.open_top else 4)


def corner_table(pockets: Iterable[MilledPocket]) -> Table:
    """Corners of each pocket: the cutter's, or less where the pocket is narrow."""
    rows = []
    for p in pockets:
        high = p.z[1] - p.z[0] + (2 * p.radius if p.open_top else 0.0)
        rows.append((p.name, mm(part.pocket_corner_mm(p.radius, p.x[1] - p.x[0], high), 3)))
    return Table("Corners of the pockets", ("Pocket", "R"), tuple(rows))


# Cylinder about the axis of a turned part: radius, start and end along the axis, mm.
Step = tuple[float, float, float]


class Turned(part.Part):
    """A part of cylinders about Z, or about Y: ``steps`` in a row, ``bores`` taken from them, and ``cuts``.

    The outer edges at start and end are broken by ``chamfers_mm`` at 45 degrees. ``what`` names the part in errors.
    """

    what: ClassVar[str]
    about_y: ClassVar[bool] = False
    chamfers_mm: ClassVar[Point2] = (0.0, 0.0)

    @abstractmethod
    def steps(self) -> Sequence[Step]:
        """The outside, in the order along the axis."""

    def bores(self) -> Sequence[Step]:
        """What is bored out, in the same order; the first begins at an end."""
        return ()

    def cuts(self) -> Sequence[cq.Shape]:
        """Tools of what is taken besides."""
        return ()

    def solid(self) -> cq.Solid:
        """Turned, then cut."""
        outside = [point for radius, start, end in self.steps() for point in ((radius, start), (radius, end))]
        inside = [point for radius, start, end in reversed(self.bores()) for point in ((radius, end), (radius, start))]
        (first, start), (last, end), (low, high) = outside[0], outside[-1], self.chamfers_mm
        # Where no bore ends there, the profile goes on along the axis.
        above = [] if inside and inside[0][1] == end else [(0.0, end), *([(0.0, inside[0][1])] if inside else [])]
        below = [] if inside and inside[-1][1] == start else [(0.0, start)]
        profile = [
            *((first - low, start), (first, start + low), *outside[1:-1], (last, end - high), (last - high, end)),
            *(*above, *inside, *below),
        ]
        body = turned_about_y(profile, 0.0, 360.0, self.what) if self.about_y else turned(profile, self.what)
        return cut(body, self.cuts(), self.what)

    def in_rings(self) -> tuple[part.Ring, ...]:
        """Its steps less its bores; chamfers and cuts do not count."""
        taken = ((0.0, radius, start, end) for radius, start, end in self.bores())
        return (*((radius, 0.0, start, end) for radius, start, end in self.steps()), *taken)

    def gyration(self) -> part.Gyration:
        """About its axis."""
        own = super().gyration()
        return own._replace(along=(0.0, 1.0, 0.0)) if self.about_y else own

    def volume_mm3(self) -> float:
        """Of its rings."""
        return part.rings_mm3(self.in_rings())


class PlainRing(Turned):
    """A turned part of one step, bored through or not."""

    @abstractmethod
    def ring(self) -> part.Ring:
        """Its radius outside and inside, start and end along the axis, mm."""

    def steps(self) -> tuple[Step, ...]:
        """The outside."""
        outside, _, start, end = self.ring()
        return ((outside, start, end),)

    def bores(self) -> tuple[Step, ...]:
        """The inside."""
        return (self.ring()[1:],)

    def in_rings(self) -> tuple[part.Ring, ...]:
        """Its ring."""
        return (self.ring(),)


@dataclass(frozen=True)
class Milled(part.MadePart):
    """A part of bodies from which features are taken. ``drilled``: its threads have the diameter of their tap drills.

    Fields of a subclass hold all dimensions. ``what`` names the part in errors.
    """

    what: ClassVar[str] = "frame"
    drilled: bool = field(default=False, kw_only=True)

    @abstractmethod
    def bodies(self) -> Sequence[Feature]:
        """What is joined."""

    @abstractmethod
    def taken(self) -> Sequence[Feature]:
        """What is taken from that."""

    def bores(self) -> tuple[Bores, ...]:
        """The holes of the sheet's table, in the order of their letters."""
        named = [f for f in self.taken() if isinstance(f, Bores) and f.letter and f.places]
        return tuple(sorted(named, key=lambda group: group.letter))

    def tapped(self) -> Self | None:
        """It with its threads as drilled for tapping; None if it has none."""
        return replace(self, drilled=True) if any(group.threaded for group in self.bores()) else None

    def solid(self) -> cq.Solid:
        """Where it stands in the assembly, or in its own frame."""
        bodies = [shape for feature in self.bodies() for shape in feature.shapes()]
        taken = [f.tapped() if self.drilled and isinstance(f, Bores) else f for f in self.taken()]
        body = fuse(bodies, self.what) if len(bodies) > 1 else one_solid(bodies[0], self.what)
        return cut(body, [tool for feature in taken for tool in feature.shapes()], self.what)

    def volume_mm3(self) -> float:
        """Bodies less what is taken."""
        return sum(f.volume_mm3() for f in self.bodies()) - sum(f.volume_mm3() for f in self.taken())


def span(
    axis: int, view: str, start: Vector, end: Vector, side: Side, what: str = "", decimals: int = 3, prefix: str = ""
) -> Linear:
    """Distance of two points along an axis of the part: 0 x, 1 y, 2 z."""
    return Linear(view, start, end, end[axis] - start[axis], side, prefix, suffix=what, decimals=decimals)


def wide(view: str, half: float, at: Point2, side: Side, what: str = "") -> Linear:
    """Width across the plane x = 0 at (y, z)."""
    return span(0, view, (-half, *at), (half, *at), side, what, decimals=2)


def rounding(at: Vector, radius: float, prefix: str) -> Radius:
    """Radius of the rounded corner at this low x and high y, seen from above."""
    (x, y, z), half = at, 0.5**0.5 * radius
    return Radius("top", (x + radius, y - radius, z), (x + radius - half, y - radius + half, z), radius, prefix=prefix)
