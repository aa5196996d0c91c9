"""Reads drawings back as a machinist does: printed dimensions, tables and the outline's shape, never the parameters."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import ezdxf
from ezdxf.document import Drawing

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
