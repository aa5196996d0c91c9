"""Printed parts: holes made wider, inserts, thin walls, overhangs.

Files for a printer are those of printed parts; what a standard names is bought and has neither file nor sheet.
"""

from __future__ import annotations

import re
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
import trimesh

from mbcdm_cad.checks.size import overhang_check, printed_walls_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.parts.fits import limits
from mbcdm_cad.parts.making import PRINTED_MM, body_accuracy, land_band_mm, model_tolerances, sheet_as_printed
from mbcdm_cad.parts.part import StandardPart
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.workshop.drawings import drawn_parts
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.prints import overhang_mm2, prints_of, round_holes, thinnest_wall, with_wider_holes
from tests.support.checked import failing, of_params

ROOT = Path(__file__).parents[3]
PRINTED = (ROOT / "params/gallery/printed.yaml").read_text("utf-8")


def _bill(text: str):
    drive = load_text(text, "printed.yaml").drive
    return drive, layout_of(drive), layout_of(drive).bill()


@pytest.fixture(scope="module")
def printed():
    return _bill(PRINTED)


def _mesh(solid: cq.Shape):
    return mesh_solid("block", solid.wrapped, 0.01)


def test_holes_are_wider_by_the_allowance_and_nothing_else_changes() -> None:
    """A stepped bore, a slit bore and a corner: the rings taken away are those of both bores."""
    block = cq.Workplane("XY").box(30, 20, 10).edges("|Z").fillet(3.0)
    block = block.faces(">Z").workplane().pushPoints([(-8, 0)]).cboreHole(4.0, 7.0, 3.0)
    block = block.faces(">Z").workplane().pushPoints([(6, 0)]).hole(6.0)
    block = block.cut(cq.Workplane("XY").box(8, 1.0, 12).translate((12, 0, 0)))
    solid = block.val()
    assert [hole.radius_mm for hole in round_holes(solid.wrapped)] == [2.0, 3.5, 3.0]
    wider = cq.Shape.cast(with_wider_holes("block", solid.wrapped, 0.2))
    assert sorted(h.radius_mm for h in round_holes(wider.wrapped)) == pytest.approx([2.1, 3.1, 3.6])
    # The slit takes the ring between y = +-0.5 from the bore that it opens.
    slit = 0.5 * (sqrt(3.1**2 - 0.25) - sqrt(3.0**2 - 0.25)) + (
        3.1**2 * np.arcsin(0.5 / 3.1) - 3.0**2 * np.arcsin(0.5 / 3.0)
    )
    taken = pi * (2.1**2 - 2.0**2) * 7 + pi * (3.6**2 - 3.5**2) * 3 + (pi * (3.1**2 - 3.0**2) - slit) * 10
    assert solid.Volume() - wider.Volume() == pytest.approx(taken, rel=1e-6)


@pytest.mark.parametrize("name", ["top_plate", "collar"])
def test_every_bore_of_a_part_is_wider(printed, name: str) -> None:
    spec = printed[2].parts[name]
    solid = spec.part.solid()
    drawn, wider = round_holes(solid.wrapped), round_holes(with_wider_holes(name, solid.wrapped, 0.2))
    assert len(drawn) >= 3
    assert [(h.foot_mm, pytest.approx(h.radius_mm + 0.1, abs=1e-4)) for h in drawn] == [
        (h.foot_mm, h.radius_mm) for h in wider
    ]


def test_thinnest_wall_is_found_where_it_is() -> None:
    block = cq.Workplane("XY").box(20, 10, 10).cut(cq.Workplane("XY").box(6, 8.6, 20).translate((3, 0, 0))).val()
    wall = thinnest_wall(_mesh(block))
    assert wall is not None
    assert wall.thickness_mm == pytest.approx(0.7, abs=1e-6)
    assert abs(wall.at_mm[1]) == pytest.approx(4.65, abs=1e-6)
    assert 0.0 <= wall.at_mm[0] <= 6.0
    tube = cq.Workplane("XY").circle(8.0).circle(7.1).extrude(12).val()
    assert thinnest_wall(_mesh(tube)).thickness_mm == pytest.approx(0.9, rel=0.02)  # type: ignore[union-attr]


def test_no_wall_of_a_printed_drum_is_too_thin(printed) -> None:
    """Its spigot on the bearing's inner ring is a cone: a ring beside the shaft would be 0.75 mm thick."""
    drive, layout, bill = printed
    d, least = layout.drum, drive.drum_material.min_wall_mm
    assert d.spigot_radius - d.bore_radius < least <= d.spigot_root_radius - d.bore_radius
    drum = bill.made["drum"]
    solid = drum.solid()
    assert drum.volume_mm3() == pytest.approx(solid.Volume(), rel=0.01)
    wall = thinnest_wall(mesh_solid("drum", solid.wrapped, 0.05))
    assert wall is None or wall.thickness_mm >= least - 1e-6, wall
    narrow = replace(drive, drum=replace(drive.drum, hub_diameter_mm=2 * (d.bore_radius + least + 0.2)))
    check = next(check for check in checks_of(narrow) if check.id == "hub_spigot")
    found = check.measure(layout_of(narrow))
    assert not found.holds and found.subject.startswith("wall of the printed spigot"), found


def test_overhang_is_the_area_below_forty_five_degrees() -> None:
    table = cq.Workplane("XY").box(10, 10, 4).union(cq.Workplane("XY").box(30, 10, 2).translate((0, 0, 30)))
    table = table.union(cq.Workplane("XY").box(6, 10, 28).translate((0, 0, 15))).val()
    # On its largest face, the plate above; the foot hangs over by 2 x 2 mm on each side of the stem.
    assert overhang_mm2(_mesh(table)) == pytest.approx(2 * 2 * 10)
    steep = cq.Workplane("XZ").polyline([(0, 0), (30, 0), (30, 8), (26, 12), (0, 12)]).close().extrude(10).val()
    assert overhang_mm2(_mesh(steep)) == 0.0


def test_checks_say_part_place_and_figure(printed) -> None:
    drive = printed[0]
    found = printed_walls_check(drive, [("drum", 0.75, 1.0, "(1, 2, 3)"), ("frame", 1.4, 1.0, "(0, 0, 0)")])
    assert found.status == "warn" and found.actual == 0.75
    assert found.message.startswith("wall of drum at (1, 2, 3) 0.75 mm")
    assert printed_walls_check(drive, [("frame", 1.0, 1.0, "(0, 0, 0)")]).status == "pass"
    assert overhang_check(drive, {"drum": 0.0}).status == "pass"
    hanging = overhang_check(drive, {"drum": 12.4, "frame": 100.0})
    assert hanging.status == "warn" and "drum 12, frame 100" in hanging.message


@pytest.mark.slow
def test_inserts_stand_in_hole_bill_order_and_table(printed) -> None:
    _, dims, bill = printed
    assert dims.frame.plate_insert.name == "M2x3" and dims.drum.payload_insert.name == "M2.5x4"
    inserts = [item for item in bill.items if item.part.startswith("insert_")]
    assert len(inserts) == 8 and all(item.kind == "bought" and item.mass_g > 0.0 for item in inserts)
    steps = dims.assembly_order
    joined = [name for step in steps for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill.items)
    for step in steps:
        assert ("plate_insert_1" in step.items) == ("4 inserts M2x3" in step.text)
    solids = {}
    for part, hole, diameter in (("frame", "D", 3.2), ("drum", "P", 4.0)):
        spec = bill.parts[part]
        (group,) = (g for g in spec.part.sheet(part).holes if g.letter == hole)
        assert (group.row()[2], group.row()[3]) == (f"{diameter:g}", f"insert {group.insert.name}")
        assert group.depth >= group.insert.depth_mm
        solids[part] = spec.part.solid()
        bores = [h for h in round_holes(solids[part].wrapped) if abs(h.radius_mm - diameter / 2) < 1e-6]
        assert len(bores) == 4
    for item in inserts:
        spec = bill.parts[item.part]
        bush = spec.part.solid().moved(_location(item))
        solid = solids["frame" if item.group == "fixed" else "drum"]
        assert abs(bush.intersect(solid).Volume()) < 1e-3, item.name
        grown = cq.Solid.makeBox(*(2.0,) * 3).moved(cq.Location(cq.Vector(*bush.Center().toTuple())))
        assert abs(grown.intersect(solid).Volume()) > 0.0, f"{item.name} stands in no metal"


def _location(item) -> cq.Location:
    from mbcdm_cad.workshop.kernel import location

    return cq.Location(location(item.location))


@pytest.mark.parametrize("file", ["gallery/printed.yaml", "gallery/capstan.yaml"])
def test_sheets_of_printed_parts_ask_what_the_model_counts_and_a_printer_holds(file: str) -> None:
    drive, _, bill = _bill((ROOT / "params" / file).read_text("utf-8"))
    material = {item.part: item.material for item in bill.items}
    printed = {name: part for name, part in bill.made.items() if material[name].printed}
    assert {"drum", "frame"} <= set(printed)
    making = body_accuracy(drive, "drum")
    assert making.position_mm >= PRINTED_MM and body_accuracy(drive, "pulley") == drive.making
    for name, part in printed.items():
        sheet = sheet_as_printed(part.sheet(name), making)
        assert not [note for note in sheet.notes if re.search(r"\bRa \d|ground|[Mm]illed", note)], sheet.notes
        assert sheet.notes[-1].startswith("Printed.")
        for frame in sheet.tolerances:
            assert frame.value_mm == (making.run_out_mm if frame.characteristic == "run-out" else making.position_mm)
        assert not {"js7"} & {cell for table in sheet.tables for row in table.rows for cell in row}
    lands = [line for line in sheet_as_printed(printed["drum"].sheet("drum"), making).fits if line.code == "js12"]
    counted = {land_band_mm(drive, c.drum_radius_mm, "drum") for c in drive.cables}
    stated = {(b.upper_mm - b.lower_mm) / 4.0 for b in (limits(line.nominal_mm, line.code) for line in lands)}
    assert lands and sorted(stated) == pytest.approx(sorted(counted)), (stated, counted)
    stack = model_tolerances(drive)
    assert stack.drum_eccentricity_m == pytest.approx(making.run_out_mm / 4e3)
    assert stack.input_eccentricity_m == pytest.approx(drive.making.run_out_mm / 4e3)


def test_walls_round_inserts_are_checked() -> None:
    narrow = PRINTED.replace("support: {material: pa12}", "support: {material: pa12, side_wall_mm: 5.7}")
    failed = failing(load_text(narrow, "narrow.yaml"))
    assert "side wall beside a plate screw's insert 1.25 mm (limit at least 1.3)" in failed["wall_holes"]


def test_threads_are_cut_in_metal_whatever_is_asked() -> None:
    text = (ROOT / "params/mbcdm.yaml").read_text("utf-8").replace("threads: cut", "threads: inserts")
    assert load_text(text, "metal.yaml").drive.printing.threads == "inserts"
    assert not [item for item in _bill(text)[2].items if "insert" in item.name]


def test_walls_of_filament_follow_the_nozzle() -> None:
    def least(material: str, nozzle: float) -> float:
        text = PRINTED.replace("pa12", material).replace("{threads: inserts}", f"{{nozzle_mm: {nozzle}}}")
        return load_text(text, "nozzle.yaml").drive.drum_material.min_wall_mm

    assert least("pla", 0.4) == 1.2
    assert least("pla", 0.8) == 1.6
    assert least("pa12", 0.8) == 1.0


@pytest.mark.slow
def test_wider_parts_are_sound_for_a_printer(printed) -> None:
    spec = printed[2].parts["top_plate"]
    solid = with_wider_holes("top_plate", spec.part.solid().wrapped, 0.2)
    mesh = mesh_solid("top_plate", solid, 0.01)
    found = trimesh.Trimesh(mesh.points_mm, mesh.triangles)
    found.merge_vertices()
    assert found.is_watertight
    assert found.volume == pytest.approx(cq.Shape.cast(solid).Volume(), rel=2e-3)
    assert load_design(ROOT / "params/gallery/printed.yaml").drive.printing.hole_allowance_mm == 0.2


PARAMS = Path(__file__).parents[3] / "params"
# Nominal lengths of ISO 2338 to 30 mm; greatest height and width across flats of ISO 4032 by thread.
PIN_LENGTHS_MM = (2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30)
NUTS_MM = {1.6: (1.3, 3.2), 2.0: (1.6, 4.0), 2.5: (2.0, 5.0), 3.0: (2.4, 5.5), 4.0: (3.2, 7.0)}


@pytest.fixture(scope="module")
def metal() -> Drive:
    drive: Drive = load_design(PARAMS / "siso_spur.yaml").drive
    return drive


def test_a_design_of_metal_prints_nothing_unless_asked(metal: Drive) -> None:
    with pytest.raises(
        MbcdmError, match=r"no part is printed \(value milled, turned, limit printed or sintered.*--all"
    ):
        prints_of(metal, Cache(cache_folder()))


def test_only_the_printed_parts_get_a_file(metal: Drive) -> None:
    drive = replace(metal, drum_material=metal.material("pla"))
    assert set(prints_of(drive, Cache(cache_folder()))) == {"drum.3mf"}


@pytest.mark.parametrize("name", ["mbcdm", "siso_bevel", "siso_spur", "miso_spur", "gallery/hip", "gallery/capstan"])
def test_nuts_and_dowels_are_bought_in_sizes_that_their_standards_have(name: str) -> None:
    drive = of_params(name).drive
    bill = layout_of(drive).bill()
    standard = {n: spec.part for n, spec in bill.parts.items() if isinstance(spec.part, StandardPart)}
    assert {"nut", "dowel"} <= set(standard), set(standard)
    assert not set(standard) & set(drawn_parts(drive))
    for part, body in standard.items():
        said = body.designation
        if pin := re.fullmatch(r"ISO 2338 - ([\d.]+) m6 x ([\d.]+)", said):
            assert float(pin[2]) in PIN_LENGTHS_MM and float(pin[1]) == 2 * body.radius, (part, said)  # type: ignore[attr-defined]
        else:
            nut = re.fullmatch(r"ISO 4032 - M([\d.]+)", said)
            assert nut and NUTS_MM[float(nut[1])] == (body.height, body.across_flats), (part, said)  # type: ignore[attr-defined]
        (weighed,) = {item.mass_g for item in bill.items if item.part == part}
        assert weighed == pytest.approx(7.85e-3 * body.volume_mm3(), rel=0.03), (part, weighed)
