"""One sheet in several programs: the model space is the part's own size, and every reader shows the same numbers."""

import io
import os
import re
import shutil
import subprocess
import zlib
from collections import Counter
from itertools import combinations
from math import dist
from pathlib import Path

import cadquery as cq
import ezdxf
import numpy as np
import pytest
from ezdxf import bbox
from ezdxf.document import Drawing

from mbcdm_cad.drawings.document import plain
from mbcdm_cad.drawings.draw import LAYOUT, PartFacts, draw_sheet
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.sheet import Linear, Vector
from mbcdm_cad.workshop.assembly_sheet import SeenBody, assembly_sheet, numbers, pointers
from tests.acceptance.freecad import freecad_program, run_in_freecad
from tests.support import drawing_reader
from tests.support.reference import ROOT

_FREECAD = """
import FreeCAD, json, os
settings = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Draft")
settings.SetBool("dxfUseLegacyImporter", False)
settings.SetBool("dxftext", True)
import Import
document = FreeCAD.newDocument("d")
Import.readDXF(os.environ["CHECKED_FILE"], "d")
found = [round(o.Distance.Value, 4) for o in document.Objects if hasattr(o, "Distance")]
print(chr(10) + json.dumps({"lengths_mm": found}))
"""


@pytest.fixture(scope="module")
def sheet() -> tuple[cq.Solid, dict[str, bytes]]:
    """The drum: views at 2:1, a detail at 4:1, diameters, lengths, a radius, an angle."""
    part = layout_of(load_design(ROOT / "params" / "mbcdm.yaml").drive).bill().made["drum"]
    solid = part.in_views().solid()
    return solid, draw_sheet(part.sheet("drum"), solid, PartFacts("mbcdm", "metal", 1.0, "0", 0.02))


@pytest.fixture(scope="module")
def doc(sheet: tuple[cq.Solid, dict[str, bytes]]) -> Drawing:
    return drawing_reader.document(sheet[1]["dxf"])


def _number(text: str) -> float:
    found = re.search(r"\d+\.?\d*", re.sub(r"^\d+x ", "", text))
    assert found, text
    return float(found[0])


def test_the_model_space_is_the_parts_size_in_the_files_unit(
    sheet: tuple[cq.Solid, dict[str, bytes]], doc: Drawing
) -> None:
    assert doc.header["$INSUNITS"] == 4
    size = bbox.extents(doc.blocks.get("VIEW_REAR")).size
    box = sheet[0].BoundingBox()
    assert (size.x, size.y) == pytest.approx((box.xlen, box.zlen), abs=1e-3)
    inserts = doc.modelspace().query("INSERT")
    assert {(i.dxf.xscale, i.dxf.yscale) for i in inserts} == {(1.0, 1.0)}


def test_the_layout_shows_the_sheet_on_its_paper_at_the_scale_of_the_title_block(doc: Drawing) -> None:
    layout = doc.paperspace(LAYOUT)
    shown = [v for v in layout.query("VIEWPORT") if v.dxf.id != 1]
    assert len(shown) == 1
    assert (layout.dxf.paper_width, layout.dxf.paper_height) == (594.0, 420.0)
    said = {t.dxf.text for t in doc.modelspace().query("TEXT")}
    assert shown[0].dxf.height / shown[0].dxf.view_height == 2.0 and "2:1" in said


def test_the_text_of_a_dimension_needs_no_scale(doc: Drawing) -> None:
    texts = {}
    for dimension in doc.modelspace().query("DIMENSION"):
        drawn = next(t.plain_text() for t in doc.blocks.get(dimension.dxf.geometry).query("MTEXT"))
        assert plain(dimension.dxf.text) == drawn and "<>" not in drawn
        texts[drawn] = dimension.override().get("dimlfac", 1.0)
    assert {"Ø15.5", "R47", "156.2°", "Ø8 H7", "12.8"} <= set(texts), texts
    assert {text for text, factor in texts.items() if factor != 1.0} == {"Ø15.5"}, "the detail alone is not 1:1"


def test_a_control_frame_names_value_and_datum_in_cells_beside_each_other(doc: Drawing) -> None:
    """Run-out of the four lands, 0.02 to the axis D: 4x above a frame of sign, value and letter."""
    texts = {t.dxf.text: t.dxf.align_point for t in doc.modelspace().query("TEXT") if t.dxf.halign != 0}
    value, count = texts["0.02"], texts["4x"]
    (right,) = [
        t.dxf.align_point
        for t in doc.modelspace().query("TEXT")
        if t.dxf.text == "D" and abs(t.dxf.align_point.y - value.y) < 1e-6
    ]
    assert 0.0 < right.x - value.x < 8.0 and 0.0 < count.y - value.y < 4.0, (value, right, count)
    assert sum(t.dxf.text == "D" for t in doc.modelspace().query("TEXT")) == 2, "the datum itself, and the frame"


def test_a_crowded_small_pulley_keeps_its_texts_apart() -> None:
    """So many dimensions stand round this one that its control frames find room only far from it."""
    part = (
        layout_of(load_design(ROOT / "params" / "gallery" / "telescope.yaml").drive).bill().made["input_pulley_right"]
    )
    facts = PartFacts("telescope", "metal", 1.0, "0", 0.02)
    crowded = drawing_reader.document(
        draw_sheet(part.sheet("input_pulley_right"), part.in_views().solid(), facts)["dxf"]
    )
    assert not drawing_reader.texts_on_texts(crowded) and not drawing_reader.texts_outside(crowded)


def _pdf_texts(data: bytes) -> list[str]:
    stream = re.search(rb"/FlateDecode >>\nstream\n(.*?)\nendstream", data, re.DOTALL)
    assert stream
    lines = zlib.decompress(stream[1]).split(b"\n")
    return [m[1].decode("cp1252") for line in lines if (m := re.search(rb" Tm \((.*)\) Tj$", line))]


def test_the_pdf_has_every_text_of_the_dxf(sheet: tuple[cq.Solid, dict[str, bytes]], doc: Drawing) -> None:
    texts = set(_pdf_texts(sheet[1]["pdf"]))
    assert b"3 Tr" in zlib.decompress(sheet[1]["pdf"].split(b"stream\n")[1].split(b"\nendstream")[0])
    wanted = {plain(d.dxf.text) for d in doc.modelspace().query("DIMENSION")}
    wanted |= {plain(t.dxf.text) for t in doc.modelspace().query("TEXT")}
    assert wanted <= {t.replace("\\(", "(").replace("\\)", ")") for t in texts}, wanted - texts


@pytest.mark.skipif(
    shutil.which("pdftotext") is None, reason="poppler is not installed (apt-get install poppler-utils)"
)
def test_poppler_finds_a_dimension_where_it_stands(
    sheet: tuple[cq.Solid, dict[str, bytes]], doc: Drawing, tmp_path: Path
) -> None:
    (tmp_path / "drum.pdf").write_bytes(sheet[1]["pdf"])
    said = subprocess.run(
        ["pdftotext", "-bbox", str(tmp_path / "drum.pdf"), "-"], capture_output=True, text=True, check=True
    ).stdout
    word = re.search(r'xMin="([\d.]+)" yMin="([\d.]+)" xMax="([\d.]+)" yMax="([\d.]+)">Ø15.5<', said)
    assert word, "no text Ø15.5"
    left, top, right, bottom = (float(v) * 25.4 / 72.0 for v in word.groups())
    (block,) = [doc.blocks.get(d.dxf.geometry) for d in doc.modelspace().query("DIMENSION") if d.dxf.text == "%%c15.5"]
    x, y, _ = next(iter(block.query("MTEXT"))).dxf.insert
    assert left < 2.0 * x < right and top < 420.0 - 2.0 * y < bottom, (x, y, left, right, top, bottom)


@pytest.mark.skipif(shutil.which("librecad") is None, reason="LibreCAD is not installed (apt-get install librecad)")
def test_librecad_draws_the_written_numbers(sheet: tuple[cq.Solid, dict[str, bytes]], tmp_path: Path) -> None:
    """Its picture does not change with the factor of the dimensions, on which a measured number would depend."""
    pictures = []
    for name, factor in (("as_written", None), ("sevenfold", 7.0)):
        changed = ezdxf.read(io.StringIO(sheet[1]["dxf"].decode().replace("\r\n", "\n")))
        for dimension in changed.modelspace().query("DIMENSION") if factor else ():
            override = dimension.override()
            override["dimlfac"] = factor
            override.commit()
        if factor:
            changed.dimstyles.get("MBCDM").dxf.dimlfac = changed.header["$DIMLFAC"] = factor
        changed.saveas(tmp_path / f"{name}.dxf")
        subprocess.run(
            ["librecad", "dxf2pdf", "-a", "-o", str(tmp_path / f"{name}.pdf"), str(tmp_path / f"{name}.dxf")],
            env=os.environ | {"QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)},
            capture_output=True,
            check=True,
            timeout=600,
        )
        pictures.append(re.sub(rb"/CreationDate.*|/ID.*", b"", (tmp_path / f"{name}.pdf").read_bytes()))
    assert len(pictures[0]) > 50_000 and pictures[0] == pictures[1]


@pytest.mark.slow
@pytest.mark.skipif(freecad_program() is None, reason="FreeCAD is not installed (Debian: freecad-python3)")
def test_freecad_measures_the_lengths_that_are_written(
    sheet: tuple[cq.Solid, dict[str, bytes]], doc: Drawing, tmp_path: Path
) -> None:
    """Linear dimensions of the views at 1:1; radii, angles and details are more than its reader understands."""
    path, script = tmp_path / "drum.dxf", tmp_path / "read.py"
    path.write_bytes(sheet[1]["dxf"])
    script.write_text(_FREECAD)
    measured = run_in_freecad(script, path)["lengths_mm"]
    linear = [d for d in doc.modelspace().query("DIMENSION") if d.dimtype == 0]
    plain_views = [d for d in linear if d.override().get("dimlfac", 1.0) == 1.0]
    assert len(plain_views) >= 9
    for dimension in plain_views:
        said = _number(plain(dimension.dxf.text))
        assert any(abs(said - value) < 6e-3 for value in measured), (dimension.dxf.text, measured)


_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def _block(number: int, middle: Vector, half: Vector, whole: bool = False, inward: bool = False) -> SeenBody:
    """A box; with ``inward`` a hollow of the body of that number."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    corners = np.array(middle) + signs * np.array(half)
    quads = [quad[::-1] if inward else quad for quad in _FACES]
    return SeenBody(number, np.array([corners[list(q)] for a, b, c, d in quads for q in ((a, b, c), (a, c, d))]), whole)


# A housing with a bearing and a screw inside it, a shaft through both, and two plates behind each other.
_HOUSING, _BEARING, _SHAFT, _SCREW, _PLATE, _BEHIND = range(1, 7)
_MADE = {
    _HOUSING: ((0.0, 0.0, 0.0), (20.0, 20.0, 20.0)),
    _BEARING: ((6.0, 0.0, 0.0), (5.0, 10.0, 5.0)),
    _SHAFT: ((6.0, 5.0, 0.0), (2.0, 30.0, 2.0)),
    _SCREW: ((-10.0, 0.0, 0.0), (2.0, 6.0, 2.0)),
    _PLATE: ((0.0, 26.0, -30.0), (19.0, 1.0, 8.0)),
    _BEHIND: ((0.0, 0.0, -30.0), (6.0, 6.0, 6.0)),
}


def _bodies() -> list[SeenBody]:
    hollow = np.concatenate(
        [_block(1, *_MADE[1]).corners_mm, _block(1, (-2.0, 0, 0), (14.0, 12.0, 8.0), inward=True).corners_mm]
    )
    others = [_block(n, *place, whole=n in (_SHAFT, _SCREW)) for n, place in _MADE.items() if n != _HOUSING]
    return [SeenBody(_HOUSING, hollow), *others]


def test_numbers_point_to_where_their_parts_are_seen() -> None:
    seen = pointers(_bodies(), ((-20.0, -25.0, -38.0), (20.0, 35.0, 20.0)))
    assert set(seen.places) == set(_MADE)
    assert seen.places[_BEARING][0].startswith("section"), "a part inside another is seen in a section"
    for number, (view, point) in seen.places.items():
        middle, half = _MADE[number]
        off = max(abs(p - m) - h for p, m, h in zip(point, middle, half, strict=True))
        assert off < 0.2, f"number {number} in {view} points {off:.2f} mm beside its part"
    on_paper = [(v, next(w for w in seen.views if w.name == v).project(p)) for v, p in seen.places.values()]
    for (one, a), (other, b) in combinations(on_paper, 2):
        assert one != other or dist(a, b) > 1.0, (one, a, b)


def test_a_part_that_no_view_shows_is_said_to_be_hidden() -> None:
    inside = [_block(2, (0.0, 0.0, 0.0), (3.0, 3.0, 3.0)), _block(3, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), whole=True)]
    cube = [_block(1, (0.0, 0.0, 0.0), (9.0, 9.0, 9.0))]
    shell = [_block(n, (x, 0.0, 0.0), (1.0, 5.0, 5.0)) for n, x in ((4, -20.0), (5, 20.0))]
    seen = pointers([*cube, *inside, *shell], ((-21.0, -9.0, -9.0), (21.0, 9.0, 9.0)))
    assert seen.hidden == (), seen
    # A screw is not cut, so no section shows what lies inside it.
    hull = [_block(9, (0.0, 0.0, 0.0), (40.0, 40.0, 40.0), whole=True), _block(8, (0.0, 0.0, 0.0), (5.0, 5.0, 5.0))]
    assert pointers(hull, ((-40.0, -40.0, -40.0), (40.0, 40.0, 40.0))).hidden == (8,)


@pytest.mark.parametrize("thick_mm", [0.2, 0.6])
def test_a_part_thinner_than_the_points_is_found(thick_mm: float) -> None:
    """A shim between blocks of 100 mm, whose points are a third of a millimetre apart; one behind them is hidden."""
    blocks = [_block(n, (0.0, 0.0, s * (25.0 + thick_mm / 2)), (50.0, 10.0, 25.0)) for n, s in ((1, 1), (2, -1))]
    shims = [_block(3, (0.0, 2.0, 0.0), (6.0, 8.0, thick_mm / 2)), _block(4, (20.0, -2.0, 0.0), (4.0, 6.0, 0.01))]
    seen = pointers([*blocks, *shims], ((-50.0, -10.0, -50.0), (50.0, 10.0, 50.0)))
    view, point = seen.places[3]
    assert 3 not in seen.hidden and abs(point[2]) <= thick_mm / 2 and abs(point[0]) <= 6.0, (view, point, seen.hidden)
    assert 4 in seen.hidden, seen


def test_list_of_parts_is_the_bill() -> None:
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    items = layout_of(drive).bill().items
    number = numbers(items)
    bodies = [_block(number[i.part], tuple(i.location.shift_mm), (1.0, 1.0, 1.0)) for i in items]
    envelope = ((-63.0, -14.0, -11.0), (63.0, 20.0, 86.0))
    sheet = assembly_sheet("assembly", items, bodies, envelope, {"nut": "ISO 4032 - M1.6"})
    (table,) = sheet.tables
    assert {row[1]: int(row[2]) for row in table.rows} == Counter(item.part for item in items)
    said = {row[1]: row[3] for row in table.rows}
    assert (said["nut"], said["screw_M2x6"], said["frame"]) == ("ISO 4032 - M1.6", "bought", "aluminium-7075"), said
    assert [label.text for label in sheet.labels] == [row[0] for row in table.rows]
    assert sorted(d.value for d in sheet.dimensions if isinstance(d, Linear)) == [34.0, 97.0, 126.0]


@pytest.mark.slow
def test_drawn_sections_have_lines_and_leaders_their_own_points() -> None:
    import cadquery as cq

    from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
    from mbcdm_cad.parts.bill import Item, Placement

    metal = next(iter(layout_of(load_design(ROOT / "params" / "mbcdm.yaml").drive).bill().items)).material
    items = [Item(f"p{n}", f"p{n}", metal, "made", Placement.identity(), "fixed") for n in _MADE]
    sheet = assembly_sheet("assembly", items, _bodies(), ((-20.0, -25.0, -38.0), (20.0, 35.0, 20.0)), {})
    solids = {n: cq.Workplane().box(*(2 * h for h in half)).translate(at).val() for n, (at, half) in _MADE.items()}
    solids[_HOUSING] = (
        cq.Workplane(obj=solids[_HOUSING]).cut(cq.Workplane().box(28, 24, 16).translate((-2, 0, 0))).val()
    )
    whole = cq.Compound.makeCompound([solids.pop(n) for n in (_SHAFT, _SCREW)])
    drawn = draw_sheet(
        sheet, cq.Compound.makeCompound(list(solids.values())), PartFacts("d", "m", 1.0, "0", 0.02), whole
    )
    doc = drawing_reader.document(drawn["dxf"])
    assert not drawing_reader.leaders_at_one_point(doc, 1.0)
    assert not drawing_reader.sections_without_line(doc)
    hatched = {h.dxf.pattern_angle for b in doc.blocks if b.name.startswith("VIEW_SECTION") for h in b.query("HATCH")}
    assert len(hatched) > 1, "bodies beside each other are hatched differently"
