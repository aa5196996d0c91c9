"""What a configuration supplies: the one face by which all other rooms know it.

A configuration is a folder (a package) whose ``CONFIGURATION`` is an object with these members. Its methods import what
they need when they are called: a program that only simulates must not load what draws.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, Protocol

from mbcdm_cad.checks.design_under_test import DesignUnderTest
from mbcdm_cad.design.drive import Drive


class Layout(Protocol):
    """All derived dimensions of one design: a frozen dataclass of each configuration's own."""

    @property
    def drive(self) -> Drive:
        """The design."""


class Configuration(Protocol):
    """A kind of drive: how its cables run, what it is built of, what it must satisfy."""

    @property
    def name(self) -> str:
        """Name in the design file (``configuration: NAME``) and of the folder."""

    @property
    def title(self) -> str:
        """One line for people."""

    def layout(self, drive: Drive) -> Any:
        """All derived dimensions of ``drive``, without CAD.

        Raises ValueError or ZeroDivisionError where no geometry exists.
        """

    def check_families(self) -> tuple[ModuleType, ...]:
        """Modules with a tuple ``CHECKS`` each, in the order in which they are run and shown."""

    def design_under_test(self, drive: Drive, layout: Any = None) -> DesignUnderTest:
        """``drive`` as its checks see it; ``layout``: dimensions to test instead of those that follow from it."""

    def bill(self, layout: Any, drum_angle_deg: float = 0.0) -> Any:
        """All parts, and all instances of them with the drum at ``drum_angle_deg``."""

    def assembly_order(self, layout: Any) -> tuple[Any, ...]:
        """Steps in which the parts go together."""
