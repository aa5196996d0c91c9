"""The configuration of Fig. 1 (a): one input beside the drum, and one cable round it with crossed spans to the drum.

Imports are inside the methods, because each command needs only some of these modules and ``check`` must start fast.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.interface import Conventions, FrameStudy
from mbcdm_cad.layouts.siso_spur.drive import spur

if TYPE_CHECKING:
    from mbcdm_cad.design.design_file import DesignFile
    from mbcdm_cad.layouts.siso_spur.design_under_test import SpurUnderTest
    from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
    from mbcdm_cad.layouts.siso_spur.path_figures import SpurFigures
    from mbcdm_cad.model.stack_up import StackUp
    from mbcdm_cad.model.tensioning_plan import TensioningPlan
    from mbcdm_cad.parts.bill import AssemblyStep, Bill, MovingBody
    from mbcdm_cad.routes.geometry import RoutedDrive


class SisoSpur:
    """See :class:`mbcdm_cad.layouts.interface.Configuration`."""

    name = "siso_spur"
    title = "one input beside the drum, one cable round it, axes parallel (Fig. 1 a)"

    def design_file(self) -> DesignFile:
        """Schema, reference values and rules of its design files, and the function that makes a drive from one."""
        from mbcdm_cad.layouts.siso_spur.design_file import DESIGN_FILE

        return DESIGN_FILE

    def routes(self, drive: Drive) -> RoutedDrive:
        """Input pulley, crossed spans, drum."""
        from mbcdm_cad.layouts.siso_spur.routes import routed

        return routed(spur(drive))

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Pulley and drum."""
        from mbcdm_cad.layouts.siso_spur.inertias import inertias_kg_m2

        return inertias_kg_m2(spur(drive))

    def layout(self, drive: Drive) -> SpurLayout:
        """All derived dimensions."""
        from mbcdm_cad.layouts.siso_spur.layout import layout

        return layout(spur(drive))

    def check_families(self) -> tuple[ModuleType, ...]:
        """The modules of the checks in order."""
        from mbcdm_cad.layouts.siso_spur.checks import FAMILIES

        return FAMILIES

    def design_under_test(self, drive: Drive, layout: SpurLayout | None = None) -> SpurUnderTest:
        """The drive with everything that the checks read."""
        from mbcdm_cad.layouts.siso_spur.design_under_test import SpurUnderTest

        return SpurUnderTest(spur(drive), layout)

    def bill(self, layout: SpurLayout, drum_angle_deg: float = 0.0) -> Bill:
        """All parts and instances."""
        from mbcdm_cad.layouts.siso_spur.bill import bill

        return bill(layout, drum_angle_deg)

    def moving_bodies(self, layout: SpurLayout) -> tuple[MovingBody, ...]:
        """Drum and input."""
        from mbcdm_cad.layouts.siso_spur.bill import moving_bodies

        return moving_bodies(layout)

    def assembly_order(self, layout: SpurLayout) -> tuple[AssemblyStep, ...]:
        """The steps of assembly."""
        from mbcdm_cad.layouts.siso_spur.assembly_order import assembly_order

        return assembly_order(layout)

    def frame_study(self, layout: SpurLayout) -> FrameStudy:
        """Rotation of the drum due to the deflection of the frame."""
        from mbcdm_cad.layouts.siso_spur.support.stiffness import frame_study

        return frame_study(layout)

    def path_figures(self, layout: SpurLayout) -> SpurFigures:
        """Figures of the cables' paths over the travel."""
        from mbcdm_cad.layouts.siso_spur.path_figures import path_figures

        return path_figures(layout)

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """Path figures of one cable as text."""
        from mbcdm_cad.layouts.siso_spur.path_figures import path_lines

        return path_lines(cable)

    @property
    def paths_template(self) -> str:
        """The report's table of cable paths."""
        return Path(__file__).with_name("paths.md.j2").read_text("utf-8")

    conventions = Conventions(
        frame="Frame: origin on the drum axis (Y), in the middle of the cable; the input stands at +Z; lengths in mm.",
        cables="The cable is a round rod at the nominal diameter; its turns walk along the input as the drum turns.",
    )

    def tensioning(self, layout: SpurLayout) -> TensioningPlan:
        """How the terminals are drawn in to set the preloads."""
        from mbcdm_cad.layouts.siso_spur.tensioning import plan

        return plan(layout)

    def tolerance_stacks(self, layout: SpurLayout) -> tuple[StackUp, ...]:
        """Effect of the tolerances of the parts on each gap and ratio."""
        from mbcdm_cad.layouts.siso_spur.checks.tolerances import stacks

        return tuple(stacks(self.design_under_test(layout.drive, layout)))


CONFIGURATION = SisoSpur()
