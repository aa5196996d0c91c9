"""The equilibrium of all cables while every input is held, its solver, and the loads that follow, on bodies too.

Cable j stretches by delta_j = sigma_j (r_ij theta_i - r_oj theta_o), and sum_j sigma_j T_j r_oj = M_l (M_l > 0 opposes
positive rotation).

The numerical core solves many cases at once. Find the drum angle theta so that sum_j weight_j T_j = goal, with
delta_j(T_j) = offset_j - lever_j theta for every cable that is not slack. Every delta_j is strictly increasing in T_j
and weight_j lever_j >= 0, so the solution is unique. Newton's method on all tensions together, which removes and adds
cables as they become slack or tight, converges in a few steps. Cases that do not converge are solved with one unknown
inside a bracket, which is slow but always converges.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.si import DriveSI, ModelError, content_of
from mbcdm_cad.model.wrap import slack_stretch_m, stretch_after_reversal, stretch_first_loading
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import BodyLoad, body_load

NEWTON_STEPS = 40
BRACKETED_STEPS = 300
WIDENINGS = 60
# Newton's method converges quadratically: after a step this small the next one is below rounding.
RELATIVE_STEP = 1e-10
# In one step a tension falls at most to this share, because the cable law ends at zero.
SMALLEST_SHARE = 0.2
# Tension at which a cable that was slack starts again, as a share of its preload.
TAUT_AGAIN = 1e-3
# Solutions with so many tensions at most are kept, this many of them: checks of a design, its figures and the trials of
# its sizing ask for the same.
KEPT_SIZE, KEPT = 64, 512
# A tension below this share of the preload counts as zero: it is far below the rounding errors of the others.
FAINT_SHARE = 1e-12
_solved: "dict[tuple[Any, ...], Equilibrium]" = {}


def stretch(d: DriveSI, tension_N: Floats, turned_at_N: Floats | None) -> tuple[Floats, Floats]:
    """Stretch (m) and its slope (m/N) on first loading, or after a reversal at ``turned_at_N``."""
    if turned_at_N is None:
        return stretch_first_loading(d, tension_N)
    return stretch_after_reversal(d, tension_N, np.maximum(turned_at_N, FAINT_SHARE * d.preload_N))


def slack_limit_m(d: DriveSI) -> Floats:
    """Stretch (m) at and below which a cable counts as slack: that of ``FAINT_SHARE`` of its preload, or of none."""
    if d.endless_wraps:
        # The formula of the law is written out here because every solution evaluates it.
        lost = (1.0 - FAINT_SHARE) * d.free_span_m + (FAINT_SHARE - 1.0 - math.log(FAINT_SHARE)) * d.slip_reach_m
        return np.asarray(-d.preload_N / d.axial_stiffness_N * lost)
    faint, _ = stretch_first_loading(d, FAINT_SHARE * d.preload_N)
    return np.maximum(faint, slack_stretch_m(d))


def _over_cables(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("j...,j...->...", a, b))


def balance(
    d: DriveSI, weight: Floats, goal: Floats, lever: Floats, offset: Floats, turned_at_N: Floats | None = None
) -> tuple[Floats, Floats]:
    """Drum angle (...) in rad and tensions (n_cables, ...) in N. Arrays are at full shape, ``d`` broadcasts to it.

    Errors: ``ModelError`` where no drum angle reaches the goal.
    """
    preload = np.broadcast_to(d.preload_N, lever.shape)
    missing = goal - _over_cables(weight, preload)
    tension = np.maximum(preload + missing * weight / _over_cables(weight, weight), SMALLEST_SHARE * preload)
    taut_limit = slack_limit_m(d)
    slack = np.zeros(lever.shape, dtype=bool)
    theta, done = np.zeros(goal.shape), np.zeros(goal.shape, dtype=bool)
    for _ in range(NEWTON_STEPS):
        some_slack = slack.any()
        now, slope = stretch(d, np.where(slack, preload, tension) if some_slack else tension, turned_at_N)
        ease = np.where(slack, 0.0, weight / slope) if some_slack else weight / slope
        linear = _over_cables(weight, tension) + _over_cables(ease, offset - now)
        with np.errstate(divide="ignore", invalid="ignore"):
            theta = (linear - goal) / _over_cables(ease, lever)
        wanted = offset - lever * theta
        step = (wanted - now) / slope
        lowest = SMALLEST_SHARE * tension
        following = np.maximum(tension + step, lowest)
        settled = (np.abs(step) <= RELATIVE_STEP * preload) & (tension + step >= lowest)
        gone = wanted <= taut_limit
        if some_slack or gone.any():
            settled = np.where(gone | slack, gone & slack, settled)
            following = np.where(gone, 0.0, np.where(slack, TAUT_AGAIN * preload, following))
            slack = gone
        tension = following
        done = settled.all(axis=0) & np.isfinite(theta)
        if done.all():
            return theta, tension
    rest = ~done
    part, columns = _only(d, goal.shape, rest), [a[:, rest] for a in (weight, lever, offset)]
    turned = None if turned_at_N is None else np.broadcast_to(turned_at_N, lever.shape)[:, rest]
    theta, tension = np.array(theta), np.array(tension)
    theta[rest], tension[:, rest] = _bracketed(part, columns[0], goal[rest], columns[1], columns[2], turned)
    return theta, tension


def tension_of_stretch(d: DriveSI, stretch_m: Floats, turned_at_N: Floats | None = None) -> Floats:
    """Inverse of the stretch, N, shape of ``stretch_m``; 0 beyond the slack limit. Newton inside a bracket: safe."""
    start = d.preload_N if turned_at_N is None else np.maximum(d.preload_N, turned_at_N)
    # Friction only makes a cable softer, so the free span alone gives an upper bound of the tension.
    high = start + np.abs(stretch_m) * d.axial_stiffness_N / d.free_span_m
    if turned_at_N is not None:
        # Counted from the turning point, the stretch may be larger by that of the turning point itself.
        turned = np.maximum(turned_at_N, FAINT_SHARE * d.preload_N)
        high = high + np.abs(stretch_first_loading(d, turned)[0]) * d.axial_stiffness_N / d.free_span_m
    slack = stretch_m <= slack_limit_m(d)
    low, tension = FAINT_SHARE * d.preload_N + np.zeros_like(high), start + np.zeros_like(high)
    for _ in range(BRACKETED_STEPS):
        now, slope = stretch(d, tension, turned_at_N)
        low, high = np.where(now < stretch_m, tension, low), np.where(now >= stretch_m, tension, high)
        newton = tension + (stretch_m - now) / slope
        # Geometric mean while the bounds are far apart (a tension may be tiny), arithmetic mean at the end.
        middle = np.where(high > 4.0 * low, np.sqrt(high * low), 0.5 * (low + high))
        following = np.where((newton > low) & (newton < high), newton, middle)
        settled = np.abs(following - tension) <= 1e-15 * tension
        tension = following
        if (settled | slack).all():
            break
    return np.asarray(np.where(slack, 0.0, tension))


def _only(d: DriveSI, shape: tuple[int, ...], which: Any) -> DriveSI:
    """The cases ``which`` (a mask of ``shape``) as a flat batch."""
    return d.mapped(
        lambda v: np.broadcast_to(v, (d.n_cables, *shape))[:, which], lambda v: np.broadcast_to(v, shape)[which]
    )


def _bracketed(
    d: DriveSI, weight: Floats, goal: Floats, lever: Floats, offset: Floats, turned_at_N: Floats | None
) -> tuple[Floats, Floats]:
    """The same solution with one unknown, the drum angle, inside a bracket; tensions are solved at each angle."""

    def pulled(angle: Floats) -> tuple[Floats, Floats, Floats]:
        tension = tension_of_stretch(d, offset - lever * angle, turned_at_N)
        _, slope = stretch(d, np.where(tension > 0.0, tension, d.preload_N), turned_at_N)
        fall = _over_cables(np.where(tension > 0.0, weight / slope, 0.0), lever)
        return tension, _over_cables(weight, tension) - goal, fall

    angle = _over_cables(lever, offset) / _over_cables(lever, lever)
    reach = np.max(d.preload_N / d.axial_stiffness_N * d.free_span_m / d.drum_radius_m, axis=0)
    low, high = angle - reach, angle + reach
    for _ in range(WIDENINGS):
        short, long = pulled(low)[1] < 0.0, pulled(high)[1] > 0.0
        if not (short | long).any():
            break
        low, high = np.where(short, low - 4.0 * (high - low), low), np.where(long, high + 4.0 * (high - low), high)
    else:
        worst = float(np.max(np.abs(goal[short | long])))
        raise ModelError(
            f"no drum angle balances {worst:.6g} (N m or N): every cable that could hold it is slack; raise preload_N"
        )
    for _ in range(BRACKETED_STEPS):
        tension, excess, fall = pulled(angle)
        low, high = np.where(excess > 0.0, angle, low), np.where(excess <= 0.0, angle, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = angle + excess / fall
        following = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
        if (np.abs(following - angle) <= 1e-16 + 1e-15 * np.abs(angle)).all():
            break
        angle = following
    return angle, tension


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Drum angle (rad, shape (...)), tensions (N) and stretches (m) of the cables, shape (n_cables, ...)."""

    drum_angle_rad: Floats
    tension_N: Floats
    stretch_m: Floats

    def input_torque_Nm(self, d: DriveSI) -> Floats:
        """Torque that holds each input, sum_j sigma_j T_j r_ij over its cables, shape (n_inputs, ...)."""
        return sum_per_input(d, self.tension_N, d.lifted(self.drum_angle_rad.shape).input_radius_m)

    def drum_torque_by_input_Nm(self, d: DriveSI) -> Floats:
        """Torque of the cables of each input on the drum, sum_j sigma_j T_j r_oj, N m, shape (n_inputs, ...)."""
        return sum_per_input(d, self.tension_N, d.lifted(self.drum_angle_rad.shape).drum_radius_m)

    def load_share(self, d: DriveSI, load_Nm: Any) -> Floats:
        """Share of the load that each input takes: the change of its drum torque from no load, over the load."""
        idle = solve_equilibrium(d, 0.0)
        before = idle.drum_torque_by_input_Nm(d)
        now = self.drum_torque_by_input_Nm(d)
        before = before.reshape(before.shape[0], *(1,) * (now.ndim - before.ndim), *before.shape[1:])
        return np.asarray((now - before) / np.asarray(load_Nm, dtype=float))

    @property
    def slack(self) -> Any:
        """True where a cable carries no tension, shape (n_cables, ...)."""
        return self.tension_N <= 0.0


def sum_per_input(d: DriveSI, tension: Floats, radius: Floats) -> Floats:
    """Torque of the cables of each input, sum_j sigma_j T_j r_j, shape (n_inputs, ...)."""
    pull = d.column(d.sigma, tension.ndim) * tension * radius
    return np.stack([pull[[j for j, k in enumerate(d.input_of) if k == i]].sum(axis=0) for i in range(d.n_inputs)])


def solve_equilibrium(
    d: DriveSI, load_Nm: Any, input_angle_rad: Any = None, path_m: Any = None, turned_at_N: Floats | None = None
) -> Equilibrium:
    """Drum angle and tensions under ``load_Nm`` (shape broadcastable to the batch, or any shape for one design).

    ``input_angle_rad`` (n_inputs, ...) defaults to zero: both inputs locked where they were preloaded. ``path_m``
    (n_cables, ...) lengthens the path of each cable, as an eccentric pulley does, and is added to its stretch.
    ``turned_at_N`` (n_cables, ...) are the tensions from which a first loading was reversed; without it this is the
    first loading. Errors: ``ModelError`` where no drum angle carries the load.
    """
    load = np.asarray(load_Nm, dtype=float)
    given = [np.shape(a)[1:] for a in (input_angle_rad, path_m) if a is not None]
    shape = np.broadcast_shapes(load.shape, d.batch_shape, *given)
    wide = d.lifted(shape)
    weight = d.column(d.sigma, len(shape) + 1) * wide.drum_radius_m
    return solve_weighted(wide, weight, np.broadcast_to(load, shape), input_angle_rad, path_m, turned_at_N)


def solve_weighted(
    d: DriveSI,
    weight: Floats,
    target: Any,
    input_angle_rad: Any = None,
    path_m: Any = None,
    turned_at_N: Floats | None = None,
) -> Equilibrium:
    """The equilibrium at which sum_j weight_j T_j = ``target``.

    ``weight`` (n_cables, ...) has sigma's sign or is zero, not all zero. With the drum's radii the target is the load;
    with the input radii of one input it is that input's torque; with one cable alone it is sigma times its tension.
    ``d`` must already be lifted to the shape of the answer. Other arguments as in :func:`solve_equilibrium`.
    """
    goal = np.asarray(target, dtype=float)
    shape = np.broadcast_shapes(goal.shape, d.batch_shape, weight.shape[1:])
    full = (d.n_cables, *shape)
    sigma = d.column(d.sigma, len(full))
    lever = np.broadcast_to(sigma * d.drum_radius_m, full)
    offset = np.zeros(full)
    if input_angle_rad is not None:
        angle = np.asarray(input_angle_rad, dtype=float)[list(d.input_of)]
        offset = offset + sigma * d.input_radius_m * d.column(angle, len(full))
    if path_m is not None:
        offset = offset + d.column(np.asarray(path_m, dtype=float), len(full))
    asked = np.broadcast_to(weight, full), np.broadcast_to(goal, shape), lever, offset
    if lever.size > KEPT_SIZE:
        theta, tension = balance(d, *asked, turned_at_N)
        return Equilibrium(theta, tension, offset - lever * theta)
    key = (*d.law_key, *content_of(*asked, *(() if turned_at_N is None else (turned_at_N,))))
    # Threads share what is kept: one may clear it while another has just looked.
    known = _solved.get(key)
    if known is None:
        theta, tension = balance(d, *asked, turned_at_N)
        known = Equilibrium(*(_fixed(found) for found in (theta, tension, offset - lever * theta)))
        if len(_solved) >= KEPT:
            _solved.clear()
        _solved[key] = known
    return known


def _fixed(found: Floats) -> Floats:
    """An array that nobody changes, since others get it too."""
    found = np.asarray(found)
    found.setflags(write=False)
    return found


@dataclass(frozen=True)
class BearingLoads:
    """The load on each body, by name."""

    bodies: dict[str, BodyLoad]
    inputs: tuple[BodyLoad, ...]
    drum: BodyLoad


def bearing_loads(d: DriveSI, tension_N: Floats) -> BearingLoads:
    """Loads for the free-span tensions of one design and one load, shape (n_cables,)."""
    loads = {body.name: body_load(d.routes, body.name, tension_N) for body in d.routes.bodies}
    return BearingLoads(loads, tuple(loads[body.name] for body in d.routes.inputs), loads[d.routes.drum.name])


class CableTensions:
    """Cable tensions (N), shape (n_cables,), in the states that the strength checks use."""

    def __init__(self, drive: Drive, si: DriveSI) -> None:
        peak, test = drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm
        self.si, self._loads = si, drive.loads
        self.torques_Nm = np.array([0.0, peak, -peak, test, -test])
        self.equilibrium = solve_equilibrium(si, self.torques_Nm)
        tension = self.equilibrium.tension_N
        self.idle, self.peak_forward, self.peak_back, self.test_forward, self.test_back = tension.T
        self.input_torque_Nm = self.equilibrium.input_torque_Nm(si).T  # (state, input), states as above

    def are_those_of(self, drive: Drive, si: DriveSI) -> bool:
        """Whether another drive has the same, because nothing differs that they follow from."""
        return self._loads == drive.loads and self.si.is_same(si)

    @property
    def test_urad_Nm(self) -> float:
        """Turn of the drum by its cables at the test torque, over that torque, urad per N m."""
        idle, test = self.equilibrium.drum_angle_rad[[0, 3]]
        return abs(float(test - idle)) / self._loads.test_torque_Nm * 1e6

    @property
    def states(self) -> tuple[tuple[str, NDArray[np.float64]], ...]:
        """Unloaded and at peak torque both ways."""
        return (("no load", self.idle), ("+peak torque", self.peak_forward), ("-peak torque", self.peak_back))

    @cached_property
    def on_bodies(self) -> tuple[BearingLoads, ...]:
        """Loads of the cables on every body in these states."""
        return tuple(bearing_loads(self.si, tension) for _, tension in self.states)

    @property
    def highest_N(self) -> float:
        """Largest tension of any cable in these states."""
        return float(max(tension.max() for _, tension in self.states))

    @property
    def highest_input_Nm(self) -> float:
        """Largest torque on an input pulley in these states."""
        return float(np.abs(self.input_torque_Nm[:3]).max())
