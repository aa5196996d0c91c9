"""Plain numbers from and for shapes of the CAD kernel: conversions, volume, area, centroid, inertia, tight box."""

from __future__ import annotations

import io
from typing import Any

from OCP.BinTools import BinTools, BinTools_FormatVersion
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Trsf
from OCP.GProp import GProp_GProps
from OCP.Message import Message, Message_Gravity, Message_ProgressRange
from OCP.OSD import OSD_ThreadPool
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape

from mbcdm_cad.parts.placement import Placement, Vector
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
