"""A small configuration for the tests: one input and a drum on parallel axes, two crossed cables.

It shows what a configuration must supply, and that no other file has to change; its parts are boxes and cylinders.
Frame: the drum's axis is Y, the input is at x = +L with its axis along -Y, so that both turn in the same sense.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.interface import Conventions


class ParallelConfiguration:
    """See :class:`mbcdm_cad.layouts.interface.Configuration`."""

    name = "parallel_test"
    title = "one input and a drum on parallel axes, for the tests"

    def design_file(self) -> Any:
        """Schema, rules and the drive of a file."""
        from parallel_drive.design_file import DESIGN_FILE

        return DESIGN_FILE

    def routes(self, drive: Drive) -> Any:
        """How the cables run."""
        from parallel_drive.routes import routed

        return routed(drive)

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Input pulley and drum."""
        from parallel_drive.layout import inertias_kg_m2

        return inertias_kg_m2(drive)

    def layout(self, drive: Drive) -> Any:
        """All dimensions."""
        from parallel_drive.layout import layout

        return layout(drive)

    def check_families(self) -> tuple[ModuleType, ...]:
        """One family."""
        from parallel_drive import checks

        return (checks,)

    def design_under_test(self, drive: Drive, layout: Any = None) -> Any:
        """The drive as the checks see it."""
        from parallel_drive.checks import ParallelUnderTest

        return ParallelUnderTest(drive, layout)

    def moving_bodies(self, layout: Any) -> tuple[Any, ...]:
        """Drum and input."""
        from parallel_drive.bill import moving_bodies

        return moving_bodies(layout)

    def bill(self, layout: Any, drum_angle_deg: float = 0.0) -> Any:
        """Parts and instances."""
        from parallel_drive.bill import bill

        return bill(layout, drum_angle_deg)

    def assembly_order(self, layout: Any) -> tuple[Any, ...]:
        """One step."""
        from parallel_drive.bill import assembly_order

        return assembly_order(layout)

    def frame_study(self, layout: Any) -> None:
        """The base is taken as rigid."""
        return

    def tolerance_stacks(self, layout: Any) -> tuple[()]:
        """No gap of it is stacked up."""
        return ()

    def tensioning(self, layout: Any) -> None:
        """How preloads are set is left open."""
        return

    def path_figures(self, layout: Any) -> Any:
        """Lengths and wraps."""
        from parallel_drive.layout import path_figures

        return path_figures(layout)

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """One line a cable."""
        yield f"  {cable['name']}: length {cable['length_mm']:.2f} mm"

    paths_template = (
        "| cable | length mm |\n| --- | --- |\n"
        "{% for c in r.paths.cables %}| {{ c.name }} | {{ '%.2f' % c.length_mm }} |\n{% endfor %}\n"
    )
    conventions = Conventions(
        frame="Frame: the drum's axis is Y; the input stands at x = +L, its axis along -Y.",
        cables="Cables are round rods at the nominal diameter, each in its own plane.",
    )


CONFIGURATION = ParallelConfiguration()
