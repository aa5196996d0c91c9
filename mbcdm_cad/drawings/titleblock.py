"""Frame, title block, projection symbol, tables and notes of a sheet."""

from __future__ import annotations

from dataclasses import dataclass

from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.layouts.blocklayout import BlockLayout
from ezdxf.layouts.layout import Modelspace

from mbcdm_cad.drawings.arrangement import FRAME_LEFT_MM, FRAME_MM, TITLE_BLOCK, table_size_mm
from mbcdm_cad.drawings.document import ROW_MM, TEXT_MM, TEXT_STYLE, TITLE_MM, text_width_mm
from mbcdm_cad.parts.fits import limits
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
