"""STEP AP242 read back by the kernel's reader: each fit, datum and tolerance on the faces that the sheet means."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cadquery as cq
import pytest
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
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.workshop.export.step import part_step, part_step_ap242
from tests.acceptance.freecad import freecad_program, run_in_freecad

_DRIVE = load_design(Path(__file__).parents[4] / "params" / "mbcdm.yaml").drive
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
