"""What the sizing rules of siso_spur read: fields, catalogue, and results of checks on a trial drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.layouts.siso_spur.checks import FAMILIES
from mbcdm_cad.layouts.siso_spur.design_file.resolve import drive
from mbcdm_cad.layouts.siso_spur.design_file.rules import broken_rules, named_entries
from mbcdm_cad.layouts.siso_spur.design_file.schema import SpurDesign
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.trial_sizing import TrialKnown, sound

CHECKS: Mapping[str, Check] = {check.id: check for family in FAMILIES for check in family.CHECKS}


class SpurKnown(TrialKnown):
    """Adds the values of an input beside the drum."""

    schema: type[Design] = SpurDesign
    asked: tuple[str, ...] = (
        "travel.half_angle_deg",
        "loads.peak_torque_Nm",
        "transmission.drum_radius_mm",
        "transmission.input_to_drum",
        "rope.type",
        "rope.preload_N",
        "drive.motor",
        "drive.gearhead",
    )

    # The neck between the stop slots of anchored cables can be too small for the shoulder of a bearing that fits it.
    own_checks: Mapping[str, tuple[str, ...]] = {
        "input_pulleys.lower_bearing": ("bearing_shoulders",),
        "input_pulleys.upper_bearing": ("bearing_shoulders",),
    }

    @property
    def anchored(self) -> bool:
        """Whether two cables end on each input."""
        return bool(self.get("transmission.cables", "continuous") == "two_anchored")

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        if self.has("transmission.input_to_drum"):
            return float(self["transmission.input_to_drum"])
        return float(self["transmission.drum_radius_mm"] / self["transmission.input_radius_mm"])

    @property
    def has_ratio(self) -> bool:
        """See the base class; if False, the ratio follows from the motor."""
        return self.has("transmission.input_to_drum") or self.has("transmission.input_radius_mm")

    @property
    def input_mm(self) -> float:
        """Pitch radius of the input."""
        return float(self["transmission.drum_radius_mm"]) / self.ratio

    @property
    def drum_mm(self) -> float:
        """Pitch radius of the drum."""
        return float(self["transmission.drum_radius_mm"])

    def checks(self) -> Mapping[str, Check]:
        """See the base class."""
        return CHECKS

    def of_design(self, design: Any) -> SpurLayout:
        """See the base class."""
        return SpurLayout(drive(design, sound(design, broken_rules(design), named_entries(design)), {}))
