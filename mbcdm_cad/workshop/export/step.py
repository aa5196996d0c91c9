"""STEP of one part and of an assembly: names, colours, materials with density; the same bytes for the same model."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool
from OCP.XSControl import XSControl_WorkSession

from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Item, sorted_items
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
