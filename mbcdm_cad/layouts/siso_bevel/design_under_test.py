"""The design under test of this configuration, with results that are computed once and used by many checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.design_variables import ALL_RADII, SHARED, DesignVariable, by_path, field, radii
from mbcdm_cad.checks.motor_head import HeadUnderTest
from mbcdm_cad.layouts.siso_bevel.cable_path import input_wrap_rad
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout, layout
from mbcdm_cad.layouts.siso_bevel.stack import DirectStack, direct_stack


def _ratio(drive: DirectDrive, value: float) -> DirectDrive:
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.drum_radius_mm / value) for c in drive.cables))


def _reserve(drive: DirectDrive, value: float) -> DirectDrive:
    return replace(drive, reserve_deg=value, dead_turns=value / 360.0)


_DRUM = (
    "sector_half_angle_deg",
    "rim_inner_radius_mm",
    "outer_face_y_mm",
    "web_thickness_mm",
    "hub_diameter_mm",
    "hub_face_y_mm",
    "shaft_bore_mm",
)
_SUPPORT = (
    "back_y_mm",
    "back_plate_mm",
    "side_wall_mm",
    "motor_shelf_mm",
    "coupling_space_mm",
    "bearing_shelf_mm",
    "encoder_shelf_mm",
    "rib_mm",
)
VARIABLES: dict[str, DesignVariable] = by_path(
    (
        *SHARED,
        radii(ALL_RADII, ("drum_radius_mm", "input_radius_mm")),
        radii("transmission.input_radii_mm", ("input_radius_mm",))._replace(applies=lambda d: d.radii_explicit),
        DesignVariable(
            "transmission.input_to_drum",
            lambda drive: drive.total_ratio,
            _ratio,
            applies=lambda drive: not drive.radii_explicit,
        ),
        DesignVariable("transmission.reserve_deg", lambda drive: drive.reserve_deg, _reserve),
        field("clearances.transfer_gap_mm"),
        field("clearances.land_edge_mm"),
        *(field(f"drum.{name}") for name in _DRUM),
        *(field(f"support.{name}") for name in _SUPPORT),
    )
)


class DirectUnderTest(HeadUnderTest):
    """Adds the wraps on the one input."""

    drive: DirectDrive
    steps: tuple[DirectRun, ...]

    @property
    def variables(self) -> Mapping[str, DesignVariable]:
        """See the base class."""
        return VARIABLES

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley and drum of each cable."""
        return [
            (c.name, body, radius)
            for c in self.steps
            for body, radius in (("input pulley", c.input_radius_mm), ("drum", c.drum_radius_mm))
        ]

    @property
    def before_drum(self) -> str:
        """See the base class."""
        return "input pulley"

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        pulley = self.layout.inputs[0]
        return (pulley.upper_surface_radius, -pulley.land_top_z), (pulley.lower_surface_radius, -pulley.wall_z)

    @cached_property
    def levels(self) -> DirectStack:
        """Heights and depths."""
        if self._given is not None:
            given: DirectLayout = self._given
            return given.levels
        return direct_stack(self.drive)

    @cached_property
    def layout(self) -> DirectLayout:
        """All dimensions: the given ones, else computed from the drive."""
        return self.given_or(lambda: layout(self.drive))

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each cable at a drum angle, never below zero, shape (n_cables,)."""
        cables = self.drive.cables
        on_input = [input_wrap_rad(self.drive, c, drum_angle_rad) for c in cables]
        on_drum = [self.anchor_rad(c) + c.drum_side * drum_angle_rad for c in cables]
        return np.maximum(on_input, 0.0), np.clip(on_drum, 0.0, 2 * pi)
