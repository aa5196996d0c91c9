"""Solid of the two-input frame from its drawing alone: envelope, walls and floors by dimensions, holes by tables.

Depths are measured from the back face, as on the sheet; X to the right and Z up, from the drum's axis.
"""

import re
from dataclasses import dataclass

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, ReadDimension, note_number, table
from tests.support.drum_from_drawing import exactly, one

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


# Beyond the part, for tools that are open on one side.
# Points nearer than this on the paper are one.
_ON_PAPER_MM = 0.05


def _halves(dims: list[ReadDimension], view: str, *words: str) -> list[float]:
    """Half of each width that has such a word."""
    return [one(dims, view, "", "across", suffix=word).value / 2 for word in words]


def _bores_of(section: list[ReadDimension]) -> tuple[float, float]:
    """Radii of the seats of the drum's bearings and of the shoulder between them."""
    seat = one(section, "section", "Ø", suffix="H6")
    (shoulder,) = exactly([d for d in section if d.prefix == "Ø" and d is not seat], 1, "shoulder of the seats")
    return seat.value / 2, shoulder.value / 2


def _seats(seat: float, shoulder: float, rear: float, front: float, end: float) -> list[cq.Shape]:
    return [
        along_y(seat, 0.0, 0.0, (-_OUT, rear)),
        along_y(shoulder, 0.0, 0.0, (rear - 0.5, front + 0.5)),
        along_y(seat, 0.0, 0.0, (front, end + _OUT)),
    ]


def column(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """The frame of a siso bevel drive, its back face at y = 0."""
    front, section = ([d for d in dims if d.view == view] for view in ("front", "section"))
    words = (" box", " column", " pockets", " boss", " ears")
    inside, post_x, inner, boss, ears = _halves(front, "front", *words)
    (wide,) = (w / 2 for w in plain([d for d in front if d.across], 1, "width"))
    heights = plain([d for d in front if not d.across], 7, "heights from the drum's axis")
    post, low, stop_low, stop_high, shelf_low, shelf_high, top = heights
    across = [d for d in section if d.across]
    above = [d for d in across if d.end[1] > 0.0]
    (depth,) = plain(above, 1, "depth")
    floor, a, ear_front = (
        one(section, "section", "", "across", suffix=word).value for word in (" pockets", " axis of A", " ears")
    )
    encoder, rear, fore, end = plain([d for d in across if d not in above], 4, "depths of the boss")
    corner = one(dims, "top", "R").value
    corners = {row[0]: float(row[1]) for row in table(doc, "Corners of the pockets")[1:]}
    ear_height = note_number(doc, r"Ears ([\d.]+) high") / 2
    reach, start = note_number(doc, r": R([\d.]+) about"), note_number(doc, r"open below Z (-?[\d.]+)\.")
    block = cq.Workplane(obj=box((-wide, wide), (0.0, depth), (shelf_low, top))).edges("|Z").fillet(corner).val()
    body = block.fuse(  # type: ignore[union-attr]
        box((-post_x, post_x), (0.0, depth), (post, shelf_low)),
        box((-boss, boss), (0.0, depth), (0.0, post)),
        along_y(boss, 0.0, 0.0, (encoder, end)),
        box((-ears, ears), (encoder, ear_front), (-ear_height, ear_height)),
    )
    out = (floor, depth + _OUT)
    under = corners["under the stop shelf"]
    tools = [
        pocket((-inside, inside), out, (shelf_high, top + 2 * corner + _OUT), corners["box"]),
        pocket((-inner, inner), out, (stop_high, shelf_low), corners["over the stop shelf"]),
        pocket((-inner, inner), out, (low, stop_low), under),
        box((-boss - _OUT, boss + _OUT), (-_OUT, encoder), (-boss - _OUT, start)),
        along_y(reach, 0.0, 0.0, (-_OUT, encoder)),
        *_seats(*_bores_of(section), rear, fore, end),
        *bored(
            doc,
            {"Z": "Positions from A, along Z", "Y": "Positions from A and the drum axis, along Y"},
            {"shelf": (shelf_low, shelf_high), "top": (0.0, top)},
            {"front": depth, "pocket floor": floor, "encoder pocket": encoder},
            a,
        ),
    ]
    for tool in tools:
        body = body.cut(tool)
    return body


@dataclass(frozen=True)
class _Arm:
    """Sizes of a plate with its yoke, Y from the end of the boss."""

    wide: float
    top: float
    corner: float
    shelf_x: float
    shelf_low: float
    bridge: float
    back: float
    face: float

    def bodies(self, near: float, far: float) -> list[cq.Shape]:
        """Plate and yoke, the shelf between two depths from the plate's back."""
        plate = box((-self.wide, self.wide), (self.back, self.face), (0.0, self.top))
        across, y = (-self.shelf_x, self.shelf_x), self.back
        under = box(across, (y, y + far), (self.top - self.bridge, self.top))
        shelf = box(across, (y + near, y + far), (self.shelf_low, self.top))
        joined = cq.Workplane(obj=under.fuse(shelf).clean()).edges("|Y").edges("<Z or >Z")
        outer = cq.Workplane(obj=plate).edges("|Y and >Z")
        return [outer.fillet(self.corner).val(), joined.fillet(self.corner).val()]  # type: ignore[list-item]


def yoke(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """The frame of a siso spur drive, the end of its boss at y = 0."""
    return _armed(doc, dims, [])


def star(doc: Drawing, dims: list[ReadDimension]) -> cq.Shape:
    """The frame of a miso spur drive: views show the first arm, a table where the others stand."""
    rows = table(doc, "Arms")[1:]
    return _armed(doc, dims, [(float(angle), float(near), float(far)) for _, angle, near, far in rows])


def _armed(doc: Drawing, dims: list[ReadDimension], arms: list[tuple[float, float, float]]) -> cq.Shape:
    """``arms``: angle about the drum's axis and depths of the shelf; none for the one that the views show."""
    rear, section, front = ([d for d in dims if d.view == view] for view in ("rear", "section", "front"))
    (wide,) = (w / 2 for w in plain([d for d in rear if d.across], 1, "width"))
    boss, ears = _halves(rear, "rear", " boss", " ears")
    _, top = plain([d for d in rear if not d.across and d.kind == "linear"], 2, "heights from the drum's axis")
    corner = one(dims, "rear", "R").value
    (shelf_x,) = _halves(front, "front", " yoke")
    (shelf_low,) = plain([d for d in front if not d.across], 1, "the shelf's height")
    across = [d for d in section if d.across]
    near, far = plain([d for d in across if d.start[1] > 0.0], 2, "depths of the shelf")
    (bridge,) = plain([d for d in section if not d.across], 1, "height of the bridge")
    ear_front = one(section, "section", "", "across", suffix=" ears").value
    said = [d for d in across if d.start[1] < 0.0 and d.suffix == ""]
    # What a depth is of, the end of its extension line says: boss, seats within it, or the plate about it.
    of_boss = [d for d in said if abs(d.end[1] - d.start[1]) < _ON_PAPER_MM]
    others = [d for d in said if d not in of_boss]
    (end,) = plain(of_boss, 1, "end of the boss")
    level = max((d.end[1] for d in others), default=0.0)
    seats = [d for d in others if abs(d.end[1] - level) < _ON_PAPER_MM]
    rear_seat, fore_seat = plain(seats, 2, "seats")
    back, face = plain([d for d in others if d not in seats], 2, "plate")
    ear_height = note_number(doc, r"Ears ([\d.]+) high") / 2
    arm = _Arm(wide, top, corner, shelf_x, shelf_low, bridge, back, face)
    arms = arms or [(0.0, near, far)]
    if arms[0] != (0.0, near, far):
        raise MissingDimensionError(f"the first arm: {arms[0]} in its table, {near}, {far} in the section")
    body: cq.Shape = along_y(wide, 0.0, 0.0, (back, face))
    body = body.fuse(
        along_y(boss, 0.0, 0.0, (0.0, end)), box((-ears, ears), (0.0, ear_front), (-ear_height, ear_height))
    )
    for angle, start, stop in arms:
        turned = [part.rotate(cq.Vector(), cq.Vector(0, 1, 0), angle) for part in arm.bodies(start, stop)]
        body = body.fuse(*turned)
    shelves = [(back + start, back + stop + 0.01) for _, start, stop in arms]
    for tool in [
        *_seats(*_bores_of(section), rear_seat, fore_seat, end),
        *_yoke_holes(doc, (back - 0.01, face + 0.01), shelves, back),
    ]:
        body = body.cut(tool)
    return body


def _yoke_holes(doc: Drawing, plate: Span, shelves: list[Span], back: float) -> list[cq.Shape]:
    """All along Y; sunk from the near face, where they are sunk. Those of a shelf stand arm by arm."""
    places = {row[0]: (float(row[1]), float(row[2])) for row in table(doc, "Positions from the drum's axis")[1:]}
    tools: list[cq.Shape] = []
    for letter, count, drill, thread, depth, _, bore, start in table(doc, "Holes")[1:]:
        radius = float(thread[1:].split()[0]) / 2 if thread.startswith("M") else float(drill) / 2
        names = [letter] if count == "1" else [f"{letter}{n}" for n in range(1, int(count) + 1)]
        for n, name in enumerate(names):
            if depth != "through":
                near = {"behind": back, "boss": 0.0}[start]
                span = (near - 0.01, near + float(depth))
            else:
                span = plate if start == "plate" else shelves[n * len(shelves) // len(names)]
            x, z = places.pop(name)
            tools.append(along_y(radius, x, z, span))
            if bore != "-":
                found = re.fullmatch(r"Ø([\d.]+)(?: [A-Z]+\d+)? x ([\d.]+)", bore)
                if found is None:
                    raise MissingDimensionError(f"counterbore of {name}: {bore}")
                tools.append(along_y(float(found[1]) / 2, x, z, (span[0] - 0.01, span[0] + float(found[2]))))
    assert not places, f"positions of holes that the table does not list: {places}"
    return tools
