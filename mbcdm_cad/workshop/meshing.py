"""Mesh solids into triangles with a chordal error that is measured and kept below its limit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.IMeshTools import IMeshTools_Parameters
from OCP.Poly import Poly_Triangulation
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_Orientation
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.workshop.deviation import edge_deviation, face_deviation, has_closed_form, surface_jets
from mbcdm_cad.workshop.kernel import Shape, kernel_shape
from mbcdm_cad.workshop.trianglemesh import FloatArray, IntArray, TriangleMesh, without_collapsed

_ATTEMPTS = 6
# Tolerance given to the kernel, as a share of the required one: on swept surfaces its error is up to 1.1 times that.
_FIRST_SHARE = 0.85
# On swept surfaces the error is sampled; the samples were found to miss up to 1.5 % of the greatest error.
_ACCEPTED_SHARE = 0.97
# A triangle whose sides are within this share of the tolerance is within it (three quarters on a quadric).
_SIDE_SHARE = 0.75
_MOST_SPLITS = 10
# A side along which the surface turns more than this is halved too: thin triangles across it would face elsewhere.
_MOST_TURN_RAD = 0.35
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
    asked = IMeshTools_Parameters()
    asked.Deflection, asked.Angle = linear_mm, angular_rad
    asked.DeflectionInterior, asked.AngleInterior = linear_mm, 2.0 * angular_rad
    # The kernel refines the face of a groove to ten times the triangles that its tolerance needs; see ``_refined``.
    asked.ControlSurfaceDeflection = False
    BRepMesh_IncrementalMesh(shape, asked)
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
        parameters = partial(_parameters, triangulation)
        if not has_closed_form(face):
            face_points, face_normals, corners, uv = _refined(
                face, face_points, face_normals, corners, parameters(), _SIDE_SHARE * linear_mm
            )
            parameters = partial(np.asarray, uv)
        error_mm = face_deviation(face, face_points, corners, parameters)
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


def _refined(
    face: TopoDS_Face, points: FloatArray, normals: FloatArray, triangles: IntArray, uv: FloatArray, within_mm: float
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Points, normals, triangles and u, v of a face whose sides inside it are no further from it than ``within_mm``.

    Sides that are further, or along which the surface turns much, are halved, in both triangles beside them. Those on
    the face's outline stay as they are, so that the mesh of the whole stays closed; the new points follow the old ones.
    """
    sign = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
    straight = np.empty((0, 2), np.int64)  # sides that were found near enough
    for _ in range(_MOST_SPLITS):
        sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
        codes, index, times = np.unique(sides[:, 0] << 32 | sides[:, 1], return_inverse=True, return_counts=True)
        new = np.flatnonzero((times == 2) & np.isin(codes, straight, invert=True))
        ends = np.column_stack((codes[new] >> 32, codes[new] & 0xFFFFFFFF))
        middles = uv[ends].mean(axis=1)
        at, du, dv = surface_jets(face, middles)
        across = np.cross(du, dv)
        across /= np.maximum(np.linalg.norm(across, axis=1), np.finfo(float).tiny)[:, None]
        far = np.abs(np.einsum("ij,ij->i", points[ends].mean(axis=1) - at, across)) > within_mm
        far |= np.einsum("ij,ij->i", normals[ends[:, 0]], normals[ends[:, 1]]) < math.cos(_MOST_TURN_RAD)
        straight = np.concatenate([straight.reshape(-1), codes[new[~far]]])
        if not far.any():
            break
        middle_of = np.full(len(codes), -1)
        middle_of[new[far]] = len(points) + np.arange(far.sum())
        points, uv = np.concatenate([points, at[far]]), np.concatenate([uv, middles[far]])
        normals = np.concatenate([normals, sign * across[far]])
        triangles = _halved(points, triangles, middle_of[index].reshape(-1, 3))
    return points, normals, triangles, uv


def _halved(points: FloatArray, triangles: IntArray, middles: IntArray) -> IntArray:
    """Triangles divided at the middles of their sides (m, 3): of corners 0-1, 1-2 and 2-0; -1 where there is none."""
    split = middles >= 0
    count = split.sum(axis=1)
    found = [triangles[count == 0]]
    # Turned so that the first side is halved, or of two halved sides the third is whole.
    turn = np.where(count == 1, split.argmax(axis=1), np.where(count == 2, (split.argmin(axis=1) + 1) % 3, 0))
    order = (turn[:, None] + np.arange(3)) % 3
    (a, b, c), (ab, bc, ca) = (np.take_along_axis(rows, order, 1).T for rows in (triangles, middles))

    def add(which: NDArray[Any], *corners: IntArray) -> None:
        found.append(np.column_stack([corner[which] for corner in corners]).astype(triangles.dtype))

    one, two, three = (np.flatnonzero(count == k) for k in (1, 2, 3))
    add(one, a, ab, c)
    add(one, ab, b, c)
    add(two, ab, b, bc)
    # The rest of two halved sides, ab and bc, is cut along the shorter diagonal.
    short = np.linalg.norm(points[ab[two]] - points[c[two]], axis=1) < np.linalg.norm(
        points[bc[two]] - points[a[two]], axis=1
    )
    add(two[short], a, ab, c)
    add(two[short], ab, bc, c)
    add(two[~short], a, ab, bc)
    add(two[~short], a, bc, c)
    for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
        add(three, *corners)
    return np.concatenate(found)


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
