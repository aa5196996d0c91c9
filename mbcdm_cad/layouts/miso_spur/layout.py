"""The layout of Fig. 1 (b): two to four inputs evenly round one drum, each with its own cable."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import Conventions
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout

if TYPE_CHECKING:
    from mbcdm_cad.parts.milled import Milled


class RoundDrumLayout(SpurLayout):
    """One design. All sectors are equal; the face of the last one is the output.

    Most checks use the first input; ``steps`` are the sides on the first sector.
    """

    name = "miso_spur"
    title = "two to four inputs evenly round one drum, a cable round each, axes parallel (Fig. 1 b)"
    conventions = Conventions(
        frame="Frame: origin on the drum axis (Y), in the middle of the first input's cable; the first input stands at "
        "+Z, the others evenly about Y, each further along it; lengths in mm.",
        cables="Cables are round rods at the nominal diameter; their turns walk along the inputs as the drum turns.",
    )

    @classmethod
    def module(cls, name: str) -> Any:
        """See the base class; bill, paths and stiffness are those of one input's layout, which has them for several."""
        return super().module(name) if name in ("design_file", "checks") else SpurLayout.module(name)

    @property
    def input_units(self) -> tuple[SpurLayout, ...]:
        """See the base class."""
        return self.units

    @property
    def frame_part(self) -> Milled:
        """See the base class."""
        from mbcdm_cad.layouts.miso_spur.star import Star

        return Star(tuple(unit.frame for unit in self.units), tuple(degrees(a) for a in self.drive.angles_rad))


LAYOUT = RoundDrumLayout
