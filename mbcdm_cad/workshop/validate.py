"""Check that a shape is one valid solid. The kernel's own check is not enough: it accepts an empty cut as valid."""

from __future__ import annotations

from typing import Any

from OCP.BOPAlgo import BOPAlgo_CheckerSI
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepAlgoAPI import BRepAlgoAPI_Check
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Shape
from OCP.TopTools import TopTools_ListOfShape

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.workshop.kernel import Shape, kernel_shape

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
