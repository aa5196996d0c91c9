"""Arrangement of a sheet: positions of views and dimensions, scale and paper size."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, inf

from mbcdm_cad.drawings import document
from mbcdm_cad.drawings.projection import Picture, box
from mbcdm_cad.parts.fits import limits
from mbcdm_cad.parts.sheet import CuttingLine, Linear, Radius, Sheet, View

# Space for an arrow from outside with its tail.
_OUTSIDE_MM = 2 * document.ARROW_MM
_APART_MM = 1.5
_LEVELS = 40


@dataclass(frozen=True)
class DimensionSpan:
    """A dimension along one side of a view, paper mm: its two ends and the length of its text."""

    low: float
    high: float
    text_mm: float

    @property
    def arrows_outside(self) -> bool:
        """Whether the arrows point inwards from outside, because the ends are too close for both."""
        return self.high - self.low < 2 * document.ARROW_MM + document.GAP_MM + 0.2

    @property
    def text_inside(self) -> bool:
        """Whether the text fits between the ends."""
        return self.high - self.low > self.text_mm + 1.0


@dataclass(frozen=True)
class Place:
    """Level from the view outwards (0 nearest) and the middle of the text along the side."""

    level: int
    text_at: float
    inside: bool


def _candidates(span: DimensionSpan, ends: list[float]) -> list[tuple[float, float, float]]:
    """(middle of the text, low end, high end) of the possible positions of a dimension, the best first."""
    out = _OUTSIDE_MM if span.arrows_outside else 0.0
    middle = (span.low + span.high) / 2
    if span.text_inside:
        return [(middle, span.low - out, span.high + out)]
    tail = out + document.GAP_MM + span.text_mm
    beyond = out + document.GAP_MM + span.text_mm / 2
    near = [
        (span.high + beyond, span.low - out, span.high + tail),
        (span.low - beyond, span.low - tail, span.high + out),
    ]
    # Outside the extension lines of all other dimensions.
    top, bottom = max([span.high + out, *ends]) + _APART_MM, min([span.low - out, *ends]) - _APART_MM
    far = [
        (top + span.text_mm / 2, span.low - out, top + span.text_mm),
        (bottom - span.text_mm / 2, bottom - span.text_mm, span.high + out),
    ]
    return near + far


def placed(spans: Sequence[DimensionSpan], within: tuple[float, float]) -> list[Place]:
    """A place for each span: shorter ones nearer to the view, without overlap, no text on an extension line.

    ``within``: the ends of the view on this side; texts stay between them if possible, clear of the adjacent sides.
    """
    order = sorted(range(len(spans)), key=lambda i: (spans[i].high - spans[i].low, spans[i].low, i))
    places: dict[int, Place] = {}
    taken: list[list[tuple[float, float]]] = [[] for _ in range(_LEVELS)]
    for i in order:
        span = spans[i]
        ends = [e for j, other in enumerate(spans) if j != i for e in (other.low, other.high)]
        lowest = 0
        for j, place in places.items():
            if min(span.high, spans[j].high) - max(span.low, spans[j].low) > 0.1:
                lowest = max(lowest, place.level + 1)
        places[i] = _first_free(span, ends, lowest, taken, within)
    return [places[i] for i in range(len(spans))]


def _first_free(
    span: DimensionSpan,
    ends: list[float],
    lowest: int,
    taken: list[list[tuple[float, float]]],
    within: tuple[float, float],
) -> Place:
    candidates = _candidates(span, ends)
    candidates.sort(key=lambda c: c[1] < within[0] - _OUTSIDE_MM or c[2] > within[1] + _OUTSIDE_MM)
    for strict in (True, False):
        for level in range(lowest, _LEVELS):
            for middle, low, high in candidates:
                if any(low < b - 0.05 and high > a + 0.05 for a, b in taken[level]):
                    continue
                half = span.text_mm / 2 + 0.4
                crossed = any(middle - half < e < middle + half for e in ends)
                if strict and crossed and not span.text_inside:
                    continue
                text = (min(low, middle - half), max(high, middle + half))
                taken[level].append((text[0], text[1] + (0.0 if span.text_inside else _APART_MM)))
                return Place(level, middle, span.text_inside)
    raise ValueError(f"{len(ends) // 2 + 1} dimensions on one side of a view: no place for all of them")


PAPERS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "A2": (594.0, 420.0), "A1": (841.0, 594.0)}
# Frame (ISO 5457): 20 mm at the left for filing, 10 mm elsewhere.
FRAME_LEFT_MM, FRAME_MM = 20.0, 10.0
TITLE_BLOCK = (170.0, 36.0)
# Scales of ISO 5455, largest first.
SCALES = (20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1)
_BETWEEN_MM = 7.0
_LABEL_ROOM_MM = 5.0
# Length of a radius's leader beyond the arc, without its text.
_RADIUS_LEADER_MM = 9.0
# Space for the letter at the end of a cutting line.
_CUTTING_END_MM = 8.0
Box = tuple[float, float, float, float]


def scale_text(scale: float) -> str:
    """A scale as it is written: 2:1, 1:2."""
    return f"{scale:g}:1" if scale >= 1.0 else f"1:{1.0 / scale:g}"


def dimension_text(d: Linear) -> str:
    """The whole text of a linear dimension: written out, because readers reckon what they measure in different ways."""
    fit = f" {d.fit}" if d.fit else ""
    limits = "" if d.deviations is None else f" {d.deviations[0]:+.3f}/{d.deviations[1]:+.3f}"
    return f"{d.prefix}{value_text(d.value, d.decimals)}{fit}{limits}{d.suffix}"


def value_text(value: float, decimals: int) -> str:
    """A value with up to ``decimals`` decimals, trailing zeros left out."""
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


@dataclass(frozen=True)
class PlacedDimension:
    """A linear dimension on paper: its ends, the coordinate of its line, and the position of its text."""

    dimension: Linear
    start: tuple[float, float]
    end: tuple[float, float]
    line_at: float
    place: Place
    text_mm: float


@dataclass(frozen=True)
class PlacedView:
    """A view on paper. A point (u, v) of the view lies at ``origin + scale * (u, v)``."""

    view: View
    origin: tuple[float, float]
    scale: float
    box: Box
    dimensions: tuple[PlacedDimension, ...]
    room_above: float  # space used above the box, title included

    def paper(self, u: float, v: float) -> tuple[float, float]:
        """Paper coordinates of a point of the view."""
        return self.origin[0] + self.scale * u, self.origin[1] + self.scale * v


@dataclass(frozen=True)
class Arrangement:
    """Paper size, scale, and the views with their dimensions."""

    paper: str
    scale: float
    views: tuple[PlacedView, ...]

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the paper."""
        return PAPERS[self.paper]


def view_box(picture: Picture, view: View) -> Box:
    """Box of the content of a view, mm on the part about the view's origin; for a detail its window."""
    if view.window is not None:
        centre, half_width, half_height = view.window
        u, v = view.project(centre)
        return u - half_width, v - half_height, u + half_width, v + half_height
    return box((*picture.visible, *picture.hidden))


def _with_axes(drawn: Box, view: View, scale: float, cutting: tuple[CuttingLine, ...]) -> Box:
    """The box of a view with its centre lines, which extend beyond its outline."""
    left, bottom, right, top = drawn
    over = document.AXIS_OVERHANG_MM / scale
    for start, end in view.axes:
        (a, b), (c, d) = view.project(start), view.project(end)
        length = hypot(c - a, d - b)
        if length > 0.0:
            dx, dy = over * abs(c - a) / length, over * abs(d - b) / length
            left, right = min(left, a - dx, c - dx), max(right, a + dx, c + dx)
            bottom, top = min(bottom, b - dy, d - dy), max(top, b + dy, d + dy)
    for centre, radius in view.circles:
        u, v = view.project(centre)
        left, right, bottom, top = (
            min(left, u - radius),
            max(right, u + radius),
            min(bottom, v - radius),
            max(top, v + radius),
        )
    for line in cutting:
        (a, b), (c, d) = view.project(line.start), view.project(line.end)
        reach = _CUTTING_END_MM / scale
        if abs(c - a) > abs(d - b):
            left, right = min(left, a - reach, c - reach), max(right, a + reach, c + reach)
        else:
            bottom, top = min(bottom, b - reach, d - reach), max(top, b + reach, d + reach)
    return left, bottom, right, top


@dataclass(frozen=True)
class _Margins:
    left: float
    below: float
    right: float
    above: float


def _packed(sheet: Sheet, view: View, around: Box, scale: float) -> tuple[list[PlacedDimension], _Margins]:
    """Dimensions of a view about its origin at ``scale`` (paper mm), and the space they use on its four sides."""
    shown: list[PlacedDimension] = []
    room = dict.fromkeys(("left", "below", "right", "above"), _LABEL_ROOM_MM)
    edge = {"left": around[0], "below": around[1], "right": around[2], "above": around[3]}
    for side in room:
        across = side in ("above", "below")
        kept = [d for d in sheet.dimensions if isinstance(d, Linear) and d.view == view.name and d.side == side]
        spans, ends = [], []
        for d in kept:
            a, b = view.project(d.start), view.project(d.end)
            pair = ((a[0] * scale, a[1] * scale), (b[0] * scale, b[1] * scale))
            ends.append(pair)
            along = sorted(p[0 if across else 1] for p in pair)
            drawn = (along[1] - along[0]) / scale
            if abs(drawn - d.value) > 1e-6:
                raise ValueError(
                    f"sheet {sheet.part}: dimension {dimension_text(d)} in view {d.view} is {d.value:.6g} mm, but its "
                    f"points are {drawn:.6g} mm apart there"
                )
            if d.fit:
                limits(d.value, d.fit)
            spans.append(DimensionSpan(along[0], along[1], document.text_width_mm(dimension_text(d))))
        first, last = ("left", "right") if across else ("below", "above")
        places = placed(spans, (edge[first] * scale, edge[last] * scale))
        sign = 1.0 if side in ("above", "right") else -1.0
        for d, pair, span, place in zip(kept, ends, spans, places, strict=True):
            line = edge[side] * scale + sign * (document.FIRST_LEVEL_MM + document.LEVEL_MM * place.level)
            shown.append(PlacedDimension(d, *pair, line, place, span.text_mm))
        if places:
            room[side] = (
                document.FIRST_LEVEL_MM + document.LEVEL_MM * max(p.level for p in places) + document.TEXT_MM + 2.5
            )
            # A text beside its dimension line can extend past the corner of the view.
            for span, place in zip(spans, places, strict=True):
                low, high = place.text_at - span.text_mm / 2, place.text_at + span.text_mm / 2
                room[first] = max(room[first], edge[first] * scale - low + 1.0)
                room[last] = max(room[last], high - edge[last] * scale + 1.0)
    for r in (d for d in sheet.dimensions if isinstance(d, Radius) and d.view == view.name):
        # The text of a radius is outside the arc, to the left or the right.
        at, centre = view.project(r.at)[0] * scale, view.project(r.centre)[0] * scale
        width = document.text_width_mm(f"{r.prefix}R{value_text(r.value, 2)}{r.suffix}") + _RADIUS_LEADER_MM
        if at < centre:
            room["left"] = max(room["left"], edge["left"] * scale - at + width)
        else:
            room["right"] = max(room["right"], at + width - edge["right"] * scale)
    margins = _Margins(**room)
    return shown, replace(margins, above=margins.above + document.LABEL_MM + 4.0) if view.title else margins


def arranged(sheet: Sheet, pictures: dict[str, Picture], table_mm: tuple[float, float], notes_mm: float) -> Arrangement:
    """The arrangement at the largest scale at which all views fit beside the tables and above the title block.

    ``table_mm``: width and height of all tables. The paper of the sheet is tried first, then larger ones. Raises
    ``ValueError`` if the views do not fit on A1.
    """
    papers = list(PAPERS)
    for paper in papers[papers.index(sheet.paper) :]:
        width, height = PAPERS[paper]
        left, right, top = FRAME_LEFT_MM + 2.0, width - FRAME_MM - 2.0, height - FRAME_MM - 2.0
        bottom = FRAME_MM + max(TITLE_BLOCK[1], notes_mm) + 2.0
        if table_mm[1] > top - bottom:
            continue
        # The views are placed beside the tables or below them, whichever allows the larger scale.
        beside = (left, bottom, right - (table_mm[0] + 4.0 if table_mm[0] else 0.0), top)
        below = (left, bottom, right, top - table_mm[1])
        for scale in SCALES:
            for free in (beside, below):
                views = _in_grid(sheet, pictures, scale, free)
                if views is not None:
                    return Arrangement(paper, scale, tuple(views))
    raise ValueError(f"sheet {sheet.part}: views and tables fit on no paper up to A1")


def _in_grid(sheet: Sheet, pictures: dict[str, Picture], scale: float, free: Box) -> list[PlacedView] | None:
    packed = {}
    widths: dict[int, list[float]] = {}
    heights: dict[int, list[float]] = {}
    for view in sheet.views:
        own = scale * view.magnify
        drawn = view_box(pictures[view.name], view)
        around = _with_axes(drawn, view, own, tuple(c for c in sheet.cutting_lines if c.view == view.name))
        shown, margins = _packed(sheet, view, around, own)
        # Details are centred in their cell and not aligned with other views.
        shift = (0.0, 0.0)
        if view.magnify != 1.0:
            shift = (own * (drawn[0] + drawn[2]) / 2, own * (drawn[1] + drawn[3]) / 2)
        packed[view.name] = (shown, around, own, shift, margins.above)
        column = widths.setdefault(view.column, [-inf, -inf])
        column[0] = max(column[0], shift[0] - own * around[0] + margins.left)
        column[1] = max(column[1], own * around[2] - shift[0] + margins.right)
        row = heights.setdefault(view.row, [-inf, -inf])
        row[0] = max(row[0], shift[1] - own * around[1] + margins.below)
        row[1] = max(row[1], own * around[3] - shift[1] + margins.above)
    wide = sum(map(sum, widths.values())) + _BETWEEN_MM * (len(widths) - 1)
    high = sum(map(sum, heights.values())) + _BETWEEN_MM * (len(heights) - 1)
    if wide > free[2] - free[0] or high > free[3] - free[1]:
        return None
    # The remaining space is divided equally between the columns and between the rows.
    gap_x = (free[2] - free[0] - wide) / (len(widths) + 1)
    gap_y = (free[3] - free[1] - high) / (len(heights) + 1)
    x_of: dict[int, float] = {}
    y_of: dict[int, float] = {}
    x, y = free[0] + gap_x, free[1] + gap_y
    for number in sorted(widths):
        x_of[number] = x + widths[number][0]
        x += sum(widths[number]) + _BETWEEN_MM + gap_x
    for number in sorted(heights):
        y_of[number] = y + heights[number][0]
        y += sum(heights[number]) + _BETWEEN_MM + gap_y
    views = []
    for view in sheet.views:
        shown, around, own, shift, above = packed[view.name]
        origin = (x_of[view.column] - shift[0], y_of[view.row] - shift[1])
        views.append(PlacedView(view, origin, own, around, tuple(shown), above))
    return views


def table_size_mm(columns: tuple[str, ...], rows: tuple[tuple[str, ...], ...]) -> tuple[list[float], float]:
    """Widths of the columns and height of a table, with its title and column heads."""
    widths = [
        max(document.text_width_mm(cell) for cell in (head, *(row[i] for row in rows))) + 2.4
        for i, head in enumerate(columns)
    ]
    return widths, document.ROW_MM * (len(rows) + 2)
