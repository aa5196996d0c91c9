"""Solid of the drum sector from its drawing alone: turned shape, tables of lands, windows and terminals.

Depths are measured from face A along the axis, angles from Z to X, as on the sheet.
"""

import re
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import (
    DoubledDimensionError,
    MissingDimensionError,
    ReadDimension,
    ReadView,
    note_number,
    table,
)

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


def exactly(found: list[ReadDimension], count: int, what: str) -> list[ReadDimension]:
    """These dimensions, smaller values first; as many as there must be."""
    if len(found) != count:
        raise (MissingDimensionError if len(found) < count else DoubledDimensionError)(f"{what}: {len(found)}")
    return sorted(found, key=lambda d: d.value)


def rounded_box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], radius: float) -> cq.Shape:
    box = cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], z[1] - z[0], cq.Vector(x[0], y[0], z[0]))
    return cq.Workplane(obj=box).edges("|Z").fillet(radius).val()  # type: ignore[return-value]


def motor_head(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    section = [d for d in dims if d.view == "section"]
    low, shelf, top = (d.value for d in exactly([d for d in section if not d.across], 3, "heights"))
    inner = one(section, "section", suffix="pocket").value / 2
    walls = [d for d in section if d.across and "pocket" not in d.suffix]
    # The flange's width stands below the part, the other one above it.
    exactly(walls, 2, "widths")
    middle = sum(d.start[1] for d in walls) / 2
    ((half_x,), (outer,)) = ([d.value / 2 for d in walls if (d.start[1] > middle) == above] for above in (False, True))
    across = [d for d in dims if d.view == "top" and d.kind == "linear"]
    right = exactly([d for d in across if max(d.start[0], d.end[0]) > 0.0], 2, "depths of the flange")
    left = [d for d in across if max(d.start[0], d.end[0]) <= 0.0]
    (front,) = (d.value for d in exactly([d for d in left if d.end[1] > 0.0], 1, "front of the box"))
    (back,) = (d.value for d in exactly([d for d in left if d.end[1] <= 0.0], 1, "back of the box"))
    flange_front, flange_deep = right[0].value, right[1].value
    radius = one(dims, "top", "R").value
    behind = note_number(doc, r"Pocket from the front, ([\d.]+) behind")
    corner = note_number(doc, r"its corners R([\d.]+)\.")
    body = rounded_box((-half_x, half_x), (flange_front - flange_deep, flange_front), (0.0, low), radius)
    body = body.fuse(rounded_box((-outer, outer), (-back, front), (low, top), radius))
    pocket = cq.Solid.makeBox(2 * inner, behind + _OPEN, shelf - low, cq.Vector(-inner, -behind, low))
    body = body.cut(cq.Workplane(obj=pocket).edges("|Y").fillet(corner).val())  # type: ignore[arg-type]
    return drilled(doc, body, (low, shelf, top))


def boxed_plate(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """A top plate with a coupling box at each hole B."""
    section, above = ([d for d in dims if d.view == name and d.kind == "linear"] for name in ("section", "top"))
    low, shelf, top = (d.value for d in exactly([d for d in section if not d.across], 3, "heights"))
    outer, inner = (one(section, "section", suffix=word).value / 2 for word in (" box", " pocket"))
    left, width = (d.value for d in exactly([d for d in above if d.across], 2, "widths"))
    front, depth = (d.value for d in exactly([d for d in above if not d.across and d.suffix == ""], 2, "depths"))
    box_front = front - depth + one(above, "top", suffix=" front of boxes").value
    box_back = box_front - exactly([d for d in above if d.suffix == " boxes"], 1, "depth of the boxes")[0].value
    radii = exactly([d for d in dims if d.view == "top" and d.kind == "radius"], 2, "corners")
    plate_corner, box_corner = (next(d.value for d in radii if d.count == n) for n in (4, 8))
    behind = note_number(doc, r"Pockets from the front, ([\d.]+) behind")
    corner = note_number(doc, r"their corners R([\d.]+)\.")
    body = rounded_box((-left, width - left), (front - depth, front), (0.0, low), plate_corner)
    axes = [(float(row[1]), float(row[2])) for row in table(doc, "Positions")[1:] if row[0].startswith("B")]
    for x, _ in axes:
        body = body.fuse(rounded_box((x - outer, x + outer), (box_back, box_front), (low, top), box_corner))
    for x, y in axes:
        pocket = cq.Solid.makeBox(2 * inner, behind + _OPEN, shelf - low, cq.Vector(x - inner, y - behind, low))
        body = body.cut(cq.Workplane(obj=pocket).edges("|Y").fillet(corner).val())  # type: ignore[arg-type]
    return drilled(doc, body, (low, shelf, top))


def drilled(doc: Drawing, body: cq.Shape, heights: tuple[float, float, float]) -> cq.Shape:
    """The body with the holes of the table; ``heights``: of the plate, and of both faces of the motor shelf."""
    low, shelf, top = heights
    places = {row[0]: (float(row[1]), float(row[2])) for row in table(doc, "Positions")[1:]}
    for letter, count, drill, _, depth, _, bore, start in table(doc, "Holes")[1:]:
        if depth != "through":
            raise MissingDimensionError(f"{letter} goes {depth}")
        span = (shelf - 0.5, top + 1.0) if start == "motor shelf" else (-1.0, low + 0.5)
        for name in [letter] if count == "1" else [f"{letter}{n}" for n in range(1, int(count) + 1)]:
            x, y = places.pop(name)
            body = body.cut(cylinder(float(drill) / 2, x, y, span))
            if bore != "-":
                sunk = re.fullmatch(r"Ø([\d.]+)(?: [A-Za-z]+\d+)? x ([\d.]+)", bore)
                assert sunk is not None, bore
                deep = float(sunk[2])
                over = (low - deep, low + 0.5) if start == "top" else (-1.0, deep)
                body = body.cut(cylinder(float(sunk[1]) / 2, x, y, over))
    assert not places, f"positions of holes that the table does not list: {places}"
    return body


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
