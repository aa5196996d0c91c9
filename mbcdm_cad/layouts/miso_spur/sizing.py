"""Sizing rules of miso_spur: those of siso_spur, for the share of one input, and names of inputs and cables."""

from collections.abc import Mapping
from math import inf

from mbcdm_cad.layouts.miso_spur.design_file import REFERENCE
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.sizing import DERIVED, FREEDOMS, spur_rules
from mbcdm_cad.layouts.siso_spur.sizing.basis import SpurKnown
from mbcdm_cad.sizing import constant, rule

__all__ = ["DERIVED", "FREEDOMS", "size"]


class RoundDrumKnown(SpurKnown):
    """As for siso_spur, with results of checks on several sectors on one shaft and on inputs round the drum."""

    layout = RoundDrumLayout
    most_sector_travel_deg = inf
    asked = (*SpurKnown.asked, "inputs")
    own_checks: Mapping[str, tuple[str, ...]] = {
        **SpurKnown.own_checks,
        "transmission.centre_distance_mm": ("sectors_clear_inputs", "heads_apart"),
        "drum.hub_face_y_mm": ("sectors_apart", "sectors_clear_shelves", "dowel_holes"),
    }


@rule("cables", "the two sides of one cable for each input", "the configuration")
def cables(given: RoundDrumKnown) -> list[dict[str, str]]:
    """The two sides of one cable for each input."""
    names = (item["name"] for item in given["inputs"])
    return [
        {"name": f"{name}_{n}", "input": name, "drum_side": side}
        for name in names
        for n, side in enumerate(("+x", "-x"), 1)
    ]


NAMES = (
    constant("inputs", REFERENCE.inputs, "two, one above and one below the drum", "least number of the configuration"),
    cables,
)


size = spur_rules(RoundDrumKnown, NAMES)
