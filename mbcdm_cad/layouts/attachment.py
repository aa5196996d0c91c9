"""Attachments: options that a design file may have or leave out, each with all that it adds to a drive in one class.

A layout names the classes that it ``takes``, and asks those that a design has at fixed places; it knows none of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from mbcdm_cad.checks.comparison import Check
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.parts.bill import AssemblyStep, BillBuilder, MovingBody
    from mbcdm_cad.routes.cable_path import CablePath


class Attachment:
    """An option of one design. What a kind does not override it does not add."""

    # The drive's field that is None in a design without it.
    block: ClassVar[str]

    def __init__(self, layout: Any) -> None:
        self.layout = layout

    @property
    def unit(self) -> Layout | None:
        """The drive that it is, as a design of its own."""
        return None

    @property
    def checks(self) -> Iterable[Check]:
        """Checks besides those of the layout, run after them."""
        return ()

    @property
    def passing_deg(self) -> Iterable[float]:
        """Drum angles (deg) at which a part of it comes by another."""
        return ()

    def moving_bodies(self) -> Iterable[MovingBody]:
        """Its bodies that turn with the drum."""
        return ()

    def add_items(self, b: BillBuilder, drum_angle_deg: float) -> None:
        """Adds its parts to the bill."""

    def cable_paths(self, drum_angle_rad: float) -> Iterable[CablePath]:
        """Centre lines of its own cables."""
        return ()

    def steps_before(self) -> Iterable[AssemblyStep]:
        """Steps of assembly before those of the layout."""
        return ()
