"""Tables of holes compared with the cylinders of the solids: every listed hole exists, every small hole is listed."""

from math import pi, radians
from typing import Any

import cadquery as cq
import numpy as np
import pytest
import trimesh
import vtk
import yaml
from hypothesis import given
from hypothesis import strategies as st
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import Bill, Placement
from mbcdm_cad.parts.bodies import CableRod, screw_places
from mbcdm_cad.parts.fits import FITS, limits, thread
from mbcdm_cad.parts.motor_head.part import MotorHead
from mbcdm_cad.routes.curves import Arc, Coil, Line
from mbcdm_cad.workshop.kernel import bounding_box
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.trianglemesh import rod_mesh
from tests.support.reference import PARAMS

PARTS = ("collar", "drum", "frame", "top_plate")
# Round holes of these that a table of another kind gives: bores that are dimensioned in a view.
BORES = {"collar": 1, "drum": 1, "frame": 4, "top_plate": 0}


def _bores(solid: cq.Solid) -> dict[tuple[float, ...], float]:
    """Radius, direction and nearest point to the origin of the axis of every hollow cylinder; how far round it goes."""
    walls: dict[tuple[float, ...], float] = {}
    for face in solid.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() != GeomAbs_Cylinder:
            continue
        cylinder = surface.Cylinder()
        place, way = cylinder.Axis().Location(), cylinder.Axis().Direction()
        at, along = np.array([place.X(), place.Y(), place.Z()]), np.array([way.X(), way.Y(), way.Z()])
        normal = np.array(face.normalAt(cq.Vector(*face.Vertices()[0].toTuple())).toTuple())
        vertex = np.array(face.Vertices()[0].toTuple())
        outward = vertex - at - along * ((vertex - at) @ along)
        if normal @ outward > 0.0:
            continue  # a shaft, not a hole
        along = along * (1.0 if along[np.argmax(np.abs(along))] > 0 else -1.0)
        foot = at - along * (at @ along)
        key = tuple(float(v) for v in np.round([cylinder.Radius(), *along, *foot], 5) + 0.0)
        walls[key] = walls.get(key, 0.0) + abs(surface.LastUParameter() - surface.FirstUParameter())
    return walls


def _told(groups: list[dict[str, Any]]) -> list[tuple[str, float, np.ndarray]]:
    found = []
    for group in groups:
        for place in group["places_mm"]:
            found.append((group["hole"], group["diameter_mm"] / 2, np.array(place)))
            if group["counterbore"]:
                found.append((group["hole"] + " counterbore", group["counterbore"]["diameter_mm"] / 2, np.array(place)))
    return found


def _passes(bore: tuple[float, ...], radius: float, place: np.ndarray) -> bool:
    along, foot = np.array(bore[1:4]), np.array(bore[4:])
    along /= np.linalg.norm(along)  # rounded, as a key
    off = place - foot
    return abs(bore[0] - radius) < 1e-4 and float(np.linalg.norm(off - along * (off @ along))) < 1e-4


@pytest.mark.parametrize("part", PARTS)
def test_holes_told_are_the_solid_s(part: str, centred: Bill, solids: dict[str, cq.Solid]) -> None:
    bores, told = _bores(solids[part]), _told(centred.holes()[part])
    for name, radius, place in told:
        assert any(_passes(bore, radius, place) for bore in bores), f"{part} {name}: no hole of {2 * radius:g} there"
    # Other holes may cut into one; corners of pockets go a quarter round.
    whole = [bore for bore, turned in bores.items() if turned > 1.9 * pi]
    untold = [bore for bore in whole if not any(_passes(bore, radius, place) for _, radius, place in told)]
    assert len(untold) <= BORES[part], f"{part}: holes that no table gives: {untold}"


def test_each_tapped_hole_has_its_drill(centred: Bill) -> None:
    for part, groups in centred.holes().items():
        for group in groups:
            if group["thread"]:
                assert 0.6 < group["tap_drill_mm"] / group["diameter_mm"] < 0.9, (part, group)


@pytest.mark.parametrize("part", ["collar", "drum", "frame"])
def test_drilled_for_tapping_the_holes_have_the_drill_s_diameter(part: str, centred: Bill) -> None:
    spec = centred.parts[part]
    assert spec.drilled is not None
    bores = _bores(spec.drilled.solid())
    for group in centred.holes()[part]:
        if group["thread"]:
            for place in group["places_mm"]:
                drill, major = group["tap_drill_mm"] / 2, group["diameter_mm"] / 2
                assert any(_passes(bore, drill, np.array(place)) for bore in bores), (part, group["hole"])
                assert not any(_passes(bore, major, np.array(place)) for bore in bores), (part, group["hole"])


def test_every_part_with_a_tapped_hole_can_be_drilled(centred: Bill) -> None:
    tapped = {part for part, groups in centred.holes().items() if any(group["thread"] for group in groups)}
    assert tapped == {name for name, spec in centred.parts.items() if spec.drilled is not None}


# Nominal: pitch, d2, D1, tap drill, stress area (ISO 261, 724, 2306, 898-1).
PRINTED = {
    1.6: (0.35, 1.373, 1.221, 1.25, 1.27),
    2.0: (0.4, 1.740, 1.567, 1.6, 2.07),
    2.5: (0.45, 2.208, 2.013, 2.05, 3.39),
    3.0: (0.5, 2.675, 2.459, 2.5, 5.03),
    4.0: (0.7, 3.545, 3.242, 3.3, 8.78),
    6.0: (1.0, 5.350, 4.917, 5.0, 20.1),
    8.0: (1.25, 7.188, 6.647, 6.8, 36.6),
    12.0: (1.75, 10.863, 10.106, 10.2, 84.3),
}


@pytest.mark.parametrize("nominal", sorted(PRINTED))
def test_printed_values(nominal: float) -> None:
    found, (pitch, d2, d1, drill, area) = thread(nominal), PRINTED[nominal]
    assert found.pitch_mm == pitch
    assert found.pitch_diameter_mm == pytest.approx(d2, abs=6e-4)
    assert found.tap_drill_mm == drill
    assert d1 < drill < nominal - 0.5 * pitch, "the tap drill leaves thread and clears its root"
    assert found.stress_area_mm2 == pytest.approx(area, rel=5e-3)


def test_names() -> None:
    assert thread(2.0).name == "M2"
    with pytest.raises(ValueError, match=r"M2\.7"):
        thread(2.7)


def test_depths() -> None:
    found = thread(2.0)
    assert found.full_thread_mm(4.9) == pytest.approx(4.1)


# One size inside each range; ISO 286-2:2010.
PRINTED_FITS = {
    ("h5", 8.0): (0, -6),
    ("h6", 4.0): (0, -8),
    ("h6", 50.0): (0, -16),
    ("h7", 25.0): (0, -21),
    ("h8", 16.0): (0, -27),
    ("h9", 100.0): (0, -87),
    ("g6", 3.0): (-2, -8),
    ("g6", 5.0): (-4, -12),
    ("g6", 12.0): (-6, -17),
    ("g6", 60.0): (-10, -29),
    ("f7", 8.0): (-13, -28),
    ("f7", 40.0): (-25, -50),
    ("k5", 8.0): (7, 1),
    ("k5", 20.0): (11, 2),
    ("k6", 10.0): (10, 1),
    ("k6", 100.0): (25, 3),
    ("m6", 2.0): (8, 2),
    ("m6", 5.0): (12, 4),
    ("m6", 16.0): (18, 7),
    ("n6", 10.0): (19, 10),
    ("n6", 30.0): (28, 15),
    ("p6", 6.0): (20, 12),
    ("p6", 80.0): (51, 32),
    ("js6", 5.0): (4, -4),
    ("js6", 8.0): (4.5, -4.5),
    ("js7", 20.0): (10, -10),
    ("H6", 16.0): (11, 0),
    ("H7", 3.0): (10, 0),
    ("H7", 4.0): (12, 0),
    ("H7", 9.0): (15, 0),
    ("H7", 120.0): (35, 0),
    ("H8", 30.0): (33, 0),
    ("H9", 50.0): (62, 0),
    ("H10", 5.0): (48, 0),
    ("H11", 18.0): (110, 0),
    ("G7", 2.0): (12, 2),
    ("G7", 16.0): (24, 6),
    ("J7", 5.0): (6, -6),
    ("J7", 16.0): (10, -8),
    ("J7", 47.0): (14, -11),
    ("K7", 2.0): (0, -10),
    ("K7", 8.0): (5, -10),
    ("K7", 22.0): (6, -15),
    ("K7", 110.0): (10, -25),
    ("M7", 3.0): (-2, -12),
    ("M7", 8.0): (0, -15),
    ("M7", 60.0): (0, -30),
    ("N7", 3.0): (-4, -14),
    ("N7", 9.0): (-4, -19),
    ("N7", 16.0): (-5, -23),
    ("N7", 90.0): (-10, -45),
    ("P7", 2.0): (-6, -16),
    ("P7", 16.0): (-11, -29),
    ("P7", 40.0): (-17, -42),
    ("P7", 100.0): (-24, -59),
    ("K6", 5.0): (2, -6),
    ("M6", 5.0): (-1, -9),
    ("H7", 130.0): (40, 0),
    ("h6", 200.0): (0, -29),
    ("g6", 300.0): (-17, -49),
    ("K7", 150.0): (12, -28),
    ("K7", 450.0): (18, -45),
    ("J7", 200.0): (30, -16),
    ("M6", 300.0): (-9, -41),
    ("M7", 300.0): (0, -52),
    ("N7", 200.0): (-14, -60),
    ("P7", 130.0): (-28, -68),
    ("js7", 128.79): (20, -20),
}


@pytest.mark.parametrize(("code", "nominal"), sorted(PRINTED_FITS), ids=lambda v: str(v))
def test_printed_limits(code: str, nominal: float) -> None:
    found = limits(nominal, code)
    assert (round(found.upper_mm * 1e3, 6), round(found.lower_mm * 1e3, 6)) == PRINTED_FITS[code, nominal]


@given(st.floats(1.0, 500.0), st.sampled_from("fghkmnp"), st.sampled_from([6, 7]))
def test_shaft_and_hole_of_one_letter_fit_alike(nominal: float, letter: str, grade: int) -> None:
    """Shaft x6 in hole H7 has the same play as hole X7 on shaft h6: the rule by which ISO 286 sets K to P."""
    if letter in "kmnp" and nominal <= 3.0:
        return
    shaft, hole = limits(nominal, f"{letter}6"), limits(nominal, f"{letter.upper()}7")
    play_on_hole_basis = limits(nominal, "H7").upper_mm - shaft.lower_mm
    play_on_shaft_basis = hole.upper_mm - limits(nominal, "h6").lower_mm
    assert play_on_hole_basis == pytest.approx(play_on_shaft_basis, abs=1e-9)


@pytest.mark.parametrize("bad", [(0.5, "H7"), (501.0, "h6"), (10.0, "H4x"), (10.0, "x6"), (10.0, "J9"), (10.0, "H99")])
def test_what_is_not_in_the_tables_is_refused(bad: tuple[float, str]) -> None:
    with pytest.raises(ValueError, match=r"fit "):
        limits(*bad)


@given(st.floats(1.0, 500.0))
def test_every_fit_in_use_has_limits(nominal: float) -> None:
    for role, fit in FITS.items():
        found = limits(nominal, fit.code)
        assert found.smallest_mm < found.largest_mm, role
        assert fit.reason, role
        assert fit.source, role


MADE = [
    "frame",
    "top_plate",
    "drum",
    "drum_shaft",
    "guide",
    "guide_axle",
    "guide_spacer",
    "input_pulley_left",
    "input_pulley_right",
    "collar",
    "terminal",
    "stop",
]
# The blunt end of the wedge where a stop's slot leaves its land (parts/input_pulley/part.py); other walls are thicker.
THINNEST_MM = 0.3
SAMPLES = 3000


def tree_of(mesh: trimesh.Trimesh) -> vtk.vtkOBBTree:
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.vertices), deep=True))
    cells = np.column_stack([np.full(len(mesh.faces), 3), mesh.faces]).astype(np.int64).ravel()
    triangles = vtk.vtkCellArray()
    triangles.ImportLegacyFormat(numpy_to_vtkIdTypeArray(cells, deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(points)
    surface.SetPolys(triangles)
    tree = vtk.vtkOBBTree()
    tree.SetDataSet(surface)
    tree.BuildLocator()
    tree.surface = surface  # the tree holds it by a bare pointer
    return tree


def thinnest_wall(solid: cq.Solid) -> tuple[float, np.ndarray]:
    """Least distance from a surface point along the inward normal to a face that looks the other way, and where."""
    vertices, faces = solid.copy(mesh=False).tessellate(0.01, 0.1)
    mesh = trimesh.Trimesh([v.toTuple() for v in vertices], faces)
    points, of_face = trimesh.sample.sample_surface(mesh, SAMPLES, seed=1)
    inward = -mesh.face_normals[of_face]
    tree, best, place = tree_of(mesh), np.inf, np.zeros(3)
    crossings, hit = vtk.vtkPoints(), vtk.vtkIdList()
    for point, normal in zip(points, inward, strict=True):
        tree.IntersectWithLine(point + 1e-3 * normal, point + 1.5 * normal, crossings, hit)
        for k in range(crossings.GetNumberOfPoints()):
            depth = float(np.linalg.norm(np.array(crossings.GetPoint(k)) - point))
            if depth < best and mesh.face_normals[hit.GetId(k)] @ normal > 0.9:
                best, place = depth, point
    return best, place


@pytest.mark.parametrize("name", MADE)
def test_no_wall_is_thinner_than_can_be_made(solids: dict[str, cq.Solid], name: str) -> None:
    wall, place = thinnest_wall(solids[name])
    assert wall >= THINNEST_MM, f"{name}: {wall:.3f} mm at {np.round(place, 2)}"


def test_the_probe_finds_a_thin_wall() -> None:
    """A block with a pocket that leaves 0.2 mm."""
    block = cq.Workplane().box(10, 10, 10).cut(cq.Workplane().box(4, 4, 20).translate((2.8, 0, 0))).val()
    wall, place = thinnest_wall(block.Solids()[0])
    assert wall == pytest.approx(0.2, abs=1e-6) and place[0] > 4.7


@pytest.mark.parametrize("turn", [0.0, 35.0, -110.0])
@pytest.mark.parametrize("name", ["siso_spur", "siso_bevel", "miso_spur"])
def test_threads_are_behind_the_holes(name: str, turn: float) -> None:
    data = yaml.safe_load((PARAMS / f"{name}.yaml").read_text("utf-8"))
    data["drive"]["gearhead_angle_deg"] = turn
    drive = load_text(yaml.safe_dump(data)).drive
    bill = layout_of(drive).bill()
    face = drive.gearhead
    heads = [item for item in bill.items if item.part == "motor_head"]
    mounted = [item for item in bill.items if item.name.startswith(f"{drive.mounted}_") and item.kind == "bought"]
    mounted = [item for item in mounted if "screw" not in item.name]
    assert len(heads) == len(mounted) == len(drive.input_names)
    local = [(x, y, 0.0) for x, y in screw_places(face.screw_count, face.bolt_circle_mm / 2)]
    threads = np.concatenate([item.location.apply(np.array(local)) for item in mounted])
    holes = []
    for item in heads:
        head = bill.parts[item.part].part
        assert isinstance(head, MotorHead)
        dims = head.dims
        holes.append(item.location.apply(np.array([(x, y, dims.top_z) for x, y in dims.gear_screws])))
    apart = np.linalg.norm(threads[:, None] - np.concatenate(holes)[None], axis=2).min(axis=1)
    assert apart.max() < 1e-6, apart


@pytest.mark.parametrize("angle_deg", [-35.0, 0.0, 35.0])
def test_volume_is_section_times_length(dims: BevelLayout, angle_deg: float) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(radians(angle_deg)):
        rod = CableRod(path.line, radius).solid()
        assert rod.isValid()
        error = rod.Volume() / (pi * radius**2 * path.length_mm) - 1
        assert abs(error) < 1e-5, f"{path.cable.name} at {angle_deg:+g} deg: {error:+.2e}"


def test_rod_lies_round_its_centre_line(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(0.0):
        points = path.sample(0.05)
        low, high = bounding_box(solids[path.cable.name])
        assert np.all(np.array(low) > points.min(axis=0) - radius - 1e-3), path.cable.name
        assert np.all(np.array(high) < points.max(axis=0) + radius + 1e-3), path.cable.name


def test_ends_are_flat_discs_in_stop_and_terminal(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(0.0):
        ends = [path.pieces[0][1].points(np.array([0.0]))[0], path.pieces[-1][1].points(np.array([1.0]))[0]]
        discs = [f for f in solids[path.cable.name].Faces() if f.geomType() == "PLANE"]
        assert len(discs) == 2, f"{path.cable.name}: {len(discs)} plane faces"
        for disc in discs:
            assert disc.Area() == pytest.approx(pi * radius**2, rel=1e-6)
            centre = np.array(disc.Center().toTuple())
            assert min(np.linalg.norm(centre - end) for end in ends) < 1e-6


def test_a_bend_tighter_than_the_rope_is_refused() -> None:
    """The kernel would sweep it into a solid that crosses itself, on which a mesh never becomes fine enough."""
    straight = Line((0.0, 0.0, -5.0), (0.0, 0.0, 0.0))
    bend = Arc((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0, 0.0, pi / 2)
    assert CableRod((straight, bend), 0.99).solid().Volume() == pytest.approx(pi * 0.99**2 * (5.0 + pi / 2), rel=1e-6)
    with pytest.raises(ValueError, match="a bend of 1 mm is too tight for a rod of 1 mm radius"):
        CableRod((straight, bend), 1.0).solid()


def test_a_long_winding_is_drawn_in_parts_that_can_be_meshed() -> None:
    """One winding of this length, drawn as one face, kept the mesher busy without end (a drum of 104 mm radius)."""
    winding = Coil((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 103.9, 1.609, 0.182, -3.95, -2.44)
    rod = CableRod((winding,), 0.405).solid()
    walls = [face for face in rod.Faces() if face.geomType() != "PLANE"]
    assert len(walls) == 4, f"{len(walls)} faces along {winding.length_mm:.0f} mm"
    volume = mesh_solid("cable", rod, 0.02).volume_mm3
    assert volume == pytest.approx(pi * 0.405**2 * winding.length_mm, rel=0.03)


@pytest.mark.slow
def test_the_mesh_of_a_rope_is_as_coarse_as_a_rope_is_rough(dims: BevelLayout) -> None:
    """Closed, at the kernel's solid within a twentieth of the radius, and a small share of the kernel's triangles."""
    radius, (path, *_) = dims.drive.cable.diameter_mm / 2, dims.cable_paths(0.0)
    mesh, solid = rod_mesh(path.line, radius, 0.05 * radius), CableRod(path.line, radius).solid()
    assert len(mesh.open_edges_mm()) == 0
    assert mesh.deviation_mm <= 0.05 * radius
    assert 0.95 < mesh.volume_mm3 / solid.Volume() < 1.0, "chords lie inside"
    fine = mesh_solid("cable", solid.wrapped, 0.01)
    low, high = mesh.box_mm(Placement.identity())
    for mine, others in ((low, fine.points_mm.min(axis=0)), (high, fine.points_mm.max(axis=0))):
        assert np.abs(mine - others).max() < 0.05 * radius + 0.01
    assert len(mesh.triangles) < 0.35 * len(fine.triangles), (len(mesh.triangles), len(fine.triangles))
    edges = mesh.points_mm[mesh.triangles]
    outward = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    assert np.all((outward * mesh.normals[mesh.triangles].mean(axis=1)).sum(axis=1) > 0.0), "normals point outward"
