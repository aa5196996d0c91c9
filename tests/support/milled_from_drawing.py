"""Solids of milled parts from their drawings alone: dimensions by their positions, tables by their headings."""

from __future__ import annotations

import re
from math import cos, radians, sin, sqrt

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, ReadDimension, table

Box = tuple[float, float]


def one(dims: list[ReadDimension], view: str, prefix: str = "", side: str = "", **wanted: float | str) -> ReadDimension:
    """The one dimension of a view with this prefix, whose text's rest contains ``suffix`` if given."""
    found = [
        d
        for d in dims
        if d.view == view
        and d.prefix == prefix
        and (side == "" or d.across == (side == "across"))
        and ("suffix" not in wanted or str(wanted["suffix"]) in d.suffix)
    ]
    if not found:
        raise MissingDimensionError(f"{view}: {prefix or 'length'} {side} {wanted}")
    if len(found) > 1:
        raise DoubledDimensionError(f"{view}: {prefix} {side} {[d.value for d in found]}")
    return found[0]


def pair(dims: list[ReadDimension], view: str, across: bool) -> tuple[float, float]:
    """The smaller and the larger of the two lengths of a view in one direction."""
    found = sorted(d.value for d in dims if d.view == view and d.across == across and d.prefix == "")
    if len(found) != 2:
        raise (MissingDimensionError if len(found) < 2 else DoubledDimensionError)(f"{view}: {found}")
    return found[0], found[1]


def cylinder(radius: float, x: float, y: float, z: Box) -> cq.Solid:
    return cq.Solid.makeCylinder(radius, z[1] - z[0], cq.Vector(x, y, z[0]))


def holes(doc: Drawing, thickness: float) -> list[cq.Solid]:
    """Tools of all holes of a plate that lies between z = 0 and ``thickness``."""
    places = {row[0]: (float(row[1]), float(row[2])) for row in table(doc, "Positions")[1:]}
    tools = []
    for letter, count, drill, thread, depth, _, bore, start in table(doc, "Holes")[1:]:
        names = [letter] if count == "1" else [f"{letter}{n}" for n in range(1, int(count) + 1)]
        radius = float(thread[1:].split()[0]) / 2 if thread != "-" else float(drill) / 2
        for name in names:
            x, y = places.pop(name)
            deep = thickness if depth == "through" else float(depth)
            span = (thickness - deep, thickness + 1.0) if start == "top" else (-1.0, deep)
            if depth == "through":
                span = (-1.0, thickness + 1.0)
            tools.append(cylinder(radius, x, y, span))
            if bore != "-":
                found = re.fullmatch(r"Ø([\d.]+)(?: [A-Z]+\d+)? x ([\d.]+)", bore)
                assert found is not None, bore
                sunk = float(found[2])
                over = (thickness - sunk, thickness + 1.0) if start == "top" else (-1.0, sunk)
                tools.append(cylinder(float(found[1]) / 2, x, y, over))
    assert not places, f"positions of holes that the table does not list: {places}"
    return tools


def top_plate(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    left, width = pair(dims, "top", True)
    front, depth = pair(dims, "top", False)
    thickness = one(dims, "section").value
    corner = next((d for d in dims if d.kind == "radius"), None)
    if corner is None:
        raise MissingDimensionError("corner radius")
    plate = cq.Solid.makeBox(width, depth, thickness, cq.Vector(-left, front - depth, 0.0))
    body = cq.Workplane(obj=plate).edges("|Z").fillet(corner.value).val()
    return body.cut(*holes(doc, thickness))  # type: ignore[union-attr, return-value]


def collar(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    radius = one(dims, "end", "Ø").value / 2
    slit, seat = pair(dims, "end", False)
    flat, offset = pair(dims, "end", True)
    bore = one(dims, "side", "Ø").value / 2
    width = one(dims, "side", "", "across").value
    clear, tapped = (row for row in table(doc, "Holes")[1:])
    body = cylinder(radius, 0.0, 0.0, (0.0, width)).cut(cylinder(bore, 0.0, 0.0, (-1.0, width + 1.0)))
    far = radius + 1.0

    def box(x: Box, y: Box) -> cq.Solid:
        return cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], width + 2.0, cq.Vector(x[0], y[0], -1.0))

    at = cq.Vector(offset, 0.0, width / 2)
    return body.cut(
        box((0.0, far), (-slit / 2, slit / 2)),
        box((flat, far), (seat, far)),
        cq.Solid.makeCylinder(float(clear[2]) / 2, far, at, cq.Vector(0, 1, 0)),
        cq.Solid.makeCylinder(float(tapped[3][1:]) / 2, far, at, cq.Vector(0, -1, 0)),
    )


def slot_tools(doc: Drawing, faces: dict[str, float], outwards: dict[str, float]) -> list[cq.Shape]:
    """Tools of the slots of an input pulley from their table; ``faces``: where the land's faces stand along the axis,
    ``outwards``: which way out of the part."""
    rows = {row[0]: row[1:] for row in table(doc, "Slots")[1:]}
    if len(rows) != 14:
        raise MissingDimensionError(f"slots: {len(rows)} lines of 14")
    tools: list[cq.Shape] = []
    for n in range(len(rows["width"])):
        say = {head.split(",")[0]: values[n] for head, values in rows.items()}
        face = say["milled from land face"]
        z, out = faces[face], outwards[face]
        a, sense = radians(float(say["u from X"])), 1.0 if say["v from u"] == "+90" else -1.0
        u, v = (cos(a), sin(a)), (-sense * sin(a), sense * cos(a))
        width, rho, centre = (
            float(say["width"]),
            float(say["bend: radius to middle of slot"]),
            float(say["bend: centre on u"]),
        )

        def at(s: float, t: float, level: float, u=u, v=v) -> cq.Vector:  # type: ignore[no-untyped-def]
            return cq.Vector(s * u[0] + t * v[0], s * u[1] + t * v[1], level)

        def arc(radius: float, deg: float, level: float, centre=centre, at=at) -> cq.Vector:  # type: ignore[no-untyped-def]
            return at(centre + radius * cos(radians(deg)), radius * sin(radians(deg)), level)

        low = z - out * float(say["depth from land face"])
        inner, outer, wide = rho - width / 2, rho + width / 2, float(say["bend: outside open from u to deg"])
        line, three = cq.Edge.makeLine, cq.Edge.makeThreePointArc
        band = [
            three(arc(inner, 0, low), arc(inner, 45, low), arc(inner, 90, low)),
            line(arc(inner, 90, low), at(0, inner, low)),
            line(at(0, inner, low), at(0, outer, low)),
            line(at(0, outer, low), arc(outer, 90, low)),
            three(arc(outer, 90, low), arc(outer, 45, low), arc(outer, 0, low)),
            line(arc(outer, 0, low), arc(inner, 0, low)),
        ]
        open_ = [
            three(arc(rho, 0, low), arc(rho, wide / 2, low), arc(rho, wide, low)),
            line(arc(rho, wide, low), arc(2 * outer, wide, low)),
            line(arc(2 * outer, wide, low), arc(2 * outer, 0, low)),
            line(arc(2 * outer, 0, low), arc(rho, 0, low)),
        ]
        height = cq.Vector(0, 0, z + out - low)
        tools += [cq.Solid.extrudeLinear(cq.Wire.assembleEdges(edges), [], height) for edges in (band, open_)]
        deep = z - out * float(say["pocket: depth from land face"])
        half_u, half_v = float(say["pocket: length along u"]) / 2, float(say["pocket: width"]) / 2
        middle = float(say["pocket: middle on u"])
        corners = [(middle + p * half_u, rho + q * half_v, p, q) for p, q in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        up = cq.Vector(0, 0, z + out - deep)
        tools.append(
            cq.Solid.extrudeLinear(cq.Wire.makePolygon([at(s, t, deep) for s, t, _, _ in corners], close=True), [], up)
        )
        relief = float(say["pocket: corner reliefs Ø"]) / 2
        for s, t, p, q in corners:
            spot = at(s - p * relief / sqrt(2), t - q * relief / sqrt(2), deep)
            tools.append(cq.Solid.extrudeLinear(cq.Wire.makeCircle(relief, spot, cq.Vector(0, 0, 1)), [], up))
    return tools
