"""Style of drawings: sizes on paper (mm), layers, and the font that measures and draws all text.

The font is DejaVu Sans from matplotlib, so that the text is the same on every machine.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
from ezdxf.fonts import fonts

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
