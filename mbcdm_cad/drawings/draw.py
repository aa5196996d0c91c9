"""One sheet as DXF, SVG and PDF, the last two from the paths that the DXF library's front end draws.

Text is drawn as outlines, so that a sheet looks the same on every machine; a PDF has it as an invisible layer too.
Paths are in millimetres on paper.
"""

import hashlib
import random
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import cadquery as cq
from ezdxf.addons.drawing.backend import BackendInterface
from ezdxf.addons.drawing.config import BackgroundPolicy, ColorPolicy, Configuration, LinePolicy
from ezdxf.addons.drawing.frontend import Frontend
from ezdxf.addons.drawing.properties import RenderContext
from ezdxf.document import Drawing
from ezdxf.entities.dxfgfx import DXFGraphic
from ezdxf.math import Matrix44
from ezdxf.path import Command

from mbcdm_cad.drawings import document
from mbcdm_cad.drawings.arrangement import (
    FRAME_LEFT_MM,
    FRAME_MM,
    PAPERS,
    TITLE_BLOCK,
    Arrangement,
    arranged,
    scale_text,
)
from mbcdm_cad.drawings.drafting import draw_views
from mbcdm_cad.drawings.projection import picture
from mbcdm_cad.drawings.titleblock import (
    GENERAL_TOLERANCE,
    PRINTED_GENERAL_TOLERANCE,
    Room,
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
from mbcdm_cad.parts.sheet import POSITION, Sheet

_POINTS_PER_MM = 72.0 / 25.4
_LIGHTEST_MM = 0.09
_FONT = "F1"

Curve = tuple[str, tuple[float, ...]]


@dataclass
class DrawnPath:
    """A path to stroke (``weight_mm`` > 0) or fill, as moves (M), lines (L) and cubic curves (C)."""

    weight_mm: float
    curves: list[Curve] = field(default_factory=list)


class Shapes(BackendInterface):
    """Collects the paths that the front end draws."""

    def __init__(self) -> None:
        self.shapes: list[DrawnPath] = []

    def _stroke(self, properties: Any, curves: list[Curve]) -> None:
        weight = max(properties.lineweight, _LIGHTEST_MM)
        if self.shapes and self.shapes[-1].weight_mm == weight:
            self.shapes[-1].curves += curves
        else:
            self.shapes.append(DrawnPath(weight, curves))

    def draw_point(self, pos: Any, properties: Any) -> None:
        """Not drawn: points are the definition points of dimensions."""

    def draw_line(self, start: Any, end: Any, properties: Any) -> None:
        self._stroke(properties, [("M", (start.x, start.y)), ("L", (end.x, end.y))])

    def draw_solid_lines(self, lines: Iterable[tuple[Any, Any]], properties: Any) -> None:
        for start, end in lines:
            self.draw_line(start, end, properties)

    def draw_path(self, path: Any, properties: Any) -> None:
        self._stroke(properties, _curves(path))

    def draw_filled_paths(self, paths: Iterable[Any], properties: Any) -> None:
        curves = [curve for path in paths if len(path) for curve in (*_curves(path), ("Z", ()))]
        if curves:
            self.shapes.append(DrawnPath(0.0, curves))

    def draw_filled_polygon(self, points: Any, properties: Any) -> None:
        corners = [(p.x, p.y) for p in points.vertices()]
        if corners:
            self.shapes.append(DrawnPath(0.0, [("M", corners[0]), *(("L", p) for p in corners[1:]), ("Z", ())]))

    def draw_image(self, image_data: Any, properties: Any) -> None:
        raise NotImplementedError("drawings contain no images")

    def configure(self, config: Any) -> None:
        """Nothing to configure."""

    def enter_entity(self, entity: Any, properties: Any) -> None:
        """Entities are not distinguished."""

    def exit_entity(self, entity: Any) -> None:
        """Entities are not distinguished."""

    def set_background(self, color: Any) -> None:
        """Ignored: the background is the paper."""

    def clear(self) -> None:
        self.shapes.clear()

    def finalize(self) -> None:
        """Nothing to do."""


def _curves(path: Any) -> list[Curve]:
    curves: list[Curve] = [("M", (path.start.x, path.start.y))]
    current = path.start
    for command in path.commands():
        end = command.end
        if command.type == Command.MOVE_TO:
            curves.append(("M", (end.x, end.y)))
        elif command.type == Command.LINE_TO:
            curves.append(("L", (end.x, end.y)))
        elif command.type == Command.CURVE3_TO:
            one, two = current.lerp(command.ctrl, 2 / 3), end.lerp(command.ctrl, 2 / 3)
            curves.append(("C", (one.x, one.y, two.x, two.y, end.x, end.y)))
        else:
            a, b = command.ctrl1, command.ctrl2
            curves.append(("C", (a.x, a.y, b.x, b.y, end.x, end.y)))
        current = end
    return curves


def shapes_of(doc: Drawing) -> list[DrawnPath]:
    """All paths of the drawing, in the order in which they are drawn."""
    backend = Shapes()
    config = Configuration(
        background_policy=BackgroundPolicy.WHITE,
        color_policy=ColorPolicy.BLACK,
        line_policy=LinePolicy.ACCURATE,
        min_lineweight=_LIGHTEST_MM / 25.4 * 300,
    )
    # The library shifts hatch lines by random numbers; a fixed seed gives the same file each time.
    state = random.getstate()
    random.seed(0)
    try:
        Frontend(RenderContext(doc), backend, config=config).draw_layout(doc.modelspace())
    finally:
        random.setstate(state)
    return backend.shapes


def _number(value: float) -> str:
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def svg_bytes(shapes: list[DrawnPath], width_mm: float, height_mm: float) -> bytes:
    """The sheet as SVG in its true size."""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width_mm:g}mm" height="{height_mm:g}mm" '
        f'viewBox="0 0 {width_mm:g} {height_mm:g}">',
        f'<rect width="{width_mm:g}" height="{height_mm:g}" fill="white"/>',
        f'<g transform="matrix(1 0 0 -1 0 {height_mm:g})" stroke="black" fill="none" stroke-linecap="round" '
        'stroke-linejoin="round">',
    ]
    for shape in shapes:
        data = "".join(kind + " ".join(_number(v) for v in values) for kind, values in shape.curves)
        how = f'stroke-width="{_number(shape.weight_mm)}"' if shape.weight_mm else 'stroke="none" fill="black"'
        rule = "" if shape.weight_mm else ' fill-rule="evenodd"'
        lines.append(f'<path d="{data}" {how}{rule}/>')
    return ("\n".join(lines) + "\n</g>\n</svg>\n").encode()


def pdf_bytes(
    shapes: list[DrawnPath], texts: list[document.PlacedText], width_mm: float, height_mm: float, title: str
) -> bytes:
    """The sheet as a PDF of one page in its true size, without times; ``texts`` are its invisible layer."""
    operators = {"M": "m", "L": "l", "C": "c", "Z": "h"}
    lines = [f"{_POINTS_PER_MM:.9f} 0 0 {_POINTS_PER_MM:.9f} 0 0 cm", "1 J 1 j 0 G 0 g"]
    for shape in shapes:
        if shape.weight_mm:
            lines.append(f"{_number(shape.weight_mm)} w")
        for kind, values in shape.curves:
            lines.append(" ".join([*(_number(v) for v in values), operators[kind]]))
        lines.append("S" if shape.weight_mm else "f*")
    content = zlib.compress(b"\n".join(["\n".join(lines).encode(), *document.text_operators(texts, _FONT)]), 9)
    box = f"[0 0 {width_mm * _POINTS_PER_MM:.3f} {height_mm * _POINTS_PER_MM:.3f}]"
    name = title.encode("ascii", "replace").decode().replace("\\", "").replace("(", "").replace(")", "")
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R "
        f"/Resources << /Font << /{_FONT} 6 0 R >> >> >>".encode(),
        f"<< /Length {len(content)} /Filter /FlateDecode >>\nstream\n".encode() + content + b"\nendstream",
        f"<< /Title ({name}) /Producer (mbcdm_cad) >>".encode(),
        document.font_object(),
    ]
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, text in enumerate(objects, 1):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + text + b"\nendobj\n"
    start = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    out += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    out += f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 5 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    return bytes(out)


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
    limits, places = fits_table(sheet.fits), f"{facts.position_mm:g}"
    tables = tuple(
        replace(table, rows=tuple(tuple(places if cell == POSITION else cell for cell in row) for row in table.rows))
        for table in sheet.tables
    ) + ((limits,) if limits else ())
    size = tables_size_mm(tables)
    paper_width = PAPERS[sheet.paper][0]
    beside = paper_width - FRAME_LEFT_MM - FRAME_MM - TITLE_BLOCK[0] - _NOTES_LEFT_OVER_MM
    lines = wrapped(sheet.notes, beside)
    arrangement = arranged(sheet, pictures, size, notes_height_mm(lines))
    with document.fixed_meta_data():
        doc = document.new_document()
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
        shapes, texts = shapes_of(doc), document.texts_of(doc)
        to_full_size(doc, arrangement.scale, arrangement.size_mm)
        dxf = document.document_bytes(doc)
    return {
        "dxf": dxf,
        "svg": svg_bytes(shapes, width, height),
        "pdf": pdf_bytes(shapes, texts, width, height, f"{facts.design} {sheet.part}"),
    }


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
    style = doc.dimstyles.get(document.DIMENSION_STYLE)
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
