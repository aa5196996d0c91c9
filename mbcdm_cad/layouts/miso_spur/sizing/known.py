"""What the sizing rules of miso_spur read: as for siso_spur, with results of checks on a drive with all its inputs."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown


class RoundDrumKnown(SpurKnown):
    """Adds the checks of several sectors on one shaft and of inputs round the drum."""

    layout = RoundDrumLayout
    most_sector_travel_deg = inf
    asked = (*SpurKnown.asked, "inputs")
    own_checks: Mapping[str, tuple[str, ...]] = {
        **SpurKnown.own_checks,
        "transmission.centre_distance_mm": ("sectors_clear_inputs", "heads_apart"),
        "drum.hub_face_y_mm": ("sectors_apart", "sectors_clear_shelves", "dowel_holes"),
    }
