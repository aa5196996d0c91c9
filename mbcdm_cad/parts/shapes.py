"""Primitives of the parts: turned profiles, prisms, cylinders, and the single solid of a boolean's result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import cos, pi, radians, sin
from typing import TYPE_CHECKING

from mbcdm_cad.parts.volume import pocket_corner_mm

if TYPE_CHECKING:
    import cadquery as cq

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


def stepped(steps: Sequence[tuple[float, float, float]], chamfer_mm: float) -> list[Point2]:
    """Half the outside of a turned body: cylinders (radius, start, end) in a row, the edges at both ends broken."""
    points = [point for radius, start, end in steps for point in ((radius, start), (radius, end))]
    (first, start), (last, end), c = points[0], points[-1], chamfer_mm
    return [(first - c, start), (first, start + c), *points[1:-1], (last, end - c), (last - c, end)]


def turned(profile: Sequence[Point2], name: str) -> cq.Solid:
    """Solid of revolution about Z of a closed polygon of (radius, z) points, mm."""
    import cadquery as cq

    wire = cq.Wire.makePolygon([cq.Vector(r, 0, z) for r, z in _distinct(profile)], close=True)
    return one_solid(cq.Solid.revolve(wire, [], 360.0, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1)), name)


def turned_about_y(profile: Sequence[Point2], start_deg: float, sweep_deg: float, name: str) -> cq.Solid:
    """Solid of revolution about Y of (radius, y) points, from ``start_deg`` (0 at +Z, positive towards +X)."""
    import cadquery as cq

    wire = cq.Wire.makePolygon([cq.Vector(r, y, 0) for r, y in _distinct(profile)], close=True)
    # The profile stands on the +X axis, which is 90 degrees from +Z.
    placed = wire.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 1, 0), start_deg - 90.0)
    return one_solid(cq.Solid.revolve(placed, [], sweep_deg, cq.Vector(0, 0, 0), cq.Vector(0, 1, 0)), name)


def cylinder(radius: float, start: Point3, direction: Point3, length: float) -> cq.Solid:
    """Cylinder of ``length`` from ``start`` along ``direction``."""
    import cadquery as cq

    return cq.Solid.makeCylinder(radius, length, cq.Vector(*start), cq.Vector(*direction))


def cylinder_y(radius: float, x: float, z: float, y_start: float, y_end: float) -> cq.Solid:
    """Cylinder parallel to Y between two depths."""
    return cylinder(radius, (x, y_start, z), (0, 1, 0), y_end - y_start)


def cylinder_z(radius: float, x: float, y: float, z_start: float, z_end: float) -> cq.Solid:
    """Cylinder parallel to Z between two heights."""
    return cylinder(radius, (x, y, z_start), (0, 0, 1), z_end - z_start)


def block(x: Point2, y: Point2, z: Point2) -> cq.Solid:
    """Box between the given limits."""
    import cadquery as cq

    return cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], z[1] - z[0], cq.Vector(x[0], y[0], z[0]))


def extruded_y(outline: cq.Wire, length: float, holes: Sequence[cq.Wire] = ()) -> cq.Solid:
    """Prism along Y of ``length`` over a flat outline less its ``holes``, which lie inside it."""
    import cadquery as cq

    return cq.Solid.extrudeLinear(outline, list(holes), cq.Vector(0, length, 0))


def prism_y(points: Sequence[Point2], y_start: float, y_end: float, radius: float = 0.0) -> cq.Solid:
    """Prism along Y over a closed polygon of (x, z) points, its edges parallel to Y rounded by ``radius``."""
    import cadquery as cq

    outline = cq.Wire.makePolygon([cq.Vector(x, y_start, z) for x, z in points], close=True)
    return extruded_y(_rounded(outline, radius), y_end - y_start)


def pocket_y(x: Point2, y: Point2, z: Point2, radius: float) -> cq.Solid:
    """Tool of a pocket milled along Y: a box, its edges parallel to Y rounded by ``radius``, or less if narrow."""
    corners = [(x[0], z[0]), (x[1], z[0]), (x[1], z[1]), (x[0], z[1])]
    return prism_y(corners, *y, pocket_corner_mm(radius, x[1] - x[0], z[1] - z[0]))


def _rounded(outline: cq.Wire, radius: float) -> cq.Wire:
    """The flat outline with all corners rounded, which is far faster than to round the edges of a prism."""
    import cadquery as cq

    if radius <= 0.0:
        return outline
    face = cq.Face.makeFromWires(outline)
    return face.fillet2D(radius, face.Vertices()).outerWire()


def sector_outline(
    r_inner: float, r_outer: float, start_deg: float, end_deg: float, y: float, radius: float = 0.0
) -> cq.Wire:
    """Outline of an annular sector about the Y axis at ``y`` (angles from +Z towards +X), its four corners rounded."""
    import cadquery as cq

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
    import cadquery as cq

    inner, outer = (cq.Wire.makeCircle(r, cq.Vector(0, y, 0), cq.Vector(0, 1, 0)) for r in (r_inner, r_outer))
    return extruded_y(outer, length, [inner, *holes])


def hexagon_z(across_flats: float, z_start: float, z_end: float) -> cq.Solid:
    """Hexagonal prism along Z."""
    import cadquery as cq

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
