"""What the sizing rules of miso_spur read: as for siso_spur, with results of checks on a drive with all its inputs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.layouts.miso_spur.checks import FAMILIES
from mbcdm_cad.layouts.miso_spur.design_file.resolve import drive
from mbcdm_cad.layouts.miso_spur.design_file.rules import broken_rules
from mbcdm_cad.layouts.miso_spur.design_file.schema import RoundDrumDesign
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.design_file.rules import named_entries
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.layouts.trial_sizing import sound

CHECKS: Mapping[str, Check] = {check.id: check for family in FAMILIES for check in family.CHECKS}


class RoundDrumKnown(SpurKnown):
    """Adds the checks of several sectors on one shaft and of inputs round the drum."""

    schema = RoundDrumDesign
    asked = (*SpurKnown.asked, "inputs")
    own_checks: Mapping[str, tuple[str, ...]] = {
        **SpurKnown.own_checks,
        "transmission.centre_distance_mm": ("sectors_clear_inputs", "heads_apart"),
        "drum.hub_diameter_mm": ("dowel_holes", "hub_dowels"),
        "drum.hub_face_y_mm": ("sectors_apart", "sectors_clear_shelves", "dowel_holes"),
    }

    def checks(self) -> Mapping[str, Check]:
        """See the base class."""
        return CHECKS

    def of_design(self, design: Any) -> RoundDrumLayout:
        """See the base class."""
        return RoundDrumLayout(drive(design, sound(design, broken_rules(design), named_entries(design)), {}))
