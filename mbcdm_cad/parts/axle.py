"""Axle of an idler, with the collar that carries the lower bearing's inner ring, and the spacer above it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.ring import Pin
from mbcdm_cad.parts.shapes import stepped, turned
from mbcdm_cad.parts.sheets.description import FitLine, Sheet
from mbcdm_cad.parts.sheets.tolerances import Datum, GeometricTolerance
from mbcdm_cad.parts.sheets.turned import ALONG_Z, MAIN
from mbcdm_cad.parts.volume import ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

# At 45 degrees, on both ends of the axle.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class AxleDims:
    """Axle between two plates, of an idler or the guide, with a collar below the bearing and a spacer above."""

    radius: float
    bottom_z: float
    top_z: float
    collar_radius: float
    collar_bottom_z: float
    collar_top_z: float
    spacer_bottom_z: float
    spacer_top_z: float


@dataclass(frozen=True)
class Axle(MadePart):
    """Axle where it stands in the assembly, axis Z."""

    cut_in_sections = False

    dims: AxleDims
    title: str = "Guide axle"

    def solid(self) -> cq.Solid:
        """Axle where it stands in the assembly, axis Z."""
        d = self.dims
        steps = (
            (d.radius, d.bottom_z, d.collar_bottom_z),
            (d.collar_radius, d.collar_bottom_z, d.collar_top_z),
            (d.radius, d.collar_top_z, d.top_z),
        )
        return turned([(0.0, d.bottom_z), *stepped(steps, CHAMFER_MM), (0.0, d.top_z)], "axle")

    def volume_mm3(self) -> float:
        """Axle of an idler with its collar."""
        d = self.dims
        collar = ring_mm3(d.collar_radius, d.radius, d.collar_top_z - d.collar_bottom_z)
        return Pin(d.radius, d.top_z - d.bottom_z).volume_mm3() + collar

    def sheet(self, part: str) -> Sheet:
        """View from the side; the axle is solid, so it is not cut."""
        dims = self.dims
        low, high, r, collar = dims.bottom_z, dims.top_z, dims.radius, dims.collar_radius
        fit = FITS["idler_axle"].code
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=False),),
            dimensions=(
                ALONG_Z.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2, datum="D"),
                ALONG_Z.diameter(collar, dims.collar_top_z, "right"),
                ALONG_Z.length(low, dims.collar_bottom_z, "below", (r - CHAMFER_MM, collar)),
                ALONG_Z.length(dims.collar_bottom_z, dims.collar_top_z, "below", (collar, collar), decimals=3),
                ALONG_Z.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM), decimals=3),
                ALONG_Z.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
            ),
            fits=(FitLine(2 * r, fit, "bearings, shelf, top plate"),),
            tolerances=(ALONG_Z.square((r, collar), (dims.collar_top_z, dims.collar_bottom_z), 0.01, "D"),),
            notes=("Bearing journals Ra 0.8.",),
        )


@dataclass(frozen=True)
class Spacer(MadePart):
    """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""

    dims: AxleDims
    title: str = "Guide spacer"
    note: str = "Ground to the length that leaves the guide's bearings free of play."

    def solid(self) -> cq.Solid:
        """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""
        dims = self.dims
        low, high = dims.spacer_bottom_z, dims.spacer_top_z
        return turned(
            [(dims.radius, low), (dims.collar_radius, low), (dims.collar_radius, high), (dims.radius, high)], "spacer"
        )

    def volume_mm3(self) -> float:
        """Spacer on an idler's axle."""
        d = self.dims
        return ring_mm3(d.collar_radius, d.radius, d.spacer_top_z - d.spacer_bottom_z)

    def sheet(self, part: str) -> Sheet:
        """Section along the axis."""
        dims = self.dims
        low, high = dims.spacer_bottom_z, dims.spacer_top_z
        fit, middle = FITS["spacer_bore"].code, (dims.radius + dims.collar_radius) / 2
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=True),),
            dimensions=(
                ALONG_Z.diameter(dims.radius, low, "left", fit=fit),
                ALONG_Z.diameter(dims.collar_radius, high, "right"),
                ALONG_Z.length(low, high, "below", (dims.collar_radius, dims.collar_radius), decimals=3),
            ),
            fits=(FitLine(2 * dims.radius, fit, "bore"),),
            datums=(Datum(MAIN, ALONG_Z.point(middle, low), "E"),),
            tolerances=(GeometricTolerance(MAIN, ALONG_Z.point(middle, high), "parallelism", 0.01, ("E",)),),
            notes=(self.note,),
        )
