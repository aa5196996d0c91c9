"""The configuration of Fig. 1 (d): two inputs, a guide, and a bevel transfer to the drum.

Imports are inside the methods, because each command needs only some of these modules and ``check`` must start fast.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.interface import Conventions, FrameStudy
from mbcdm_cad.layouts.miso_bevel.drive import bevel

if TYPE_CHECKING:
    from mbcdm_cad.design.design_file import DesignFile
    from mbcdm_cad.layouts.miso_bevel.design_under_test import BevelUnderTest
    from mbcdm_cad.layouts.miso_bevel.layout import Layout
    from mbcdm_cad.layouts.miso_bevel.path_figures import PathFigures
    from mbcdm_cad.model.stack_up import StackUp
    from mbcdm_cad.model.tensioning_plan import TensioningPlan
    from mbcdm_cad.parts.bill import AssemblyStep, Bill, MovingBody
    from mbcdm_cad.routes.geometry import RoutedDrive


class MisoBevel:
    """See :class:`mbcdm_cad.layouts.interface.Configuration`."""

    name = "miso_bevel"
    title = "two inputs, a guide and a bevel transfer to the drum (Fig. 1 d)"

    def design_file(self) -> DesignFile:
        """Schema, reference values and rules of its design files, and the function that makes a drive from one."""
        from mbcdm_cad.layouts.miso_bevel.design_file import DESIGN_FILE

        return DESIGN_FILE

    def routes(self, drive: Drive) -> RoutedDrive:
        """Input pulley, free span, guide, transfer, drum."""
        from mbcdm_cad.layouts.miso_bevel.routes import routed

        return routed(bevel(drive))

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Pulleys, guide and drum."""
        from mbcdm_cad.layouts.miso_bevel.inertias import inertias_kg_m2

        return inertias_kg_m2(bevel(drive))

    def layout(self, drive: Drive) -> Layout:
        """All derived dimensions."""
        from mbcdm_cad.layouts.miso_bevel.layout import layout

        return layout(bevel(drive))

    def check_families(self) -> tuple[ModuleType, ...]:
        """The modules of the checks in order."""
        from mbcdm_cad.layouts.miso_bevel.checks import FAMILIES

        return FAMILIES

    def design_under_test(self, drive: Drive, layout: Layout | None = None) -> BevelUnderTest:
        """The drive with everything that the checks read."""
        from mbcdm_cad.layouts.miso_bevel.design_under_test import BevelUnderTest

        return BevelUnderTest(bevel(drive), layout)

    def bill(self, layout: Layout, drum_angle_deg: float = 0.0) -> Bill:
        """All parts and instances."""
        from mbcdm_cad.layouts.miso_bevel.bill import bill

        return bill(layout, drum_angle_deg)

    def moving_bodies(self, layout: Layout) -> tuple[MovingBody, ...]:
        """Drum, guide and inputs."""
        from mbcdm_cad.layouts.miso_bevel.bill import moving_bodies

        return moving_bodies(layout)

    def assembly_order(self, layout: Layout) -> tuple[AssemblyStep, ...]:
        """The steps of assembly."""
        from mbcdm_cad.layouts.miso_bevel.assembly_order import assembly_order

        return assembly_order(layout)

    def frame_study(self, layout: Layout) -> FrameStudy:
        """Rotation of the drum due to the deflection of the frame."""
        from mbcdm_cad.layouts.miso_bevel.support.stiffness import frame_study

        return frame_study(layout)

    def path_figures(self, layout: Layout) -> PathFigures:
        """Figures of the cables' paths over the travel."""
        from mbcdm_cad.layouts.miso_bevel.path_figures import path_figures

        return path_figures(layout)

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """Path figures of one cable as text."""
        from mbcdm_cad.layouts.miso_bevel.path_figures import path_lines

        return path_lines(cable)

    @property
    def paths_template(self) -> str:
        """The report's table of cable paths."""
        return Path(__file__).with_name("paths.md.j2").read_text("utf-8")

    conventions = Conventions(
        frame="Frame: origin where drum axis (Y) and guide axis (Z) meet; input pulleys at x = -L and +L; "
        "lengths in mm.",
        cables="Cables are round rods at the nominal diameter; on the guide they lie in their step planes.",
    )

    def tolerance_stacks(self, layout: Layout) -> tuple[StackUp, ...]:
        """Effect of the tolerances of the parts on each gap and ratio."""
        from mbcdm_cad.layouts.miso_bevel.checks.tolerances import stacks

        return tuple(stacks(self.design_under_test(layout.drive, layout)))

    def tensioning(self, layout: Layout) -> TensioningPlan:
        """How the terminals are drawn in to set the preloads."""
        from mbcdm_cad.layouts.miso_bevel.tensioning import plan

        return plan(layout)


CONFIGURATION = MisoBevel()
