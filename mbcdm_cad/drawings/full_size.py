"""A sheet drawn in millimetres of the paper, turned into one whose model space is the part's own size.

A shop takes contours from the model space and trusts its unit. The whole sheet, frame and texts included, is therefore
stretched until its views are 1:1; the layout ``SHEET`` shows it at the scale of the title block on the paper's size.
"""

from __future__ import annotations

from ezdxf.document import Drawing
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.math import Matrix44

from mbcdm_cad.drawings.document import DIMENSION_STYLE

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
