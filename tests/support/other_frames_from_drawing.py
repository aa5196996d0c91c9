"""Frames with a motor head from their drawings alone: a column (siso bevel), a yoke (siso spur), a star (miso spur).

X to the right and Z up from the drum's axis, Y from the face from which the sheet gives depths.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import MissingDimensionError, ReadDimension, note_number, table
from tests.support.frame_from_drawing import Span, along_y, bored, box, plain, pocket
from tests.support.head_from_drawing import exactly
from tests.support.milled_from_drawing import one

# Beyond the part, for tools that are open on one side.
_OUT = 2.0
# Points nearer than this on the paper are one.
_ON_PAPER_MM = 0.05


def _halves(dims: list[ReadDimension], view: str, *words: str) -> list[float]:
    """Half of each width that has such a word."""
    return [one(dims, view, "", "across", suffix=word).value / 2 for word in words]


def _bores(section: list[ReadDimension]) -> tuple[float, float]:
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
        *_seats(*_bores(section), rear, fore, end),
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
        *_seats(*_bores(section), rear_seat, fore_seat, end),
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
