"""Wrap on the drum over the travel: more than zero, less than a turn, and against the model's slip zones.

Both ends of a cable are anchored, so a wrap shorter than the slip zone is allowed. Eq. (5) and (6), for endless wraps,
then give another turn than the model with the wraps that are there.
"""

from __future__ import annotations

from math import atan2, degrees

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import ModelError

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


def _slip_beside_wrap(s: SectorLayout, states: tuple[np.ndarray, ...]) -> str:
    """The cable whose slip angle exceeds its smallest wrap most, in words."""
    friction, found = s.drive.friction_coefficient, []
    for k, c in enumerate(s.drive.cables):
        slip = max(abs(np.log(max(float(state[k]), 1e-9) / c.preload_N)) for state in states) / friction
        found.append((degrees(s.smallest_wrap_rad(c)), degrees(slip), c.name))
    wrap, slip, name = min(found, key=lambda row: row[0] - row[1])
    return f"{name} slips over {slip:.3g} deg of drum and has {wrap:.3g} deg at an end of the travel"


def _turns(s: SectorLayout) -> tuple[np.ndarray, np.ndarray]:
    """Turn of the drum under the loads (4,) of ``s.loads`` beside none, with endless wraps (4,) and with real (4, 3).

    Real ones are those in the middle and at both ends of the travel.
    """
    loads, angles = s.loads, (-s.half_travel_rad, 0.0, s.half_travel_rad)
    try:
        wraps = [np.stack(side, axis=1) for side in zip(*(s.wraps_rad(angle) for angle in angles), strict=True)]
        real = loads.si.spread(len(angles)).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
        turned = solve_equilibrium(real, loads.torques_Nm[:, None]).drum_angle_rad
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None
    endless = loads.equilibrium.drum_angle_rad
    return endless[1:] - endless[0], turned[1:] - turned[0]


def _turn_with_real_wraps(s: SectorLayout, first: int, load_Nm: float, states: tuple[np.ndarray, ...]) -> Comparison:
    """How much further the drum turns with wraps that end at anchors and stops than with endless ones.

    The largest share over the travel and both ways, loads ``first`` and the next one of :func:`_turns`. It is not above
    zero, since what is beyond an anchor does not stretch: figures for endless wraps are on the safe side, so that
    nothing is judged here.
    """
    endless, real = (turn[first : first + 2] for turn in s.once("turns with real wraps", _turns))
    further = float((real / endless[:, None] - 1.0).max())
    what = f"what the wraps that are there, in place of endless ones, change in the drum's turn at {load_Nm:g} N m"
    return noted(what, 100.0 * further, "%", _slip_beside_wrap(s, states))


def slip_at_test(s: SectorLayout) -> Comparison:
    """How far the turn at the test torque hangs on where the wraps end."""
    loads = s.loads
    return _turn_with_real_wraps(s, 2, s.drive.loads.test_torque_Nm, (loads.test_forward, loads.test_back))


def slip_at_peak(s: SectorLayout) -> Comparison:
    """How far the turn at the peak torque hangs on where the wraps end."""
    loads = s.loads
    return _turn_with_real_wraps(s, 0, s.drive.loads.peak_torque_Nm, (loads.peak_forward, loads.peak_back))


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
        "Wraps that end, at the test torque",
        "paper Eq. (5), (6); solved with the wraps over the travel",
        slip_at_test,
    ),
    Check(
        "wrap_slip_peak",
        "Wraps that end, at the peak torque",
        "paper Eq. (5), (6); solved with the wraps over the travel",
        slip_at_peak,
    ),
)
