"""Draw an arranged sheet: views, hatches, centre lines, dimensions, labels, cutting lines."""

from math import atan2, cos, degrees, hypot, radians, sin

import numpy as np
from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.layouts.blocklayout import BlockLayout
from ezdxf.layouts.layout import Modelspace

from mbcdm_cad.drawings import document
from mbcdm_cad.drawings.arrangement import (
    Arrangement,
    PlacedDimension,
    PlacedView,
    dimension_text,
    scale_text,
    value_text,
)
from mbcdm_cad.drawings.projection import ArcStroke, LineStroke, Picture, Point, PolyStroke, Stroke, clipped
from mbcdm_cad.drawings.titleblock import Box, Room, draw_axis_datum, draw_face_datum, draw_tolerance
from mbcdm_cad.parts.sheet import Angle, CuttingLine, Label, Radius, Sheet

_HATCH_APART = 0.8
_VIEW_LAYERS = ("VISIBLE", "HIDDEN")
# Angles to here are between two lines; greater ones are by three points, which some readers leave out.
_MOST_BY_LINES_DEG = 175.0


def draw_views(doc: Drawing, sheet: Sheet, arrangement: Arrangement, pictures: dict[str, Picture], room: Room) -> None:
    """Draw all views with their dimensions and labels; the space that they use is added to ``room``."""
    paper = doc.modelspace()
    for placed in arrangement.views:
        picture = pictures[placed.view.name]
        if placed.view.window is not None:
            picture = clipped(picture, placed.view)
        _picture(doc, placed, picture)
        room.add_strokes((*picture.visible, *picture.hidden), placed.origin, placed.scale)
        for loops in picture.faces:
            room.add_face(loops, placed.origin, placed.scale)
        _centre_lines(paper, placed, room)
        _title(paper, placed, arrangement, room)
        for dimension in placed.dimensions:
            _linear(paper, placed, dimension, room)
    for cutting in sheet.cutting_lines:
        _cutting_line(paper, _of(arrangement, cutting.view), cutting, room)
    for other in sheet.dimensions:
        if isinstance(other, Radius):
            _radius(paper, _of(arrangement, other.view), other, room)
        elif isinstance(other, Angle):
            _angle(paper, _of(arrangement, other.view), other, room)
    for placed in arrangement.views:
        for dimension in placed.dimensions:
            if dimension.dimension.datum:
                draw_axis_datum(paper, placed, dimension, room)
    for datum in sheet.datums:
        draw_face_datum(paper, _of(arrangement, datum.view), datum, room)
    for tolerance in sheet.tolerances:
        draw_tolerance(paper, _of(arrangement, tolerance.view), tolerance, room)
    for label in sheet.labels:
        _label(paper, _of(arrangement, label.view), label, room)


def _of(arrangement: Arrangement, name: str) -> PlacedView:
    return next(p for p in arrangement.views if p.view.name == name)


def _picture(doc: Drawing, placed: PlacedView, picture: Picture) -> None:
    """Lines and hatches of a view as one block, which can be moved as a whole."""
    name = "VIEW_" + placed.view.name.upper().replace(" ", "_").replace("-", "_")
    block = doc.blocks.new(name)
    for layer, strokes in zip(_VIEW_LAYERS, (picture.visible, picture.hidden), strict=True):
        for stroke in strokes:
            _stroke(block, stroke, placed.scale, layer)
    for loops, body in zip(picture.faces, picture.bodies, strict=True):
        hatch = block.add_hatch(dxfattribs={"layer": "HATCH"})
        # Bodies beside each other differ: the other way, or further apart.
        apart = _HATCH_APART * (1.0, 1.6, 0.6)[body // 2 % 3]
        hatch.set_pattern_fill("ANSI31", scale=apart, angle=90.0 * (body % 2))
        for n, loop in enumerate(loops):
            points = [(u * placed.scale, v * placed.scale) for u, v in loop]
            hatch.paths.add_polyline_path(points, is_closed=True, flags=1 if n == 0 else 16)
    doc.modelspace().add_blockref(name, placed.origin, dxfattribs={"layer": "VISIBLE"})


def _stroke(block: BlockLayout, stroke: Stroke, scale: float, layer: str) -> None:
    attributes = {"layer": layer}
    if isinstance(stroke, LineStroke):
        block.add_line(_scaled(stroke.start, scale), _scaled(stroke.end, scale), dxfattribs=attributes)
    elif isinstance(stroke, PolyStroke):
        block.add_lwpolyline([_scaled(p, scale) for p in stroke.points], dxfattribs=attributes)
    elif stroke.end_deg - stroke.start_deg > 359.99:
        block.add_circle(_scaled(stroke.centre, scale), stroke.radius * scale, dxfattribs=attributes)
    else:
        block.add_arc(
            _scaled(stroke.centre, scale),
            stroke.radius * scale,
            stroke.start_deg,
            stroke.end_deg,
            dxfattribs=attributes,
        )


def _scaled(p: Point, scale: float) -> Point:
    return p[0] * scale, p[1] * scale


def _centre_lines(paper: Modelspace, placed: PlacedView, room: Room) -> None:
    for start, end in placed.view.axes:
        a, b = np.array(placed.paper(*placed.view.project(start))), np.array(placed.paper(*placed.view.project(end)))
        length = float(np.hypot(*(b - a)))
        if length < 1e-6:
            continue
        over = (b - a) / length * document.AXIS_OVERHANG_MM
        paper.add_line(tuple(a - over), tuple(b + over), dxfattribs={"layer": "CENTRE"})
        room.add_line(np.array([a - over, b + over]))
    for centre, radius in placed.view.circles:
        u, v = placed.view.project(centre)
        at, reach = placed.paper(u, v), radius * placed.scale
        paper.add_circle(at, reach, dxfattribs={"layer": "CENTRE"})
        room.add_strokes([ArcStroke(at, reach, 0.0, 360.0)], (0.0, 0.0), 1.0)


def _text(paper: Modelspace, text: str, middle: Point, height: float = document.TEXT_MM, rotation: float = 0.0) -> None:
    entity = paper.add_text(
        text, height=height, rotation=rotation, dxfattribs={"layer": "TEXT", "style": document.TEXT_STYLE}
    )
    entity.set_placement(middle, align=TextEntityAlignment.MIDDLE_CENTER)


def _box(middle: Point, width: float, height: float) -> Box:
    return middle[0] - width / 2, middle[1] - height / 2, middle[0] + width / 2, middle[1] + height / 2


def _title(paper: Modelspace, placed: PlacedView, arrangement: Arrangement, room: Room) -> None:
    if not placed.view.title:
        return
    text = placed.view.title
    if placed.view.magnify != 1.0:
        text += f" ({scale_text(placed.scale)})"
    middle = (
        placed.origin[0] + placed.scale * (placed.box[0] + placed.box[2]) / 2,
        placed.origin[1] + placed.scale * placed.box[3] + placed.room_above - document.LABEL_MM / 2 - 1.0,
    )
    _text(paper, text, middle, document.LABEL_MM)
    room.add_box(_box(middle, document.text_width_mm(text, document.LABEL_MM) + 1.0, document.LABEL_MM + 1.0))


def _measures(placed: PlacedView) -> dict[str, float]:
    """What a detail's dimensions are multiplied by, for readers that measure instead of reading the text."""
    return {} if placed.view.magnify == 1.0 else {"dimlfac": 1.0 / placed.view.magnify}


def _linear(paper: Modelspace, placed: PlacedView, shown: PlacedDimension, room: Room) -> None:
    d, (ox, oy) = shown.dimension, placed.origin
    across = d.side in ("above", "below")
    start, end = (shown.start[0] + ox, shown.start[1] + oy), (shown.end[0] + ox, shown.end[1] + oy)
    line = shown.line_at + (oy if across else ox)
    text_at = shown.place.text_at + (ox if across else oy)
    # The text is above its line in the direction of reading: to the left of a vertical line.
    lift = document.GAP_MM + document.TEXT_MM / 2
    middle = (text_at, line + lift) if across else (line - lift, text_at)
    first, last = _level(paper, start, end, line, across)
    made = paper.add_linear_dim(
        base=(ox, line) if across else (line, oy),
        p1=first,
        p2=last,
        angle=0.0 if across else 90.0,
        text=dimension_text(d),
        dimstyle=document.DIMENSION_STYLE,
        override=_measures(placed),
        dxfattribs={"layer": "DIMENSION"},
    )
    made.set_location(middle)
    made.render()
    features = [(1040, value / placed.scale) for value in (*shown.start, *shown.end)]
    made.dimension.set_xdata(document.APPLICATION, [*features, (1000, d.view)])
    block = made.dimension.get_geometry_block()
    assert block is not None
    low, high = sorted((start[0 if across else 1], end[0 if across else 1]))
    ends = [low, high]
    if not shown.place.inside:
        # The dimension line continues under its text.
        near, far = (high, text_at + shown.text_mm / 2) if text_at > high else (low, text_at - shown.text_mm / 2)
        ends_at = ((near, line), (far, line)) if across else ((line, near), (line, far))
        block.add_line(*ends_at, dxfattribs={"layer": "DIMENSION"})
        ends += [far]
    size = (shown.text_mm, document.TEXT_MM) if across else (document.TEXT_MM, shown.text_mm)
    room.add_box(_box(middle, size[0] + 0.6, size[1] + 0.6))
    out = 2 * document.ARROW_MM
    low, high = min(ends) - out, max(ends) + out
    room.add_line(np.array([(low, line), (high, line)] if across else [(line, low), (line, high)]))
    for point in (start, end):
        foot = (point[0], line) if across else (line, point[1])
        room.add_line(np.array([point, foot]))


def _level(paper: Modelspace, start: Point, end: Point, line: float, across: bool) -> tuple[Point, Point]:
    """The points that a dimension measures, both at the distance of the nearer one from its line.

    Some readers take the distance of the two points for the size, whatever its direction. The extension line of the
    farther point begins at the feature all the same.
    """
    k = 1 if across else 0
    level = min(start[k], end[k], key=lambda value: abs(line - value))
    away = 1.0 if line > level else -1.0
    found: list[Point] = []
    for point in (start, end):
        at = (point[0], level) if across else (level, point[1])
        if abs(point[k] - level) > document.EXTENSION_OFFSET_MM:
            begins, ends = point[k] + away * document.EXTENSION_OFFSET_MM, level + away * document.EXTENSION_OFFSET_MM
            pair = ((point[0], begins), (point[0], ends)) if across else ((begins, point[1]), (ends, point[1]))
            paper.add_line(*pair, dxfattribs={"layer": "DIMENSION"})
        found.append(at)
    return found[0], found[1]


def _radius(paper: Modelspace, placed: PlacedView, d: Radius, room: Room) -> None:
    centre, at = placed.paper(*placed.view.project(d.centre)), placed.paper(*placed.view.project(d.at))
    drawn = hypot(at[0] - centre[0], at[1] - centre[1]) / placed.scale
    if abs(drawn - d.value) > 1e-6:
        raise ValueError(f"radius {d.value:.6g} mm in view {d.view}: its points are {drawn:.6g} mm apart")
    text = f"{d.prefix}R{value_text(d.value, 2)}{d.suffix}"
    # The leader ends in a horizontal leg as long as an arrow; after it the library sets the text, slightly wider.
    width = document.text_width_mm(text) + 2 * document.ARROW_MM
    x, y = room.place(at, width, document.TEXT_MM, 3.0, beside=True)
    leg = (x + (width / 2 if x < at[0] else -width / 2), y)
    made = paper.add_radius_dim(
        center=centre,
        mpoint=at,
        text=text,
        dimstyle=document.DIMENSION_STYLE,
        override=_measures(placed) | {"dimtoh": 1, "dimtih": 1, "dimtad": 0, "dimtmove": 1},
        dxfattribs={"layer": "DIMENSION"},
    )
    # Set only now: if the text's position is known earlier, the library turns the arrow towards it.
    made.user_location_override(leg)
    room.add_line(np.array([at, leg]))
    made.render()
    made.dimension.set_xdata(document.APPLICATION, [(1000, d.view)])


def _angle(paper: Modelspace, placed: PlacedView, d: Angle, room: Room) -> None:
    vertex, start, end = (placed.paper(*placed.view.project(p)) for p in (d.vertex, d.start, d.end))
    first = degrees(atan2(start[1] - vertex[1], start[0] - vertex[0]))
    last = degrees(atan2(end[1] - vertex[1], end[0] - vertex[0]))
    drawn = (last - first) % 360.0
    if abs(drawn - d.value) > 1e-6:
        raise ValueError(f"angle {d.value:.6g} deg in view {d.view}: its points are {drawn:.6g} deg apart")
    reach = d.reach * placed.scale
    middle = radians(first + drawn / 2)
    base = (vertex[0] + reach * cos(middle), vertex[1] + reach * sin(middle))
    text, style, layer = f"{value_text(d.value, 2)}%%d{d.suffix}", document.DIMENSION_STYLE, {"layer": "DIMENSION"}
    if d.value < _MOST_BY_LINES_DEG:
        made = paper.add_angular_dim_2l(
            base, (vertex, end), (vertex, start), text=text, dimstyle=style, dxfattribs=layer
        )
    else:
        made = paper.add_angular_dim_3p(base, vertex, start, end, text=text, dimstyle=style, dxfattribs=layer)
    made.render()
    made.dimension.set_xdata(document.APPLICATION, [(1000, d.view)])
    width = document.text_width_mm(f"{d.value:.2f}°{d.suffix}")
    at = (vertex[0] + (reach + 2.0) * cos(middle), vertex[1] + (reach + 2.0) * sin(middle))
    room.add_box(_box(at, width, width))
    room.add_strokes([ArcStroke(vertex, reach, first % 360.0, first % 360.0 + drawn)], (0.0, 0.0), 1.0)


def _label(paper: Modelspace, placed: PlacedView, label: Label, room: Room) -> None:
    at = placed.paper(*placed.view.project(label.at))
    width = document.text_width_mm(label.text)
    clear = label.clear_mm * placed.scale + (3.0 if label.leader else 0.0)

    def from_edge(middle: Point) -> Point:
        edge = min(max(at[0], middle[0] - width / 2 - 0.5), middle[0] + width / 2 + 0.5)
        return edge, min(max(at[1], middle[1] - document.TEXT_MM / 2 - 0.5), middle[1] + document.TEXT_MM / 2 + 0.5)

    middle = room.place(at, width, document.TEXT_MM, clear, leader=from_edge if label.leader else None)
    _text(paper, label.text, middle)
    if label.leader:
        start = from_edge(middle)
        paper.add_line(at, start, dxfattribs={"layer": "DIMENSION"})
        room.add_line(np.array([at, start]))
        dot = paper.add_hatch(color=256, dxfattribs={"layer": "DIMENSION"})
        dot.paths.add_edge_path().add_arc(at, 0.35, 0.0, 360.0)


def _cutting_line(paper: Modelspace, placed: PlacedView, cutting: CuttingLine, room: Room) -> None:
    a, b = (np.array(placed.paper(*placed.view.project(p))) for p in (cutting.start, cutting.end))
    along = (b - a) / np.hypot(*(b - a))
    looks = np.array(placed.view.project(cutting.looks))
    paper.add_line(tuple(a), tuple(b), dxfattribs={"layer": "CENTRE"})
    room.add_line(np.array([a, b]))
    for end, out in ((a, -along), (b, along)):
        corner = end + out * 6.0
        paper.add_line(tuple(end + out * 1.0), tuple(corner), dxfattribs={"layer": "CUTTING", "linetype": "Continuous"})
        tip = corner - out * 1.5 - looks * 1.0
        tail = corner - out * 1.5 - looks * 8.0
        _arrow(paper, tail, tip)
        room.add_line(np.array([end, corner]))
        room.add_line(np.array([tail, tip]))
        places: list[Point] = [
            tuple(tail + out * 3.2 + looks * on) for on in (2.0, 1.0, 0.0, -1.0, -2.0, -3.0, 3.0, 4.0)
        ]
        size = document.LABEL_MM + 0.4
        middle = next((place for place in places if room.is_free(_box(place, size, size))), places[0])
        _text(paper, cutting.letter, middle, document.LABEL_MM)
        room.add_box(_box(middle, document.LABEL_MM + 1.0, document.LABEL_MM + 1.0))


def _arrow(paper: Modelspace, tail: np.ndarray, tip: np.ndarray) -> None:
    direction = (tip - tail) / np.hypot(*(tip - tail))
    across = np.array([-direction[1], direction[0]])
    paper.add_line(tuple(tail), tuple(tip), dxfattribs={"layer": "DIMENSION"})
    back = tip - direction * document.ARROW_MM
    paper.add_solid(
        [tuple(tip), tuple(back + across * 0.7), tuple(back - across * 0.7), tuple(back - across * 0.7)],
        dxfattribs={"layer": "DIMENSION"},
    )
