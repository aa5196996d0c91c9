"""STEP files: the same bytes for the same model, and the same model after reading."""

import hashlib
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import cadquery as cq
import pytest
from export_samples import STEEL
from OCP.Quantity import Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDF import TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import (
    XCAFDoc_Datum,
    XCAFDoc_Dimension,
    XCAFDoc_DimTolTool,
    XCAFDoc_DocumentTool,
    XCAFDoc_GeomTolerance,
    XCAFDoc_ShapeTool,
)

from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.parts.bill import Item
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.export.files import canonical_step, with_description
from mbcdm_cad.workshop.export.step import assembly_step, part_step, part_step_ap242
from mbcdm_cad.workshop.kernel import brep_bytes, measure, shape_from_brep
from mbcdm_cad.workshop.mass import PartFiles
from mbcdm_cad.workshop.meshing import make_part_files
from tests.acceptance.freecad import freecad_program, run_in_freecad
from tests.support.reference import DRIVE as _DRIVE

# Another process: other addresses, another order of items, other exports before.
_ELSEWHERE = """
import hashlib, random, sys
sys.path[:0] = sys.argv[2:]
from export_samples import STEEL, make_items, make_solids
from mbcdm_cad.workshop.export.step import assembly_step, part_step
chance = random.Random(int(sys.argv[1]))
waste = [bytearray(chance.randrange(10, 5000)) for _ in range(chance.randrange(3000))]
solids, items = make_solids(), make_items()
chance.shuffle(items)
for part in chance.sample(sorted(solids), chance.randrange(4)):
    part_step(part, solids[part], STEEL)
print(hashlib.sha256(assembly_step("model", items, solids)).hexdigest())
print(hashlib.sha256(part_step("plate", solids["plate"], STEEL)).hexdigest())
"""


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_same_bytes_in_another_process(seed: int, items: list[Item], solids: dict[str, cq.Solid]) -> None:
    here = [_digest(assembly_step("model", items, solids)), _digest(part_step("plate", solids["plate"], STEEL))]
    paths = [str(Path(__file__).parents[4]), str(Path(__file__).parent)]
    command = [sys.executable, "-c", _ELSEWHERE, str(seed), *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split() == here, f"process {seed} wrote other bytes: {done.stdout.split()} against {here}"


def test_same_bytes_whatever_came_before(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    chance = random.Random(4)
    first = assembly_step("model", items, solids)
    for turn in range(10):
        chance.shuffle(items)
        part_step("plate", solids["plate"], STEEL)
        again = assembly_step("model", items, solids)
        assert again == first, f"turn {turn}: {_digest(again)} against {_digest(first)}"


def test_same_bytes_from_stored_solids(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    stored = {part: shape_from_brep(brep_bytes(solid)) for part, solid in solids.items()}
    assert assembly_step("model", items, stored) == assembly_step("model", items, solids)


def test_another_model_gives_other_bytes(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    moved = [replace(items[0], location=items[1].location @ items[0].location), *items[1:]]
    assert assembly_step("model", moved, solids) != assembly_step("model", items, solids)


def test_assembly_comes_back_equal(items: list[Item], solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    path = tmp_path / "model.step"
    path.write_bytes(assembly_step("model", items, solids))
    back = cq.Assembly.importStep(str(path))
    assert back.name == "model"
    found = {name: node for name, node in back.traverse() if node.obj is not None}
    assert set(found) == {item.name for item in items}
    for item in items:
        node = found[item.name]
        volume, expected = node.obj.Volume(), solids[item.part].Volume()
        assert abs(volume / expected - 1.0) < 1e-6, f"{item.name}: volume {volume} against {expected}"
        shift = node.loc.toTuple()[0]
        assert shift == pytest.approx(tuple(item.location.shift_mm), abs=1e-9), f"{item.name} is at {shift}"
        linear = tuple(node.color.wrapped.GetRGB().Values(Quantity_TypeOfColor.Quantity_TOC_RGB))
        assert linear == pytest.approx(item.material.colour, abs=1e-5), f"{item.name} has colour {linear}"
        assert node.material.name == item.material.name
        assert node.material.density == pytest.approx(item.material.density_g_cm3, rel=1e-12)
        assert node.parent.name == item.group


def test_part_is_named(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    path = tmp_path / "plate.step"
    path.write_bytes(part_step("plate", solids["plate"], STEEL, description="it's 30 µm off"))
    text = path.read_text("ascii")
    assert text.count("=PRODUCT('plate','plate',") == 1, "the product is not named"
    assert "('it''s 30 \\X4\\000000B5\\X0\\m off')" in text
    back = cq.importers.importStep(str(path)).val()
    assert back.Volume() == pytest.approx(solids["plate"].Volume(), rel=1e-9)


def test_density_has_a_density_unit(solids: dict[str, cq.Solid]) -> None:
    text = part_step("plate", solids["plate"], STEEL).decode()
    exponents = sorted(line.split(",")[1] for line in text.splitlines() if "DERIVED_UNIT_ELEMENT(" in line)
    assert exponents == ["-3.);", "1.);"], f"unit of density is not g cm^-3: {exponents}"


def test_description_can_be_set_later(solids: dict[str, cq.Solid]) -> None:
    late = with_description(part_step("plate", solids["plate"], STEEL).decode(), "forced")
    assert late.encode() == part_step("plate", solids["plate"], STEEL, description="forced")


def test_text_that_is_no_step_is_refused() -> None:
    with pytest.raises(ValueError, match="no STEP data section"):
        canonical_step("hello", "x", "")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "plate_1"}, "two items are named"),
        ({"name": "../x"}, "must match"),
        ({"part": "gone"}, "has no solid"),
        ({"mass_g": 3.0}, "differ in material, kind or mass"),
    ],
)
def test_bad_items_are_refused(
    items: list[Item], solids: dict[str, cq.Solid], change: dict[str, str], message: str
) -> None:
    index = next(k for k, item in enumerate(items) if item.name == "plate_0")
    items[index] = replace(items[index], **change)
    with pytest.raises(ValueError, match=message):
        assembly_step("model", items, solids)


# The stored files of a part contain everything that a build needs of it.


KEY = "5" * 64


def test_part_survives_the_cache(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    made = make_part_files("plate", solids["plate"], STEEL, 0.02)
    Cache(tmp_path).put(KEY, made.to_blobs())
    blobs = Cache(tmp_path).get(KEY)
    assert blobs is not None
    found = PartFiles.from_blobs("plate", blobs)
    assert (found.brep, found.step, found.stl, found.shape) == (made.brep, made.step, made.stl, made.shape)
    assert abs(found.mesh_volume_error) < 1e-3, f"mesh volume off by {found.mesh_volume_error:.1e}"
    solid = shape_from_brep(found.brep)
    assert measure(solid).volume_mm3 == pytest.approx(made.shape.volume_mm3, rel=1e-12)
    assert part_step("plate", solid, STEEL) == made.step


def test_stored_part_is_read_without_the_kernel(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    Cache(tmp_path).put(KEY, make_part_files("disc", solids["disc"], STEEL, 0.02).to_blobs())
    code = f"""
import sys
from pathlib import Path
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.export.files import glb_bytes
from mbcdm_cad.workshop.mass import item_mass
from mbcdm_cad.workshop.mass import PartFiles
part = PartFiles.from_blobs("disc", Cache(Path({str(tmp_path)!r})).get({KEY!r}))
print(len(part.stl), round(part.shape.volume_mm3), [n for n in ("cadquery", "OCP", "vtkmodules") if n in sys.modules])
"""
    root = Path(__file__).parents[4]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    size, volume, imported = done.stdout.split(maxsplit=2)
    assert int(size) > 84
    assert int(volume) == 51472  # pi 64^2 4
    assert imported == "[]\n"


def test_unsound_part_is_not_made() -> None:
    with pytest.raises(GeometryError, match="drum: a Compound of 2 solids"):
        make_part_files("drum", cq.Workplane().box(9, 1, 1).cut(cq.Workplane().box(3, 3, 3)).val(), STEEL, 0.02)


# STEP AP242 read back by the kernel's reader: each fit, datum and tolerance on the faces that the sheet means.


_BILL = layout_of(_DRIVE).bill()


def _made(name: str) -> tuple[MadePart, Material]:
    return _BILL.made[name], next(item.material for item in _BILL.items if item.part == name)


def _step(name: str) -> bytes:
    part, material = _made(name)
    return part_step_ap242(name, part.solid(), material, part.sheet(name))


def _read(path: Path) -> Any:
    """Tool of the dimensions and tolerances that the kernel reads in a file, and the document that keeps it alive."""
    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    reader = STEPCAFControl_Reader()
    reader.SetGDTMode(True)
    reader.ReadFile(str(path))
    assert reader.Transfer(document)
    return XCAFDoc_DocumentTool.DimTolTool_s(document.Main()), document


@pytest.fixture(scope="module")
def guide(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What the kernel reads in the guide pulley's file."""
    path = tmp_path_factory.mktemp("pmi") / "guide.step"
    path.write_bytes(_step("guide"))
    return _read(path)


def _labels(fill: Any) -> list[Any]:
    found = TDF_LabelSequence()
    fill(found)
    return list(found)


def _faces(label: Any) -> list[cq.Shape]:
    first, second = TDF_LabelSequence(), TDF_LabelSequence()
    XCAFDoc_DimTolTool.GetRefShapeLabel_s(label, first, second)
    return [cq.Shape.cast(XCAFDoc_ShapeTool.GetShape_s(shape)) for shape in first]


def _diameters(label: Any) -> list[float]:
    return sorted(round(2 * face._geomAdaptor().Cylinder().Radius(), 4) for face in _faces(label))


def test_each_fit_is_on_the_cylinders_of_its_size(guide: Any) -> None:
    tool, _ = guide
    found = {}
    for label in _labels(tool.GetDimensionLabels):
        size = XCAFDoc_Dimension.Set_s(label).GetObject()
        limits = (round(size.GetLowerBound(), 4), round(size.GetUpperBound(), 4))
        found[limits] = _diameters(label)
    # 9 N7: -4 to -19 um of ISO 286, on both seats; the four steps js7: +-9 and +-10 um.
    assert found[8.981, 8.996] == [9.0, 9.0], found
    assert found[17.181, 17.199] == [17.19] and found[20.78, 20.8] == [20.79], found
    assert len(found) == 5


def test_tolerances_name_their_faces_and_datum(guide: Any) -> None:
    tool, _ = guide
    found = {}
    for label in _labels(tool.GetGeomToleranceLabels):
        demand = XCAFDoc_GeomTolerance.Set_s(label).GetObject()
        kind = demand.GetType().name.rsplit("_", 1)[1]
        datums = []
        for datum_label in _labels(lambda out, label=label: XCAFDoc_DimTolTool.GetDatumOfTolerLabels_s(label, out)):
            datums.append((XCAFDoc_Datum.Set_s(datum_label).GetObject().GetName().ToCString(), _diameters(datum_label)))
        found[kind] = (demand.GetValue(), sorted(face.geomType() for face in _faces(label)), datums)
    seats = [("D", [9.0, 9.0])]
    assert found == {
        "CircularRunout": (0.01, ["CYLINDER"] * 4, seats),
        "Perpendicularity": (0.01, ["PLANE"] * 2, seats),
    }


@pytest.mark.parametrize(
    ("name", "threads"),
    [
        ("drum", {"M2.5-6H x 5.1": [2.5] * 4, "M3-6H": [3.0] * 2}),
        ("collar", {"M1.6-6H": [1.6]}),
        ("terminal", {"M1.6-6g": [1.6]}),
    ],
)
def test_each_thread_is_on_the_cylinders_of_its_holes(name: str, threads: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    path.write_bytes(_step(name))
    tool, _document = _read(path)
    found = {}
    for label in _labels(tool.GetDimensionLabels):
        size = XCAFDoc_Dimension.Set_s(label).GetObject()
        for k in range(size.NbDescriptions()):
            found[size.GetDescription(k).ToCString()] = _diameters(label)
    assert found == threads


@pytest.mark.parametrize("name", ["guide_axle", "guide_spacer", "input_pulley_left"])
def test_the_same_part_gives_the_same_bytes_in_the_schema_of_ap242(name: str) -> None:
    data = _step(name)
    assert data == _step(name)
    assert b"AP242_MANAGED_MODEL_BASED_3D_ENGINEERING" in data
    assert data.count(b"_TOLERANCE(") >= len(_made(name)[0].sheet(name).tolerances)


def test_the_plain_file_stays_ap214_after_it() -> None:
    part, material = _made("guide_spacer")
    _step("guide_spacer")
    assert b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'))" in part_step("s", part.solid(), material)


@pytest.mark.slow
@pytest.mark.skipif(freecad_program() is None, reason="FreeCAD is not installed (Debian: freecad-python3)")
def test_freecad_opens_it_as_the_same_solid(tmp_path: Path) -> None:
    path, script = tmp_path / "guide.step", tmp_path / "read.py"
    path.write_bytes(_step("guide"))
    script.write_text(
        "import Part, json, os\ns = Part.read(os.environ['CHECKED_FILE'])\n"
        "print(chr(10) + json.dumps({'solids': len(s.Solids), 'volume_mm3': s.Volume}))"
    )
    found = run_in_freecad(script, path)
    assert found["solids"] == 1
    assert found["volume_mm3"] == pytest.approx(_made("guide")[0].solid().Volume(), rel=1e-6)
