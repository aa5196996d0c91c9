"""Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared with the slip zones.

Both ends of the cable are fixed to the drum. A wrap shorter than the slip zone is therefore legal, but Eq. (5) and (6)
are no longer valid.
"""

from __future__ import annotations

from math import cos, hypot, sin

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.drum_wraps import MORE_WRAP, SLIPS, WRAPS
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout


def terminal_clears_input(s: SpurLayout) -> Comparison:
    """Gap of the terminals to the input and its yoke at the end of travel where they come nearest."""
    drive, f = s.drive, s.frame
    reach = max(s.inputs[0].lower_land_radius, drive.input_radius_mm + s.flank_mm)
    found = []
    for t in s.drum.tensioners:
        turn = -t.side * s.half_travel_rad
        c, sine = cos(turn), sin(turn)
        for name, outline, _, _ in bodies_of(s, t):
            gaps = []
            for x, z in outline.tolist():
                # About Y from Z towards X, as the drum turns.
                at_x, at_z = x * c + z * sine, z * c - x * sine
                pulley = hypot(at_x, at_z - drive.centre_distance_mm) - reach
                yoke = max(abs(at_x) - f.shelf_half_width, f.shelf_bottom_z - at_z)
                gaps.append(min(pulley, yoke))
            what = f"{name} of {t.cable_name} from the input and its yoke at the end of travel"
            found.append(at_least(what, min(gaps), drive.clearances.running_mm, "mm"))
    return worst(found)


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
