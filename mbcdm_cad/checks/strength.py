"""Cables under load: no cable slack, no cable near breaking, and the torque on each input from the preloads."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, exp, tau

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.remedies import floored, rounded
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.model.capability import SLACK_SHARE, balanced_preload_N, torque_at_input_limit_Nm
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import ModelError

# Share of an input's rated torque that the preload alone may take (estimate).
BIAS_SHARE = 0.1


def no_slack(s: Layout) -> Comparison:
    """Lowest tension at peak torque in both directions, at both ends of travel, with the wraps that are left there."""
    peak = s.drive.loads.peak_torque_Nm
    si = s.loads.si
    found, ends = [], s.wraps_at_ends_rad
    if not ends:
        raise NoFigureError("the terminals have no place, so that no wrap is known")
    for wraps in ends:
        try:
            tension = solve_equilibrium(si.with_(**wraps), np.array([peak, -peak])).tension_N
        except ModelError as error:
            raise NoFigureError(f"the model has no answer: {error}") from None
        for k, c in enumerate(s.drive.cables):
            low = float(tension[k].min())
            found.append(at_least(f"lowest tension of {c.name} at +-{peak:g} N m", low, SLACK_SHARE * c.preload_N, "N"))
    return worst(found)


def tension(s: Layout) -> Comparison:
    """Breaking load divided by the largest tension at peak torque."""
    highest = s.loads.highest_N
    return at_least(
        f"breaking load {s.drive.cable.breaking_load_N:g} N over the largest tension {highest:.4g} N",
        s.drive.cable.breaking_load_N / highest,
        s.drive.limits.tension_safety_factor,
        "times",
    )


def preload_share(s: Layout) -> Comparison:
    """Preload divided by breaking load."""
    most = max(s.drive.cables, key=lambda c: c.preload_N)
    return at_most(
        f"preload of {most.name} over the breaking load",
        most.preload_N / s.drive.cable.breaking_load_N,
        s.drive.limits.preload_share_max,
        "of breaking load",
    )


def termination_fits(s: Layout) -> Comparison:
    """The chosen termination suits the rope's construction, and the rope's diameter lies within its range."""
    end, rope = s.drive.termination, s.drive.cable
    if rope.construction not in end.constructions:
        what = f"{end.name} ends are made on {', '.join(end.constructions)}, not on {rope.construction}:"
        return at_least(what, 0.0, 1.0, "fitting constructions")
    return worst(
        (
            at_least(f"diameter for {end.name} ends", rope.diameter_mm, end.smallest_mm, "mm"),
            at_most(f"diameter for {end.name} ends", rope.diameter_mm, end.largest_mm, "mm"),
        )
    )


def _other_termination(s: Layout) -> str:
    """The terminations that fit the rope, the strongest first."""
    rope = s.drive.cable
    fitting = sorted((e for e in s.drive.terminations if e.fits(rope)), key=lambda e: -e.strength_share)
    if not fitting:
        low, high = min(e.smallest_mm for e in s.drive.terminations), max(e.largest_mm for e in s.drive.terminations)
        return f"choose a rope of {low:g} to {high:g} mm: no termination of the catalogue fits this one"
    return f"choose rope.termination: {' or '.join(e.name for e in fitting)}, or leave it out"


def cable_ends(s: Layout) -> Comparison:
    """Strength of the terminal, and of the stop on the input behind its dead turn, against the cable's force."""
    highest, end = s.loads.highest_N, s.drive.termination
    grip, factor = end.strength_share * s.drive.cable.breaking_load_N, s.drive.limits.tension_safety_factor
    terminal = at_least(f"{end.name} terminal: {grip:.4g} N over {highest:.4g} N", grip / highest, factor, "times")
    if s.loads.si.through_wrap_rad is not None:
        return terminal
    at_stop = highest * exp(-s.drive.friction_coefficient * tau * s.drive.dead_turns)
    return worst(
        (
            terminal,
            at_least(f"{end.name} stop: {grip:.4g} N over {at_stop:.4g} N there", grip / at_stop, factor, "times"),
        )
    )


def _stronger_rope(measure: Callable[[Layout], Comparison], more: str = "") -> Callable[[Layout], str]:
    """Advice with the breaking load at which ``measure`` holds at these tensions, and the weakest rope that has it."""

    def advice(s: Layout) -> str:
        found, rope = measure(s), s.drive.cable
        least_N = rope.breaking_load_N * max(found.limit / found.actual, found.actual / found.limit)
        fitting = (
            (entry["breaking_load_N"], name)
            for name, entry in package_entries("ropes").items()
            if entry["construction"] == rope.construction and entry["breaking_load_N"] >= least_N
        )
        weakest = min(fitting, default=None)
        such = f" (such as {weakest[1]})" if weakest else ""
        return f"choose a rope that breaks at {rounded(least_N, ceil)} N or more{such}{more}"

    return advice


def rated_input_Nm(s: Layout) -> float:
    """Motor's rated torque through the gearhead, lossless as the paper counts."""
    return s.drive.motor.rated_torque_mNm * 1e-3 * s.drive.reduction.ratio


def preload_bias(s: Layout) -> Comparison:
    """Torque on each input from the preload alone, T_2 r_2 - T_1 r_1; equal preloads on unequal radii do not cancel."""
    bias = s.loads.input_torque_Nm[0]
    rated = rated_input_Nm(s)
    listed = ", ".join(f"{name} {value * 1e3:+.4g} mN m" for name, value in zip(s.drive.input_names, bias, strict=True))
    k = int(np.argmax(np.abs(bias)))
    return at_most(
        f"preload bias {listed}: share of the rated {rated * 1e3:.4g} mN m on {s.drive.input_names[k]}",
        abs(float(bias[k])) / rated,
        BIAS_SHARE,
        "of rated torque",
    )


def balanced_preloads(s: Layout) -> str:
    """Advice with preloads T ~ 1/r within each pair, and the torques that the drive then reaches."""
    try:
        si = s.loads.si
    except NoFigureError:
        return ""
    balanced = balanced_preload_N(si)
    freed = si.with_(preload_N=balanced)
    both = [float(torque_at_input_limit_Nm(freed, rated_input_Nm(s), sign).min()) for sign in (1, -1)]
    given = ", ".join(f"{c.name} {value:.4g}" for c, value in zip(s.drive.cables, balanced, strict=True))
    return (
        f"set preload_N of each cable, T ~ 1/r ({given} N), which leaves no bias on any input and reaches "
        f"{both[0]:.4g} and {both[1]:.4g} N m"
    )


def _less_bias(s: Layout) -> str:
    """Advice to lower the preload, since the bias grows with it."""
    most = max(c.preload_N for c in s.drive.cables)
    fitting = floored(BIAS_SHARE / preload_bias(s).actual * most)
    return f"lower rope.preload_N to at most {fitting} or {balanced_preloads(s)}"


CHECKS = (
    Check(
        "no_slack",
        "No cable slack at peak torque",
        "paper section 3; a hundredth of the preload: estimate",
        no_slack,
        adjust=(up("rope.preload_N"), down("loads.peak_torque_Nm")),
    ),
    Check(
        "tension",
        "Tension against the breaking load",
        "limits.tension_safety_factor; rope makers: 5 to 10",
        tension,
        adjust=(down("loads.peak_torque_Nm"), down("rope.preload_N")),
        advice=_stronger_rope(tension),
    ),
    Check(
        "preload_share",
        "Preload against the breaking load",
        "limits.preload_share_max; rope makers: under half",
        preload_share,
        adjust=(down("rope.preload_N"),),
        advice=_stronger_rope(preload_share),
    ),
    Check(
        "termination_fits",
        "Terminations fit the rope",
        "catalogue of terminations",
        termination_fits,
        advice=_other_termination,
    ),
    Check(
        "cable_ends",
        "Ends hold the cable",
        "limits.tension_safety_factor; strength share in the catalogue of terminations",
        cable_ends,
        adjust=(up("rope.dead_turns"), down("loads.peak_torque_Nm"), down("rope.preload_N")),
        advice=_stronger_rope(cable_ends, " or a stronger rope.termination"),
    ),
    Check(
        "preload_bias",
        "Bias of the preload on each input",
        "model: T_2 r_2 - T_1 r_1; a tenth of the rated torque: estimate",
        preload_bias,
        "warn",
        advice=_less_bias,
    ),
)
