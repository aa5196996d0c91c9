"""Solid of a motor head, or of a top plate with boxes, from its drawing alone.

Z from the lower face, the origin on the axis of hole A.
"""

from __future__ import annotations

import re

import cadquery as cq
from ezdxf.document import Drawing

from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, ReadDimension, note_number, table
from tests.support.milled_from_drawing import cylinder, one

_OPEN = 300.0


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
