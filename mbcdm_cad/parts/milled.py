"""A milled part as lists of features, each of which says once what solid, volume and sheet need of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Protocol, Self

from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import Point2, block, cut, cylinder, fuse, one_solid, pocket_y
from mbcdm_cad.parts.sheets.description import Holes, Linear, Radius, Side, Table, Vector, mm
from mbcdm_cad.parts.threads import thread
from mbcdm_cad.parts.volume import CORNER, pocket_corner_mm, pocket_mm3, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

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
class Block:
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
        return (across - 4 * CORNER * self.radius**2) * (length - self.into_mm)


def rounded(body: cq.Shape, radius: float, edges: str = "|Z", *of_these: str) -> cq.Shape:
    """The body with these edges rounded, those along Z if not given; each selector chooses among those before it."""
    import cadquery as cq

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
        taken = ring_mm3(radius, 0.0, length - sum(max(deep, 0.0) for _, deep, _ in wide))
        return len(self.places) * self.share * (taken + sum(ring_mm3(r, 0.0, deep) for r, deep, _ in wide))

    def tapped(self) -> Bores:
        """As drilled for tapping, where they are threads."""
        if not self.threaded:
            return self
        return replace(self, diameter=thread(self.diameter).tap_drill_mm, threaded=False)


@dataclass(frozen=True, kw_only=True)
class Pocket:
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
        return pocket_mm3(wide, deep, high, self.radius, 2 if self.open_top else 4)


def corner_table(pockets: Iterable[Pocket]) -> Table:
    """Corners of each pocket: the cutter's, or less where the pocket is narrow."""
    rows = []
    for p in pockets:
        high = p.z[1] - p.z[0] + (2 * p.radius if p.open_top else 0.0)
        rows.append((p.name, mm(pocket_corner_mm(p.radius, p.x[1] - p.x[0], high), 3)))
    return Table("Corners of the pockets", ("Pocket", "R"), tuple(rows))


@dataclass(frozen=True)
class Milled(MadePart):
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
