"""Cables under load and in time: slack, strength, torque on each input from the preloads; creep; life.

The generic figure of the life may fail a wanted life, or warn of it; it never shows one. Only a test of the rope
(``life_anchor``) does.
"""

from collections.abc import Iterator
from math import ceil, exp, tau

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Family, Findings, at_least, at_most, check, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.design.catalogue import smallest_entry
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.model.capability import SLACK_SHARE, balanced_preload_N, torque_at_input_limit_Nm, torque_at_slip_Nm
from mbcdm_cad.model.creep import DAY_S, TOLD_C, creeps, relaxation
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.rope_bendings import MOST_BENDINGS
from mbcdm_cad.model.si import DriveSI, ModelError

# Share of an input's rated torque that the preload alone may take (estimate).
BIAS_SHARE = 0.1
# Shortest acceptable time between two tensionings (estimate).
RETENSION_DAYS = 30.0
_HALVINGS = 12
_TEST_IT = "not shown: the generic figure shows no life; test the rope and state its life_anchor"
_ADJUST = (*down(at.rope.preload_N), *up("all radii of transmission"))


def wound_ends(s: Layout, si: DriveSI) -> Iterator[tuple[DriveSI, np.ndarray]]:
    """The model with the wraps at each end of the travel, and its tensions at the peak torque in both directions.

    Raises ``NoFigureError`` where it has no answer, or where no wrap is known.
    """
    peak, ends = s.drive.loads.peak_torque_Nm, s.wraps_at_ends_rad
    if not ends:
        raise NoFigureError("the terminals have no place, so that no wrap is known")
    for wraps in ends:
        wound = si.with_(**wraps)
        try:
            yield wound, solve_equilibrium(wound, np.array([peak, -peak])).tension_N
        except ModelError as error:
            raise NoFigureError(f"the model has no answer: {error}") from None


UNDER_LOAD = Family(
    "Cables under load: no cable slack, no cable near breaking, and the torque on each input from the preloads."
)


@check(
    "No cable slack at peak torque",
    "paper section 3; a hundredth of the preload: estimate",
    *up(at.rope.preload_N),
    *down(at.loads.peak_torque_Nm),
    unit="N",
)
def no_slack(s: Layout) -> Findings:
    """Lowest tension at peak torque in both directions, at both ends of travel, with the wraps that are left there."""
    for _, tension in wound_ends(s, s.loads.si):
        for c, each in zip(s.drive.cables, tension, strict=True):
            what = f"lowest tension of {c.name} at +-{s.drive.loads.peak_torque_Nm:g} N m"
            yield what, float(each.min()), SLACK_SHARE * c.preload_N


def _stronger_rope(s: Layout, found: Comparison) -> str:
    """Advice with the breaking load at which the check holds at these tensions, and the weakest rope that has it."""
    rope = s.drive.cable
    least_N = rope.breaking_load_N * max(found.limit / found.actual, found.actual / found.limit)
    weakest = smallest_entry(
        "ropes", "breaking_load_N", lambda e: e["construction"] == rope.construction and e["breaking_load_N"] >= least_N
    )
    such = f" (such as {weakest})" if weakest else ""
    return f"choose a rope that breaks at {rounded(least_N, ceil)} N or more{such}"


@check(
    "Tension against the breaking load",
    "limits.tension_safety_factor; rope makers: 5 to 10",
    *down(at.loads.peak_torque_Nm, at.rope.preload_N),
    advice_on=_stronger_rope,
    unit="times",
)
def tension(s: Layout) -> Findings:
    """Breaking load divided by the largest tension at peak torque."""
    highest = s.loads.highest_N
    what = f"breaking load {s.drive.cable.breaking_load_N:g} N over the largest tension {highest:.4g} N"
    yield what, s.drive.cable.breaking_load_N / highest, s.drive.limits.tension_safety_factor


@check(
    "Preload against the breaking load",
    "limits.preload_share_max; rope makers: under half",
    *down(at.rope.preload_N),
    advice_on=_stronger_rope,
)
def preload_share(s: Layout) -> Comparison:
    """Preload divided by breaking load."""
    most = max(s.drive.cables, key=lambda c: c.preload_N)
    what = f"preload of {most.name} over the breaking load"
    return at_most(
        what, most.preload_N / s.drive.cable.breaking_load_N, s.drive.limits.preload_share_max, "of breaking load"
    )


def _other_termination(s: Layout) -> str:
    """The terminations that fit the rope, the strongest first."""
    rope = s.drive.cable
    fitting = sorted((e for e in s.drive.terminations if e.fits(rope)), key=lambda e: -e.strength_share)
    if not fitting:
        low, high = min(e.smallest_mm for e in s.drive.terminations), max(e.largest_mm for e in s.drive.terminations)
        return f"choose a rope of {low:g} to {high:g} mm: no termination of the catalogue fits this one"
    return f"choose rope.termination: {' or '.join(e.name for e in fitting)}, or leave it out"


@check(
    "Terminations fit the rope", "catalogue of terminations", advice=_other_termination, unit="fitting constructions"
)
def termination_fits(s: Layout) -> Findings:
    """The chosen termination suits the rope's construction, and the rope's diameter lies within its range."""
    end, rope = s.drive.termination, s.drive.cable
    if rope.construction not in end.constructions:
        what = f"{end.name} ends are made on {', '.join(end.constructions)}, not on {rope.construction}:"
        yield what, 0.0, 1.0
        return
    yield at_least(f"diameter for {end.name} ends", rope.diameter_mm, end.smallest_mm, "mm")
    yield at_most(f"diameter for {end.name} ends", rope.diameter_mm, end.largest_mm, "mm")


@check(
    "Ends hold the cable",
    "limits.tension_safety_factor; strength share in the catalogue of terminations",
    *up(at.rope.dead_turns),
    *down(at.loads.peak_torque_Nm, at.rope.preload_N),
    advice_on=lambda s, found: f"{_stronger_rope(s, found)} or a stronger rope.termination",
    unit="times",
)
def cable_ends(s: Layout) -> Findings:
    """Strength of the terminal, and of the stop on the input behind its dead turn, against the cable's force."""
    highest, end = s.loads.highest_N, s.drive.termination
    grip, factor = end.strength_share * s.drive.cable.breaking_load_N, s.drive.limits.tension_safety_factor
    terminal = at_least(f"{end.name} terminal: {grip:.4g} N over {highest:.4g} N", grip / highest, factor, "times")
    if s.loads.si.through_wrap_rad is not None:
        yield terminal
        return
    at_stop = highest * exp(-s.drive.friction_coefficient * tau * s.drive.dead_turns)
    yield terminal
    yield f"{end.name} stop: {grip:.4g} N over {at_stop:.4g} N there", grip / at_stop, factor


def rated_input_Nm(s: Layout) -> float:
    """Motor's rated torque through the gearhead, lossless as the paper counts."""
    return s.drive.motor.rated_torque_mNm * 1e-3 * s.drive.reduction.ratio


def _less_bias(s: Layout, found: Comparison) -> str:
    """Advice to lower the preload, since the bias grows with it."""
    most = max(c.preload_N for c in s.drive.cables)
    fitting = rounded(BIAS_SHARE / found.actual * most)
    return f"lower rope.preload_N to at most {fitting} or {balanced_preloads(s)}"


@check(
    "Bias of the preload on each input",
    "model: T_2 r_2 - T_1 r_1; a tenth of the rated torque: estimate",
    advice_on=_less_bias,
    warn=True,
)
def preload_bias(s: Layout) -> Comparison:
    """Torque on each input from the preload alone, T_2 r_2 - T_1 r_1; equal preloads on unequal radii do not cancel."""
    bias = s.loads.input_torque_Nm[0]
    rated = rated_input_Nm(s)
    listed = ", ".join(f"{name} {value * 1e3:+.4g} mN m" for name, value in zip(s.drive.input_names, bias, strict=True))
    k = int(np.argmax(np.abs(bias)))
    what = f"preload bias {listed}: share of the rated {rated * 1e3:.4g} mN m on {s.drive.input_names[k]}"
    return at_most(what, abs(float(bias[k])) / rated, BIAS_SHARE, "of rated torque")


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


CREEP = Family("Creep of fibre ropes: how long the preload suffices before the cables must be tensioned again.")


def _suffices(s: Layout, share: float) -> bool:
    """Whether a share of the preloads carries the peak torque both ways: no cable slack, none slips on its input."""
    peak = s.drive.loads.peak_torque_Nm
    less = s.loads.si.with_(preload_N=s.loads.si.preload_N * share)
    try:
        for wound, tension in wound_ends(s, less):
            if np.any(tension < SLACK_SHARE * less.preload_N[:, None]):
                return False
            if less.through_wrap_rad is None:
                continue
            if min(float(torque_at_slip_Nm(wound, way).min()) for way in (1, -1)) < peak:
                return False
    except (ModelError, NoFigureError):
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


@check(
    "Preload left after the rope's creep",
    "model: creep of the catalogue; 30 days: estimate",
    *up(at.rope.preload_N),
    *down(at.loads.peak_torque_Nm),
    advice="choose a rope.type that creeps less, or a thicker one",
    warn=True,
)
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


LIFE = Family("Life of the cables against the wanted number of cycles.")


def _what_helps(s: Layout) -> str:
    """The changes that help most, with their factors of the life."""
    helps = [f"{each.change} (x{each.factor:.2g})" for each in life_of(s).helps[:3] if each.factor > 1.0]
    return f"what helps most: {', '.join(helps)}" if helps else "state the life_anchor of a test of the rope"


@check(
    "Cycles until the cables break",
    "targets.life_cycles or life_h; bendings by Feyrer's form, generic figure: estimate",
    *_ADJUST,
    advice=_what_helps,
)
def life(s: Layout) -> Comparison:
    """Cycles after which nine of ten cables have broken, against the wanted number; without one, the median."""
    found = life_of(s)
    wanted = found.wanted_cycles
    first = found.first
    if first is None:
        return noted(
            "smallest D/d of the cables; their life has no figure:", s.smallest_bend_ratio, "D/d", found.refused
        )
    low, high = first.reached(0.1), first.reached(0.9)
    if wanted is not None and high < wanted:
        what = f"cycles after which nine of ten {first.name} have broken, half of them after {first.cycles:.2g}:"
        return at_least(what, high, wanted, "cycles", found.told)
    what = f"cycles after which half of all {first.name} have broken"
    return noted(what, first.cycles, "cycles", f"one in ten after {low:.2g}, nine after {high:.2g}; {found.told}")


@check(
    "Cycles at which to replace the cables",
    "targets.life_cycles or life_h; one cable in ten, generic figure: estimate",
    *_ADJUST,
    advice=_what_helps,
    warn=True,
)
def life_shown(s: Layout) -> Comparison:
    """Cycles after which one cable in ten has broken, against the wanted number: the time to replace them."""
    found = life_of(s)
    wanted = found.wanted_cycles
    first = found.first
    if first is None and wanted is None:
        return noted("the cables' life has no figure, and the design file wants none: cycles", 0.0, "", found.refused)
    if first is None and found.longer:
        what = f"bendings at which the data end, before the cables would break; {wanted:g} cycles wanted:"
        return noted(what, MOST_BENDINGS, "bendings", _TEST_IT)
    if first is None:
        return at_least("cycles that are shown for the cables", 0.0, wanted or 0.0, "cycles", found.refused)
    low, what = first.reached(0.1), f"cycles after which one in ten {first.name} has broken"
    if wanted is None:
        return noted(f"{what}: replace it then;", low, "cycles", "the design file wants none")
    if low >= wanted and found.generic:
        return noted(f"{what}, {wanted:g} wanted:", low, "cycles", _TEST_IT)
    return at_least(what, low, wanted, "cycles", found.told)
