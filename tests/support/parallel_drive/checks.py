"""The checks of the parallel drive: the shared ones of all configurations, and its own one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks import motors, strength
from mbcdm_cad.checks.bending import bending_checks
from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.design_under_test import DesignUnderTest, NoFigureError
from mbcdm_cad.checks.design_variables import SHARED, DesignVariable, by_path, down, field
from parallel_drive.layout import layout, wraps_rad


class ParallelUnderTest(DesignUnderTest):
    """The drive with its layout."""

    @property
    def variables(self) -> Mapping[str, DesignVariable]:
        """The shared ones and the centre distance."""
        return by_path((*SHARED, field("centre_distance_mm")))

    @property
    def layout(self) -> Any:
        """All dimensions."""
        try:
            return self._given or layout(self.drive)
        except ValueError as error:
            raise NoFigureError(str(error)) from None

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See the base class."""
        both = np.array([wraps_rad(self.drive, run, drum_angle_rad) for run in self.drive.cables])
        return both[:, 0], both[:, 1]

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley and drum."""
        return [
            (run.name, body, radius)
            for run in self.drive.cables
            for body, radius in (("input pulley", run.input_radius_mm), ("drum", run.drum_radius_mm))
        ]


def under_a_turn(design: ParallelUnderTest) -> Comparison:
    """The cable stays in its plane, so that its wrap on the input is under a turn."""
    ends = (-design.half_travel_rad, design.half_travel_rad)
    return worst(
        at_most("largest wrap on the input", degrees(float(design.wraps_rad(angle)[0].max())), 350.0, "deg")
        for angle in ends
    )


CHECKS = (
    *bending_checks((down("rope diameter_mm"),)),
    *strength.CHECKS,
    *motors.CHECKS,
    Check(
        "input_wrap", "Wrap on the input under a turn", "derived", under_a_turn, adjust=(down("travel.half_angle_deg"),)
    ),
)
