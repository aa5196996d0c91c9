"""Mesh solids into triangles with a chordal error that is measured and kept below its limit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.Poly import Poly_Triangulation
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_Orientation
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from mbcdm_cad.build.deviation import edge_deviation, face_deviation
from mbcdm_cad.build.kernel import Shape, kernel_shape
from mbcdm_cad.build.trianglemesh import FloatArray, IntArray, TriangleMesh, without_collapsed
from mbcdm_cad.errors import GeometryError

_ATTEMPTS = 6
# Tolerance given to the kernel, as a share of the required one: on swept surfaces its error is up to 1.1 times that.
_FIRST_SHARE = 0.85
# On swept surfaces the error is sampled; the samples were found to miss up to 1.5 % of the greatest error.
_ACCEPTED_SHARE = 0.97
_ANGLE_RADIUS_MM = 1.0
_ANGLE_LIMITS_RAD = (0.05, 0.5)


def mesh_solid(name: str, solid: Shape, tolerance_mm: float) -> TriangleMesh:
    """The surface of ``solid`` as a watertight mesh with a measured deviation of at most ``tolerance_mm``.

    The solid itself gets no mesh. Raises ``GeometryError`` if the tolerance cannot be kept or the mesh has a gap.
    """
    if not (math.isfinite(tolerance_mm) and tolerance_mm > 0.0):
        raise ValueError(f"mesh tolerance must be positive, got {tolerance_mm} mm")
    linear_mm, angular_rad = kernel_tolerances(tolerance_mm)
    for _ in range(_ATTEMPTS):
        mesh = _triangulated(name, kernel_shape(solid), linear_mm, angular_rad)
        if mesh.deviation_mm <= _ACCEPTED_SHARE * tolerance_mm:
            break
        # The error is proportional to the square of the step, so the angle is reduced by the root of the length's
        # factor.
        shrink = max(0.1, _FIRST_SHARE * tolerance_mm / mesh.deviation_mm)
        linear_mm, angular_rad = linear_mm * shrink, angular_rad * math.sqrt(shrink)
    else:
        raise GeometryError(
            f"{name}: mesh deviates by {mesh.deviation_mm:.4g} mm after {_ATTEMPTS} attempts, "
            f"limit {_ACCEPTED_SHARE * tolerance_mm:g} mm; raise the mesh tolerance"
        )
    gaps = mesh.open_edges_mm()
    if len(gaps):
        x, y, z = gaps[0]
        raise GeometryError(
            f"{name}: mesh is not watertight at ({x:.3f}, {y:.3f}, {z:.3f}) mm and {len(gaps) - 1} other places; is a "
            "face missing there, or does the part touch itself along a line (a hole as wide as its wall is thick)?"
        )
    return mesh


def kernel_tolerances(tolerance_mm: float) -> tuple[float, float]:
    """First tolerances given to the kernel for a mesh within ``tolerance_mm``: a length (mm) and an angle (rad)."""
    return _FIRST_SHARE * tolerance_mm, angular_tolerance(tolerance_mm)


def angular_tolerance(tolerance_mm: float) -> float:
    """Angle in rad between neighbouring chords at which an arc of 1 mm radius has a sagitta of ``tolerance_mm``.

    s = r (1 - cos(a / 2)). For larger arcs the linear tolerance decides, and smaller ones have a smaller sagitta;
    limited to 0.05 to 0.5 rad.
    """
    angle = 2.0 * math.acos(max(-1.0, 1.0 - tolerance_mm / _ANGLE_RADIUS_MM))
    return min(max(angle, _ANGLE_LIMITS_RAD[0]), _ANGLE_LIMITS_RAD[1])


def _triangulated(name: str, shape: TopoDS_Shape, linear_mm: float, angular_rad: float) -> TriangleMesh:
    # The kernel stores a mesh with its shape and does not replace a fine one by a coarser one, so a copy without mesh
    # is used.
    shape = BRepBuilderAPI_Copy(shape, True, False).Shape()
    BRepMesh_IncrementalMesh(shape, linear_mm, False, angular_rad, False)
    points: list[FloatArray] = []
    normals: list[FloatArray] = []
    triangles: list[IntArray] = []
    edges: list[IntArray] = []
    drawn = TopTools_IndexedMapOfShape()
    count, deviation_mm = 0, 0.0
    for face in _faces(shape):
        place = TopLoc_Location()
        triangulation = BRep_Tool.Triangulation_s(face, place)
        if triangulation is None:
            raise GeometryError(f"{name}: the kernel could not mesh a face at {linear_mm:.4g} mm; is the solid valid?")
        face_points, face_normals, corners = _arrays(face, triangulation, place)
        error_mm = face_deviation(face, face_points, corners, partial(_parameters, triangulation))
        deviation_mm = max(deviation_mm, error_mm)
        for segments, error in _edge_segments(face, triangulation, place, drawn):
            edges.append(segments + count)
            deviation_mm = max(deviation_mm, error)
        points.append(face_points)
        normals.append(face_normals)
        triangles.append(corners + count)
        count += len(face_points)
    all_points = np.concatenate(points)
    return TriangleMesh(
        all_points,
        np.concatenate(normals),
        without_collapsed(all_points, np.concatenate(triangles).astype(np.int32)),
        np.concatenate([*edges, np.empty((0, 2), np.int32)]).astype(np.int32),
        deviation_mm,
    )


def _faces(shape: TopoDS_Shape) -> Iterator[TopoDS_Face]:
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield TopoDS.Face_s(explorer.Current())
        explorer.Next()


def _arrays(
    face: TopoDS_Face, triangulation: Poly_Triangulation, place: TopLoc_Location
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Points, outward normals and outward-facing triangles of one face."""
    BRepLib_ToolTriangulatedShape.ComputeNormals_s(face, triangulation)
    numbers = range(1, triangulation.NbNodes() + 1)
    points = np.array([triangulation.Node(k).Coord() for k in numbers])
    normals = np.array([triangulation.Normal(k).Coord() for k in numbers])
    triangles = np.array([triangulation.Triangle(k).Get() for k in range(1, triangulation.NbTriangles() + 1)], np.int32)
    if not place.IsIdentity():
        motion = place.Transformation()
        matrix = np.array([[motion.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])
        points, normals = points @ matrix[:, :3].T + matrix[:, 3], normals @ matrix[:, :3].T
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        triangles, normals = triangles[:, ::-1], -normals
    return points, normals, triangles - np.int32(1)


def _parameters(triangulation: Poly_Triangulation) -> FloatArray:
    """Surface parameters u, v of the points of one face, (n, 2)."""
    return np.array([triangulation.UVNode(k).Coord() for k in range(1, triangulation.NbNodes() + 1)])


def _edge_segments(
    face: TopoDS_Face, triangulation: Poly_Triangulation, place: TopLoc_Location, drawn: TopTools_IndexedMapOfShape
) -> Iterator[tuple[IntArray, float]]:
    """For each edge of the face that is not yet in ``drawn``: its chords as pairs of node indices, and their error."""
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(face, TopAbs_EDGE, found)
    for number in range(1, found.Extent() + 1):
        edge = TopoDS.Edge_s(found.FindKey(number))
        polygon = BRep_Tool.PolygonOnTriangulation_s(edge, triangulation, place)
        if drawn.Contains(edge) or BRep_Tool.Degenerated_s(edge) or polygon is None:
            continue
        drawn.Add(edge)
        steps = range(1, polygon.NbNodes() + 1)
        nodes = np.array([polygon.Node(k) for k in steps], np.int32) - np.int32(1)
        parameters = np.array([polygon.Parameter(k) for k in steps]) if polygon.HasParameters() else np.empty(0)
        if not BRep_Tool.IsClosed_s(edge, face):  # a seam is not a visible edge
            yield np.column_stack((nodes[:-1], nodes[1:])), edge_deviation(edge, parameters)
