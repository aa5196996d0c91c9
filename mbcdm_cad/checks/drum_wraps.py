"""Wrap on the drum over the travel: more than zero, less than a turn, and against the model's slip zones.

Both ends of a cable are anchored, so a wrap shorter than the slip zone is allowed; Eq. (5) and (6) do not hold then.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import atan2, degrees

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.remedies import floored
from mbcdm_cad.layouts.sector import SectorLayout

# Remaining land under the cable between transfer point and terminal at the end of travel (estimate).
LEAST_WRAP_DEG = 2.0
FULL_TURN_DEG = 360.0


def wrap_left(s: SectorLayout) -> Comparison:
    """The cable still wraps the drum at both ends of the travel."""
    return worst(
        at_least(
            f"wrap left of {c.name} (anchor at {degrees(s.anchor_rad(c)):.4g} deg)",
            degrees(s.smallest_wrap_rad(c)),
            LEAST_WRAP_DEG,
            "deg",
        )
        for c in s.steps
    )


def _larger_angle(s: SectorLayout) -> str:
    """Remedy for a cable whose wrap ends too early because the file states where its terminal is."""
    least = degrees(s.half_travel_rad) + LEAST_WRAP_DEG
    asked = [
        c.name for c in s.steps if c.terminal_angle_rad is not None and degrees(s.smallest_wrap_rad(c)) < LEAST_WRAP_DEG
    ]
    return (
        f"state a terminal_angle_deg of at least {least:.4g} for {', '.join(asked)}, or leave it out" if asked else ""
    )


def wrap_under_a_turn(s: SectorLayout) -> Comparison:
    """Cable and terminal take less than a full turn; otherwise they would reach the transfer point a second time."""
    return worst(
        at_most(
            f"largest wrap of {t.cable_name}, terminal included",
            degrees(t.anchor_rad + s.half_travel_rad + atan2(t.last_tip, t.radius_mm)),
            FULL_TURN_DEG,
            "deg",
        )
        for t in s.drum.tensioners
    )


def _wrap_against_slip(s: SectorLayout, load: str, states: tuple[np.ndarray, np.ndarray]) -> Comparison:
    friction = s.drive.friction_coefficient
    found = []
    for k, c in enumerate(s.drive.cables):
        lowest, highest = (float(f(state[k] for state in states)) for f in (min, max))
        preload = c.preload_N
        slip = max(abs(np.log(max(t, 1e-9) / preload)) for t in (lowest, highest)) / friction
        found.append(
            at_least(
                f"{c.name}: wrap left at the end of travel against the slip angle at {load}",
                degrees(s.smallest_wrap_rad(c)),
                degrees(slip),
                "deg",
                "the ends are anchored, so it holds; Eq. (5), (6) are not valid, and the model's figures are estimates",
            )
        )
    return worst(found)


def slip_at_test(s: SectorLayout) -> Comparison:
    """The smallest wrap on the drum is compared with the slip angle at the test torque."""
    load = f"{s.drive.loads.test_torque_Nm:g} N m"
    return _wrap_against_slip(s, load, (s.loads.test_forward, s.loads.test_back))


def slip_at_peak(s: SectorLayout) -> Comparison:
    """The smallest wrap on the drum is compared with the slip angle at peak torque."""
    load = f"{s.drive.loads.peak_torque_Nm:g} N m"
    return _wrap_against_slip(s, load, (s.loads.peak_forward, s.loads.peak_back))


def _travel_within(measure: Callable[[SectorLayout], Comparison], s: SectorLayout) -> str:
    travel = s.drive.half_travel_deg + measure(s).margin
    if travel > 1.0:
        return f"raise rope.preload_N or lower travel.half_angle_deg to at most {floored(travel)}"
    return "no travel is short enough: use the model's figures at this load as estimates, or raise rope.preload_N"


MORE_WRAP: tuple[Adjustment, ...] = (down("travel.half_angle_deg"), up("drum.sector_half_angle_deg"))
WRAPS = (
    Check(
        "wrap_left",
        "Wrap left on the drum at both ends of travel",
        "derived; 2 deg: estimate",
        wrap_left,
        adjust=MORE_WRAP,
        advice=_larger_angle,
    ),
    Check(
        "wrap_under_turn",
        "Wrap on the drum stays under a turn",
        "paper section 2.1",
        wrap_under_a_turn,
        adjust=(down("drum.sector_half_angle_deg"), down("travel.half_angle_deg")),
    ),
)
SLIPS = (
    Check(
        "wrap_slip_test",
        "Wrap left against the slip angle at the test torque",
        "paper Eq. (5), (6)",
        slip_at_test,
        "warn",
        advice=partial(_travel_within, slip_at_test),
    ),
    Check(
        "wrap_slip_peak",
        "Wrap left against the slip angle at peak torque",
        "paper Eq. (5), (6)",
        slip_at_peak,
        "warn",
        advice=partial(_travel_within, slip_at_peak),
    ),
)
