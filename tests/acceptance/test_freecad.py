"""FreeCAD opens an assembly: every solid and every name, valid, and with the same volume."""

import sys
from pathlib import Path

import cadquery as cq
import pytest

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import Item, Placement
from mbcdm_cad.workshop.export.step import assembly_step

sys.path.insert(0, str(Path(__file__).parent))

from freecad import differences, freecad_findings, freecad_program, read_parts

needs_freecad = pytest.mark.skipif(
    freecad_program() is None, reason="FreeCAD is not installed (Debian: apt-get install freecad-python3)"
)
STEEL = Material(
    name="steel",
    density_g_cm3=7.85,
    youngs_modulus_GPa=200.0,
    poisson_ratio=0.3,
    yield_MPa=500.0,
    process="turned",
    min_wall_mm=1.0,
    min_internal_radius_mm=1.0,
    colour=(0.3, 0.3, 0.3),
    source="test",
)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[str, float]]]:
    wire = cq.Workplane(cq.Wire.makeHelix(0.87, 0.87 * 1.75, 6.4))
    plane = cq.Plane((6.4, 0, 0), (1, 0, 0), (0, 1, 0))
    solids = {
        "plate": cq.Workplane().box(60, 40, 5).faces(">Z").workplane().hole(8).val().Solids()[0],
        "cable_1": cq.Workplane(plane).circle(0.405).sweep(wire, isFrenet=True).val(),
        "nut": cq.Workplane().polygon(6, 4).extrude(1.5).val(),
    }
    items = [
        Item(
            f"{part}_{n}",
            part,
            STEEL,
            "made",
            Placement.translation(70.0 * n, 50.0 * k, 0.0) @ Placement.about((1, 1, 0), 20.0 * n),
            f"group_{n}",
        )
        for k, part in enumerate(solids)
        for n in range(2)
    ]
    path = tmp_path_factory.mktemp("step") / "model.step"
    path.write_bytes(assembly_step("model", items, solids))
    return path, [(item.part, solids[item.part].Volume()) for item in items]


@needs_freecad
def test_freecad_reads_what_was_written(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    findings = freecad_findings(path)
    assert differences(findings, expected) == []
    assert findings["assemblies"] == ["group_0", "group_1", "model"]


@needs_freecad
def test_differences_are_seen(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    findings = freecad_findings(path)
    heavier = [(name, volume * (1 + 3e-6)) for name, volume in expected]
    assert any("volume of all" in line for line in differences(findings, heavier))
    assert any("missing ['bolt']" in line for line in differences(findings, [("bolt", expected[0][1]), *expected[1:]]))
    assert differences(findings, expected[1:])[0] == "6 solids, expected 5"


def test_own_reader_agrees(model: tuple[Path, list[tuple[str, float]]]) -> None:
    path, expected = model
    found = sorted(read_parts(path))
    assert [name for name, _ in found] == sorted(name for name, _ in expected)
    for (name, volume), (_, wanted) in zip(found, sorted(expected), strict=True):
        assert volume == pytest.approx(wanted, rel=1e-6), name


@needs_freecad
def test_what_is_no_step_file_is_said(tmp_path: Path) -> None:
    path = tmp_path / "bad.step"
    path.write_text("not a STEP file")
    with pytest.raises(RuntimeError, match="no findings"):
        freecad_findings(path)
