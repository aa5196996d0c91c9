"""The texts of a drawing with their places on paper, for the invisible layer of a PDF that readers search and copy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from math import cos, radians, sin
from typing import Any

from ezdxf.document import Drawing

from mbcdm_cad.drawings.style import plain, text_width_mm

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
