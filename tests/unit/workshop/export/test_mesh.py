"""Meshes: the chordal error is within its limit, STL and GLB are valid, and the bytes are reproducible."""

import hashlib
import io
import math
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
import trimesh
from export_samples import make_solids
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.bill import Item
from mbcdm_cad.workshop.export.files import glb_bytes, lying, stl_bytes, threemf_bytes, with_note
from mbcdm_cad.workshop.kernel import brep_bytes, shape_from_brep, validate_faces, validate_solid
from mbcdm_cad.workshop.meshing import angular_tolerance, mesh_solid
from mbcdm_cad.workshop.pairs import Faces, PartShape
from mbcdm_cad.workshop.trianglemesh import TriangleMesh
from tests.support.reference import ROOT

PARTS = sorted(make_solids())
TOLERANCE_MM = 0.02


@pytest.fixture(scope="module")
def meshes(solids: dict[str, cq.Solid]) -> dict[str, TriangleMesh]:
    return {part: mesh_solid(part, solid, TOLERANCE_MM) for part, solid in solids.items()}


def _distances(solid: cq.Solid, places: np.ndarray) -> np.ndarray:
    """Distance of each place to the nearest point of the solid's surface, by the kernel's own search."""
    shell = solid.Shells()[0]
    return np.array([shell.distance(cq.Vertex.makeVertex(*place)) for place in places.tolist()])


@pytest.mark.parametrize("part", PARTS)
def test_error_is_held_where_the_kernel_looks_for_itself(
    part: str, solids: dict[str, cq.Solid], meshes: dict[str, TriangleMesh]
) -> None:
    corners = meshes[part].corners_mm
    chosen = corners[np.random.default_rng(1).choice(len(corners), size=min(120, len(corners)), replace=False)]
    middles = np.concatenate((chosen.mean(axis=1), (chosen + np.roll(chosen, 1, axis=1)).reshape(-1, 3)[::3] / 2.0))
    worst = _distances(solids[part], middles).max()
    assert worst <= TOLERANCE_MM, f"{part}: a triangle is {worst:.4f} mm from the surface, limit {TOLERANCE_MM}"
    found = meshes[part].deviation_mm
    assert worst <= 1.02 * found + 1e-7, f"{part}: the mesh says {found:.5f} mm, the kernel finds {worst:.5f}"
    assert found <= TOLERANCE_MM


@pytest.mark.parametrize("part", PARTS)
def test_points_lie_on_the_solid(part: str, solids: dict[str, cq.Solid], meshes: dict[str, TriangleMesh]) -> None:
    worst = _distances(solids[part], meshes[part].points_mm[::7]).max()
    assert worst < 1e-5, f"{part}: a point of the mesh is {worst:.2e} mm off the surface"


@pytest.mark.parametrize("part", PARTS)
def test_stl_is_watertight_and_close(part: str, solids: dict[str, cq.Solid], meshes: dict[str, TriangleMesh]) -> None:
    read = trimesh.load(io.BytesIO(stl_bytes(part, meshes[part])), file_type="stl")
    assert read.is_watertight, f"{part}: trimesh finds gaps"
    assert read.is_winding_consistent
    assert read.volume == pytest.approx(meshes[part].volume_mm3, rel=1e-5)
    # No volume lies farther from the solid than the tolerance: |error| <= area x deviation.
    error, bound = abs(read.volume - solids[part].Volume()), solids[part].Area() * meshes[part].deviation_mm
    assert error <= bound + 1e-6 * solids[part].Volume(), f"{part}: volume off by {error:.3g} mm^3, limit {bound:.3g}"


@pytest.mark.parametrize("part", PARTS)
def test_triangles_and_normals_face_outwards(part: str, meshes: dict[str, TriangleMesh]) -> None:
    corners = meshes[part].corners_mm
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    least = float(np.einsum("ij,ij->i", facets, meshes[part].normals[meshes[part].triangles].mean(axis=1)).min())
    assert least > 0.85, f"{part}: a normal of the surface is {math.degrees(math.acos(least)):.0f} deg off its triangle"


def test_known_volumes_of_meshes(solids: dict[str, cq.Solid]) -> None:
    cube = mesh_solid("cube", cq.Workplane().box(3, 4, 5).val(), 0.1)
    assert cube.volume_mm3 == pytest.approx(60.0, rel=1e-12)
    assert (len(cube.triangles), len(cube.edges), cube.deviation_mm) == (12, 12, 0.0)


def test_open_mesh_is_seen() -> None:
    cube = mesh_solid("cube", cq.Workplane().box(3, 4, 5).val(), 0.1)
    assert len(cube.open_edges_mm()) == 0
    gaps = replace(cube, triangles=cube.triangles[1:]).open_edges_mm()
    assert len(gaps) == 3, f"a missing triangle leaves 3 open edges, not {len(gaps)}"
    turned = cube.triangles.copy()
    turned[0] = turned[0, ::-1]
    assert len(replace(cube, triangles=turned).open_edges_mm()) > 0


def test_open_shell_is_refused() -> None:
    shell = cq.Shell.makeShell(cq.Workplane().box(3, 4, 5).val().Faces()[1:])
    with pytest.raises(GeometryError, match=r"lid: mesh is not watertight at .* and 3 other places"):
        mesh_solid("lid", shell, 0.1)


def test_part_that_touches_itself_is_refused() -> None:
    """A hole exactly as wide as the plate is thick leaves two bodies that meet in a line: valid to the kernel."""
    plate = cq.Workplane().box(20, 20, 3).faces(">Y").workplane().hole(3, 10).val().Solids()[0]
    assert plate.isValid()
    with pytest.raises(GeometryError, match=r"touch itself along a line"):
        mesh_solid("plate", plate, 0.01)


@pytest.mark.parametrize("tolerance_mm", [0.0, -1.0, math.nan, math.inf])
def test_senseless_tolerance_is_refused(tolerance_mm: float, solids: dict[str, cq.Solid]) -> None:
    with pytest.raises(ValueError, match="mesh tolerance must be positive"):
        mesh_solid("disc", solids["disc"], tolerance_mm)


@given(st.floats(1e-5, 10.0))
def test_angle_keeps_an_arc_of_1_mm_within_the_tolerance(tolerance_mm: float) -> None:
    angle = angular_tolerance(tolerance_mm)
    sagitta = 1.0 - math.cos(angle / 2.0)
    assert sagitta <= tolerance_mm * (1 + 1e-9) or angle == 0.05, f"{sagitta} > {tolerance_mm}"


@settings(max_examples=15, deadline=None)
@given(st.floats(0.3, 60.0), st.floats(0.5, 30.0), st.floats(0.002, 0.2))
def test_error_of_any_cylinder_is_held(radius_mm: float, height_mm: float, tolerance_mm: float) -> None:
    mesh = mesh_solid("rod", cq.Solid.makeCylinder(radius_mm, height_mm), tolerance_mm)
    radii = np.hypot(*mesh.corners_mm.mean(axis=1).T[:2])
    side = np.abs(mesh.normals[mesh.triangles[:, 0], 2]) < 0.5
    depth = radius_mm - radii[side].min()
    assert depth <= tolerance_mm, f"r {radius_mm}: triangles {depth} mm inside, limit {tolerance_mm}"


def test_solid_keeps_no_mesh(solids: dict[str, cq.Solid]) -> None:
    coarse_first = mesh_solid("disc", solids["disc"], 0.1)
    fine = mesh_solid("disc", solids["disc"], 0.01)
    coarse_again = mesh_solid("disc", solids["disc"], 0.1)
    assert len(fine.triangles) > len(coarse_first.triangles)
    assert stl_bytes("disc", coarse_again) == stl_bytes("disc", coarse_first)


def test_stored_solid_gives_the_same_stl(solids: dict[str, cq.Solid], meshes: dict[str, TriangleMesh]) -> None:
    for part in PARTS:
        stored = mesh_solid(part, shape_from_brep(brep_bytes(solids[part])), TOLERANCE_MM)
        assert stl_bytes(part, stored) == stl_bytes(part, meshes[part]), part


def test_stored_mesh_gives_the_same_files(items: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    stored = {part: TriangleMesh.from_bytes(mesh.to_bytes()) for part, mesh in meshes.items()}
    assert glb_bytes("model", items, stored) == glb_bytes("model", items, meshes)
    assert stored["disc"].deviation_mm == meshes["disc"].deviation_mm


_ELSEWHERE = f"""
import hashlib, random, sys
sys.path[:0] = sys.argv[1:]
from export_samples import make_items, make_solids
from mbcdm_cad.workshop.export.files import glb_bytes
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.export.files import stl_bytes
items = make_items()[::-1]
meshes = {{part: mesh_solid(part, solid, {TOLERANCE_MM}) for part, solid in reversed(make_solids().items())}}
digest = hashlib.sha256(glb_bytes("model", items, meshes))
for part in sorted(meshes):
    digest.update(stl_bytes(part, meshes[part]))
print(digest.hexdigest())
"""


def test_same_bytes_in_another_process(items: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    digest = hashlib.sha256(glb_bytes("model", items, meshes))
    for part in PARTS:
        digest.update(stl_bytes(part, meshes[part]))
    paths = [str(Path(__file__).parents[4]), str(Path(__file__).parent)]
    done = subprocess.run([sys.executable, "-c", _ELSEWHERE, *paths], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == digest.hexdigest()


def test_note_in_the_stl_header(meshes: dict[str, TriangleMesh]) -> None:
    plain, noted = stl_bytes("disc", meshes["disc"]), stl_bytes("disc", meshes["disc"], "FORCED: mass")
    assert noted[:80].startswith(b"mbcdm_cad disc (mm); FORCED: mass")
    assert noted[80:] == plain[80:]
    assert with_note(plain, "disc", "FORCED: mass") == noted
    assert len(stl_bytes("disc", meshes["disc"], "x" * 300)) == len(plain)


def test_glb_is_in_metres_with_y_up(
    items: list[Item], solids: dict[str, cq.Solid], meshes: dict[str, TriangleMesh]
) -> None:
    scene = trimesh.load(io.BytesIO(glb_bytes("model", items, meshes)), file_type="glb")
    assert set(scene.geometry) == set(meshes), "one mesh a part"
    nodes = scene.graph.nodes_geometry
    assert set(nodes) == {item.name for item in items}
    for item in items:
        turn, geometry = scene.graph[item.name]
        assert geometry == item.part
        mesh = scene.geometry[geometry]
        found = trimesh.transform_points(mesh.vertices, turn) * 1e3
        expected = item.location.apply(meshes[item.part].points_mm)
        low, high = expected.min(axis=0), expected.max(axis=0)
        upright = np.array([[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]])
        assert np.abs(np.array([found.min(axis=0), found.max(axis=0)]) - upright).max() < 1e-4, item.name
        assert mesh.volume * 1e9 == pytest.approx(meshes[item.part].volume_mm3, rel=1e-5)
        colour = np.array(mesh.visual.material.baseColorFactor)[:3] / 255.0
        assert colour == pytest.approx(item.material.colour, abs=1 / 255), item.name
        assert mesh.visual.material.name == item.material.name


def test_glb_does_not_depend_on_the_order(items: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    assert glb_bytes("model", items[::-1], dict(reversed(meshes.items()))) == glb_bytes("model", items, meshes)


# 3MF files read back by another program: unit, name, watertight, volume, lying on the bed; the same bytes twice.


_DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
_BILL = layout_of(_DRIVE).bill()
MADE = tuple(dict.fromkeys(item.part for item in _BILL.items if item.kind == "made"))


@pytest.mark.parametrize("name", MADE)
def test_read_back(name: str) -> None:
    spec = _BILL.parts[name]
    solid = spec.part.solid()
    data = threemf_bytes(name, mesh_solid(name, solid.wrapped, 0.02))
    assert data == threemf_bytes(name, mesh_solid(name, solid.copy(mesh=False).wrapped, 0.02))
    scene = trimesh.load(io.BytesIO(data), file_type="3mf")
    assert isinstance(scene, trimesh.Scene)
    assert scene.units in ("mm", "millimeter", "millimeters")
    (found,) = scene.geometry.values()
    text = zipfile.ZipFile(io.BytesIO(data)).read("3D/3dmodel.model").decode()
    assert f'name="{name}"' in text
    assert 'unit="millimeter"' in text
    assert found.is_watertight
    assert found.volume == pytest.approx(solid.Volume(), rel=1e-2)  # a stop of 2 mm, meshed to 0.02 mm
    low, high = found.bounds
    assert low[2] == pytest.approx(0.0, abs=1e-4)
    assert (low + high)[:2] == pytest.approx((0.0, 0.0), abs=1e-4)


def test_lies_on_its_largest_flat_face() -> None:
    """A T of which the top is larger than the foot is turned over."""
    shape = cq.Workplane().box(4, 4, 10).faces(">Z").workplane().box(20, 20, 2, centered=(True, True, False))
    mesh = mesh_solid("t", shape.val().wrapped, 0.05)
    assert np.array_equal(lying(mesh)[2], (0.0, 0.0, -1.0))


def test_rotation_is_proper() -> None:
    for plane in ("XY", "YZ", "XZ"):
        mesh = mesh_solid("plate", cq.Workplane(plane).box(10, 8, 1).val().wrapped, 0.05)
        turn = lying(mesh)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        assert np.ptp(mesh.points_mm @ turn[2]) == pytest.approx(1.0)


# One valid solid or a message: each fault that the kernel can produce is made and must be found.


def test_sound_solids_pass(solids: dict[str, cq.Solid]) -> None:
    for part, solid in solids.items():
        validate_solid(part, solid)


def _solid_of(*faces: cq.Face) -> cq.Solid:
    return cq.Solid.makeSolid(cq.Shell.makeShell(faces))


def _inside_out() -> cq.Shape:
    return cq.Shape.cast(cq.Solid.makeBox(1, 1, 1).wrapped.Reversed())


def _crossing() -> cq.Solid:
    """Closed and valid to the kernel, but the hole pierces the wall of the block."""
    outer = cq.Solid.makeBox(10, 10, 10).Shells()[0]
    hole = cq.Shape.cast(cq.Solid.makeBox(4, 4, 4, cq.Vector(8, 3, 3)).Shells()[0].wrapped.Reversed())
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid

    return cq.Solid(BRepBuilderAPI_MakeSolid(outer.wrapped, hole.wrapped).Solid())


FAULTS = {
    "compound": (lambda: cq.Compound.makeCompound([cq.Solid.makeBox(1, 1, 1)]), "a Compound of 1 solids, must be one"),
    "two solids": (
        lambda: cq.Workplane().box(9, 1, 1).cut(cq.Workplane().box(3, 3, 3)).val(),
        "a Compound of 2 solids, must be one Solid",
    ),
    "empty cut": (lambda: cq.Workplane().box(1, 1, 1).cut(cq.Workplane().box(2, 2, 2)).val(), "0 solids"),
    "face": (lambda: cq.Face.makePlane(1, 1), "a Face of 0 solids"),
    "open": (lambda: _solid_of(*cq.Solid.makeBox(1, 1, 1).Faces()[1:]), "open"),
    "inside out": (_inside_out, "inside out"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_found(fault: str) -> None:
    make, message = FAULTS[fault]
    with pytest.raises(GeometryError, match=f"drum: .*({message})"):
        validate_solid("drum", make())


def test_null_shape() -> None:
    with pytest.raises(GeometryError, match="no shape at all"):
        validate_solid("drum", None)


def test_faces_that_cut_each_other_are_found_apart() -> None:
    validate_solid("drum", _crossing())
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        validate_faces("drum", _crossing())


def test_edges_find_them_in_parts_of_many_swept_faces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three grooves of many turns: all their faces against each other would take minutes."""
    monkeypatch.setattr("mbcdm_cad.workshop.kernel._MOST_SWEPT", -1)
    validate_faces("block", cq.Workplane().box(4, 4, 4).cut(cq.Workplane().box(1, 1, 9)).val())
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        validate_faces("drum", _crossing())


def test_the_interference_run_looks_for_them() -> None:
    shape = _crossing()
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        Faces("drum", PartShape("key", np.zeros((2, 3)), lambda: shape)).test()
