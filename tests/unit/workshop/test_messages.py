"""Messages of a build during the work and for a part that cannot be drawn; messages that must not appear.

Mass properties of a rod from its centre line: against closed forms, and against the kernel's of the drawn cable.

A process that is forked after its parent used the kernel must not wait for threads that do not exist in it.
"""

import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin, sqrt
from pathlib import Path
from types import SimpleNamespace

import cadquery as cq
import numpy as np
import pytest
import trimesh

from mbcdm_cad.checks.size import overhang_check, printed_walls_check
from mbcdm_cad.cli.group import progress
from mbcdm_cad.design.bought import Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import GeometryError, MbcdmError
from mbcdm_cad.jobs import build as job
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.parts.bill import CABLE, Item, Placement, Vector
from mbcdm_cad.parts.fits import limits
from mbcdm_cad.parts.making import PRINTED_MM, body_accuracy, land_band_mm, model_tolerances, sheet_as_printed
from mbcdm_cad.parts.part import StandardPart
from mbcdm_cad.routes.curves import Arc, Line
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.workshop import pictures
from mbcdm_cad.workshop.drawings import drawn_parts
from mbcdm_cad.workshop.kernel import measure
from mbcdm_cad.workshop.mass import rod_shape
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pictures import EXPLODED, exploded, transfer_section
from mbcdm_cad.workshop.prints import overhang_mm2, prints_of, round_holes, thinnest_wall, with_wider_holes
from tests.support.checked import failing, of_params
from tests.support.reference import DRIVE, PARAMS, ROOT

DESIGN = ROOT / "params" / "mbcdm.yaml"

_STEP_WITHOUT_CADQUERY = """
import sys
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from mbcdm_cad.workshop.export.step import part_step
from mbcdm_cad.layouts.loader import load_design
from pathlib import Path
material = load_design(Path(sys.argv[1])).drive.material("steel")
assert len(part_step("box", BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), material)) > 1000
assert "cadquery" not in sys.modules, "the test shows nothing: cadquery silences the kernel too"
"""


def test_the_kernel_writes_no_statistics_to_standard_output() -> None:
    code = [sys.executable, "-c", _STEP_WITHOUT_CADQUERY, str(DESIGN)]
    done = subprocess.run(code, cwd=ROOT, env={"PYTHONPATH": str(ROOT)}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "", done.stdout[:300]


def test_a_part_that_cannot_be_drawn_is_put_down_to_the_checks_that_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A forced build names the checks that failed; one that passed them all asks for the design file."""

    def fails(*_: object) -> None:
        raise GeometryError("drum: cannot be drawn with these dimensions")

    monkeypatch.setattr(job, "made_parts", fails)
    with pytest.raises(GeometryError, match=r"^drum: cannot be drawn with these dimensions; .*please report"):
        build(load_design(DESIGN), tmp_path, cache=Cache(None))
    changed = tmp_path / "changed.yaml"
    text = DESIGN.read_text("utf-8")
    assert text.count("  preload_N: 70.0 ") == 1
    changed.write_text(text.replace("  preload_N: 70.0 ", "  preload_N: 700.0 "), "utf-8")
    with pytest.raises(GeometryError, match=r"although checks fail \([a-z_0-9, .]+\): their messages"):
        build(load_design(changed), tmp_path, cache=Cache(None), force=True)


def test_progress_is_one_line_a_stage_where_it_is_piped(capsys: pytest.CaptureFixture[str]) -> None:
    with progress() as note:
        note("frame, drum")
        note("interference at 9 poses")
    said = capsys.readouterr()
    assert said.err == "making frame, drum\nmaking interference at 9 poses\n" and said.out == ""


def test_straight_rod_has_the_inertia_of_a_cylinder() -> None:
    length, radius = 40.0, 3.0
    shape = rod_shape([Line((1.0, 2.0, -20.0), (1.0, 2.0, 5.0)), Line((1.0, 2.0, 5.0), (1.0, 2.0, 20.0))], radius)
    volume = pi * radius**2 * length
    assert shape.volume_mm3 == pytest.approx(volume)
    assert shape.area_mm2 == pytest.approx(2 * pi * radius * (length + radius))
    assert shape.centroid_mm == pytest.approx((1.0, 2.0, 0.0))
    across, along = volume * (3 * radius**2 + length**2) / 12, volume * radius**2 / 2
    # The rod is summed as 96 slices, which are points along it.
    assert np.diag(shape.inertia_mm5) == pytest.approx([across, across, along], rel=1e-3)


def test_bent_rod_has_the_volume_and_centroid_of_pappus() -> None:
    ring, radius, half = 20.0, 0.5, 1.2
    arc = Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), ring, -half, half)
    shape = rod_shape([arc], radius)
    assert shape.volume_mm3 == pytest.approx(pi * radius**2 * ring * 2 * half)
    # Exact: (R + r^2/(4 R)) sin(a)/a; the line alone has R sin(a)/a.
    exact = (ring + radius**2 / (4 * ring)) * sin(half) / half
    assert shape.centroid_mm[0] == pytest.approx(exact, abs=radius**2 / (4 * ring) * 1.1 + 1e-3)
    assert shape.low_mm[0] == pytest.approx(ring * cos(half) - radius) and shape.high_mm[2] == pytest.approx(radius)


@pytest.mark.parametrize("design", ["mbcdm", "siso_spur"])
def test_cable_has_the_mass_that_the_kernel_finds(design: str) -> None:
    drive = load_design(PARAMS / f"{design}.yaml").drive
    parts = layout_of(drive).bill().parts
    spec = next(spec for name, spec in parts.items() if name.startswith(CABLE))
    line, solid = rod_shape(spec.part.pieces, spec.part.radius), measure(spec.part.solid())
    assert line.volume_mm3 == pytest.approx(solid.volume_mm3, rel=1e-5)
    assert line.centroid_mm == pytest.approx(solid.centroid_mm, abs=0.01)
    assert np.diag(line.inertia_mm5) == pytest.approx(np.diag(solid.inertia_mm5), rel=0.002)
    ends = drive.cable.diameter_mm / 2 + 0.01
    assert np.all(np.array(line.low_mm) <= np.array(solid.low_mm) + 0.02), "the box holds the cable"
    assert line.low_mm + line.high_mm == pytest.approx(solid.low_mm + solid.high_mm, abs=ends)


SCRIPT = """
from mbcdm_cad.workshop import kernel  # as everything of this room that draws does
from mbcdm_cad.parallel.forks import allow_processes, fork_map
import cadquery as cq

def drawn(size):
    return cq.Solid.makeBox(size, 1, 1).cut(cq.Solid.makeSphere(0.5, cq.Vector(0, 0, 0))).Volume()

allow_processes()
here = [drawn(size) for size in (1.0, 2.0)]
assert fork_map(drawn, [1.0, 2.0], 2) == here, here
print("the same", kernel.__name__)
"""


@pytest.mark.slow
def test_a_forked_process_draws_after_its_parent_has_drawn() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0 and "the same" in done.stdout, done.stderr


# Pictures for the assembly: the section is where cables reach the drum, the exploded view separates the parts.


METAL = Material(
    name="metal",
    density_g_cm3=1.0,
    youngs_modulus_GPa=70.0,
    poisson_ratio=0.3,
    yield_MPa=100.0,
    process="milled",
    min_wall_mm=0.5,
    min_internal_radius_mm=0.5,
    colour=(0.5, 0.5, 0.5),
    source="test",
)


def test_the_section_shows_the_plane_through_the_drum_s_axis_and_the_transfer_points() -> None:
    """Of miso_bevel: the plane x = 0, the points at (0, r_g, r_o)."""
    found = transfer_section(layout_of(DRIVE))
    assert found is not None
    centre, normal, half = found
    guide = [c.guide_radius_mm for c in DRIVE.cables]  # type: ignore[attr-defined]
    drum = [c.drum_radius_mm for c in DRIVE.cables]
    assert np.abs(normal) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert centre == pytest.approx([0.0, (min(guide) + max(guide)) / 2, (min(drum) + max(drum)) / 2], abs=1e-6)
    assert half > (max(drum) - min(drum)) / 2


def test_the_exploded_view_keeps_directions_and_multiplies_distances() -> None:
    cube = mesh_solid("cube", cq.Solid.makeBox(2, 2, 2, cq.Vector(-1, -1, -1)), 0.1)
    places = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 3.0]])
    items = [
        Item(f"cube_{n}", "cube", METAL, "made", Placement.translation(*place), "fixed")
        for n, place in enumerate(places.tolist())
    ]
    moved = np.array([item.location.apply(np.zeros((1, 3)))[0] for item in exploded(items, {"cube": cube})])
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    assert moved - middle == pytest.approx((1.0 + EXPLODED) * (places - middle))


def test_each_cable_has_a_colour_of_its_own() -> None:
    items = layout_of(DRIVE).bill().items
    colours = [item.material.colour for item in items if item.name.startswith("cable_")]
    assert len(set(colours)) == len(colours) == 4


def test_cables_keep_their_colours_in_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stood before is grey, what joins is blue, each cable stays as its own."""
    items = [
        Item(name, "cube", METAL, "made", Placement.identity(), "fixed") for name in ("cable_1", "cable_2", "a", "b")
    ]
    seen: dict[str, Vector] = {}

    def fake(shown: list[Item], *_: object, colour_of: Callable[[Item], Vector], cut: object) -> bytes:
        seen.update({item.name: colour_of(item) for item in shown})
        return b"png"

    monkeypatch.setattr("mbcdm_cad.workshop.export.picture.picture_png", fake)
    made = {"cube": SimpleNamespace(files=SimpleNamespace(mesh=None))}
    assert pictures._png(made, items, {"new": frozenset({"cable_2", "b"})}) == b"png"  # type: ignore[arg-type]
    assert seen == {"cable_1": METAL.colour, "cable_2": METAL.colour, "a": pictures.BEFORE, "b": pictures.NEW}


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
