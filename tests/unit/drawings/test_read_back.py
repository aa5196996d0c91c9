"""Each drawing, read from its DXF alone, gives the part; without any one of its dimensions it does not."""

import io
import re
from math import atan2, degrees, pi

import cadquery as cq
import ezdxf
import numpy as np
import pytest
from ezdxf.document import Drawing

from mbcdm_cad.drawings.document import plain
from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
from mbcdm_cad.drawings.titleblock import Room
from mbcdm_cad.layouts.loader import layout_of, load_design
from tests.support import drawing_reader
from tests.support.rebuilt import LARGE, OTHERS, SMALL, Rebuild, turned
from tests.support.reference import ROOT

pytestmark = pytest.mark.slow
# Lengths are printed to a hundredth or a thousandth of a millimetre; a small part feels that most.
_VOLUME_ERROR = 2e-3


@pytest.fixture(scope="module")
def parts() -> dict[str, tuple[cq.Solid, bytes]]:
    """Solid and DXF of the parts that are rebuilt."""
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    specs = layout_of(drive).bill().parts
    made = {}
    for name in SMALL:
        spec = specs[name]
        solid = spec.part.solid()
        sheet = spec.part.sheet(name)
        made[name] = (solid, draw_sheet(sheet, solid, PartFacts("mbcdm", "metal", 1.0, "0", 0.02))["dxf"])
    return made


@pytest.mark.parametrize("name", SMALL)
def test_the_drawing_makes_the_part(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    solid, data = parts[name]
    doc = drawing_reader.document(data)
    assert SMALL[name](doc, drawing_reader.dimensions(doc)) == pytest.approx(solid.Volume(), rel=_VOLUME_ERROR)


@pytest.mark.parametrize("name", SMALL)
def test_without_any_one_dimension_it_does_not(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    solid, data = parts[name]
    doc = drawing_reader.document(data)
    dims = drawing_reader.dimensions(doc)
    for missing in dims:
        rest = [d for d in dims if d is not missing]
        try:
            volume = SMALL[name](doc, rest)
        except (drawing_reader.MissingDimensionError, ValueError, IndexError, StopIteration):
            continue
        error = abs(volume / solid.Volume() - 1.0)
        assert error > _VOLUME_ERROR, f"{missing.prefix}{missing.value} in {missing.view} is not needed: {error:.2g}"


# Only where the outline says which dimensions there can be.
@pytest.mark.parametrize("name", [name for name, made in SMALL.items() if made is turned])
def test_a_dimension_said_twice_is_found(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    doc = drawing_reader.document(parts[name][1])
    dims = drawing_reader.dimensions(doc)
    for doubled in dims:
        if "45" in doubled.suffix:
            continue
        with pytest.raises(drawing_reader.DoubledDimensionError):
            turned(doc, [*dims, doubled])


# Far under the volume of the smallest hole. Corners in which a motor head's bodies meet are a little more than it.
_MILLED_ERROR, _OF_OTHERS = 1e-4, 5e-4
Sheets = dict[str, tuple[float, Drawing]]
DESIGNS = {
    "mbcdm": LARGE,
    # Motors above: a plate with boxes, and a frame that holds encoders.
    "gallery/overhead": {"frame": LARGE["frame"], "top_plate": SMALL["top_plate"]},
    "siso_bevel": OTHERS["siso_bevel"],
    "siso_spur": OTHERS["siso_spur"],
    # Its drum has the dowels that hold two sectors together, which no other has.
    "miso_spur": {"frame": OTHERS["miso_spur"]["frame"], "drum": LARGE["drum"]},
}
CASES: dict[str, Rebuild] = {f"{file}/{part}": make for file, parts in DESIGNS.items() for part, make in parts.items()}


@pytest.fixture(scope="module")
def sheets() -> Sheets:
    """Volume of each solid, and its drawing."""
    made = {}
    for file, parts in DESIGNS.items():
        drive = load_design(ROOT / "params" / f"{file}.yaml").drive
        specs = layout_of(drive).bill().parts
        for name in parts:
            spec = specs[name]
            solid = spec.part.solid()
            data = draw_sheet(spec.part.sheet(name), solid, PartFacts(file, "metal", 1.0, "0", 0.02))
            made[f"{file}/{name}"] = (solid.Volume(), drawing_reader.document(data["dxf"]))
    return made


@pytest.mark.parametrize("case", CASES)
def test_the_drawing_makes_the_milled_part(sheets: Sheets, case: str) -> None:
    volume, doc = sheets[case]
    error = _MILLED_ERROR if case.startswith("mbcdm") else _OF_OTHERS
    assert CASES[case](doc, drawing_reader.dimensions(doc)) == pytest.approx(volume, rel=error)


@pytest.mark.parametrize("case", CASES)
def test_every_dimension_is_needed_once(sheets: Sheets, case: str) -> None:
    _, doc = sheets[case]
    dims = drawing_reader.dimensions(doc)
    assert len(dims) >= 10
    for n, one in enumerate(dims):
        said = f"{one.view}: {one.prefix}{one.value:g}{one.suffix}"
        assert _refused(case, doc, dims[:n] + dims[n + 1 :]), f"{said} is not needed"
        assert _refused(case, doc, [*dims, one]), f"{said} may stand there twice"


def _refused(case: str, doc: Drawing, dims: list[drawing_reader.ReadDimension]) -> bool:
    try:
        CASES[case](doc, dims)
    except (drawing_reader.MissingDimensionError, drawing_reader.DoubledDimensionError, ValueError):
        return True
    return False


def test_a_missing_hole_would_be_seen(sheets: Sheets) -> None:
    volume, doc = sheets["mbcdm/frame"]
    depths = [(float(row[2]), float(row[4])) for row in drawing_reader.table(doc, "Holes")[1:] if row[4][0].isdigit()]
    assert min(pi / 4 * d**2 * deep for d, deep in depths) > _MILLED_ERROR * volume


_DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
_BILL = layout_of(_DRIVE).bill()
MADE = tuple(dict.fromkeys(item.part for item in _BILL.items if item.kind == "made"))
_FACTS = PartFacts("mbcdm", "metal", 1.0, "0", 0.02)


@pytest.fixture(scope="module")
def drawn() -> dict[str, tuple[cq.Solid, dict[str, bytes]]]:
    """Solid and files of every made part."""
    made = {}
    for name in MADE:
        spec = _BILL.parts[name]
        solid = spec.part.solid()
        made[name] = (solid, draw_sheet(spec.part.sheet(name), solid, _FACTS))
    return made


Drawn = dict[str, tuple[cq.Solid, dict[str, bytes]]]


@pytest.mark.parametrize("name", MADE)
def test_audit_finds_nothing(drawn: Drawn, name: str) -> None:
    found = drawing_reader.document(drawn[name][1]["dxf"]).audit()
    assert not found.errors
    assert not found.fixes


@pytest.mark.parametrize("name", ["input_pulley_left", "collar", "top_plate"])
def test_the_same_bytes_twice(drawn: Drawn, name: str) -> None:
    spec = _BILL.parts[name]
    solid = spec.part.solid()
    again = draw_sheet(spec.part.sheet(name), solid, _FACTS)
    for kind, data in drawn[name][1].items():
        assert again[kind] == data, kind


@pytest.mark.parametrize("name", MADE)
def test_no_text_stands_on_another(drawn: Drawn, name: str) -> None:
    assert not drawing_reader.texts_on_texts(drawing_reader.document(drawn[name][1]["dxf"]))


@pytest.mark.parametrize("name", MADE)
def test_all_texts_are_inside_the_frame(drawn: Drawn, name: str) -> None:
    assert not drawing_reader.texts_outside(drawing_reader.document(drawn[name][1]["dxf"]))


def test_a_place_is_taken_whose_leader_crosses_no_text() -> None:
    room = Room((-50.0, -50.0, 50.0, 50.0))
    room.add_line(np.array([(0.0, -40.0), (0.0, -41.0)]))
    room.add_box((1.0, 1.0, 3.0, 9.0))
    straight = room.place((0.0, 5.0), 8.0, 2.0, 3.5, leader=lambda middle: middle)
    assert straight[0] < 0.0, straight


@pytest.mark.parametrize("name", MADE)
def test_leaders_sections_and_cells(drawn: Drawn, name: str) -> None:
    """No two leaders end at one point or cross a text, each section has its cutting line, no text leaves its cell."""
    doc = drawing_reader.document(drawn[name][1]["dxf"])
    assert not drawing_reader.leaders_at_one_point(doc, 1e-3)
    assert not drawing_reader.texts_on_lines(doc)
    assert not drawing_reader.sections_without_line(doc)
    assert not drawing_reader.texts_over_their_cells(doc)


def test_a_radius_is_drawn_where_its_sheet_puts_it_wherever_its_text_finds_room(drawn: Drawn) -> None:
    """The rim's inner radius of the drum: 35 degrees from Z towards X, which is 55 degrees on paper."""
    radii = [
        d for d in drawing_reader.document(drawn["drum"][1]["dxf"]).modelspace().query("DIMENSION") if d.dimtype == 4
    ]
    assert len(radii) == 1
    along = radii[0].dxf.defpoint4 - radii[0].dxf.defpoint
    assert degrees(atan2(along.y, along.x)) == pytest.approx(55.0, abs=1e-6)


@pytest.mark.parametrize("name", MADE)
def test_readable_by_others(drawn: Drawn, name: str) -> None:
    """SVG of the paper's size, a PDF of one page, and a DXF whose dimensions measure the part, not the paper."""
    files = drawn[name][1]
    assert re.search(rb'width="(297|420|594|841)mm"', files["svg"])
    assert files["pdf"].startswith(b"%PDF-1.4")
    assert files["pdf"].count(b"/Type /Page ") == 1
    doc = ezdxf.read(io.StringIO(files["dxf"].decode("utf-8").replace("\r\n", "\n")))
    shown = [d for d in doc.modelspace().query("DIMENSION") if d.dimtype == 0]
    assert shown
    for dimension in shown:
        block = doc.blocks.get(dimension.dxf.geometry)
        text = next(t.plain_text() for t in block.query("MTEXT"))
        value = float(re.search(r"(\d+\.?\d*)(?!x)(?:$|[^\dx.])", re.sub(r"^\d+x ", "", text))[1])  # type: ignore[index]
        factor = dimension.override().get("dimlfac", 1.0)
        measured = (dimension.dxf.defpoint2 - dimension.dxf.defpoint3).magnitude
        assert measured * factor == pytest.approx(value, abs=6e-3), text
        assert plain(dimension.dxf.text) == text, "a reader that writes the text itself shows another one"


def _cylinders(solid: cq.Solid, least_share: float) -> set[tuple[float, str, float, float]]:
    """(diameter, axis direction, the two coordinates across it) of the cylinders bored into a solid, of whose wall
    at least ``least_share`` is left."""
    found: dict[tuple[float, str, float, float], float] = {}
    for face in solid.Faces():
        if face.geomType() != "CYLINDER":
            continue
        surface = face._geomAdaptor().Cylinder()
        at, along = surface.Axis().Location(), surface.Axis().Direction()
        radius = surface.Radius()
        # Inside faces only: their normal points to the axis.
        inward = face.wrapped.Orientation().name.endswith("REVERSED")
        if not inward:
            continue
        for name, d, place in (("Z", along.Z(), (at.X(), at.Y())), ("Y", along.Y(), (at.X(), at.Z()))):
            if abs(d) > 0.999:
                key = (round(2 * radius, 3), name, round(place[0], 3) + 0.0, round(place[1], 3) + 0.0)
                box = face.BoundingBox()
                length = box.zlen if name == "Z" else box.ylen
                found[key] = max(found.get(key, 0.0), face.Area() / (2 * 3.14159265 * radius * max(length, 1e-9)))
    return {key for key, share in found.items() if share > least_share}


def test_hole_table_of_the_frame_is_what_the_solid_has(drawn: Drawn) -> None:
    solid, files = drawn["frame"]
    doc = drawing_reader.document(files["dxf"])
    rows = {row[0]: row for row in drawing_reader.table(doc, "Holes")[1:]}
    said = set()
    for axis in "ZY":
        title = f"Positions from A and the drum axis, along {axis}"
        for name, first, second, _ in drawing_reader.table(doc, title)[1:]:
            row = rows[name[0]]
            diameter = float(row[3][1:].split()[0]) if row[3] != "-" else float(row[2])
            said.add((round(diameter, 3), axis, float(first), float(second)))
            if row[6] != "-":
                sunk = float(re.match(r"Ø([\d.]+)", row[6])[1])  # type: ignore[index]
                said.add((round(sunk, 3), axis, float(first), float(second)))
    drum = {(16.0, "Y", 0.0, 0.0), (14.2, "Y", 0.0, 0.0), (24.5, "Y", 0.0, 0.0)}

    def near(a: tuple[float, str, float, float], b: tuple[float, str, float, float]) -> bool:
        return a[1] == b[1] and all(abs(p - q) < 2e-3 for p, q in zip((a[0], *a[2:]), (b[0], *b[2:]), strict=True))

    # Holes that cut into each other keep a part of their walls; corners of pockets are quarters of cylinders.
    walls, whole = _cylinders(solid, 0.05), _cylinders(solid, 0.45) - drum
    assert not [hole for hole in said if not any(near(hole, other) for other in walls)]
    assert not [hole for hole in whole if not any(near(hole, other) for other in said)]
