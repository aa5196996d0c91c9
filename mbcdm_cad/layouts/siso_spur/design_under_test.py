"""A design of this configuration under test, with results that are computed once and read by many checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.design_variables import ALL_RADII, SHARED, DesignVariable, by_path, field, radii
from mbcdm_cad.checks.motor_head import HeadUnderTest
from mbcdm_cad.layouts.siso_spur.cable_path import input_wrap_rad, side_length_mm
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, SpurRun, laid, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout, layout
from mbcdm_cad.layouts.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.parts.drum_sector.design import SectorRun


def _ratio(drive: SpurDrive, value: float) -> SpurDrive:
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.drum_radius_mm / value) for c in drive.cables))


def _turns(drive: SpurDrive, value: float) -> SpurDrive:
    return replace(drive, turns=max(1, round(value)))


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
    "plate_mm",
    "bridge_mm",
    "side_wall_mm",
    "motor_shelf_mm",
    "coupling_space_mm",
    "bearing_shelf_mm",
    "encoder_shelf_mm",
)


def _with_lands(variable: DesignVariable) -> DesignVariable:
    """The design variable; a drive with a new value gets new planes of its terminals."""
    return variable._replace(put=lambda drive, value: laid(spur(variable.put(drive, value))))


VARIABLES: dict[str, DesignVariable] = by_path(
    _with_lands(variable)
    for variable in (
        *SHARED,
        radii(ALL_RADII, ("drum_radius_mm", "input_radius_mm")),
        radii("transmission.input_radius_mm", ("input_radius_mm",))._replace(applies=lambda d: d.radii_explicit),
        DesignVariable(
            "transmission.input_to_drum",
            lambda drive: drive.total_ratio,
            _ratio,
            applies=lambda drive: not drive.radii_explicit,
        ),
        field("transmission.centre_distance_mm", "centre_distance_mm"),
        DesignVariable("transmission.turns", lambda drive: float(drive.turns), _turns),
        field("rope.helix_lead_mm", "helix_lead_mm"),
        field("clearances.land_edge_mm"),
        *(field(f"drum.{name}") for name in _DRUM),
        *(field(f"support.{name}") for name in _SUPPORT),
    )
)


class SpurUnderTest(HeadUnderTest):
    """Adds the winding of the input."""

    drive: SpurDrive
    steps: tuple[SpurRun, ...]

    @property
    def variables(self) -> Mapping[str, DesignVariable]:
        """See the base class."""
        return VARIABLES

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley and drum."""
        name, drive = self.drive.input_names[0], self.drive
        return [(name, "input pulley", drive.input_radius_mm), (name, "drum", drive.drum_radius_mm)]

    @property
    def levels_sense(self) -> int:
        """See the base class."""
        return -1

    @property
    def before_drum(self) -> str:
        """See the base class."""
        return "input pulley"

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        pulley = self.layout.inputs[0]
        return ((pulley.lower_surface_radius, pulley.land_bottom_z),)

    @cached_property
    def levels(self) -> SpurStack:
        """Heights and depths."""
        if self._given is not None:
            given: SpurLayout = self._given
            return given.levels
        return spur_stack(self.drive)

    @cached_property
    def layout(self) -> SpurLayout:
        """All dimensions: the layout that was given, else computed."""
        return self.given_or(lambda: layout(self.drive))

    def anchor_rad(self, cable: SectorRun) -> float:
        """Wrap on the drum with the drum centred: from where the cable lands to where it leaves its land."""
        return super().anchor_rad(cable) - self.drive.landing_rad

    def tensioned_lengths_mm(self) -> Sequence[float]:
        """Length that each terminal tensions: half of the one cable, or its own cable."""
        anchors = self.layout.anchors
        return [side_length_mm(self.drive, c, *anchors[c.name]) for c in self.drive.cables]

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each side at a drum angle, never below zero, shape (n_cables,)."""
        cables = self.drive.cables
        on_input = [input_wrap_rad(self.drive, c, drum_angle_rad) for c in cables]
        on_drum = [self.anchor_rad(c) + c.drum_side * drum_angle_rad for c in cables]
        return np.maximum(on_input, 0.0), np.clip(on_drum, 0.0, 2 * pi)
