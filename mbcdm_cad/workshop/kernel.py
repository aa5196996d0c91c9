"""Shapes of the CAD kernel: plain numbers from and for them, the volume two share, whether one is a valid solid."""

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BinTools import BinTools, BinTools_FormatVersion
from OCP.Bnd import Bnd_Box
from OCP.BOPAlgo import BOPAlgo_CheckerSI
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Check, BRepAlgoAPI_Common
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Trsf
from OCP.GProp import GProp_GProps
from OCP.Message import Message, Message_Gravity, Message_ProgressRange
from OCP.OSD import OSD_ThreadPool
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape
from OCP.TopTools import TopTools_ListOfShape

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Placement, Vector
from mbcdm_cad.parts.rod import swept_rod
from mbcdm_cad.routes.curves import Piece
from mbcdm_cad.workshop.mass import Matrix, ShapeProperties

# A cadquery.Shape (anything with ``wrapped``) or the kernel's own shape; cadquery itself is not needed to write files.
Shape = Any

# The kernel writes statistics of every STEP file to standard output; only failures are wanted. cadquery makes the same
# setting when it is imported, but an assembly of cached parts is written without cadquery.
for _printer in Message.DefaultMessenger_s().Printers():
    _printer.SetTraceLevel(Message_Gravity.Message_Fail)

# The kernel must start no threads: work is divided among forked processes, and a process forked after the kernel has
# started threads waits for them for ever. Only the first call has an effect, so it comes before anything is drawn.
OSD_ThreadPool.DefaultPool_s(1)


def kernel_shape(shape: Shape) -> TopoDS_Shape:
    """The kernel's shape inside a cadquery shape, or the kernel's shape itself."""
    return getattr(shape, "wrapped", shape)


def location(placement: Placement) -> TopLoc_Location:
    """A placement as the kernel's location.

    The identity is also written as a transformation and not as the empty location: the kernel takes an instance with an
    empty location for the part itself, and the STEP writer then gives its name to another instance.
    """
    transformation = gp_Trsf()
    first, second, third = placement.rows
    transformation.SetValues(*first, *second, *third)
    return TopLoc_Location(transformation)


def brep_bytes(shape: Shape) -> bytes:
    """The shape in the kernel's binary form: exact doubles, no mesh, the same bytes every time."""
    buffer = io.BytesIO()
    version = BinTools_FormatVersion.BinTools_FormatVersion_VERSION_4
    BinTools.Write_s(kernel_shape(shape), buffer, False, False, version, Message_ProgressRange())
    return buffer.getvalue()


def shape_from_brep(data: bytes) -> TopoDS_Shape:
    """The kernel's shape from :func:`brep_bytes`. Raises ``ValueError`` if the bytes contain no shape."""
    shape = TopoDS_Shape()
    BinTools.Read_s(shape, io.BytesIO(data), Message_ProgressRange())
    if shape.IsNull():
        raise ValueError(f"{len(data)} bytes hold no shape in the kernel's binary form")
    return shape


def measure(solid: Shape) -> ShapeProperties:
    """Volume, centroid, inertia of ``solid`` in its own frame. The solid should be valid: an open one has no volume.

    Exact to rounding on planes, cylinders, cones, spheres and tori; about 1e-6 of the volume on swept surfaces.
    """
    shape = kernel_shape(solid)
    surface, volume = GProp_GProps(), GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, surface)
    BRepGProp.VolumeProperties_s(shape, volume)
    low, high = bounding_box(shape)
    return ShapeProperties(volume.Mass(), surface.Mass(), volume.CentreOfMass().Coord(), _inertia(volume), low, high)


def bounding_box(solid: Shape, placement: Placement | None = None) -> tuple[Vector, Vector]:
    """Lowest and highest corner (mm) of the tight box about a solid, at ``placement`` if given.

    The kernel's default box encloses control points and is 8 % too wide on a torus; this one touches the surface.
    """
    shape = kernel_shape(solid)
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape if placement is None else shape.Moved(location(placement)), box, False, False)
    x_low, y_low, z_low, x_high, y_high, z_high = box.Get()
    return (x_low, y_low, z_low), (x_high, y_high, z_high)


def _inertia(volume: GProp_GProps) -> Matrix:
    tensor = volume.MatrixOfInertia()
    rows = [(tensor.Value(row, 1), tensor.Value(row, 2), tensor.Value(row, 3)) for row in (1, 2, 3)]
    return rows[0], rows[1], rows[2]


def common(first: Shape, second: Shape, placement: Placement) -> tuple[float, Vector]:
    """Volume (mm^3) that a solid shares with a second one moved by ``placement``, and the centre of that volume."""
    operation = BRepAlgoAPI_Common(kernel_shape(first), kernel_shape(second).Moved(location(placement)))
    properties = GProp_GProps()
    if not operation.IsDone() or operation.Shape().IsNull():
        return 0.0, (0.0, 0.0, 0.0)
    BRepGProp.VolumeProperties_s(operation.Shape(), properties)
    centre = properties.CentreOfMass()
    return properties.Mass(), (centre.X(), centre.Y(), centre.Z())


def rod(pieces: Sequence[Piece], radius_mm: float) -> Any:
    """The solid of a rod along ``pieces`` of a centre line. Raises ``GeometryError`` if the kernel cannot make it."""
    try:
        return swept_rod(pieces, radius_mm)
    except Exception as error:  # the kernel raises its own types, with texts such as StdFail_NotDone
        x, y, z = pieces[0].points(np.array([0.0]))[0]
        raise GeometryError(
            f"the stretch of a cable that begins at ({x:.2f}, {y:.2f}, {z:.2f}) mm cannot be drawn as a rod"
        ) from error


# A part with more swept faces than these, each of which takes the kernel half a second against those beside it, is
# tested by the edges of its faces: where two faces cross, the edge of one runs through the other, unless they cross in
# a closed curve, as no grooves of a helix do.
_MOST_SWEPT = 12
_EDGES_AND_FACES = 4  # level of the kernel's check; 5 adds faces and faces


def validate_solid(name: str, shape: Shape) -> None:
    """Raise ``GeometryError``, naming the part and the reason, unless ``shape`` is exactly one closed, valid solid.

    That is a Solid (not a Compound that contains one) with closed shells, valid for the kernel, no edge or face too
    small, volume above zero. Intersecting faces are not tested here: see :func:`validate_faces`.
    """
    reason = _reason(kernel_shape(shape))
    if reason:
        raise GeometryError(f"{name}: {reason}")


def validate_faces(name: str, shape: Shape) -> None:
    """Raise ``GeometryError``, naming the part, if faces of a solid intersect or touch each other: of many, by edges.

    It takes a fifth of the time of drawing a part, so it runs together with the interference tests. It is not used for
    a helical cable, for which it takes a second: the distance of its turns gives the same answer at once.
    """
    solid = kernel_shape(shape)
    kinds = [BRepAdaptor_Surface(TopoDS.Face_s(face), False).GetType() for face in _all(solid, TopAbs_FACE)]
    many = kinds.count(GeomAbs_SurfaceType.GeomAbs_BSplineSurface) > _MOST_SWEPT
    found = _crossing_edges(solid) if many else _faults(solid, self_intersection=True)
    if found:
        raise GeometryError(f"{name}: {found}")


def _reason(shape: TopoDS_Shape) -> str:
    if shape is None or shape.IsNull():
        return "no shape at all; the last operation has failed"
    if shape.ShapeType() != TopAbs_SOLID:
        count = len(_all(shape, TopAbs_SOLID))
        kind = shape.ShapeType().name.removeprefix("TopAbs_").capitalize()
        return f"a {kind} of {count} solids, must be one Solid; take the solid out, or find what cut it apart"
    shells = _all(shape, TopAbs_SHELL)
    if not shells:
        return "a solid without a shell"
    if not all(BRep_Tool.IsClosed_s(shell) for shell in shells):
        return "its shell is open; a face is missing"
    if not BRepCheck_Analyzer(shape).IsValid():
        return "not valid to the kernel; edges or faces do not fit together"
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    if not properties.Mass() > 0.0:
        return f"volume {properties.Mass():.6g} mm^3, must be above 0; is it inside out?"
    return _faults(shape, self_intersection=False)


def _faults(shape: TopoDS_Shape, self_intersection: bool) -> str:
    """Faults that the test used by ``cadquery.func.check`` finds, in words."""
    check = BRepAlgoAPI_Check(shape, True, self_intersection)
    if not check.IsValid():
        faults = sorted({result.GetCheckStatus().name.removeprefix("BOPAlgo_") for result in check.Result()})
        return f"not sound: {', '.join(faults)}; do faces touch or cut each other?"
    return ""


def _crossing_edges(shape: TopoDS_Shape) -> str:
    """What edges that run through faces, or into each other, are called; empty if there are none."""
    check, whole = BOPAlgo_CheckerSI(), TopTools_ListOfShape()
    whole.Append(shape)
    check.SetArguments(whole)
    check.SetLevelOfCheck(_EDGES_AND_FACES)
    check.Perform()
    if check.HasErrors() or check.DS().Interferences().Extent():
        return "not sound: SelfIntersect; do faces touch or cut each other?"
    return ""


def _all(shape: TopoDS_Shape, kind: Any) -> list[TopoDS_Shape]:
    found, explorer = [], TopExp_Explorer(shape, kind)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found
