"""Solid of the two-input frame from its drawing alone: envelope, walls and floors by dimensions, holes by tables.

Depths are measured from the back face, as on the sheet; X to the right and Z up, from the drum's axis.
"""

from __future__ import annotations

import re

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, ReadDimension, table
from tests.support.milled_from_drawing import one

Span = tuple[float, float]
# Beyond the part, for tools that are open on one side.
_OUT = 2.0


def plain(dims: list[ReadDimension], wanted: int, what: str) -> list[float]:
    """Values of lengths without a word, from the smallest."""
    found = sorted(d.value for d in dims if d.suffix == "" and d.prefix == "")
    if len(found) != wanted:
        raise (MissingDimensionError if len(found) < wanted else DoubledDimensionError)(f"{what}: {found}")
    return found


def box(x: Span, y: Span, z: Span) -> cq.Solid:
    return cq.Solid.makeBox(x[1] - x[0], y[1] - y[0], z[1] - z[0], cq.Vector(x[0], y[0], z[0]))


def pocket(x: Span, y: Span, z: Span, radius: float) -> cq.Shape:
    return cq.Workplane(obj=box(x, y, z)).edges("|Y").fillet(radius).val()  # type: ignore[return-value]


def along_y(radius: float, x: float, z: float, y: Span) -> cq.Solid:
    return cq.Solid.makeCylinder(radius, y[1] - y[0], cq.Vector(x, y[0], z), cq.Vector(0, 1, 0))


def along_z(radius: float, x: float, y: float, z: Span) -> cq.Solid:
    return cq.Solid.makeCylinder(radius, z[1] - z[0], cq.Vector(x, y, z[0]))


class _Said:
    """Sizes that the views give, by name."""

    def __init__(self, dims: list[ReadDimension]) -> None:
        front = [d for d in dims if d.view == "front"]
        section = [d for d in dims if d.view == "section"]

        def half(word: str) -> float:
            return one(front, "front", "", "across", suffix=word).value / 2

        (self.wide,) = (w / 2 for w in plain([d for d in front if d.across], 1, "width"))
        self.inside, self.web, self.ears = half(" pockets"), half(" web"), half(" ears")
        self.boss, self.rib = half(" column"), _column_pocket(front)
        self.ear_height = one(front, "front", "", "up", suffix=" ears").value / 2
        upright = [d for d in front if not d.across and d.suffix == ""]
        from_axis = [d for d in upright if min(abs(d.start[1]), abs(d.end[1])) < 0.05]
        self.column_floor, self.low, self.top = plain(from_axis, 3, "heights from the drum's axis")
        walls = sorted((d for d in upright if d not in from_axis), key=lambda d: min(d.start[1], d.end[1]))
        if len(walls) != 3:
            raise MissingDimensionError(f"shelves and coupling space: {[d.value for d in walls]}")
        self.motor, self.coupling, self.shelf = (d.value for d in walls)
        across = [d for d in section if d.across]
        above = [d for d in across if d.end[1] > 0.0]
        (self.depth,) = plain(above, 1, "depth")
        self.floor = one(section, "section", "", "across", suffix=" pockets").value
        self.upper_floor = one(section, "section", "", "across", suffix=" top pocket").value
        self.a = one(section, "section", "", "across", suffix=" axis of A").value
        self.ear_front = one(section, "section", "", "across", suffix=" ears").value
        below = plain([d for d in across if d not in above], 4, "depths of the boss")
        self.encoder, self.rear_seat, self.front_seat, self.boss_front = below
        self.seat = one(section, "section", "Ø", suffix="H6").value / 2
        (self.shoulder,) = (d.value / 2 for d in _bores(section))
        self.column_start = one(dims, "rear", suffix=" column").value
        (self.encoder_radius,) = (d.value for d in _radii(dims, "rear"))
        (self.corner,) = (d.value for d in _radii(dims, "top"))


def _column_pocket(front: list[ReadDimension]) -> float:
    """Half width of the column's pocket: its word is 'pocket', that of the wide ones 'pockets'."""
    found = [d for d in front if d.suffix == " pocket"]
    if len(found) != 1:
        raise MissingDimensionError("width of the column's pocket")
    return found[0].value / 2


def _bores(section: list[ReadDimension]) -> list[ReadDimension]:
    found = [d for d in section if d.prefix == "Ø" and "H" not in d.suffix]
    if len(found) != 1:
        raise MissingDimensionError("shoulder of the drum's bearings")
    return found


def _radii(dims: list[ReadDimension], view: str) -> list[ReadDimension]:
    found = [d for d in dims if d.view == view and d.kind == "radius"]
    if len(found) != 1:
        raise MissingDimensionError(f"radius in {view}: {len(found)}")
    return found


def bored(
    doc: Drawing, tables: dict[str, str], shelves: dict[str, Span], faces: dict[str, float], axis: float
) -> list[cq.Shape]:
    """Tools of all holes, from the face and along the axis that their positions are given for.

    ``tables``: title of the table of positions by axis; ``shelves``: where the faces of holes along Z begin and end;
    ``faces``: where those of holes along Y are; ``axis``: where that of hole A is along Y.
    """
    rows = {row[0]: row for row in table(doc, "Holes")[1:]}
    tools: list[cq.Shape] = []
    for along, title in tables.items():
        for name, first, second, _ in table(doc, title)[1:]:
            _, _, drill, thread, depth, _, bore, start = rows[name[0]]
            radius = float(thread[1:].split()[0]) / 2 if thread.startswith("M") else float(drill) / 2
            found = re.fullmatch(r"Ø([\d.]+)(?: [A-Z]+\d+)? x ([\d.]+)", bore)
            if along == "Z":
                low, high = shelves[start]
                x, y = float(first), float(second) + axis
                bottom = low - _OUT if depth == "through" else high - float(depth)
                tools.append(along_z(radius, x, y, (max(bottom, low - 0.01), high + 0.01)))
                if found:
                    tools.append(along_z(float(found[1]) / 2, x, y, (high - float(found[2]), high + 0.01)))
                continue
            x, z, face = float(first), float(second), faces[start]
            if depth == "to A":
                tools.append(along_y(radius, x, z, (axis, face + _OUT)))
            elif start == "encoder pocket":
                tools.append(along_y(radius, x, z, (face - 0.01, face + float(depth))))
            else:
                deep = 0.0 if depth == "through" else face - float(depth)
                tools.append(along_y(radius, x, z, (deep - (0.01 if depth == "through" else 0.0), face + _OUT)))
            if found:
                tools.append(along_y(float(found[1]) / 2, x, z, (face - float(found[2]), face + 0.01)))
    return tools


def frame(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """The frame, its back face at y = 0."""
    s = _Said(dims)
    upper: cq.Shape = box((-s.wide, s.wide), (0.0, s.depth), (s.low, s.top))
    upper = cq.Workplane(obj=upper).edges("|Z").fillet(s.corner).val()  # type: ignore[assignment]
    body = upper.fuse(
        box((-s.boss, s.boss), (0.0, s.depth), (0.0, s.low)),
        along_y(s.boss, 0.0, 0.0, (s.encoder, s.boss_front)),
        box((-s.ears, s.ears), (s.encoder, s.ear_front), (-s.ear_height, s.ear_height)),
    )
    out, shelf = (s.floor, s.depth + _OUT), s.low + s.motor + s.coupling
    corners = {row[0]: float(row[1]) for row in table(doc, "Corners of the pockets")[1:]}
    beside = corners["beside the web"]
    tables = {along: f"Positions from A and the drum axis, along {along}" for along in "ZY"}
    shelves = {"bearing shelf": (shelf, shelf + s.shelf), "motor shelf": (s.low, s.low + s.motor), "top": (0.0, s.top)}
    faces = {"front": s.depth, "pocket floor": s.floor, "encoder pocket": s.encoder}
    upper_z = (shelf + s.shelf, s.top + 2 * s.corner + _OUT)
    tools = [
        pocket((-s.inside, s.inside), (s.upper_floor, out[1]), upper_z, corners["top pocket"]),
        pocket((s.web, s.inside), out, (s.low + s.motor, shelf), beside),
        pocket((-s.inside, -s.web), out, (s.low + s.motor, shelf), beside),
        pocket((-s.rib, s.rib), out, (s.column_floor, s.low), corners["column"]),
        box((-s.boss - _OUT, s.boss + _OUT), (-_OUT, s.encoder), (-s.boss - _OUT, s.column_start)),
        along_y(s.encoder_radius, 0.0, 0.0, (-_OUT, s.encoder)),
        along_y(s.seat, 0.0, 0.0, (-_OUT, s.rear_seat)),
        along_y(s.shoulder, 0.0, 0.0, (s.rear_seat - 0.5, s.front_seat + 0.5)),
        along_y(s.seat, 0.0, 0.0, (s.front_seat, s.boss_front + _OUT)),
        *bored(doc, tables, shelves, faces, s.a),
    ]
    for tool in tools:
        body = body.cut(tool)
    return body
