"""Creep of fibre ropes: how long the preload suffices before the cables must be tensioned again."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.model.capability import SLACK_SHARE, torque_at_slip_Nm
from mbcdm_cad.model.creep import DAY_S, TOLD_C, creeps, relaxation
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import ModelError

# Shortest acceptable time between two tensionings (estimate).
RETENSION_DAYS = 30.0
_HALVINGS = 12


def _suffices(s: Layout, share: float) -> bool:
    """Whether a share of the preloads carries the peak torque both ways: no cable slack, none slips on its input."""
    peak = s.drive.loads.peak_torque_Nm
    less = s.loads.si.with_(preload_N=s.loads.si.preload_N * share)
    try:
        for wraps in s.wraps_at_ends_rad:
            wound = less.with_(**wraps)
            tension = solve_equilibrium(wound, np.array([peak, -peak])).tension_N
            if np.any(tension < SLACK_SHARE * less.preload_N[:, None]):
                return False
            if less.through_wrap_rad is None:
                continue
            if min(float(torque_at_slip_Nm(wound, way).min()) for way in (1, -1)) < peak:
                return False
    except ModelError:
        return False
    return True


def needed_share(s: Layout) -> float:
    """Least share of the preloads that still carries the peak torque; 1 if not even the full preloads do."""
    low, high = 0.0, 1.0
    if not _suffices(s, high):
        return 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _suffices(s, middle) else (middle, high)
    return high


def retension(s: Layout) -> Comparison:
    """Days until creep has lowered the preload to the need of the peak torque; ends fixed, room temperature."""
    rope = s.drive.cable
    if not creeps(rope):
        return noted("creep of the rope, none in the catalogue", 0.0, "days")
    most = max(c.preload_N for c in s.drive.cables)
    share = s.once("preload needed", needed_share)
    days = [relaxation(rope, most, t, s.softer_ends).time_until_s(share * most) / DAY_S for t in TOLD_C]
    told = [f"{d:.4g} days" if np.isfinite(d) else "over 100 years" for d in days]
    return at_least(
        f"days until the preload of {most:g} N has crept to {share:.0%}, which the peak torque needs",
        min(days[0], 36525.0),
        RETENSION_DAYS,
        "days",
        f"{told[0]} at {TOLD_C[0]:g} C, {told[1]} at {TOLD_C[1]:g} C, ends fixed, bedded in",
    )


CHECKS = (
    Check(
        "retension",
        "Preload left after the rope's creep",
        "model: creep of the catalogue; 30 days: estimate",
        retension,
        "warn",
        adjust=(up("rope.preload_N"), down("loads.peak_torque_Nm")),
        advice="choose a rope.type that creeps less, or a thicker one",
    ),
)
