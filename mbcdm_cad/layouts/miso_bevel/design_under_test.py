"""The design under test of this configuration, with results that are computed once and used by many checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import pi, tau

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.design_under_test import NoFigureError
from mbcdm_cad.checks.design_variables import DesignVariable
from mbcdm_cad.checks.sector_under_test import SectorUnderTest
from mbcdm_cad.layouts.miso_bevel.design_variables import VARIABLES
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import Layout, layout
from mbcdm_cad.layouts.miso_bevel.stack import Stack, stack


class BevelUnderTest(SectorUnderTest):
    """Adds the cables' wraps and paths."""

    drive: BevelDrive
    steps: tuple[BevelRun, ...]

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

    @property
    def before_drum(self) -> str:
        """See the base class."""
        return "guide"

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        guide = self.layout.guide
        return tuple(zip(guide.surface_radii, (guide.bottom_z, *guide.walls_z), strict=True))

    @property
    def motor_shelf_mm(self) -> float:
        """See the base class."""
        return self.drive.support.motor_shelf_mm

    @property
    def encoder_plate_mm(self) -> float:
        """See the base class."""
        return self.drive.encoder_plate_mm

    @property
    def levels_sense(self) -> int:
        """See the base class."""
        return -1 if self.drive.motors_above else 1

    @property
    def input_levels(self) -> Stack:
        """See the base class."""
        return self.levels.from_gearhead

    def levels_of(self, index: int) -> Stack:
        """See the base class."""
        return self.input_levels

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
        """All dimensions: the given ones, else computed from the drive."""
        return self.given_or(self._layout)

    def _layout(self) -> Layout:
        levels = self.levels
        if levels.shelf_bottom_z <= 0.0:
            shelf, between = ("lowest", "encoders") if levels.motors_above else ("motor", "coupling space")
            raise NoFigureError(
                f"the {shelf} shelf comes to z = {levels.shelf_bottom_z:.4g} mm, below the drum's axis (limit 0): "
                f"pulleys, {between} and shelves are higher than the drum's radius"
            )
        return layout(self.drive)

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
