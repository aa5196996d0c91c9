"""The DXF document, the same bytes for the same content: style, layers, line types, and its texts by place.

The font is DejaVu Sans from matplotlib, so that the text is the same on every machine.
"""

import io
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from math import cos, radians, sin
from pathlib import Path
from typing import Any

import matplotlib
from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.filemanagement import new
from ezdxf.fonts import fonts
from ezdxf.lldxf.const import DXFError

FONT_FILE = "DejaVuSans.ttf"
TEXT_MM = 2.5
LABEL_MM = 3.5
TITLE_MM = 5.0
ARROW_MM = 2.5
GAP_MM = 0.8
EXTENSION_BEYOND_MM = 1.25
EXTENSION_OFFSET_MM = 0.8
FIRST_LEVEL_MM = 9.0
LEVEL_MM = 6.5
AXIS_OVERHANG_MM = 3.0
ROW_MM = 4.2

# Layer: line type, line weight in 1/100 mm.
LAYERS = {
    "BORDER": ("Continuous", 70),
    "TITLE": ("Continuous", 25),
    "TABLE": ("Continuous", 18),
    "VISIBLE": ("Continuous", 50),
    "HIDDEN": ("HIDDEN", 25),
    "CENTRE": ("CENTER", 18),
    "CUTTING": ("CENTER", 50),
    "HATCH": ("Continuous", 13),
    "DIMENSION": ("Continuous", 18),
    "TEXT": ("Continuous", 18),
    "VIEWPORTS": ("Continuous", 0),
}
# Dash lengths in mm on paper (ISO 128-2 in proportion to the line width).
LINE_TYPES = {
    "HIDDEN": ("hidden __ __", [3.75, 2.5, -1.25]),
    "CENTER": ("centre ____ _ ____", [9.5, 6.0, -1.25, 1.0, -1.25]),
}


@cache
def _font(height_mm: float) -> Any:
    use_own_font()
    return fonts.make_font(FONT_FILE, cap_height=height_mm)


@cache
def use_own_font() -> None:
    """Make the DXF library use only this font, whatever fonts the machine has."""
    fonts.font_manager.clear()
    fonts.font_manager.build([str(Path(matplotlib.get_data_path()) / "fonts" / "ttf")], support_dirs=False)


def plain(text: str) -> str:
    """The text with DXF's codes for diameter, degree and plus-minus replaced by their signs."""
    for code, sign in (("%%c", "Ø"), ("%%d", "°"), ("%%p", "±")):
        text = text.replace(code, sign)
    return text


def text_width_mm(text: str, height_mm: float = TEXT_MM) -> float:
    """Width of one line of text on paper."""
    return float(_font(height_mm).text_width(plain(text)))


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
    for name in sorted({entity.dxftype() for entity in doc.entitydb.values()} | {"SUN", "ACDBPLACEHOLDER", "LAYOUT"}):
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


# Height of a capital letter over the size of the font that the outlines are from, DejaVu Sans.
_CAP_HEIGHT = 0.729
_FIRST, _LAST = 32, 255
_CODES = "cp1252"
_TEXT_HEIGHT_MM = 10.0


@dataclass(frozen=True)
class PlacedText:
    """One line: its left end on the base line in mm of the paper, height of a capital in mm, direction in degrees."""

    text: str
    at: tuple[float, float]
    height_mm: float
    direction_deg: float


def texts_of(doc: Drawing) -> list[PlacedText]:
    """All texts of the model space, of its blocks and dimensions, in the order of the file."""
    found: list[PlacedText] = []
    for entity in doc.modelspace():
        kind = entity.dxftype()
        if kind == "TEXT":
            found.append(_of_text(entity, (0.0, 0.0)))
        elif kind == "INSERT":
            x, y, _ = entity.dxf.insert
            found += [_of_text(text, (x, y)) for text in doc.blocks.get(entity.dxf.name).query("TEXT")]
        elif kind == "DIMENSION":
            block = doc.blocks.get(entity.dxf.geometry)
            found += [_of_mtext(text) for text in block.query("MTEXT")]
    return found


def _of_text(text: Any, offset: tuple[float, float]) -> PlacedText:
    said, height = plain(text.dxf.text), text.dxf.height
    if text.dxf.halign == 0:
        x, y, _ = text.dxf.insert
        return PlacedText(said, (x + offset[0], y + offset[1]), height, text.dxf.rotation)
    x, y, _ = text.dxf.align_point
    return _centred(said, (x + offset[0], y + offset[1]), height, text.dxf.rotation)


def _of_mtext(text: Any) -> PlacedText:
    x, y, _ = text.dxf.insert
    return _centred(plain(text.plain_text()), (x, y), text.dxf.char_height, text.get_rotation())


def _centred(said: str, middle: tuple[float, float], height: float, direction_deg: float) -> PlacedText:
    c, s = cos(radians(direction_deg)), sin(radians(direction_deg))
    half, down = text_width_mm(said, height) / 2, height / 2
    at = (middle[0] - c * half + s * down, middle[1] - s * half - c * down)
    return PlacedText(said, at, height, direction_deg)


@cache
def _width_mm(letter: str) -> float:
    """Advance of a letter between two others, at a height of 10 mm."""
    return text_width_mm(f"x{letter}x", _TEXT_HEIGHT_MM) - text_width_mm("xx", _TEXT_HEIGHT_MM)


def font_object() -> bytes:
    """The PDF's font: one that every reader has, with the widths of the outlines' letters."""
    em = _TEXT_HEIGHT_MM / _CAP_HEIGHT
    letters = (bytes([code]).decode(_CODES, "replace") for code in range(_FIRST, _LAST + 1))
    widths = " ".join(f"{_width_mm(letter) / em * 1000.0:.0f}" for letter in letters)
    return (
        "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding "
        f"/FirstChar {_FIRST} /LastChar {_LAST} /Widths [{widths}] >>"
    ).encode()


def text_operators(texts: Iterable[PlacedText], font: str) -> Iterator[bytes]:
    """The PDF's operators that set the texts without drawing them."""
    yield b"BT 3 Tr"
    for text in texts:
        c, s = cos(radians(text.direction_deg)), sin(radians(text.direction_deg))
        said = text.text.encode(_CODES, "replace")
        for code in (b"\\", b"(", b")"):
            said = said.replace(code, b"\\" + code)
        place = " ".join(f"{value:.3f}" for value in (c, s, -s, c, *text.at))
        yield f"/{font} {text.height_mm / _CAP_HEIGHT:.3f} Tf {place} Tm (".encode() + said + b") Tj"
    yield b"ET"
