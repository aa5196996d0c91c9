"""The configuration of Fig. 1 (d): two inputs, a guide, and a bevel transfer to the drum.

Imports stand inside the methods, since each command needs only some of these modules and ``check`` must start fast.
"""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING

from mbcdm_cad.design.drive import Drive

if TYPE_CHECKING:
    from mbcdm_cad.configurations.miso_bevel.assembly_order import Step
    from mbcdm_cad.configurations.miso_bevel.bill import Bill
    from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest
    from mbcdm_cad.configurations.miso_bevel.layout import Layout


class MisoBevel:
    """See :class:`mbcdm_cad.configurations.interface.Configuration`."""

    name = "miso_bevel"
    title = "two inputs, a guide and a bevel transfer to the drum (Fig. 1 d)"

    def layout(self, drive: Drive) -> Layout:
        """All derived dimensions."""
        from mbcdm_cad.configurations.miso_bevel.layout import layout

        return layout(drive)

    def check_families(self) -> tuple[ModuleType, ...]:
        """The checks' modules in order."""
        from mbcdm_cad.configurations.miso_bevel.checks import FAMILIES

        return FAMILIES

    def design_under_test(self, drive: Drive, layout: Layout | None = None) -> BevelUnderTest:
        """The drive as the checks see it."""
        from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest

        return BevelUnderTest(drive, layout)

    def bill(self, layout: Layout, drum_angle_deg: float = 0.0) -> Bill:
        """All parts and instances."""
        from mbcdm_cad.configurations.miso_bevel.bill import bill

        return bill(layout, drum_angle_deg)

    def assembly_order(self, layout: Layout) -> tuple[Step, ...]:
        """Steps in which the parts go together."""
        from mbcdm_cad.configurations.miso_bevel.assembly_order import assembly_order

        return assembly_order(layout)


CONFIGURATION = MisoBevel()
