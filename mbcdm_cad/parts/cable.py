"""A cable as a round rod swept along its true centre line, one piece after the other, tangent everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.parts.part import Part
from mbcdm_cad.parts.shapes import one_solid
from mbcdm_cad.routes.curves import Piece

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class CableRod(Part):
    """Rod along ``pieces`` of a centre line, in the frame of the assembly at the path's drum angle; radius in mm."""

    pieces: tuple[Piece, ...]
    radius: float

    def solid(self) -> cq.Solid:
        """One sweep. Raises ``ValueError`` where the rod is thicker than a bend allows."""
        import cadquery as cq

        from mbcdm_cad.parts.rod import swept_rod

        return one_solid(cq.Shape.cast(swept_rod(self.pieces, self.radius)), "cable")
