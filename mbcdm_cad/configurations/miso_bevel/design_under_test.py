"""A design of this configuration under test, with what is worked out from it once and read by many checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import pi, tau

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.design_under_test import DesignUnderTest, NoFigureError
from mbcdm_cad.checks.design_variables import DesignVariable
from mbcdm_cad.configurations.miso_bevel.design_variables import VARIABLES
from mbcdm_cad.configurations.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.configurations.miso_bevel.layout import Layout, layout
from mbcdm_cad.configurations.miso_bevel.stack import Stack, stack
from mbcdm_cad.routes.cable_path import CablePath


class BevelUnderTest(DesignUnderTest):
    """Adds the levels and the cables in the order of their steps."""

    drive: BevelDrive

    def __init__(self, drive: BevelDrive, layout: Layout | None = None) -> None:
        super().__init__(drive, layout)
        self.steps: tuple[BevelRun, ...] = tuple(sorted(drive.cables, key=lambda cable: cable.step))

    @property
    def variables(self) -> Mapping[str, DesignVariable]:
        """See the base class."""
        return VARIABLES

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley, guide and drum of each cable."""
        return [
            (c.name, body, radius)
            for c in self.steps
            for body, radius in (
                ("input pulley", c.input_radius_mm),
                ("guide", c.guide_radius_mm),
                ("drum", c.drum_radius_mm),
            )
        ]

    @cached_property
    def levels(self) -> Stack:
        """Heights and depths."""
        if self._given is not None:
            given: Layout = self._given
            return given.levels
        try:
            return stack(self.drive)
        except ValueError as error:
            raise NoFigureError(f"the pulleys have no place: {error}") from None

    @cached_property
    def layout(self) -> Layout:
        """All dimensions: those given, else worked out."""
        if self._given is not None:
            given: Layout = self._given
            return given
        levels = self.levels
        if levels.motor_shelf_bottom_z <= 0.0:
            raise NoFigureError(
                f"the motor shelf comes to z = {levels.motor_shelf_bottom_z:.4g} mm, below the drum's axis (limit 0)"
            )
        try:
            return layout(self.drive)
        except (ValueError, ZeroDivisionError) as error:
            raise NoFigureError(f"the dimensions have no solution: {error}") from None

    @cached_property
    def extreme_paths(self) -> tuple[tuple[float, tuple[CablePath, ...]], ...]:
        """Cable paths at one end of travel, centred, and at the other end, with the drum angles in rad."""
        half = self.half_travel_rad
        return tuple((angle, self.layout.cable_paths(angle)) for angle in (-half, 0.0, half))

    def anchor_rad(self, cable: BevelRun) -> float:
        """Where the cable leaves its land, drum centred."""
        return next(t.anchor_rad for t in self.layout.drum.tensioners if t.cable_name == cable.name)

    def smallest_wrap_rad(self, cable: BevelRun) -> float:
        """Wrap on the drum at the end of travel that unwinds it."""
        return self.anchor_rad(cable) - self.half_travel_rad

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each cable at a drum angle, never below zero, shape (n_cables,)."""
        cables = self.drive.cables
        on_drum = [self.anchor_rad(c) + c.drum_side * drum_angle_rad for c in cables]
        on_input = [
            tau * self.drive.dead_turns
            + c.drum_radius_mm / c.input_radius_mm * (self.half_travel_rad - c.drum_side * drum_angle_rad)
            for c in cables
        ]
        return np.maximum(on_input, 0.0), np.clip(on_drum, 0.0, 2 * pi)
