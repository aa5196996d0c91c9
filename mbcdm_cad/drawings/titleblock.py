"""Frame, title block, tables and notes of a sheet; in a view labels where they cover nothing, feature control frames
(ISO 1101), datums (ISO 5459)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import cos, hypot, radians, sin, tau

import numpy as np
from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.layouts.blocklayout import BlockLayout
from ezdxf.layouts.layout import Modelspace
from numpy.typing import NDArray

from mbcdm_cad.drawings.arrangement import (
    FRAME_LEFT_MM,
    FRAME_MM,
    TITLE_BLOCK,
    PlacedDimension,
    PlacedView,
    table_size_mm,
    value_text,
)
from mbcdm_cad.drawings.document import ARROW_MM, ROW_MM, TEXT_MM, TEXT_STYLE, TITLE_MM, text_width_mm
from mbcdm_cad.drawings.projection import Point, Stroke, points_of
from mbcdm_cad.parts.fits import Characteristic, Datum, GeometricTolerance, limits
from mbcdm_cad.parts.sheet import FitLine, Table, mm

# A printer holds the coarse class.
GENERAL_TOLERANCE, PRINTED_GENERAL_TOLERANCE = "ISO 2768-mK", "ISO 2768-cL"


@dataclass(frozen=True)
class TitleFields:
    """Content of the title block."""

    title: str
    part: str
    design: str
    material: str
    mass: str
    scale: str
    paper: str
    revision: str
    made_by: str
    general: str


def draw_border(doc: Drawing, width: float, height: float) -> None:
    """Frame of the sheet (ISO 5457)."""
    paper = doc.modelspace()
    left, low, right, top = FRAME_LEFT_MM, FRAME_MM, width - FRAME_MM, height - FRAME_MM
    frame = [(left, low), (right, low), (right, top), (left, top)]
    paper.add_lwpolyline(frame, close=True, dxfattribs={"layer": "BORDER"})


def draw_title_block(doc: Drawing, fields: TitleFields, width: float) -> None:
    """Title block at the lower right corner of the frame."""
    paper = doc.modelspace()
    w, h = TITLE_BLOCK
    left, low = width - FRAME_MM - w, FRAME_MM
    right, top = left + w, low + h
    outline = [(left, low), (right, low), (right, top), (left, top)]
    paper.add_lwpolyline(outline, close=True, dxfattribs={"layer": "BORDER", "lineweight": 50})
    row = h / 4
    first, second = left + 62.0, left + 116.0
    lines = [((x, low), (x, top)) for x in (first, second)]
    lines += [((first, low + k * row), (right, low + k * row)) for k in (1, 2, 3)]
    lines += [((left, low + row), (first, low + row)), ((left, low + 2 * row), (first, low + 2 * row))]
    lines += [((second + 27.0, low + k * row), (second + 27.0, low + (k + 1) * row)) for k in (0, 1, 2)]
    for a, b in lines:
        paper.add_line(a, b, dxfattribs={"layer": "TITLE"})

    def cell(x: float, k: int, head: str, text: str, height: float = TEXT_MM) -> None:
        _put(paper, head, (x + 1.2, low + (k + 1) * row - 2.4), 1.6)
        _put(paper, text, (x + 1.2, low + k * row + 1.6), height)

    _put(paper, "Title", (left + 1.2, top - 2.4), 1.6)
    room = first - left - 3.0
    size = min(TITLE_MM, TITLE_MM * room / text_width_mm(fields.title, TITLE_MM))
    _put(paper, fields.title, (left + 1.2, low + 2 * row + 5.0), size)
    cell(left, 1, "Part / drawing number", fields.part)
    cell(left, 0, "Design", fields.design)
    cell(first, 3, "Material", fields.material)
    cell(first, 2, "Mass", fields.mass)
    cell(first, 1, "General tolerances", fields.general)
    cell(first, 0, "Edges (ISO 13715)", "outside -0.1/-0.3  inside +0.1/+0.3", 2.0)
    cell(second, 3, "Made by", fields.made_by)
    cell(second, 2, "Scale", fields.scale, 3.5)
    cell(second + 27.0, 2, "Paper", fields.paper)
    cell(second, 1, "Dimensions", "mm")
    cell(second + 27.0, 1, "Revision", fields.revision)
    cell(second, 0, "Sheet", "1 / 1")
    _put(paper, "Projection", (second + 28.2, low + row - 2.4), 1.6)
    _projection_symbol(paper, second + 32.0, low + 3.4)


def _projection_symbol(paper: Modelspace, x: float, y: float) -> None:
    """Symbol of first angle projection (ISO 5456-2): side view of the cone, and to the right its view from the left."""
    attributes = {"layer": "TITLE"}
    small, large, length = 1.1, 2.2, 5.0
    corners = [(x, y - small), (x + length, y - large), (x + length, y + large), (x, y + small)]
    paper.add_lwpolyline(corners, close=True, dxfattribs=attributes)
    centre = (x + length + 5.0, y)
    for radius in (small, large):
        paper.add_circle(centre, radius, dxfattribs=attributes)
    thin = {"layer": "CENTRE", "linetype": "Continuous", "lineweight": 13}
    paper.add_line((x - 1.0, y), (centre[0] + large + 1.0, y), dxfattribs=thin)
    paper.add_line((centre[0], y - large - 1.0), (centre[0], y + large + 1.0), dxfattribs=thin)


def _put(paper: Modelspace | BlockLayout, text: str, at: tuple[float, float], height: float = TEXT_MM) -> None:
    entity = paper.add_text(text, height=height, dxfattribs={"layer": "TEXT", "style": TEXT_STYLE})
    entity.set_placement(at, align=TextEntityAlignment.LEFT)


def fits_table(fits: tuple[FitLine, ...]) -> Table | None:
    """Table of the limits of all toleranced sizes, each once."""
    if not fits:
        return None
    rows: dict[tuple[float, str], list[str]] = {}
    for fit in fits:
        uses = rows.setdefault((fit.nominal_mm, fit.code), [])
        if fit.what not in uses:
            uses.append(fit.what)
    lines = []
    for (nominal, code), uses in sorted(rows.items()):
        found = limits(nominal, code)
        lines.append(
            (
                f"{mm(nominal, 3)} {code}",
                f"{found.upper_mm * 1e3:+.4g}" if found.upper_mm else "0",
                f"{found.lower_mm * 1e3:+.4g}" if found.lower_mm else "0",
                f"{found.largest_mm:.4f}".rstrip("0") if found.upper_mm * 1e4 % 10 else f"{found.largest_mm:.3f}",
                f"{found.smallest_mm:.4f}".rstrip("0") if found.lower_mm * 1e4 % 10 else f"{found.smallest_mm:.3f}",
                ", ".join(uses),
            )
        )
    return Table("Fits (ISO 286, deviations in µm)", ("Size", "upper", "lower", "max", "min", "where"), tuple(lines))


def tables_size_mm(tables: tuple[Table, ...]) -> tuple[float, float]:
    """Width and height of all tables in one column."""
    width, height = 0.0, 0.0
    for table in tables:
        widths, tall = table_size_mm(table.columns, table.rows)
        width = max(width, sum(widths), text_width_mm(table.title) + 3.0)
        height += tall + 3.0
    return width, height


def draw_tables(doc: Drawing, tables: tuple[Table, ...], right: float, top: float) -> None:
    """Tables along the right edge; each is a block with its texts in rows and columns."""
    y = top
    for table in tables:
        widths, tall = table_size_mm(table.columns, table.rows)
        name = "TABLE_" + "".join(c if c.isascii() and c.isalnum() else "_" for c in table.title.upper())
        block = doc.blocks.new(name)
        _table(block, table, widths)
        across = max(sum(widths), text_width_mm(table.title) + 1.0)
        doc.modelspace().add_blockref(name, (right - across, y), dxfattribs={"layer": "TABLE"})
        y -= tall + 3.0


def _table(block: BlockLayout, table: Table, widths: list[float]) -> None:
    total = sum(widths)
    attributes = {"layer": "TABLE"}
    _put(block, table.title, (0.0, -ROW_MM + 1.2))
    lines = (table.columns, *(tuple(cell or "-" for cell in row) for row in table.rows))
    for n, line in enumerate(lines):
        y = -(n + 1) * ROW_MM
        block.add_line((0.0, y), (total, y), dxfattribs=attributes | ({"lineweight": 35} if n < 2 else {}))
        x = 0.0
        for cell, width in zip(line, widths, strict=True):
            _put(block, cell, (x + 1.2, y - ROW_MM + 0.9))
            x += width
    bottom = -(len(lines) + 1) * ROW_MM
    block.add_line((0.0, bottom), (total, bottom), dxfattribs=attributes | {"lineweight": 35})
    x = 0.0
    for width in (0.0, *widths):
        x += width
        block.add_line((x, -ROW_MM), (x, bottom), dxfattribs=attributes)


def wrapped(notes: tuple[str, ...], width_mm: float) -> list[str]:
    """Numbered notes, broken into lines of at most ``width_mm``."""
    lines: list[str] = []
    for n, note in enumerate(notes, 1):
        line = f"{n}."
        for word in note.split():
            if text_width_mm(f"{line} {word}") > width_mm:
                lines.append(line)
                line = "   " + word
            else:
                line += " " + word
        lines.append(line)
    return lines


def notes_height_mm(lines: list[str]) -> float:
    """Height of the notes with their heading."""
    return (len(lines) + 1) * 4.0 + 2.0 if lines else 0.0


def draw_notes(doc: Drawing, lines: list[str]) -> None:
    """Notes at the lower left, beside the title block."""
    if not lines:
        return
    paper = doc.modelspace()
    y = FRAME_MM + notes_height_mm(lines) - 4.5
    _put(paper, "Notes", (FRAME_LEFT_MM + 3.0, y))
    for line in lines:
        y -= 4.0
        _put(paper, line, (FRAME_LEFT_MM + 3.0, y))


_DIRECTIONS = (45, 135, 315, 225, 0, 90, 180, 270, 22, 67, 112, 157, 202, 247, 292, 337)
_AROUND_MM = 0.5
# The farthest place is some 70 mm away: a small part has many dimensions around it.
_STEPS = 60
Box = tuple[float, float, float, float]


class Room:
    """The space that is used on the paper, as segments and boxes; each placed text is added."""

    def __init__(self, within: Box) -> None:
        self._within = within
        self._segments: list[NDArray[np.float64]] = []
        self._together: NDArray[np.float64] | None = None
        self._boxes: list[Box] = []
        self._faces: list[list[NDArray[np.float64]]] = []

    def add_strokes(self, strokes: Iterable[Stroke], origin: Point, scale: float) -> None:
        """Add lines of a view, which texts must not cover."""
        for stroke in strokes:
            points = np.array(points_of(stroke)) * scale + np.array(origin)
            self.add_line(points)

    def add_line(self, points: NDArray[np.float64]) -> None:
        """Add a polyline on paper, (n, 2)."""
        self._segments.append(np.concatenate([points[:-1], points[1:]], axis=1))
        self._together = None

    def add_face(self, loops: Iterable[tuple[Point, ...]], origin: Point, scale: float) -> None:
        """Add a hatched face of a view."""
        self._faces.append([np.array(loop) * scale + np.array(origin) for loop in loops])

    def add_box(self, taken: Box) -> None:
        """Add a text or table on paper."""
        self._boxes.append(taken)

    def is_free(self, wanted: Box) -> bool:
        """Whether a box lies on the sheet and on nothing else."""
        left, bottom, right, top = wanted
        if left < self._within[0] or bottom < self._within[1] or right > self._within[2] or top > self._within[3]:
            return False
        if any(left < b[2] and right > b[0] and bottom < b[3] and top > b[1] for b in self._boxes):
            return False
        if any(_inside(((left + right) / 2, (bottom + top) / 2), loops) for loops in self._faces):
            return False
        if self._together is None:
            self._together = np.concatenate(self._segments) if self._segments else np.zeros((0, 4))
        return not crossed(self._together, wanted)

    def place(
        self,
        at: Point,
        width: float,
        height: float,
        clear: float,
        beside: bool = False,
        leader: Callable[[Point], Point] | None = None,
    ) -> Point:
        """Middle of a text near ``at``, at least ``clear`` away from it; its box is added to the used space.

        ``beside``: the whole text is to the left or to the right of ``at``. ``leader``: where the line to ``at`` begins
        for a middle; it crosses no other text, if there is such a place.
        """
        best: tuple[Point, Box] | None = None
        for step in range(_STEPS):
            for deg in _DIRECTIONS:
                away = clear + 0.6 + 1.2 * step
                dx, dy = cos(radians(deg)), sin(radians(deg))
                x = at[0] + dx * (away + width / 2)
                y = at[1] + dy * (away + height / 2)
                if beside and abs(x - at[0]) < width / 2:
                    continue
                wanted = (
                    x - width / 2 - _AROUND_MM,
                    y - height / 2 - _AROUND_MM,
                    x + width / 2 + _AROUND_MM,
                    y + height / 2 + _AROUND_MM,
                )
                if not self.is_free(wanted):
                    continue
                best = best or ((x, y), wanted)
                if leader is None or not any(
                    crossed(np.array([(*leader((x, y)), *at)]), taken) for taken in self._boxes
                ):
                    self.add_box(wanted)
                    return x, y
        if best is not None:
            self.add_box(best[1])
            return best[0]
        # No free place: a test of the sheet finds the overlap, the text is drawn anyway.
        return at[0] + clear + width, at[1] + clear + height


def crossed(segments: NDArray[np.float64], wanted: Box) -> bool:
    """Whether any segment (n, 4) meets the box (separating axes: x, y and the segment's normal)."""
    left, bottom, right, top = wanted
    ax, ay, bx, by = segments.T
    near = (np.maximum(ax, bx) >= left) & (np.minimum(ax, bx) <= right)
    near &= (np.maximum(ay, by) >= bottom) & (np.minimum(ay, by) <= top)
    if not near.any():
        return False
    ax, ay, bx, by = segments[near].T
    nx, ny = ay - by, bx - ax
    corners = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
    side = np.outer(nx, corners[:, 0]) + np.outer(ny, corners[:, 1]) - (nx * ax + ny * ay)[:, None]
    return bool(((side.min(axis=1) <= 0) & (side.max(axis=1) >= 0)).any())


def _inside(point: Point, loops: list[NDArray[np.float64]]) -> bool:
    """Whether a point lies in a face with holes, by an odd number of edges to its right."""
    odd = False
    for loop in loops:
        (ax, ay), (bx, by) = loop.T, np.roll(loop, -1, axis=0).T
        spans = (ay > point[1]) != (by > point[1])
        rise = np.where(spans, by - ay, 1.0)
        right = ax + (point[1] - ay) * (bx - ax) / rise > point[0]
        odd ^= bool(np.count_nonzero(spans & right) % 2)
    return odd


_HIGH_MM = 2 * TEXT_MM
_BESIDE_MM = 1.2
_TRIANGLE_MM = 2.5
_STEM_MM = 2.5
_FARTHEST_MM = 40.0
_THIN = {"layer": "DIMENSION"}


def _ring(radius: float) -> tuple[Point, ...]:
    """A circle about the middle of a square of 1."""
    return tuple((0.5 + radius * cos(a), 0.5 + radius * sin(a)) for a in np.linspace(0.0, tau, 33).tolist())


# Signs of ISO 1101 in a square of 1: polylines.
_SIGNS: dict[Characteristic, tuple[tuple[Point, ...], ...]] = {
    "run-out": (((0.2, 0.15), (0.8, 0.85)),),
    "perpendicularity": (((0.15, 0.2), (0.85, 0.2)), ((0.5, 0.2), (0.5, 0.85))),
    "parallelism": (((0.2, 0.15), (0.5, 0.85)), ((0.5, 0.15), (0.8, 0.85))),
    "coaxiality": (_ring(0.36), _ring(0.18)),
}


def draw_tolerance(paper: Modelspace, placed: PlacedView, tolerance: GeometricTolerance, room: Room) -> None:
    """The frame where it finds room, with an arrow to its feature; above it number and letter of several."""
    cells = [("%%c" if tolerance.axis else "") + value_text(tolerance.value_mm, 3), *tolerance.datums]
    widths = [_HIGH_MM, *(text_width_mm(text) + 2 * _BESIDE_MM for text in cells)]
    count = " ".join(filter(None, (f"{len(tolerance.places)}x" if tolerance.others else "", tolerance.of)))
    high = _HIGH_MM + (TEXT_MM + 1.0 if count else 0.0)
    tip = placed.paper(*placed.view.project(tolerance.at))
    wide = sum(widths)

    def from_side(middle: Point) -> Point:
        left, low = middle[0] - wide / 2, middle[1] - high / 2
        if left < tip[0] < left + wide:
            return tip[0], low if tip[1] < low else low + high
        return left if tip[0] < left else left + wide, low + _HIGH_MM / 2

    middle = room.place(tip, wide, high, 6.0, leader=from_side)
    left, low = middle[0] - wide / 2, middle[1] - high / 2
    _cells(paper, left, low, widths)
    for sign in _SIGNS[tolerance.characteristic]:
        points = [(left + _HIGH_MM * u, low + _HIGH_MM * v) for u, v in sign]
        paper.add_lwpolyline(points, dxfattribs=_THIN | {"lineweight": 35})
    if tolerance.characteristic == "run-out":
        _arrow_head(paper, (left + 0.2 * _HIGH_MM, low + 0.15 * _HIGH_MM), points[-1], 1.6)
    at = left + widths[0]
    for text, width in zip(cells, widths[1:], strict=True):
        _middle(paper, text, (at + width / 2, low + _HIGH_MM / 2))
        at += width
    if count:
        _middle(paper, count, (left + text_width_mm(count) / 2, low + _HIGH_MM + 0.7 + TEXT_MM / 2))
    start = from_side(middle)
    paper.add_line(start, tip, dxfattribs=_THIN)
    _arrow_head(paper, start, tip, ARROW_MM)
    room.add_line(np.array([start, tip]))


def draw_axis_datum(paper: Modelspace, placed: PlacedView, shown: PlacedDimension, room: Room) -> None:
    """The datum of a diameter's axis: its triangle continues the dimension line, beyond one of the ends."""
    across = shown.dimension.side in ("above", "below")
    k = 0 if across else 1
    line = shown.line_at + placed.origin[1 if across else 0]
    ends = sorted(p[k] + placed.origin[k] for p in (shown.start, shown.end))
    text_at = shown.place.text_at + placed.origin[k]
    steps = np.arange(2 * ARROW_MM, _FARTHEST_MM, 1.5)
    tried = [
        (end, sign, away)
        for away in steps
        for end, sign in ((ends[0], -1.0), (ends[1], 1.0))
        if shown.place.inside or (text_at - end) * sign < 0.0
    ]
    places = []
    for end, sign, away in tried:
        foot = end + sign * away
        middle = foot + sign * (_TRIANGLE_MM + _STEM_MM + _HIGH_MM / 2)
        at = (middle, line) if across else (line, middle)
        half = _HIGH_MM / 2 + 0.4
        places.append((end, foot, sign, at, (at[0] - half, at[1] - half, at[0] + half, at[1] + half)))
    # Where none is free the nearest is taken, as for a label: a sheet with an overlap is better than none.
    end, foot, sign, at, taken = next((place for place in places if room.is_free(place[-1])), places[0])
    base = (foot, line) if across else (line, foot)
    paper.add_line((end, line) if across else (line, end), base, dxfattribs=_THIN)
    _indicator(paper, base, (sign, 0.0) if across else (0.0, sign), at, shown.dimension.datum)
    room.add_box(taken)
    room.add_line(np.array([(end, line) if across else (line, end), at]))


def draw_face_datum(paper: Modelspace, placed: PlacedView, datum: Datum, room: Room) -> None:
    """The datum of a plane face: its triangle stands on the face, the letter where it finds room."""
    foot = placed.paper(*placed.view.project(datum.at))
    at = room.place(foot, _HIGH_MM, _HIGH_MM, _TRIANGLE_MM + _STEM_MM)
    length = hypot(at[0] - foot[0], at[1] - foot[1])
    _indicator(paper, foot, ((at[0] - foot[0]) / length, (at[1] - foot[1]) / length), at, datum.letter)
    room.add_line(np.array([foot, at]))


def _indicator(paper: Modelspace, base: Point, direction: Point, at: Point, letter: str) -> None:
    """A filled triangle on ``base``, a line along ``direction`` to a square about ``at`` with the letter."""
    (dx, dy), half = direction, _TRIANGLE_MM / 2
    tip = (base[0] + dx * _TRIANGLE_MM, base[1] + dy * _TRIANGLE_MM)
    corners = [(base[0] - dy * half, base[1] + dx * half), (base[0] + dy * half, base[1] - dx * half), tip, tip]
    paper.add_solid(corners, dxfattribs=_THIN)
    reach = _HIGH_MM / 2 / max(abs(dx), abs(dy))
    paper.add_line(tip, (at[0] - dx * reach, at[1] - dy * reach), dxfattribs=_THIN)
    _cells(paper, at[0] - _HIGH_MM / 2, at[1] - _HIGH_MM / 2, [_HIGH_MM])
    _middle(paper, letter, at)


def _cells(paper: Modelspace, left: float, low: float, widths: list[float]) -> None:
    right, top = left + sum(widths), low + _HIGH_MM
    outline = [(left, low), (right, low), (right, top), (left, top)]
    paper.add_lwpolyline(outline, close=True, dxfattribs=_THIN)
    for width in np.cumsum(widths[:-1]):
        paper.add_line((left + width, low), (left + width, top), dxfattribs=_THIN)


def _arrow_head(paper: Modelspace, tail: Point, tip: Point, length: float) -> None:
    along = np.array(tip) - np.array(tail)
    along = along / np.hypot(*along)
    across = np.array([-along[1], along[0]])
    back = np.array(tip) - along * length
    sides = (tuple(back + across * length / 6), tuple(back - across * length / 6))
    paper.add_solid([tip, *sides, sides[1]], dxfattribs=_THIN)


def _middle(paper: Modelspace, text: str, at: Point) -> None:
    entity = paper.add_text(text, height=TEXT_MM, dxfattribs={"layer": "TEXT", "style": TEXT_STYLE})
    entity.set_placement(at, align=TextEntityAlignment.MIDDLE_CENTER)
