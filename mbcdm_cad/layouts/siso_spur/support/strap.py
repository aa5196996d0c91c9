"""Strap over the front ends of a pair's axles, screwed on the posts of the frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_spur.support.idlers import StandDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import block, cut, cylinder_y
from mbcdm_cad.parts.sheets.description import FitLine, Holes, Linear, Sheet, View, X, Y, Z, minus
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.volume import CORNER, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

# Radius of the strap's corners.
CORNER_MM = 2.0


@dataclass(frozen=True)
class Strap(MadePart):
    """Strap where it stands in the assembly."""

    dims: StandDims

    def solid(self) -> cq.Solid:
        """Strap where it stands in the assembly."""
        import cadquery as cq

        d = self.dims
        back, front = d.strap_back_y, d.strap_front_y
        body = block((-d.half_width, d.half_width), (back, front), (d.low_z, d.post_z[1]))
        rounded: cq.Shape = cq.Workplane(obj=body).edges("|Y").fillet(CORNER_MM).val()  # type: ignore[assignment]
        tools = []
        for side in (-1, 1):
            tools.append(cylinder_y(d.axle_radius, side * d.x, d.z, back - 1.0, front + 1.0))
            tools.append(cylinder_y(d.clearance_radius, side * d.screw_x, d.screw_z, back - 1.0, front + 1.0))
        return cut(rounded, tools, "strap")

    def volume_mm3(self) -> float:
        """Plate with rounded corners less its holes."""
        d = self.dims
        thick = d.strap_front_y - d.strap_back_y
        plate = (2 * d.half_width * (d.post_z[1] - d.low_z) - 4 * CORNER * CORNER_MM**2) * thick
        return plate - 2 * (ring_mm3(d.axle_radius, 0.0, thick) + ring_mm3(d.clearance_radius, 0.0, thick))

    def sheet(self, part: str) -> Sheet:
        """From the front and from the side; positions from the drum's axis."""
        d = self.dims
        front, high, wide = d.strap_front_y, d.post_z[1], d.half_width
        bore = FITS["axle_bore"].code
        axles = tuple((side * d.x, front, d.z) for side in (-1, 1))
        screws = tuple((side * d.screw_x, front, d.screw_z) for side in (-1, 1))
        holes = (
            Holes("A", 2 * d.axle_radius, THROUGH, axles, "front", "axles", fit=bore),
            Holes("B", 2 * d.clearance_radius, THROUGH, screws, "front", "screws"),
        )
        return Sheet(
            part=part,
            title="Idler strap",
            views=(View("front", minus(X), Z), View("side", Y, Z, column=1)),
            dimensions=(
                Linear("front", (-wide, front, high), (wide, front, high), 2 * wide, "above"),
                Linear("front", (wide, front, d.low_z), (wide, front, high), high - d.low_z, "left"),
                Linear("side", (0.0, d.strap_back_y, d.low_z), (0.0, front, d.low_z), front - d.strap_back_y, "below"),
            ),
            labels=hole_labels(holes, "front"),
            holes=holes,
            tables=(hole_table(holes), position_table(holes, (0, 2), "Positions from the drum's axis")),
            fits=(FitLine(2 * d.axle_radius, bore, "axles"),),
            notes=("Corners R2. Bores of the axles together with those of the frame, Ra 1.6.",),
        )
