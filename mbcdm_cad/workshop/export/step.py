"""STEP of one part and of an assembly: names, colours, materials with density; the same bytes for the same model.

A part's STEP AP242 has the demands of its sheet on the faces they are for: fits, threads, datums, tolerances. They are
semantic product and manufacturing information (ISO 10303-242), which measuring and CAM programs read; nothing of it is
drawn. The schema has no entity for a thread: one is a diameter on the cylinder of its hole, with its designation as the
dimensional note that goes with the diameter.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Lin, gp_Pnt
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDimTolObjects import (
    XCAFDimTolObjects_DatumObject,
    XCAFDimTolObjects_DimensionObject,
    XCAFDimTolObjects_DimensionType,
    XCAFDimTolObjects_GeomToleranceObject,
    XCAFDimTolObjects_GeomToleranceType,
    XCAFDimTolObjects_GeomToleranceTypeValue,
)
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_Datum, XCAFDoc_Dimension, XCAFDoc_DocumentTool, XCAFDoc_GeomTolerance
from OCP.XSControl import XSControl_WorkSession

from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Item, sorted_items
from mbcdm_cad.parts.fits import THREAD_CLASS, Vector, limits
from mbcdm_cad.parts.part import cq
from mbcdm_cad.parts.sheet import Holes, Linear, Sheet
from mbcdm_cad.workshop.export.files import canonical_step
from mbcdm_cad.workshop.kernel import Shape, kernel_shape, location

# The kernel's numbers of the schemas.
_AP214, _AP242 = 4, 5


def part_step(name: str, solid: Shape, material: Material, description: str = "") -> bytes:
    """The STEP file of one part: one product called ``name``, coloured, with its material and density (g/cm^3)."""
    document = StepDocument()
    document.add_part(name, solid, material)
    return document.step(name, description)


def assembly_step(name: str, items: Sequence[Item], solids: Mapping[str, Shape], description: str = "") -> bytes:
    """The STEP file of an assembly: one sub-assembly a group, in it the items at their places.

    ``solids`` maps each part to its solid in the part's own frame; a part is written once however often it occurs.
    The order of ``items`` does not matter. Raises ``ValueError`` as :func:`sorted_items` does.
    """
    document = StepDocument()
    root = document.add_assembly(name)
    parts: dict[str, TDF_Label] = {}
    groups: dict[str, TDF_Label] = {}
    for item in sorted_items(items, solids):
        if item.part not in parts:
            parts[item.part] = document.add_part(item.part, solids[item.part], item.material)
        if item.group not in groups:
            groups[item.group] = document.add_assembly(item.group)
        document.add_component(groups[item.group], parts[item.part], item.name, location(item.location))
    for group, label in groups.items():
        document.add_component(root, label, group, TopLoc_Location())
    return document.step(name, description)


class StepDocument:
    """The kernel's document of named, coloured shapes; ``main`` is the label that its tools hang on."""

    def __init__(self) -> None:
        self._document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
        XCAFApp_Application.GetApplication_s().InitDocument(self._document)
        self.main = main = self._document.Main()
        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(main)
        self.shapes.SetAutoNaming_s(False)
        self._colours = XCAFDoc_DocumentTool.ColorTool_s(main)
        self._materials = XCAFDoc_DocumentTool.MaterialTool_s(main)

    def add_assembly(self, name: str) -> TDF_Label:
        """An empty assembly."""
        label = self.shapes.NewShape()
        _set_name(label, name)
        return label

    def add_part(self, name: str, solid: Shape, material: Material) -> TDF_Label:
        """A part with its colour, material and density."""
        label = self.shapes.AddShape(kernel_shape(solid), False)
        _set_name(label, name)
        colour = Quantity_Color(*material.colour, Quantity_TypeOfColor.Quantity_TOC_RGB)
        self._colours.SetColor(label, colour, XCAFDoc_ColorType.XCAFDoc_ColorGen)
        self._materials.SetMaterial(
            label,
            TCollection_HAsciiString(material.name),
            TCollection_HAsciiString(""),
            material.density_g_cm3,
            TCollection_HAsciiString("density measure"),
            TCollection_HAsciiString("POSITIVE_RATIO_MEASURE"),
        )
        return label

    def add_component(self, parent: TDF_Label, child: TDF_Label, name: str, place: TopLoc_Location) -> None:
        """An instance of ``child`` in ``parent``."""
        _set_name(self.shapes.AddComponent(parent, child, place), name)

    def step(self, name: str, description: str, ap242: bool = False) -> bytes:
        """The document as AP214, or as AP242 with its dimensions and tolerances."""
        self.shapes.UpdateAssemblies()
        writer = STEPCAFControl_Writer(XSControl_WorkSession(), False)
        # The kernel keeps these settings for the whole process, so all that affect the file are set each time.
        Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)  # no curves in parameter space: a third smaller
        Interface_Static.SetIVal_s("write.precision.mode", 0)
        Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        writer.SetNameMode(True)
        writer.SetColorMode(True)
        writer.SetMaterialMode(True)
        Interface_Static.SetIVal_s("write.step.schema", _AP242 if ap242 else _AP214)
        writer.SetDimTolMode(ap242)
        buffer = io.BytesIO()
        if not writer.Transfer(self._document, STEPControl_StepModelType.STEPControl_AsIs):
            raise GeometryError(f"the kernel could not translate {name!r} to STEP: is every solid valid?")
        writer.WriteStream(buffer)
        return canonical_step(buffer.getvalue().decode("ascii"), name, description).encode("ascii")


def _set_name(label: TDF_Label, name: str) -> None:
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))


_KINDS = {
    "run-out": XCAFDimTolObjects_GeomToleranceType.XCAFDimTolObjects_GeomToleranceType_CircularRunout,
    "perpendicularity": XCAFDimTolObjects_GeomToleranceType.XCAFDimTolObjects_GeomToleranceType_Perpendicularity,
    "coaxiality": XCAFDimTolObjects_GeomToleranceType.XCAFDimTolObjects_GeomToleranceType_Coaxiality,
    "parallelism": XCAFDimTolObjects_GeomToleranceType.XCAFDimTolObjects_GeomToleranceType_Parallelism,
}
_SAME_MM = 1e-4
# Name of a text that goes with a dimension (recommended practices for AP242).
_NOTE = "dimensional note"


@dataclass(frozen=True)
class _Cylinder:
    """A cylindrical face with its diameter; ``inside`` that of a hole."""

    face: cq.Face
    diameter_mm: float
    inside: bool
    axis: gp_Lin


def part_step_ap242(name: str, solid: Shape, material: Material, sheet: Sheet) -> bytes:
    """The STEP AP242 file of one part with the fits, threads, datums and geometric tolerances of its ``sheet``.

    The same part gives the same bytes. Raises ``ValueError`` if a demand names no face of the solid.
    """
    document = StepDocument()
    part = document.add_part(name, solid, material)
    demands = _Demands(document, part, cq.Shape.cast(kernel_shape(solid)))
    demands.add_fits(sheet)
    demands.add_threads(sheet)
    demands.add_tolerances(sheet)
    return document.step(name, f"{name}, with the tolerances of its sheet", ap242=True)


class _Demands:
    """Adds a sheet's demands to the faces of one part of a document."""

    def __init__(self, document: StepDocument, part: TDF_Label, solid: cq.Shape) -> None:
        self._shapes = document.shapes
        self._tool = XCAFDoc_DocumentTool.DimTolTool_s(document.main)
        self._part = part
        self._faces = solid.Faces()
        self._cylinders = list(_cylinders(self._faces))
        self._labels: dict[cq.Face, TDF_Label] = {}

    def add_fits(self, sheet: Sheet) -> None:
        """Each toleranced diameter, on all cylinders of that size and side; an upper-case class is that of holes."""
        for nominal, code in dict.fromkeys((fit.nominal_mm, fit.code) for fit in sheet.fits):
            inside = code[0].isupper()
            faces = [c.face for c in self._cylinders if c.inside == inside and abs(c.diameter_mm - nominal) < _SAME_MM]
            if faces:
                found = limits(nominal, code)
                size = _diameter(f"{nominal:g} {code}")
                # Limits of size: the kernel's own reader mistakes deviations of one sign, such as those of N7.
                size.SetLowerBound(found.smallest_mm)
                size.SetUpperBound(found.largest_mm)
                self._add_dimension(size, faces)

    def add_threads(self, sheet: Sheet) -> None:
        """Each tapped hole's thread on its cylinder, each outside thread on the cylinder that its dimension ends on."""
        for group in sheet.holes:
            if group.threaded:
                faces = [face for place in group.places for face in self._hole(group, place)]
                self._add_thread(faces, group.diameter, group.thread_text(f"-{THREAD_CLASS}"))
        for line in sheet.dimensions:
            if isinstance(line, Linear) and line.prefix == "M":
                at = [c for c in self._cylinders if abs(c.diameter_mm - line.value) < _SAME_MM and not c.inside]
                faces = [c.face for c in at if _meets(c, line.end)]
                self._add_thread(faces, line.value, f"M{line.value:g}{line.suffix}")

    def _add_thread(self, faces: list[cq.Face], diameter_mm: float, designation: str) -> None:
        size = _diameter(designation)
        size.SetValue(diameter_mm)
        size.AddDescription(TCollection_HAsciiString(designation), TCollection_HAsciiString(_NOTE))
        self._add_dimension(size, faces)

    def _hole(self, group: Holes, place: Vector) -> list[cq.Face]:
        """The cylinders of one hole. ValueError: the solid has none there."""
        inside = [c for c in self._cylinders if c.inside and abs(c.diameter_mm - group.diameter) < _SAME_MM]
        faces = [c.face for c in inside if c.axis.Distance(gp_Pnt(*place)) < _SAME_MM]
        if not faces:
            raise ValueError(f"hole {group.letter}: no cylinder of {group.diameter:g} mm at {place}")
        return faces

    def _add_dimension(self, size: XCAFDimTolObjects_DimensionObject, faces: list[cq.Face]) -> None:
        label = self._tool.AddDimension()
        self._tool.SetDimension(self._sequence(faces), TDF_LabelSequence(), label)
        XCAFDoc_Dimension.Set_s(label).SetObject(size)

    def add_tolerances(self, sheet: Sheet) -> None:
        """Each geometric tolerance with the datums that it refers to."""
        for tolerance in sheet.tolerances:
            demand = XCAFDimTolObjects_GeomToleranceObject()
            demand.SetSemanticName(TCollection_HAsciiString(tolerance.characteristic))
            demand.SetType(_KINDS[tolerance.characteristic])
            demand.SetValue(tolerance.value_mm)
            if tolerance.axis:
                demand.SetTypeOfValue(
                    XCAFDimTolObjects_GeomToleranceTypeValue.XCAFDimTolObjects_GeomToleranceTypeValue_Diameter
                )
            label = self._tool.AddGeomTolerance()
            self._tool.SetGeomTolerance(self._sequence([self._face_at(at) for at in tolerance.places]), label)
            XCAFDoc_GeomTolerance.Set_s(label).SetObject(demand)
            letters = [letter for datum in tolerance.datums for letter in datum.split("-")]
            for position, letter in enumerate(letters, 1):
                datum = XCAFDimTolObjects_DatumObject()
                datum.SetName(TCollection_HAsciiString(letter))
                datum.SetPosition(1 if len(tolerance.datums) == 1 else position)
                datum_label = self._tool.AddDatum()
                self._tool.SetDatum(self._sequence(self._datum_faces(letter, sheet)), datum_label)
                XCAFDoc_Datum.Set_s(datum_label).SetObject(datum)
                self._tool.SetDatumToGeomTol(datum_label, label)

    def _datum_faces(self, letter: str, sheet: Sheet) -> list[cq.Face]:
        for datum in sheet.datums:
            if datum.letter == letter:
                return [self._face_at(datum.at)]
        (size,) = (d for d in sheet.dimensions if isinstance(d, Linear) and d.datum == letter)
        near = [c for c in self._cylinders if abs(c.diameter_mm - size.value) < _SAME_MM]
        faces = [c.face for c in near] if size.prefix[0].isdigit() else [c.face for c in near if _meets(c, size.end)]
        if not faces:
            raise ValueError(f"{sheet.part}: no cylinder of {size.value:g} mm for datum {letter}")
        return faces

    def _face_at(self, at: Vector) -> cq.Face:
        return min(self._faces, key=lambda face: _distance_mm(face, at))

    def _sequence(self, faces: list[cq.Face]) -> TDF_LabelSequence:
        sequence = TDF_LabelSequence()
        for face in faces:
            if face not in self._labels:
                self._labels[face] = self._shapes.AddSubShape(self._part, face.wrapped)
            sequence.Append(self._labels[face])
        return sequence


def _diameter(name: str) -> XCAFDimTolObjects_DimensionObject:
    size = XCAFDimTolObjects_DimensionObject()
    size.SetSemanticName(TCollection_HAsciiString(name))
    size.SetType(XCAFDimTolObjects_DimensionType.XCAFDimTolObjects_DimensionType_Size_Diameter)
    return size


def _cylinders(faces: list[cq.Face]) -> Iterator[_Cylinder]:
    for face in faces:
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Cylinder:
            # The outward normal of the solid points to the axis inside a hole, however the surface is parametrised.
            at, cylinder = face.positionAt(0.5, 0.5), surface.Cylinder()
            axis = cylinder.Axis()
            origin, along = cq.Vector(axis.Location()), cq.Vector(axis.Direction())
            radial = at - origin - along * (at - origin).dot(along)
            inside = face.normalAt(at).dot(radial) < 0.0
            yield _Cylinder(face, 2.0 * cylinder.Radius(), inside, gp_Lin(axis))


def _meets(cylinder: _Cylinder, at: Vector) -> bool:
    return _distance_mm(cylinder.face, at) < cylinder.diameter_mm / 2


def _distance_mm(face: Any, at: Vector) -> float:
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*at)).Vertex()
    return float(BRepExtrema_DistShapeShape(face.wrapped, vertex).Value())
