"""The DXF document: layers, line types, styles; the same bytes for the same content."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.filemanagement import new
from ezdxf.lldxf.const import DXFError

from mbcdm_cad.drawings.style import (
    ARROW_MM,
    EXTENSION_BEYOND_MM,
    EXTENSION_OFFSET_MM,
    FONT_FILE,
    GAP_MM,
    LAYERS,
    LINE_TYPES,
    TEXT_MM,
    use_own_font,
)

DIMENSION_STYLE = "MBCDM"
TEXT_STYLE = "MBCDM"
# Application name of the extended data, which contain the view of a dimension.
APPLICATION = "MBCDM_CAD"
_MILLIMETRES = 4


@contextmanager
def fixed_meta_data() -> Iterator[None]:
    """Documents made and written in this context contain no times and no random identifiers."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def new_document() -> Drawing:
    """An empty drawing in millimetres whose dimensions state what they measure."""
    use_own_font()
    doc = new("R2010")
    doc.header["$INSUNITS"] = _MILLIMETRES
    doc.header["$MEASUREMENT"] = 1
    doc.header["$LTSCALE"] = 1.0
    doc.appids.add(APPLICATION)
    for name, (description, pattern) in LINE_TYPES.items():
        doc.linetypes.add(name, pattern, description=description)
    for name, (line_type, weight) in LAYERS.items():
        doc.layers.add(name, linetype=line_type, lineweight=weight)
    doc.styles.add(TEXT_STYLE, font=FONT_FILE)
    style = doc.dimstyles.new(DIMENSION_STYLE)
    attributes = {
        "dimtxsty": TEXT_STYLE,
        "dimtxt": TEXT_MM,
        "dimasz": ARROW_MM,
        "dimgap": GAP_MM,
        "dimexe": EXTENSION_BEYOND_MM,
        "dimexo": EXTENSION_OFFSET_MM,
        "dimtad": 1,
        "dimtih": 0,
        "dimtoh": 0,
        "dimtofl": 1,
        "dimzin": 8,
        "dimdec": 2,
        "dimadec": 2,
        "dimazin": 2,
        "dimdsep": ord("."),
        "dimlfac": 1.0,
        "dimscale": 1.0,
        "dimblk": "",
        "dimlwd": 18,
        "dimlwe": 18,
    }
    for name, value in attributes.items():
        style.set_dxf_attrib(name, value)
    # Some programs read the variables of the header instead of the style.
    style.copy_to_header(doc)
    return doc


def document_bytes(doc: Drawing) -> bytes:
    """The DXF file, audited. Raises ``ValueError`` if the document has errors."""
    for name in sorted(_required_classes(doc)):
        doc.classes.add_class(name)
    problems = doc.audit()
    if problems.errors or problems.fixes:
        raise ValueError(f"DXF: {[e.message for e in (*problems.errors, *problems.fixes)][:5]}")
    stream = io.StringIO()
    try:
        doc.write(stream)
    except DXFError as error:
        raise ValueError(f"DXF: {error}") from error
    return re.sub(r"\r?\n", "\r\n", stream.getvalue()).encode(doc.output_encoding, errors="dxfreplace")


def _required_classes(doc: Drawing) -> set[str]:
    return {entity.dxftype() for entity in doc.entitydb.values()} | {"SUN", "ACDBPLACEHOLDER", "LAYOUT"}
