"""Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared with the slip zones.

Both ends of a cable are anchored, so that a wrap shorter than the slip zone is allowed; Eq. (5) and (6) are then not
valid.
"""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.drum_wraps import MORE_WRAP, SLIPS, WRAPS
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.path_figures import terminal_to_input_mm


def terminal_clears_input(s: DirectLayout) -> Comparison:
    """Gap between terminals and input at the end of travel where they are nearest."""
    return worst(
        at_least(
            f"terminal of {t.cable_name} from the input and its cables at the end of travel",
            terminal_to_input_mm(s, t, t.anchor_rad - s.half_travel_rad),
            s.drive.clearances.running_mm,
            "mm",
        )
        for t in s.drum.tensioners
    )


CHECKS = (
    *WRAPS,
    Check(
        "terminal_clears_input",
        "Terminals clear the input at the ends of travel",
        "clearances.running_mm",
        terminal_clears_input,
        adjust=MORE_WRAP,
    ),
    *SLIPS,
)
