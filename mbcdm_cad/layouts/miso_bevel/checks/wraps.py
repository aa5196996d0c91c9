"""Wrap on the drum over the travel: more than zero, less than a turn, and compared with the model's slip zones.

Both ends of a cable are anchored, so a wrap shorter than the slip zone is allowed; Eq. (5) and (6) do not hold then.
"""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.drum_wraps import MORE_WRAP, SLIPS, WRAPS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.path_figures import terminal_to_guide_mm


def terminal_clears_guide(s: BevelLayout) -> Comparison:
    """Gap between terminals and guide at the end of travel where they are nearest."""
    return worst(
        at_least(
            f"terminal of {t.cable_name} from the guide and its cables at the end of travel",
            terminal_to_guide_mm(s, t, wrap),
            s.drive.clearances.running_mm,
            "mm",
        )
        for t in s.drum.tensioners
        for wrap in (t.anchor_rad - s.half_travel_rad,)
    )


CHECKS = (
    *WRAPS,
    Check(
        "terminal_clears_guide",
        "Terminals clear the guide at the ends of travel",
        "clearances.running_mm",
        terminal_clears_guide,
        adjust=MORE_WRAP,
    ),
    *SLIPS,
)
