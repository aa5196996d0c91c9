"""Wrap on the input under one turn: the cable stays in the plane of its transfer point, so it has no second turn.

A helix would move the tangent point off that plane by its lead in each turn. This limits the ratio of a drive without a
guide: i x full travel + reserve + the stop's slot <= 360 degrees.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.remedies import floored
from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, stop_bend
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout

TURN_DEG = 360.0
# Wrap left before the stop's bend on the unwound pulley, so that the cable never pulls at the bend (estimate).
LEAST_RESERVE_DEG = 15.0
# The slot changes little with the ratio, so a few iterations are enough.
_ROUNDS = 30


def one_turn(s: DirectLayout) -> Comparison:
    """Sum of ratio x full travel, reserve and the angle of the stop's slot, compared with one turn of the input."""
    s.require_geometry()  # without a layout there is no slot
    found = []
    for c in s.steps:
        ratio, taken = c.drum_radius_mm / c.input_radius_mm, degrees(stop_bend(s.drive, c).taken_rad)
        travel = 2 * s.drive.half_travel_deg
        note = f"{ratio:.4g} x {travel:g} deg of travel + {s.drive.reserve_deg:g} reserve + {taken:.3g} for the slot"
        what = f"turn of the input that {c.name} takes up"
        found.append(at_most(what, full_input_turn_deg(s.drive, c), TURN_DEG, "deg", note))
    return worst(found)


def reserve(s: DirectLayout) -> Comparison:
    """Wrap that stays on the input at the unwound end."""
    return at_least("wrap left on the input, all unwound", s.drive.reserve_deg, LEAST_RESERVE_DEG, "deg")


def highest_ratio(drive: DirectDrive) -> float:
    """The total ratio that uses one turn of the input over this travel, with the same drum radii; 0 if there is none.

    A smaller pulley has a slot of a larger angle, so that both are found together. Raises ValueError if the pulley is
    too small for a stop.
    """
    ratio = 1.0
    for _ in range(_ROUNDS):
        taken = max(
            degrees(stop_bend(drive, replace(c, input_radius_mm=c.drum_radius_mm / ratio)).taken_rad)
            for c in drive.cables
        )
        ratio = (TURN_DEG - drive.reserve_deg - taken) / (2 * drive.half_travel_deg)
        if ratio <= 0.0:
            return 0.0
    return ratio


def _ratio_that_fits(s: DirectLayout) -> str:
    """Remedy: the highest ratio for this travel, which the paper calls restricted within the available work space."""
    try:
        ratio = highest_ratio(s.drive)
    except ValueError as error:
        return str(error)
    if ratio <= 0.0:
        return "no ratio fits: lower transmission.reserve_deg"
    return (
        f"a total ratio of at most {floored(ratio)} for this travel; a guide between input and drum (miso_bevel) "
        "allows more, because its inputs can wind any number of turns"
    )


_LESS: tuple[Adjustment, ...] = (
    down("transmission.input_to_drum"),
    down("travel.half_angle_deg"),
    down("transmission.reserve_deg"),
)
CHECKS = (
    Check(
        "input_under_turn",
        "Wrap on the input stays under a turn",
        "derived: the transfer point stays in its plane; paper section 2.1",
        one_turn,
        adjust=_LESS,
        advice=_ratio_that_fits,
    ),
    Check(
        "input_reserve",
        "Wrap that stays on the input",
        "15 deg: estimate",
        reserve,
        adjust=(up("transmission.reserve_deg"),),
    ),
)
