"""The interface of a configuration, through which all other rooms use it.

A configuration is a folder (a package) whose ``CONFIGURATION`` is an object with the members of :class:`Configuration`.
Its methods import modules when they are called, so that a program that only simulates does not load the CAD code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

from mbcdm_cad.design.drive import Drive

if TYPE_CHECKING:
    from mbcdm_cad.checks.design_under_test import DesignUnderTest
    from mbcdm_cad.design.design_file import DesignFile
    from mbcdm_cad.model.stack_up import StackUp
    from mbcdm_cad.model.tensioning_plan import TensioningPlan
    from mbcdm_cad.parts.bill import AssemblyStep, Bill, MovingBody
    from mbcdm_cad.routes.cable_path import CablePath
    from mbcdm_cad.routes.geometry import RoutedDrive


class Layout(Protocol):
    """All derived dimensions of one design, mm, drum centred: a frozen dataclass of each configuration's own."""

    @property
    def drive(self) -> Drive:
        """The design."""

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre lines of all cables, in the order of the design's cables."""


@dataclass(frozen=True)
class FrameCompliance:
    """Rotation of the drum per N m by the support's deflection, in total and by the part whose strain causes it."""

    windup_urad_Nm: float
    shares_urad_Nm: dict[str, float]

    def windup_mrad(self, torque_Nm: float) -> float:
        """Rotation of the drum under an external torque, mrad; proportional to the torque."""
        return self.windup_urad_Nm * torque_Nm * 1e-3


@dataclass(frozen=True)
class FrameStudy:
    """The computation of the frame's compliance and all that it depends on, so that its result can be cached.

    ``module`` is the one whose code computes it, ``inputs`` are plain data, complete for the cache key. ``advice`` says
    how to make the frame stiffer.
    """

    module: str
    inputs: Any
    compliance: Callable[[], FrameCompliance]
    advice: str = "thicken the walls that bend most"


class PathFigures(Protocol):
    """Figures of the cables' true paths: a frozen dataclass that goes into the report with all its fields.

    ``cables`` has an entry for each cable, with at least ``name``, ``length_um`` (change of the length between the
    anchors from the centred drum, at each angle) and ``input_wrap_deg``, ``drum_wrap_deg`` (at each angle).
    """

    @property
    def drum_angle_deg(self) -> tuple[float, ...]:
        """The drum angles over the travel."""

    @property
    def cables(self) -> tuple[Any, ...]:
        """Figures of each cable."""

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle of the usable travel, deg."""


@dataclass(frozen=True)
class Conventions:
    """Texts of the report on the drawn model: its frame of reference, and how its cables are drawn."""

    frame: str
    cables: str


class Configuration(Protocol):
    """A kind of drive: its routes, parts and checks."""

    @property
    def name(self) -> str:
        """Name in the design file (``configuration: NAME``) and of the folder."""

    @property
    def title(self) -> str:
        """Short description in one line."""

    def design_file(self) -> DesignFile:
        """Schema, reference values and rules of its design files, and the function that makes a drive from one."""

    def routes(self, drive: Drive) -> RoutedDrive:
        """Routes of the cables, on which model, rig and loop work."""

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Moment of inertia of each body of the routes about its own axis, without CAD."""

    def layout(self, drive: Drive) -> Layout:
        """All derived dimensions of ``drive``, without CAD.

        Raises ValueError or ZeroDivisionError where no geometry exists.
        """

    def check_families(self) -> tuple[ModuleType, ...]:
        """Modules with a tuple ``CHECKS`` each, in the order in which they are run and shown."""

    def design_under_test(self, drive: Drive, layout: Any = None) -> DesignUnderTest:
        """The design under test of ``drive``; ``layout``: dimensions to test instead of those computed from it."""

    def moving_bodies(self, layout: Any) -> tuple[MovingBody, ...]:
        """The moving bodies: the drum, the bodies that cables pass, the inputs in the order of the design's inputs."""

    def bill(self, layout: Any, drum_angle_deg: float = 0.0) -> Bill:
        """All parts, and all instances of them with the drum at ``drum_angle_deg``.

        The group of each instance is ``"fixed"`` or the name of a moving body.
        """

    def assembly_order(self, layout: Any) -> tuple[AssemblyStep, ...]:
        """Steps of the assembly; every item of the bill joins in one of them."""

    def frame_study(self, layout: Any) -> FrameStudy | None:
        """Study of the drum's rotation by the frame's deflection; None if the frame is assumed to be rigid."""

    def path_figures(self, layout: Any) -> PathFigures:
        """Figures of the cables' paths over the travel."""

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """One cable's path figures (as a dict) for the terminal."""

    @property
    def paths_template(self) -> str:
        """Jinja template of the report's table of cable paths; ``r`` is the report's data."""

    @property
    def conventions(self) -> Conventions:
        """Texts of the report on the drawn model."""

    def tolerance_stacks(self, layout: Any) -> tuple[StackUp, ...]:
        """Tolerance stacks of each gap and ratio; may be empty."""

    def tensioning(self, layout: Any) -> TensioningPlan | None:
        """Plan for setting the preloads: cut lengths, nut turns, pitch of the spans, order; None if there is none."""
