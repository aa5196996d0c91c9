"""What a configuration supplies: the interface through which all other rooms use it.

A configuration is a folder (a package) whose ``CONFIGURATION`` is an object with the members of :class:`Configuration`.
Its methods import what they need when they are called: a program that only simulates must not load what draws.
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
    """Turning of the drum per N m by the support's deflection, whole and by the part whose strain causes it."""

    windup_urad_Nm: float
    shares_urad_Nm: dict[str, float]

    def windup_mrad(self, torque_Nm: float) -> float:
        """Turning of the drum under an external torque, mrad: linear in it."""
        return self.windup_urad_Nm * torque_Nm * 1e-3


@dataclass(frozen=True)
class FrameStudy:
    """What the frame's compliance depends on, and how it is worked out: it takes long enough to be kept in the cache.

    ``module`` is the one whose code makes it, ``inputs`` plain data, all that it depends on. ``advice`` says what makes
    the frame stiffer.
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
        """(lowest, highest) drum angle that nothing forbids."""


@dataclass(frozen=True)
class Conventions:
    """What the report must say of the drawn model: its frame of reference, and how its cables are drawn."""

    frame: str
    cables: str


class Configuration(Protocol):
    """A kind of drive: how its cables run, what it is built of, what it must satisfy."""

    @property
    def name(self) -> str:
        """Name in the design file (``configuration: NAME``) and of the folder."""

    @property
    def title(self) -> str:
        """One line for people."""

    def design_file(self) -> DesignFile:
        """Schema, reference values and rules of its design files, and how a drive is made of one."""

    def routes(self, drive: Drive) -> RoutedDrive:
        """How the cables run: what model, rig and identification work on."""

    def inertias_kg_m2(self, drive: Drive) -> dict[str, float]:
        """Moment of inertia of each body of the routes about its own axis, without CAD."""

    def layout(self, drive: Drive) -> Layout:
        """All derived dimensions of ``drive``, without CAD.

        Raises ValueError or ZeroDivisionError where no geometry exists.
        """

    def check_families(self) -> tuple[ModuleType, ...]:
        """Modules with a tuple ``CHECKS`` each, in the order in which they are run and shown."""

    def design_under_test(self, drive: Drive, layout: Any = None) -> DesignUnderTest:
        """``drive`` as its checks see it; ``layout``: dimensions to test instead of those that follow from it."""

    def moving_bodies(self, layout: Any) -> tuple[MovingBody, ...]:
        """What moves: the drum, the bodies that cables pass, the inputs in the order of the design's inputs."""

    def bill(self, layout: Any, drum_angle_deg: float = 0.0) -> Bill:
        """All parts, and all instances of them with the drum at ``drum_angle_deg``.

        The group of each instance is ``"fixed"`` or the name of a moving body.
        """

    def assembly_order(self, layout: Any) -> tuple[AssemblyStep, ...]:
        """Steps in which the parts go together; every item of the bill joins in one of them."""

    def frame_study(self, layout: Any) -> FrameStudy | None:
        """How far the frame's deflection turns the drum; None where it is taken as rigid."""

    def path_figures(self, layout: Any) -> PathFigures:
        """Figures of the cables' true paths over the travel."""

    def path_lines(self, cable: dict[str, Any]) -> Iterator[str]:
        """One cable's path figures (as a dict) for the terminal."""

    @property
    def paths_template(self) -> str:
        """Jinja template of the report's table of cable paths; ``r`` is the report's data."""

    @property
    def conventions(self) -> Conventions:
        """What the report says of the drawn model."""

    def tolerance_stacks(self, layout: Any) -> tuple[StackUp, ...]:
        """What the tolerances of the parts do to each gap and ratio; empty where nothing is stacked up."""

    def tensioning(self, layout: Any) -> TensioningPlan | None:
        """How the preloads are set: cut lengths, nut turns, pitch of the spans, order; None where nothing is set."""
