"""Solid of the drum sector from its drawing alone: turned shape, tables of lands, windows and terminals.

Depths are measured from face A along the axis, angles from Z to X, as on the sheet.
"""

from __future__ import annotations

from math import cos, radians, sin

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import MissingDimensionError, ReadDimension, table
from tests.support.milled_from_drawing import one

# Where the sheet says open: beyond the end of the longest sector, mm.
_OPEN = 300.0
# What a lug is rooted in below the wall of its pocket stands inside the rim, so that any depth gives the same part.
_ROOT = 0.3


def _rows(doc: Drawing, title: str, wanted: int) -> list[list[str]]:
    rows = table(doc, title)[1:]
    if len(rows) < wanted:
        raise MissingDimensionError(f"{title}: {len(rows)} lines of {wanted}")
    return rows


def _ring(outer: float, inner: float, y: tuple[float, float]) -> cq.Shape:
    def rod(radius: float) -> cq.Solid:
        return cq.Solid.makeCylinder(radius, y[1] - y[0], cq.Vector(0, y[0], 0), cq.Vector(0, 1, 0))

    return rod(outer).cut(rod(inner))


def _at(radius: float, deg: float, y: float = 0.0) -> cq.Vector:
    return cq.Vector(radius * sin(radians(deg)), y, radius * cos(radians(deg)))


def _wedge(half_deg: float, reach: float, y: tuple[float, float]) -> cq.Solid:
    """Everything within the angle on both sides of Z, up to ``reach``."""
    steps = [half_deg * k / 8 for k in range(-8, 9)]
    points = [cq.Vector(0, y[0], 0), *(_at(reach / cos(radians(half_deg / 16)), a, y[0]) for a in steps)]
    return cq.Solid.extrudeLinear(cq.Wire.makePolygon(points, close=True), [], cq.Vector(0, y[1] - y[0], 0))


def _window(inner: float, outer: float, start: float, end: float, y: tuple[float, float], corner: float) -> cq.Shape:
    middle = (start + end) / 2
    edges = [
        cq.Edge.makeThreePointArc(_at(outer, start, y[0]), _at(outer, middle, y[0]), _at(outer, end, y[0])),
        cq.Edge.makeLine(_at(outer, end, y[0]), _at(inner, end, y[0])),
        cq.Edge.makeThreePointArc(_at(inner, end, y[0]), _at(inner, middle, y[0]), _at(inner, start, y[0])),
        cq.Edge.makeLine(_at(inner, start, y[0]), _at(outer, start, y[0])),
    ]
    tool = cq.Solid.extrudeLinear(cq.Wire.assembleEdges(edges), [], cq.Vector(0, y[1] - y[0], 0))
    return cq.Workplane(obj=tool).edges("|Y").fillet(corner).val() if corner else tool  # type: ignore[return-value]


class _Terminal:
    """One column of the table of terminals, with the frame that s and n are measured in."""

    def __init__(self, say: dict[str, str], outer: float) -> None:
        angle = float(say["angle from Z to X, deg"])
        side = 1.0 if angle > 0 else -1.0
        self.foot = _at(float(say["pitch radius"]), angle)
        self.outward = _at(1.0, angle)
        self.along = _at(1.0, angle + 90.0 * side)
        self.axis = float(say["depth of axis from A"])

        def number(head: str, open_: float) -> float:
            return open_ if say[head] in ("open", "through") else float(say[head])

        self.start = float(say["swage pocket from s"])
        self.lug = (float(say["swage pocket to, lug from s"]), float(say["lug to, nut pocket from s"]))
        self.end, self.top = number("nut pocket to s", _OPEN), number("pockets up to n", _OPEN)
        self.swage = number("swage pocket depth from A", outer + 1.0)
        self.nuts = number("nut pocket depth from A", outer + 1.0)
        low, high = say["lug depth from A"].split(" to ")
        self.lug_depth = (float(low), float(high))

    def point(self, s: float, n: float, y: float) -> cq.Vector:
        return self.foot + self.along * s + self.outward * n + cq.Vector(0, y, 0)

    def box(self, s: tuple[float, float], n: tuple[float, float], y: tuple[float, float]) -> cq.Solid:
        corners = [self.point(a, b, y[0]) for a, b in ((s[0], n[0]), (s[1], n[0]), (s[1], n[1]), (s[0], n[1]))]
        return cq.Solid.extrudeLinear(cq.Wire.makePolygon(corners, close=True), [], cq.Vector(0, y[1] - y[0], 0))


def _terminals(doc: Drawing, body: cq.Shape, outer: float) -> cq.Shape:
    rows = _rows(doc, "Terminals", 12)
    shared = {row[0]: row[1] for row in _rows(doc, "Pockets, lugs and stop slot", 10)}
    flat, nuts, lug = (float(shared[k]) for k in ("swage pocket n from", "nut pocket n from", "lug n up to"))
    slot, corner = float(shared["stud slot of the lug, width, round end"]), float(shared["pocket corners R"])
    low = -2.0

    def milled(tool: cq.Solid) -> cq.Shape:
        return cq.Workplane(obj=tool).edges("|Y").fillet(corner).val()  # type: ignore[return-value]

    for k in range(1, len(rows[0])):
        t = _Terminal({row[0]: row[k] for row in rows}, outer)
        body = body.cut(milled(t.box((t.start, t.lug[0]), (flat, t.top), (low, t.swage))))
        body = body.cut(milled(t.box((t.lug[1], t.end), (nuts, t.top), (low, t.nuts))))
        body = body.cut(t.box(t.lug, (flat, t.top), (low, t.swage)))
        body = body.cut(t.box((t.lug[0] - corner, t.lug[1] + corner), (lug, t.top), (low, t.swage)))
        body = body.fuse(t.box(t.lug, (flat - _ROOT, lug), t.lug_depth))
        width = t.box((t.lug[0] - 0.5, t.lug[1] + 0.5), (-slot / 2, slot / 2), (low, t.axis))
        start = t.point(t.lug[0] - 0.5, 0.0, t.axis)
        body = body.cut(width.fuse(cq.Solid.makeCylinder(slot / 2, t.lug[1] - t.lug[0] + 1.0, start, t.along)))
    return body


def drum(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """The drum, face A at y = 0."""
    half = one(dims, "rear", suffix="°").value / 2
    (inner,) = (d.value for d in dims if d.view == "rear" and d.kind == "radius" and "°" not in d.suffix)
    across = [d for d in dims if d.view == "section" and d.across]
    web = one(across, "section", suffix=" web").value
    screws = one(across, "section", suffix=" Q").value
    chamfer = one(across, "section", suffix="45").value
    plain = sorted(d.value for d in across if d.suffix == "")
    bores = sorted(d.value / 2 for d in dims if d.view == "section" and d.prefix == "Ø")
    if len(plain) != 3 or len(bores) != 3:
        raise MissingDimensionError(f"lengths {plain}, diameters {bores}")
    (hub_start, web_start, face), (bore, spigot, hub) = plain, bores
    circle = one(dims, "hub", "Ø").value / 2
    terminals = len(_rows(doc, "Terminals", 12)[0]) - 1  # each stands on a step of its own
    rows = _rows(doc, "Lands", 1)
    if (steps := sum(row[0].count(",") + 1 for row in rows)) != terminals:
        raise MissingDimensionError(f"Lands: {steps} steps for {terminals} terminals")
    lands = [(float(r), float(a), float(b)) for _, r, _, a, b in rows]
    reach, outer = max(r for r, _, _ in lands), lands[-1][2]
    wedge = _wedge(half, reach + 1.0, (-1.0, face))
    body: cq.Shape = _ring(hub, bore, (hub_start, face - chamfer))
    cone = cq.Solid.makeCone(hub, hub - chamfer, chamfer, cq.Vector(0, face - chamfer, 0), cq.Vector(0, 1, 0))
    bodies = [cone, _ring(spigot, bore, (0.0, hub_start))]
    bodies.append(_ring(inner + 0.5, hub - 0.5, (web_start, web_start + web)).intersect(wedge))
    sizes = {row[0]: float(row[1]) for row in _rows(doc, "Pockets, lugs and stop slot", 10)}
    root, front = sizes["web thicker up to R"], sizes["web thicker, in front up to"]
    if root > hub:
        bodies.append(_ring(root, hub - 0.5, (web_start, front)).intersect(wedge))
    bodies += [_ring(r, inner, (a, b)).intersect(wedge) for r, a, b in lands]
    body = body.fuse(*bodies).cut(cq.Solid.makeCylinder(bore, face + 2, cq.Vector(0, -1, 0), cq.Vector(0, 1, 0)))
    body = _terminals(doc, body, outer)
    through = (web_start - 1.0, web_start + web + 1.0)
    windows = table(doc, "Windows")
    corner = float(_title(doc, "Windows").split("corners R")[1].split(",")[0])
    for _, r_in, r_out, start, end in windows[1:]:
        body = body.cut(_window(float(r_in), float(r_out), float(start), float(end), through, corner))
    shared = {row[0]: row[1] for row in _rows(doc, "Pockets, lugs and stop slot", 10)}
    stop, wide = float(shared["stop slot: radius"]), float(shared["stop slot: width, round ends"]) / 2
    ends = float(shared["stop slot: ends at +- deg"])
    body = body.cut(_window(stop - wide, stop + wide, -ends, ends, through, 0.0))
    for deg in (-ends, ends):
        rod = cq.Solid.makeCylinder(wide, through[1] - through[0], _at(stop, deg, through[0]), cq.Vector(0, 1, 0))
        body = body.cut(rod)
    holes = {row[0]: row for row in _rows(doc, "Holes", 2)}
    radius = {
        k: float(row[3][1:].split()[0]) / 2 if row[3].startswith("M") else float(row[2]) / 2 for k, row in holes.items()
    }
    for name, x, z, _ in table(doc, "Positions from the axis")[1:]:
        at, along = cq.Vector(float(x), 0.0, float(z)), cq.Vector(0, 1, 0)
        _, _, _, _, depth, _, _, begins = holes[name[0]]
        if begins == "hub, radial":
            tool = cq.Solid.makeCylinder(radius[name[0]], hub + 1.0, cq.Vector(0, face - screws, 0), at.normalized())
        elif begins == "hub back":
            deep = float(depth)
            tool = cq.Solid.makeCylinder(radius[name[0]], deep + 1.0, at + along * (hub_start - 1.0), along)
        else:
            if name[0] == "P" and abs(at.Length - circle) > 2e-3:
                raise MissingDimensionError(f"{name} is not on its circle")
            deep = float(depth)
            tool = cq.Solid.makeCylinder(radius[name[0]], deep + 1.0, at + along * (face - deep), along)
        body = body.cut(tool)
    return body


def _title(doc: Drawing, start: str) -> str:
    for block in doc.blocks:
        for text in block.query("TEXT"):
            if text.dxf.text.startswith(start):
                return str(text.dxf.text)
    raise MissingDimensionError(start)
