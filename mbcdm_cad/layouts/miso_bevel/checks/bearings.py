"""Bearing loads against static ratings, and the deflection at the gearhead that the pulley's own bearings leave.

A deep-groove bearing runs normally at a static safety of 1 and quietly at 2 (bearing makers). The cables pull each
input pulley with well over 100 N, more than a gearhead of this size can carry, so each pulley has a bearing at both
ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.bearings import (
    BEARING_SPACING,
    COUPLING_RUNOUT,
    DRUM_BEARINGS,
    INPUT_BEARINGS,
    LARGER,
    LESS,
    QUIET_SAFETY,
    RATING,
    STATIC_SAFETY,
    drum_safety,
    input_safety,
    quiet,
    safety,
)
from mbcdm_cad.checks.comparison import Check, Comparison, worst
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.routes import GUIDE


def guide_forces_N(s: BevelLayout) -> list[NDArray[np.float64]]:
    """Forces on the axle at the guide's (lower, upper) bearing, shape (2, 3), in each state of the loads."""
    g = s.guide
    apart = (g.top_z - g.bottom_z - g.seat_depth) * 1e-3
    middle = 0.5 * (s.steps[0].drum_radius_mm + s.steps[-1].drum_radius_mm)
    shift = (0.5 * (g.top_z + g.bottom_z) - middle) * 1e-3
    found = []
    for loads in s.loads.on_bodies:
        at = loads.bodies[GUIDE]
        # Moments about the middle of the bearings, which need not be that of the steps.
        moment = at.moment_Nm - np.cross([0.0, 0.0, shift], at.force_N)
        couple = np.array([moment[1], -moment[0], 0.0]) / apart
        found.append(np.stack([at.force_N / 2 - couple, at.force_N / 2 + couple]))
    return found


def guide_reaction_N(s: BevelLayout) -> float:
    """Largest radial load on one of the guide's bearings."""
    return max(float(np.linalg.norm(pair, axis=1).max()) for pair in s.once("guide_forces", guide_forces_N))


def guide_safety(s: BevelLayout, limit: float) -> list[Comparison]:
    return [safety(s.drive.bearings.guide, "guide", guide_reaction_N(s), limit)]


def guide_bearings(s: BevelLayout) -> Comparison:
    """Static safety of the bearings in the guide, from the resulting pull and its moment."""
    return worst(guide_safety(s, STATIC_SAFETY))


def quiet_running(s: BevelLayout) -> Comparison:
    """Static safety of all bearings against the value for quiet running."""
    return worst([*input_safety(s, QUIET_SAFETY), *guide_safety(s, QUIET_SAFETY), *drum_safety(s, QUIET_SAFETY)])


CHECKS = (
    INPUT_BEARINGS,
    Check("guide_bearings", "Guide's bearings carry the cables", RATING, guide_bearings, adjust=LESS, advice=LARGER),
    DRUM_BEARINGS,
    quiet(quiet_running),
    BEARING_SPACING,
    COUPLING_RUNOUT,
)
