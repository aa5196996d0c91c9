"""Mesh solids into triangles with a chordal error that is measured and kept below its limit; all files of a part."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepLib import BRepLib_ToolTriangulatedShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.gp import gp_Ax3, gp_Pnt, gp_Vec
from OCP.IMeshTools import IMeshTools_Parameters
from OCP.Poly import Poly_Triangulation
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_Orientation
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import PartSpec
from mbcdm_cad.parts.bodies import ROD_MESH_RADII, CableRod
from mbcdm_cad.workshop.export.step import part_step
from mbcdm_cad.workshop.kernel import Shape, brep_bytes, kernel_shape, measure, validate_solid
from mbcdm_cad.workshop.mass import PartFiles
from mbcdm_cad.workshop.trianglemesh import FloatArray, IntArray, TriangleMesh, rod_mesh, without_collapsed

# Places of a triangle at which it may be farthest from its surface: its centroid and the middle of each side.
_SAMPLES = np.array([[1 / 3, 1 / 3, 1 / 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]])
_NEWTON_STEPS = 2
_SMALLEST = 1e-20
_MOST_PROJECTIONS = 4000  # on surfaces without a closed form, about 10 us each; samples are spread evenly over the face


def face_deviation(
    face: TopoDS_Face, points: FloatArray, triangles: NDArray[np.int32], parameters: Callable[[], FloatArray]
) -> float:
    """Greatest distance in mm from the triangles of one face to the surface under it.

    ``points`` (n, 3) in the frame of the face, ``triangles`` (m, 3), ``parameters`` returns the u, v (n, 2) of the
    points and is called only where they are needed. Exact at the sampled places for planes, cylinders, cones, spheres
    and tori; else by projection from the mean u, v at up to 4000 places spread over the face, which finds at least 98 %
    of the greatest distance.
    """
    surface = BRepAdaptor_Surface(face)
    kind = surface.GetType()
    if kind == GeomAbs_SurfaceType.GeomAbs_Plane or not len(triangles):
        return 0.0
    places = np.einsum("sk,mkj->smj", _SAMPLES, points[triangles]).reshape(-1, 3)
    if kind in _CLOSED_FORMS:
        of, distances = _CLOSED_FORMS[kind]
        own = of(surface)
        return float(np.abs(distances(own, *_local(own.Position(), places))).max())
    start = np.einsum("sk,mkj->smj", _SAMPLES, parameters()[triangles]).reshape(-1, 2)
    step = -(-len(places) // _MOST_PROJECTIONS)
    return float(_distances_to_surface(surface, places[::step], start[::step]).max())


def edge_deviation(edge: TopoDS_Edge, parameters: FloatArray) -> float:
    """Greatest distance in mm from the chords of an edge's polygon, at parameters (n,), to its curve."""
    curve = BRepAdaptor_Curve(edge)
    kind = curve.GetType()
    if kind == GeomAbs_CurveType.GeomAbs_Line or len(parameters) < 2:
        return 0.0
    if kind == GeomAbs_CurveType.GeomAbs_Circle:
        widest = float(np.abs(np.diff(parameters)).max())
        return float(curve.Circle().Radius() * (1.0 - np.cos(widest / 2.0)))
    points = np.array([curve.Value(parameter).Coord() for parameter in parameters])
    middles, start = (points[1:] + points[:-1]) / 2.0, (parameters[1:] + parameters[:-1]) / 2.0
    return float(_distances_to_curve(curve, middles, start).max())


def _local(frame: gp_Ax3, places: FloatArray) -> FloatArray:
    """Places (n, 3) in the frame of an analytic surface, as rows x, y, z."""
    axes = np.array([direction.Coord() for direction in (frame.XDirection(), frame.YDirection(), frame.Direction())])
    local: FloatArray = axes @ (places - np.array(frame.Location().Coord())).T
    return local


# Surfaces with a closed form: the surface itself, and its signed distance from places in its frame. The radius of a
# cone is positive on both sides of the apex.
_CLOSED_FORMS: dict[GeomAbs_SurfaceType, tuple[Callable[[BRepAdaptor_Surface], Any], Callable[..., FloatArray]]] = {
    GeomAbs_SurfaceType.GeomAbs_Cylinder: (
        BRepAdaptor_Surface.Cylinder,
        lambda own, x, y, _: np.hypot(x, y) - own.Radius(),
    ),
    GeomAbs_SurfaceType.GeomAbs_Cone: (
        BRepAdaptor_Surface.Cone,
        lambda own, x, y, z: (
            (np.hypot(x, y) - np.abs(own.RefRadius() + z * np.tan(own.SemiAngle()))) * np.cos(own.SemiAngle())
        ),
    ),
    GeomAbs_SurfaceType.GeomAbs_Sphere: (
        BRepAdaptor_Surface.Sphere,
        lambda own, *local: np.linalg.norm(local, axis=0) - own.Radius(),
    ),
    GeomAbs_SurfaceType.GeomAbs_Torus: (
        BRepAdaptor_Surface.Torus,
        lambda own, x, y, z: np.hypot(np.hypot(x, y) - own.MajorRadius(), z) - own.MinorRadius(),
    ),
}


def has_closed_form(face: TopoDS_Face) -> bool:
    """Whether the surface of a face is a plane, or one to which a distance is exact."""
    kind = BRepAdaptor_Surface(face, False).GetType()
    return kind == GeomAbs_SurfaceType.GeomAbs_Plane or kind in _CLOSED_FORMS


def surface_jets(face: TopoDS_Face, uv: FloatArray) -> list[FloatArray]:
    """Points of the surface of a face at uv (n, 2), and its derivatives along u and v, each (n, 3), mm."""
    return _jets(BRepAdaptor_Surface(face, False), uv)


def _jets(surface: BRepAdaptor_Surface, uv: FloatArray) -> list[FloatArray]:
    point, along_u, along_v = gp_Pnt(), gp_Vec(), gp_Vec()

    def jet(u: float, v: float) -> tuple[float, ...]:
        surface.D1(u, v, point, along_u, along_v)
        return (*point.Coord(), *along_u.Coord(), *along_v.Coord())

    return np.split(np.array([jet(u, v) for u, v in uv.tolist()]).reshape(-1, 9), 3, axis=1)


def _distances_to_surface(surface: BRepAdaptor_Surface, places: FloatArray, uv: FloatArray) -> FloatArray:
    """Distances from places (n, 3) to the surface near uv (n, 2): upper bounds that Gauss-Newton steps bring down."""
    nearest = np.full(len(places), np.inf)
    for _ in range(_NEWTON_STEPS + 1):
        at, du, dv = _jets(surface, uv)
        gap = places - at
        nearest = np.minimum(nearest, np.linalg.norm(gap, axis=1))
        uu, uv_, vv = _dots(du, du), _dots(du, dv), _dots(dv, dv)
        along, across = _dots(du, gap), _dots(dv, gap)
        # At a pole the determinant vanishes and no step is possible; the first bound remains.
        determinant = np.maximum(uu * vv - uv_**2, _SMALLEST)
        uv = uv + np.column_stack((vv * along - uv_ * across, uu * across - uv_ * along)) / determinant[:, None]
    return nearest


def _distances_to_curve(curve: BRepAdaptor_Curve, places: FloatArray, parameters: FloatArray) -> FloatArray:
    """Distances from places (n, 3) to the curve near parameters (n,): upper bounds, as for the surface."""
    point, along = gp_Pnt(), gp_Vec()

    def jet(parameter: float) -> tuple[float, ...]:
        curve.D1(parameter, point, along)
        return (*point.Coord(), *along.Coord())

    nearest = np.full(len(places), np.inf)
    for _ in range(_NEWTON_STEPS + 1):
        at, tangent = np.split(np.array([jet(parameter) for parameter in parameters.tolist()]), 2, axis=1)
        gap = places - at
        nearest = np.minimum(nearest, np.linalg.norm(gap, axis=1))
        parameters = parameters + _dots(tangent, gap) / np.maximum(_dots(tangent, tangent), _SMALLEST)
    return nearest


def _dots(a: FloatArray, b: FloatArray) -> FloatArray:
    products: FloatArray = np.einsum("ij,ij->i", a, b)
    return products


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


# Called with a part's name and its STEP file as soon as the file exists, before its mesh is made.
OnStep = Callable[[str, bytes], None]


def drawn_part(
    spec: PartSpec, material: Material, mesh_tolerance_mm: float | None, on_step: OnStep = lambda name, step: None
) -> PartFiles:
    """All files of one part; the mesh is empty if no tolerance is given.

    Raises ``GeometryError``, naming the part, if the result is not one valid solid.
    """
    try:
        solid = spec.part.solid()
    except Exception as error:  # the kernel raises its own types, with texts such as StdFail_NotDone
        raise GeometryError(f"{spec.name}: cannot be drawn with these dimensions") from error
    if mesh_tolerance_mm is None or not isinstance(rope := spec.part, CableRod):
        return make_part_files(spec.name, solid, material, mesh_tolerance_mm, on_step)
    files = make_part_files(spec.name, solid, material, None, on_step)
    tolerance_mm = max(mesh_tolerance_mm, ROD_MESH_RADII * rope.radius)
    return replace(files, mesh=rod_mesh(rope.pieces, rope.radius, tolerance_mm))


def make_part_files(
    name: str,
    solid: Shape,
    material: Material,
    mesh_tolerance_mm: float | None,
    on_step: OnStep = lambda name, step: None,
) -> PartFiles:
    """Validate, translate, mesh (where a tolerance is given) and measure one solid.

    Raises ``GeometryError`` as :func:`validate_solid` and :func:`mesh_solid` do. The interference run finds faces that
    intersect each other.
    """
    validate_solid(name, solid)
    step = part_step(name, solid, material)
    on_step(name, step)
    mesh = TriangleMesh.empty() if mesh_tolerance_mm is None else mesh_solid(name, solid, mesh_tolerance_mm)
    return PartFiles(name=name, brep=brep_bytes(solid), step=step, mesh=mesh, shape=measure(solid))
