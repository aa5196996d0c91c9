"""No slivers: the distance through the part, from points all over its surface."""

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest
import trimesh
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

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
