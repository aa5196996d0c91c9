"""Read drawings as a machinist does: printed dimensions, tables and the shape of the outline, never the parameters."""

import io
import re
from dataclasses import dataclass
from itertools import combinations

import ezdxf
import numpy as np
from ezdxf.document import Drawing

from mbcdm_cad.drawings.document import text_width_mm
from mbcdm_cad.drawings.titleblock import crossed

_TEXT = re.compile(r"(?:(\d+)x )?(Ø|M|AF |R)?(\d+(?:\.\d+)?)(.*)")


class MissingDimensionError(Exception):
    """The sheet does not say a size that is needed."""


class DoubledDimensionError(Exception):
    """The sheet says a size twice."""


@dataclass(frozen=True)
class ReadDimension:
    """One dimension as printed; ``start`` and ``end`` are where its extension lines begin, about the view's origin."""

    view: str
    handle: str
    count: int
    prefix: str
    value: float
    suffix: str
    across: bool
    start: tuple[float, float]
    end: tuple[float, float]
    kind: str


@dataclass(frozen=True)
class ReadView:
    """Straight visible lines of a view, about its origin on the part's scale of the drawing (paper mm)."""

    lines: tuple[tuple[tuple[float, float], tuple[float, float]], ...]


def document(data: bytes) -> Drawing:
    return ezdxf.read(io.StringIO(data.decode("utf-8").replace("\r\n", "\n")))


def _plain(text: str) -> str:
    for code, sign in (("%%c", "Ø"), ("%%d", "°"), ("%%p", "±")):
        text = text.replace(code, sign)
    return text


def dimensions(doc: Drawing) -> list[ReadDimension]:
    """All linear dimensions and radii, from the text that stands in each one's own picture."""
    found = []
    origins = {i.dxf.name: i.dxf.insert for i in doc.modelspace().query("INSERT")}
    for entity in doc.modelspace().query("DIMENSION"):
        view = entity.get_xdata("MBCDM_CAD")[-1].value
        name = "VIEW_" + view.upper().replace(" ", "_").replace("-", "_")
        ox, oy, _ = origins[name]
        text = next(t.plain_text() for t in doc.blocks.get(entity.dxf.geometry).query("MTEXT"))
        match = _TEXT.fullmatch(_plain(text))
        if match is None:
            continue
        linear = entity.dimtype == 0
        points = (entity.dxf.defpoint2, entity.dxf.defpoint3) if linear else (entity.dxf.defpoint, entity.dxf.defpoint4)
        (ax, ay), (bx, by) = ((p.x - ox, p.y - oy) for p in points)
        if linear:
            # Where the extension lines begin: the dimension's own points are both at the level of the nearer one.
            ax, ay, bx, by = (tag.value for tag in entity.get_xdata("MBCDM_CAD") if tag.code == 1040)
        found.append(
            ReadDimension(
                view,
                entity.dxf.handle,
                int(match[1] or 1),
                (match[2] or "").strip(),
                float(match[3]),
                match[4],
                linear and abs(entity.dxf.get("angle", 0.0)) < 1.0,
                (ax, ay),
                (bx, by),
                "linear" if linear else "radius",
            )
        )
    return found


def table(doc: Drawing, title_start: str) -> list[list[str]]:
    """Rows of the table whose title begins so, its heads first."""
    for block in doc.blocks:
        if not block.name.startswith("TABLE_"):
            continue
        texts = [(t.dxf.insert.y, t.dxf.insert.x, _plain(t.dxf.text)) for t in block.query("TEXT")]
        title = max(texts)[2]
        if not title.startswith(title_start):
            continue
        rows: dict[float, list[tuple[float, str]]] = {}
        for y, x, text in texts:
            if text != title:
                rows.setdefault(round(y, 3), []).append((x, text))
        return [[text for _, text in sorted(rows[y])] for y in sorted(rows, reverse=True)]
    raise MissingDimensionError(f"no table {title_start!r}")


def view(doc: Drawing, name: str) -> ReadView:
    block = doc.blocks.get("VIEW_" + name.upper().replace(" ", "_").replace("-", "_"))
    lines = [
        ((e.dxf.start.x, e.dxf.start.y), (e.dxf.end.x, e.dxf.end.y))
        for e in block.query("LINE")
        if e.dxf.layer == "VISIBLE"
    ]
    return ReadView(tuple(lines))


def text_boxes(doc: Drawing) -> list[tuple[str, tuple[float, float, float, float]]]:
    """Every text on the paper with its box: labels, titles, and what stands at dimensions."""
    boxes = []
    for text in doc.modelspace().query("TEXT"):
        width = text_width_mm(text.dxf.text, text.dxf.height)
        x, y, _ = text.dxf.align_point if text.dxf.hasattr("align_point") else text.dxf.insert
        left, low = (x, y) if text.dxf.halign == 0 else (x - width / 2, y - text.dxf.height / 2)
        boxes.append((text.dxf.text, (left, low, left + width, low + text.dxf.height)))
    for dimension in doc.modelspace().query("DIMENSION"):
        for text in doc.blocks.get(dimension.dxf.geometry).query("MTEXT"):
            height = text.dxf.char_height
            width = text_width_mm(text.plain_text(), height)
            turned = abs(text.get_rotation() % 180.0 - 90.0) < 45.0
            half = (height / 2, width / 2) if turned else (width / 2, height / 2)
            x, y, _ = text.dxf.insert
            boxes.append((text.plain_text(), (x - half[0], y - half[1], x + half[0], y + half[1])))
    return boxes


def texts_on_texts(doc: Drawing) -> list[tuple[str, str]]:
    return [
        (one, other)
        for (one, a), (other, b) in combinations(text_boxes(doc), 2)
        if a[0] < b[2] - 0.1 and b[0] < a[2] - 0.1 and a[1] < b[3] - 0.1 and b[1] < a[3] - 0.1
    ]


def texts_on_lines(doc: Drawing) -> list[str]:
    """Texts that a dimension line, an extension line or a leader meets, in the model space 0.1 mm within their box."""
    paper = doc.modelspace()
    lines = [line for line in paper.query("LINE") if line.dxf.layer == "DIMENSION"]
    lines += [line for d in paper.query("DIMENSION") for line in doc.blocks.get(d.dxf.geometry).query("LINE")]
    segments = np.array([(*line.dxf.start.vec2, *line.dxf.end.vec2) for line in lines]).reshape(-1, 4)
    return [
        text
        for text, (left, low, right, top) in text_boxes(doc)
        if crossed(segments, (left + 0.1, low + 0.1, right - 0.1, top - 0.1))
    ]


def texts_outside(doc: Drawing) -> list[str]:
    frame = next(p for p in doc.modelspace().query("LWPOLYLINE") if p.dxf.layer == "BORDER")
    xs, ys = zip(*((p[0], p[1]) for p in frame.get_points()), strict=True)
    return [
        text
        for text, (left, low, right, top) in text_boxes(doc)
        if left < min(xs) or right > max(xs) or low < min(ys) or top > max(ys)
    ]


def note_number(doc: Drawing, pattern: str) -> float:
    """The number that the notes say where ``pattern`` fits; it stands there once."""
    texts = (_plain(text.dxf.text) for text in doc.modelspace().query("TEXT"))
    found = [match[1] for text in texts for match in re.finditer(pattern, text)]
    if len(found) != 1:
        raise (DoubledDimensionError if found else MissingDimensionError)(f"{pattern}: {found}")
    return float(found[0])


def leader_ends(doc: Drawing) -> list[tuple[float, float]]:
    """Where leaders end on what they name: their dots."""
    ends = []
    for hatch in doc.modelspace().query("HATCH"):
        for path in hatch.paths.paths:
            ends += [(edge.center.x, edge.center.y) for edge in getattr(path, "edges", []) if hasattr(edge, "radius")]
    return ends


def leaders_at_one_point(doc: Drawing, apart_mm: float) -> list[tuple[float, float]]:
    """Ends of leaders that are nearer than ``apart_mm`` (in the model space) to the end of another."""
    pairs = combinations(leader_ends(doc), 2)
    return [a for a, b in pairs if (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 < apart_mm**2]


def sections_without_line(doc: Drawing) -> list[str]:
    """Sections titled A-A whose cutting line has not its two letters in another view."""
    texts = [text.dxf.text for text in doc.modelspace().query("TEXT")]
    titles = [match[1] for text in texts if (match := re.match(r"([A-Z])-\1(?: |$)", text))]
    return [letter for letter in titles if texts.count(letter) < 2]


def texts_over_their_cells(doc: Drawing) -> list[str]:
    """Texts of the title block that cross one of its upright lines."""
    walls = [
        (line.dxf.start.x, *sorted((line.dxf.start.y, line.dxf.end.y)))
        for line in doc.modelspace().query("LINE")
        if line.dxf.layer == "TITLE" and abs(line.dxf.start.x - line.dxf.end.x) < 1e-6
    ]
    return [
        text
        for text, (left, low, right, top) in text_boxes(doc)
        if any(left < x < right and a < top and low < b for x, a, b in walls)
    ]
