"""The quasi-static rig: angles of drum and input pulleys at which every torque balances, sample by sample.

Unknown are the drum's angle and the angle of each input pulley that a gearhead with compliance or play drives:

    drum    sum_j (sigma_j r_oj - lever_j - z s_j r_oj) T_j = M
    input   s(phi - theta) = sum_j sigma_j r_ij T_j         s: gearhead's shaft with play, phi the gearhead's angle

lever_j is what the path of cable j grows by per drum angle, s_j the share of its tension that it loses where it bends
on passed bodies and drum, against the motion: z is from -1 to 1.

Newton steps with a line search, and where these stop at the end of a play, bisection; the tensions come from
:mod:`mbcdm_cad.rig.chain` without a change of its state, which is updated when the balance is found. The drum wrap
moves with the predicted drum angle (that of the inputs over the ratio), whose error is below a milliradian and is
corrected one sample later.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig import chain
from mbcdm_cad.rig.chain import Chains, carry, look, settle, strain
from mbcdm_cad.rig.through import go_over
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

_STEPS = 80
_HALVINGS, _MOST_HALVINGS = 12, 40
# Bisection: first reach to each side in rad, how often it is doubled, and how often an interval is halved.
_REACH_RAD, _DOUBLINGS, _BISECTIONS = 1e-7, 24, 48
# Share of the shaft's stiffness inside its play, so that a pulley free within its play has one equilibrium angle.
_IN_PLAY = 1e-4


@compiled
def shaft(twist_rad: float, stiffness: float, play_rad: float) -> tuple[float, float]:
    """Torque of a shaft with play, N m, and its slope, which is small but not zero inside the play."""
    inside = min(max(twist_rad, -0.5 * play_rad), 0.5 * play_rad)
    slope = stiffness * _IN_PLAY if abs(twist_rad) < 0.5 * play_rad else stiffness
    return stiffness * (twist_rad - inside) + stiffness * _IN_PLAY * inside, slope


class QuasistaticCourse(NamedTuple):
    """The course of a run over n samples.

    ``input_of`` (n_cables,) is the input of each cable; ``gears`` (n_inputs, 2): stiffness in N m/rad (infinite: held)
    and play in rad; ``motor`` (n_inputs, n) gearhead angles; ``path`` and ``lever`` (n_cables, n) extra path in m and
    its slope in m/rad about the ``predicted`` drum angle (n,); ``load`` (n,) N m; ``strains`` (n_cables, w, n)
    stress-free strain of rope over bed on each wrap, or n = 0; ``through`` (m, 2) the two sides of each cable that is
    anchored nowhere on its input. ``rub`` (n_cables,): share of its tension that a cable loses by bending on passed
    bodies and drum; ``slide`` (n,): sense of the motion that friction opposes, -1 to 1.
    """

    input_of: NDArray[np.int64]
    gears: Floats
    motor: Floats
    path: Floats
    lever: Floats
    predicted: Floats
    load: Floats
    strains: Floats
    through: NDArray[np.int64]
    rub: Floats
    slide: Floats


class _Leftover(NamedTuple):
    """Residual torques (pulleys, then drum), their slopes, and the tensions."""

    miss: Floats
    slopes: Floats
    tension: Floats


@compiled
def _misses(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> float:
    """Fill ``left`` for the angles ``x`` (pulleys, then drum) in sample ``k``; returns the sum of squares."""
    input_of, gears, miss, slopes, tension = course.input_of, course.gears, left.miss, left.slopes, left.tension
    n_inputs = gears.shape[0]
    miss[:] = 0.0
    slopes[:] = 0.0
    for j in range(input_of.size):
        c, i, lever = chains.constants[j], input_of[j], course.lever[j, k]
        inner, outer = c[chain.SIGMA] * c[chain.INPUT_RADIUS], c[chain.SIGMA] * c[chain.DRUM_RADIUS] - lever
        delta = inner * x[i] - outer * x[n_inputs] + course.path[j, k] - lever * course.predicted[k]
        tension[j], rate = look(chains, j, delta)
        pull = outer - course.slide[k] * course.rub[j] * c[chain.DRUM_RADIUS]
        miss[n_inputs] += pull * tension[j]
        miss[i] -= inner * tension[j]
        slopes[n_inputs, n_inputs] -= pull * outer * rate
        slopes[i, i] -= inner * inner * rate
        slopes[i, n_inputs] += inner * outer * rate
        slopes[n_inputs, i] += inner * pull * rate
    miss[n_inputs] -= course.load[k]
    for i in range(n_inputs):
        if math.isinf(gears[i, 0]):
            # A rigid gearhead holds the pulley at the motor's angle: not an unknown.
            miss[i] = 0.0
            slopes[i, :] = 0.0
            slopes[:, i] = 0.0
            slopes[i, i] = -1.0
        else:
            torque, slope = shaft(course.motor[i, k] - x[i], gears[i, 0], gears[i, 1])
            miss[i] += torque
            slopes[i, i] -= slope
    total = 0.0
    for i in range(n_inputs + 1):
        total += miss[i] * miss[i]
    return total


@compiled
def _newton(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover, scale: float) -> float:
    """Bring the angles ``x`` to balance by Newton steps; returns the sum of squares (N m)^2 that is left."""
    trial = np.empty_like(x)
    size = _misses(chains, course, k, x, left)
    for _ in range(_STEPS):
        if size <= (1e-12 * scale) ** 2:
            break
        step = np.linalg.solve(left.slopes - 1e-9 * np.eye(x.size), left.miss)
        share, better = 1.0, False
        for halved in range(_MOST_HALVINGS):
            # At the end of a play the slope changes by orders of magnitude: only there many are needed.
            if halved >= _HALVINGS and size <= (1e-7 * scale) ** 2:
                break
            trial[:] = x - share * step
            there = _misses(chains, course, k, trial, left)
            if there < size:
                better = True
                break
            share *= 0.5
        if not better:
            break
        x[:] = trial
        size = there
    return size


@compiled
def _bisect(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> None:
    """Bring the angles ``x`` to balance by bisection of the drum's angle; as they were where no interval has a balance.

    At the end of a play the sum of squares has a valley that Newton steps do not leave. But the torque on each pulley
    falls with its own angle, and that on the drum with the drum's where the pulleys follow.
    """
    begun, drum = x.copy(), x.size - 1
    low = high = x[drum]
    reach = _REACH_RAD
    for _ in range(_DOUBLINGS):
        _follow(chains, course, k, x, left)
        if left.miss[drum] > 0.0:
            low, high = x[drum], x[drum] + reach
            x[drum] = high
            _follow(chains, course, k, x, left)
            if left.miss[drum] <= 0.0:
                break
        else:
            low, high = x[drum] - reach, x[drum]
            x[drum] = low
            _follow(chains, course, k, x, left)
            if left.miss[drum] > 0.0:
                break
        reach *= 2.0
    else:
        x[:] = begun
        return
    for _ in range(_BISECTIONS):
        x[drum] = 0.5 * (low + high)
        _follow(chains, course, k, x, left)
        if left.miss[drum] > 0.0:
            low = x[drum]
        else:
            high = x[drum]


@compiled
def _follow(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> None:
    """Turn every pulley to where its own torques balance at the drum's angle, by bisection; a held one stays."""
    n_inputs = x.size - 1
    low, high = x[:n_inputs].copy(), x[:n_inputs].copy()
    reach = _REACH_RAD
    for _ in range(_DOUBLINGS):
        between = True
        x[:n_inputs] = low
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] < 0.0:
                low[i] -= reach
                between = False
        x[:n_inputs] = high
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] > 0.0:
                high[i] += reach
                between = False
        if between:
            break
        reach *= 2.0
    for _ in range(_BISECTIONS):
        x[:n_inputs] = 0.5 * (low + high)
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] > 0.0:
                low[i] = x[i]
            else:
                high[i] = x[i]


@compiled
def run(chains: Chains, course: QuasistaticCourse, pulleys: Floats, drum: Floats, tension: Floats) -> int:
    """Fill ``pulleys`` (n_inputs, n), ``drum`` (n,) in rad and ``tension`` (n_cables, n) in N; the sample at which no
    balance was found, or -1."""
    motor, predicted, strains, input_of = course.motor, course.predicted, course.strains, course.input_of
    n_inputs, n_cables = motor.shape[0], input_of.size
    x = np.zeros(n_inputs + 1)
    left = _Leftover(np.empty(n_inputs + 1), np.empty((n_inputs + 1, n_inputs + 1)), np.empty(n_cables))
    scale = 0.0
    for j in range(n_cables):
        scale += chains.constants[j, chain.PRELOAD] * chains.constants[j, chain.DRUM_RADIUS]
    before = np.zeros(n_inputs + 1)
    for k in range(predicted.size):
        for i in range(n_inputs):
            x[i] += motor[i, k] - before[i]
            before[i] = motor[i, k]
        x[n_inputs] += predicted[k] - before[n_inputs]
        before[n_inputs] = predicted[k]
        for j in range(n_cables):
            carry(chains, j, float(x[input_of[j]]), float(x[n_inputs]))
            if strains.shape[2] > 0 and k > 0:
                strain(chains, j, strains[j, :, k] - strains[j, :, k - 1])
        size = _newton(chains, course, k, x, left, scale)
        if not size <= (1e-7 * scale) ** 2:
            _bisect(chains, course, k, x, left)
            size = _newton(chains, course, k, x, left, scale)
        if not size <= (1e-7 * scale) ** 2:
            return k
        for j in range(n_cables):
            settle(chains, j, left.tension[j])
            tension[j, k] = left.tension[j]
        for m in range(course.through.shape[0]):
            if not go_over(chains, course.through[m, 0], course.through[m, 1]):
                return k
        pulleys[:, k] = x[:n_inputs]
        drum[k] = x[n_inputs]
    return -1
