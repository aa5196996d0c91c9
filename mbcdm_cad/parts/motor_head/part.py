"""The motor head as a part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.volume import CORNER, pocket_mm3, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


def coupling_box_mm3(d: CouplingBox, plate_mm3: float = 0.0) -> float:
    """A plate with a coupling box on it, less the box's pocket, bearing seat and holes."""
    flange, height = d.flange_top_z - d.bottom_z, d.top_z - d.flange_top_z
    body = plate_mm3 + (2 * d.outer_x * (d.front_y - d.back_y) - 4 * CORNER * d.corner_radius**2) * height
    inner, shelf = d.inner_x, d.top_z - d.shelf_bottom_z
    return (
        body
        - pocket_mm3(2 * inner, d.front_y + inner, d.shelf_bottom_z - d.flange_top_z, d.corner_radius)
        - ring_mm3(d.pilot_radius, 0.0, shelf)
        - ring_mm3(d.shoulder_radius, 0.0, flange - d.seat_depth)
        - ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        # About half of each key hole lies outside the shoulder's bore.
        - len(d.gear_screws)
        * (ring_mm3(d.gear_screw_clearance, 0.0, shelf) + ring_mm3(d.key_hole_radius, 0.0, flange - d.seat_depth) / 2)
    )


@dataclass(frozen=True)
class MotorHead(MadePart):
    """Motor head, its axis Z."""

    dims: HeadDims

    def solid(self) -> cq.Solid:
        """Drawn by ``draw.py`` beside this module."""
        from mbcdm_cad.parts.motor_head.draw import create_motor_head

        return create_motor_head(self.dims)

    def volume_mm3(self) -> float:
        """Flange, box and motor shelf less pocket, seat and holes."""
        d = self.dims
        f, flange = d.flange, d.flange_top_z - d.bottom_z
        plate = (2 * f.half_x * (f.front_y - f.back_y) - 4 * CORNER * d.corner_radius**2) * flange
        return (
            coupling_box_mm3(d, plate)
            - len(f.screws) * ring_mm3(d.screw_clearance, 0.0, flange)
            - len(f.dowels) * ring_mm3(d.dowel_radius, 0.0, flange)
        )

    def sheet(self, part: str) -> Sheet:
        """Described by ``sheet.py`` beside this module."""
        from mbcdm_cad.parts.motor_head.sheet import motor_head_sheet

        return motor_head_sheet(part, self.dims)
