"""One sheet in several programs: the model space is the part's own size, and every reader shows the same numbers."""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import zlib
from pathlib import Path

import cadquery as cq
import ezdxf
import pytest
from ezdxf import bbox
from ezdxf.document import Drawing

from mbcdm_cad.drawings.document import plain
from mbcdm_cad.drawings.draw import LAYOUT, PartFacts, draw_sheet
from mbcdm_cad.layouts.loader import layout_of, load_design
from tests.acceptance.freecad import freecad_program, run_in_freecad
from tests.support.drawing_reader import document, texts_on_texts, texts_outside

ROOT = Path(__file__).parents[3]
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
    return document(sheet[1]["dxf"])


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
    crowded = document(draw_sheet(part.sheet("input_pulley_right"), part.in_views().solid(), facts)["dxf"])
    assert not texts_on_texts(crowded) and not texts_outside(crowded)


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
