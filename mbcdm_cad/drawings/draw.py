"""One sheet as DXF, SVG and PDF."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import Any

import cadquery as cq
from ezdxf.document import Drawing
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.math import Matrix44

from mbcdm_cad.drawings.arrangement import (
    FRAME_LEFT_MM,
    FRAME_MM,
    PAPERS,
    TITLE_BLOCK,
    Arrangement,
    arranged,
    scale_text,
)
from mbcdm_cad.drawings.document import DIMENSION_STYLE, document_bytes, fixed_meta_data, new_document
from mbcdm_cad.drawings.drafting import draw_views
from mbcdm_cad.drawings.labels import Room
from mbcdm_cad.drawings.projection import picture
from mbcdm_cad.drawings.rendering import pdf_bytes, shapes_of, svg_bytes
from mbcdm_cad.drawings.texts import texts_of
from mbcdm_cad.drawings.titleblock import (
    GENERAL_TOLERANCE,
    PRINTED_GENERAL_TOLERANCE,
    TitleFields,
    draw_border,
    draw_notes,
    draw_tables,
    draw_title_block,
    fits_table,
    notes_height_mm,
    tables_size_mm,
    wrapped,
)
from mbcdm_cad.parts.sheet import POSITION, Sheet, Table

_NOTES_LEFT_OVER_MM = 8.0


@dataclass(frozen=True)
class PartFacts:
    """Values of a part for its drawing. ``position_mm``: tolerance of the position of a hole with a fit (+-)."""

    design: str
    material: str
    mass_g: float
    version: str
    position_mm: float
    printed: bool = False


def draw_sheet(sheet: Sheet, solid: Any, facts: PartFacts, whole: cq.Shape | None = None) -> dict[str, bytes]:
    """The sheet's files by extension: ``dxf``, ``svg``, ``pdf``. Sections do not cut the bodies of ``whole``.

    Raises ``ValueError`` with the part's name if a dimension does not agree with its points, or if no paper is large
    enough.
    """
    shape = cq.Shape.cast(getattr(solid, "wrapped", solid))
    pictures = {view.name: picture(shape, view, whole) for view in sheet.views}
    limits = fits_table(sheet.fits)
    tables = (*(_with_positions(table, facts) for table in sheet.tables), *((limits,) if limits else ()))
    size = tables_size_mm(tables)
    paper_width = PAPERS[sheet.paper][0]
    beside = paper_width - FRAME_LEFT_MM - FRAME_MM - TITLE_BLOCK[0] - _NOTES_LEFT_OVER_MM
    lines = wrapped(sheet.notes, beside)
    arrangement = arranged(sheet, pictures, size, notes_height_mm(lines))
    with fixed_meta_data():
        doc = new_document()
        width, height = arrangement.size_mm
        draw_border(doc, width, height)
        draw_title_block(doc, _fields(sheet, facts, arrangement), width)
        draw_notes(doc, lines)
        right, top = width - FRAME_MM - 2.0, height - FRAME_MM - 2.0
        draw_tables(doc, tables, right, top)
        room = Room((FRAME_LEFT_MM + 1.0, FRAME_MM + 1.0, width - FRAME_MM - 1.0, height - FRAME_MM - 1.0))
        room.add_box((width - FRAME_MM - TITLE_BLOCK[0], FRAME_MM, width - FRAME_MM, FRAME_MM + TITLE_BLOCK[1]))
        room.add_box((FRAME_LEFT_MM, FRAME_MM, FRAME_LEFT_MM + beside, FRAME_MM + notes_height_mm(lines)))
        if tables:
            room.add_box((right - size[0], top - size[1], right, top))
        draw_views(doc, sheet, arrangement, pictures, room)
        shapes, texts = shapes_of(doc), texts_of(doc)
        to_full_size(doc, arrangement.scale, arrangement.size_mm)
        dxf = document_bytes(doc)
    return {
        "dxf": dxf,
        "svg": svg_bytes(shapes, width, height),
        "pdf": pdf_bytes(shapes, texts, width, height, f"{facts.design} {sheet.part}"),
    }


def _with_positions(table: Table, facts: PartFacts) -> Table:
    places = f"{facts.position_mm:g}"
    rows = tuple(tuple(places if cell == POSITION else cell for cell in row) for row in table.rows)
    return replace(table, rows=rows)


def _fields(sheet: Sheet, facts: PartFacts, arrangement: Arrangement) -> TitleFields:
    revision = hashlib.sha256(repr((sheet, facts)).encode()).hexdigest()[:8]
    mass = f"{facts.mass_g:.3g} g" if facts.mass_g < 100.0 else f"{facts.mass_g:.1f} g"
    return TitleFields(
        title=sheet.title,
        part=sheet.part,
        design=facts.design,
        material=facts.material,
        mass=mass,
        scale=scale_text(arrangement.scale),
        paper=arrangement.paper,
        revision=revision,
        made_by=f"mbcdm_cad {facts.version}",
        general=PRINTED_GENERAL_TOLERANCE if facts.printed else GENERAL_TOLERANCE,
    )


LAYOUT = "SHEET"


def to_full_size(doc: Drawing, scale: float, paper_mm: tuple[float, float]) -> None:
    """Stretch the model space of ``doc`` by 1 / ``scale`` and add the layout; ``paper_mm``: width and height."""
    factor = 1.0 / scale
    stretch = Matrix44.scale(factor, factor, factor)
    for block in doc.blocks:
        if block.name.startswith(("VIEW_", "TABLE_")):
            _stretch(list(block), stretch)
    _stretch(list(doc.modelspace()), stretch)
    doc.header["$LTSCALE"] = factor
    doc.header["$PSLTSCALE"] = 0
    style = doc.dimstyles.get(DIMENSION_STYLE)
    style.set_dxf_attrib("dimscale", factor)
    style.copy_to_header(doc)
    width, height = paper_mm
    middle = (width * factor / 2, height * factor / 2)
    doc.set_modelspace_vport(height * factor, middle)
    doc.layouts.rename("Layout1", LAYOUT)
    layout = doc.paperspace(LAYOUT)
    layout.page_setup(size=paper_mm, margins=(0.0, 0.0, 0.0, 0.0), units="mm")
    layout.add_viewport(
        center=(width / 2, height / 2),
        size=paper_mm,
        view_center_point=middle,
        view_height=height * factor,
        dxfattribs={"layer": "VIEWPORTS"},
    )


def _stretch(entities: list[DXFGraphic], stretch: Matrix44) -> None:
    for entity in entities:
        if entity.dxftype() == "INSERT":
            # What the block contains is stretched already.
            entity.dxf.insert = stretch.transform(entity.dxf.insert)
        else:
            entity.transform(stretch)
