"""A configuration whose modules are in one package under the usual names.

Each module is imported on first use, since every command needs only some of them and ``check`` must start fast.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.interface import Conventions, FrameStudy, Layout, PathFigures

if TYPE_CHECKING:
    from mbcdm_cad.checks.design_under_test import DesignUnderTest
    from mbcdm_cad.design.design_file import DesignFile
    from mbcdm_cad.model.stack_up import StackUp
    from mbcdm_cad.model.tensioning_plan import TensioningPlan
    from mbcdm_cad.parts.bill import AssemblyStep, Bill, MovingBody
    from mbcdm_cad.routes.geometry import RoutedDrive


@dataclass(frozen=True)
class FolderConfiguration:
    """See :class:`mbcdm_cad.layouts.interface.Configuration`.

    ``package``: full name of the folder, whose last part is the configuration's name. ``own`` gives a drive as one of
    this configuration and raises ``TypeError`` for a drive of another.
    """

    package: str
    title: str
    conventions: Conventions
    own: Callable[[Drive], Any]

    @property
    def name(self) -> str:
        """Name in the design file."""
        return self.package.rpartition(".")[2]

    def _module(self, name: str) -> Any:
        return import_module(f"{self.package}.{name}")

    def design_file(self) -> DesignFile:
        """Schema, reference values and rules of its design files, and the function that makes a drive from a file."""
        found: DesignFile = self._module("design_file").DESIGN_FILE
        return found

    def routes(self, drive: Drive) -> RoutedDrive:
        """Routes of the cables."""
        found: RoutedDrive = self._module("routes").routed(self.own(drive))
        return found

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Moment of inertia of each body of the routes."""
        found: dict[str, float] = self._module("inertias").inertias_kg_m2(self.own(drive))
        return found

    def layout(self, drive: Drive) -> Layout:
        """All derived dimensions."""
        found: Layout = self._module("layout").layout(self.own(drive))
        return found

    def check_families(self) -> tuple[ModuleType, ...]:
        """The modules of the checks in order."""
        found: tuple[ModuleType, ...] = self._module("checks").FAMILIES
        return found

    def design_under_test(self, drive: Drive, layout: Any = None) -> DesignUnderTest:
        """The design under test of a drive."""
        found: DesignUnderTest = self._module("design_under_test").UNDER_TEST(self.own(drive), layout)
        return found

    def bill(self, layout: Any, drum_angle_deg: float = 0.0) -> Bill:
        """All parts and instances."""
        found: Bill = self._module("bill").bill(layout, drum_angle_deg)
        return found

    def moving_bodies(self, layout: Any) -> tuple[MovingBody, ...]:
        """The moving bodies."""
        found: tuple[MovingBody, ...] = self._module("bill").moving_bodies(layout)
        return found

    def assembly_order(self, layout: Any) -> tuple[AssemblyStep, ...]:
        """The steps of assembly."""
        found: tuple[AssemblyStep, ...] = self._module("assembly_order").assembly_order(layout)
        return found

    def frame_study(self, layout: Any) -> FrameStudy:
        """Rotation of the drum due to the deflection of the frame."""
        found: FrameStudy = self._module("support.stiffness").frame_study(layout)
        return found

    def path_figures(self, layout: Any) -> PathFigures:
        """Figures of the cables' paths over the travel."""
        found: PathFigures = self._module("path_figures").path_figures(layout)
        return found

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """Path figures of one cable as text."""
        found: Iterator[str] = self._module("path_figures").path_lines(cable)
        return found

    @property
    def paths_template(self) -> str:
        """The report's table of cable paths."""
        return Path(import_module(self.package).__file__ or "").with_name("paths.md.j2").read_text("utf-8")

    def tensioning(self, layout: Any) -> TensioningPlan:
        """How the terminals are drawn in to set the preloads."""
        found: TensioningPlan = self._module("tensioning").plan(layout)
        return found

    def tolerance_stacks(self, layout: Any) -> tuple[StackUp, ...]:
        """Tolerance stacks of each gap and ratio."""
        under_test = self.design_under_test(layout.drive, layout)
        return tuple(self._module("checks.tolerances").stacks(under_test))
