"""The time-series reference model: drum angle and tensions for given input angles and load, with friction history.

Both inputs are held at their measured angles; cable j stretches by delta_j = sigma_j (r_ij theta_i - r_oj theta_o) and
sum_j sigma_j T_j r_oj = M. The clip rule of :mod:`mbcdm_cad.model.wrap` has a closed form: after a reversal at T_r

    EA (delta - delta_r) = L_free (T - T_r) +- (r_i + r_o)/mu (sqrt T - sqrt T_r)^2,

a quadratic in sqrt T, until the loop closes at the previous turning point (both are then removed), or, on a branch that
left the first-loading curve at T_1, until T T_1 = T_pre^2, where the first-loading curve continues. So a stack of
turning points for each cable is its whole history, and each sample costs a few square roots. This holds for wraps that
are longer than any slip zone and do not move with the pulleys; finite wraps and winding history are in
:mod:`mbcdm_cad.model.profiles`.

A pulley with play rests on the flank that transmits its torque. Without torque it floats between the flanks, at the
angle at which the torques of its cables cancel. The friction of the cables depends on the path, so this position is
found at each sample before the cables are moved.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.model.profiles import Response, checked_series, next_angle, path_offset_m, simulate_profiles
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled, inlined

# Columns of the table of constants, one row a cable.
FREE, REACH, PRELOAD, DRUM, SIGMA = range(5)
# Columns of the table of states.
TENSION, STRETCH, DIRECTION, LEVEL, MIRROR = range(5)
STEPS = 200
VIRGIN_STEPS = 60


def simulate(d: DriveSI, input_angle_rad: Any, load_Nm: Any, path_m: Any = None, winding: bool = False) -> Response:
    """Run the model over a series.

    ``input_angle_rad`` (n_inputs, n), in the sense that drives the drum positive; ``load_Nm`` (n,) or one value, > 0
    opposing positive rotation; ``path_m`` (n_cables, n) lengthens the path of each cable, as an eccentric pulley does,
    and is added to its stretch. Before the first sample every cable holds its preload with all angles zero; the first
    sample is reached in one monotone step. ``winding`` adds the winding history: cable wound on keeps the tension it
    had. With it, and where wraps are finite, :func:`mbcdm_cad.model.profiles.simulate_profiles` computes the result.
    Errors: ``ModelError`` for shapes that do not fit, values that are not finite, a batch of designs, a friction of
    zero, a load that no drum angle balances, or a pulley that would wind off more than its wrap.
    """
    if winding or not d.endless_wraps:
        return simulate_profiles(d, input_angle_rad, load_Nm, path_m, winding)
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    drum, tension = np.empty(load.size), np.empty((d.n_cables, load.size))
    offset = (d.sigma * d.input_radius_m)[:, None] * angle[list(d.input_of)] + path_offset_m(d, path_m, load.size)
    turns = np.empty((d.n_cables, load.size + 2, 2))
    failed = _run(constants(d), offset, load, drum, tension, turns)
    if failed >= 0:
        raise ModelError(
            f"sample {failed}: no drum angle balances a load of {load[failed]:.6g} N m; check its unit and sign"
        )
    return Response(drum, tension)


def constants(d: DriveSI) -> Floats:
    """Per cable: L_free/(EA) and (r_i + r_o)/(mu EA) in m/N, preload in N, r_o in m, sigma; shape (n_cables, 5)."""
    stiffness = float(d.axial_stiffness_N)
    columns = (d.free_span_m / stiffness, d.slip_reach_m / stiffness, d.preload_N, d.drum_radius_m, d.sigma)
    return np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=1))


@compiled
def _virgin_stretch(c: Floats, tension: float) -> float:
    """First-loading curve, m; ``c`` is the cable's row of constants."""
    u = tension / c[PRELOAD]
    slip = u - 1.0 - math.log(u)
    return float(c[PRELOAD] * (c[FREE] * (u - 1.0) + (c[REACH] * slip if u >= 1.0 else -c[REACH] * slip)))


@compiled
def _virgin_tension(c: Floats, stretch: float) -> tuple[float, float]:
    """Tension and dT/d(delta) on the first-loading curve. Newton from the safe side of a convex curve."""
    kappa = c[FREE] / c[REACH]
    y = abs(stretch) / (c[PRELOAD] * c[REACH])
    f = math.sqrt(kappa * kappa + 2.0 * y) - kappa
    sign = 1.0 if stretch >= 0.0 else -1.0
    if sign < 0.0:
        f = min(f, 1.0 - math.exp(-y - 1.0))
    for _ in range(VIRGIN_STEPS):
        step = kappa * f + sign * f - math.log1p(sign * f) - y
        step /= kappa + f / (1.0 + sign * f)
        f -= step
        if abs(step) <= 1e-15 * (1.0 + f):
            break
    return c[PRELOAD] * (1.0 + sign * f), 1.0 / (c[FREE] + c[REACH] * f / (1.0 + sign * f))


@compiled
def _branch(table: Floats, j: int, from_tension: float, change: float) -> tuple[float, float]:
    """Tension and dT/d(delta) after the stretch has changed by ``change`` since a turning point."""
    free, reach = table[j, FREE], table[j, REACH]
    w = math.sqrt(from_tension)
    square = free + reach if change >= 0.0 else free - reach
    v = change / (free * w + math.sqrt(free * free * from_tension + square * change))
    now = w + v
    return now * now, now / (free * now + reach * abs(v))


@inlined
def _look(table: Floats, state: Floats, turns: Floats, j: int, stretch: float) -> tuple[float, float]:
    """Tension and dT/d(delta) that cable ``j`` would have at ``stretch``; its state does not change."""
    change = stretch - state[j, STRETCH]
    if change == 0.0:
        return state[j, TENSION], 1.0 / table[j, FREE]
    move = 1.0 if change > 0.0 else -1.0
    level = int(state[j, LEVEL])
    if move != state[j, DIRECTION] and state[j, DIRECTION] != 0.0:
        if level >= 1:
            closes = turns[j, level, STRETCH]
        else:
            closes = _virgin_stretch(table[j], table[j, PRELOAD] ** 2 / state[j, TENSION])
        if move * (stretch - closes) <= 0.0:
            return _branch(table, j, state[j, TENSION], change)
        level -= 1
    while level >= 1:
        closes = turns[j, level - 1, STRETCH] if level >= 2 else state[j, MIRROR]
        if move * (stretch - closes) <= 0.0:
            return _branch(table, j, turns[j, level, TENSION], stretch - turns[j, level, STRETCH])
        level -= 2
    return _virgin_tension(table[j], stretch)


@inlined
def _move(table: Floats, state: Floats, turns: Floats, j: int, stretch: float, tension: float) -> None:
    """Bring cable ``j`` to ``stretch``: add a turning point on reversal, remove the loops that close."""
    change = stretch - state[j, STRETCH]
    # A rounding error must not count as a reversal.
    if abs(change) <= 1e-13 * table[j, PRELOAD] * table[j, FREE]:
        return
    move = 1.0 if change > 0.0 else -1.0
    level = int(state[j, LEVEL])
    if move != state[j, DIRECTION] and state[j, DIRECTION] != 0.0:
        level += 1
        turns[j, level, TENSION] = state[j, TENSION]
        turns[j, level, STRETCH] = state[j, STRETCH]
        if level == 1:
            state[j, MIRROR] = _virgin_stretch(table[j], table[j, PRELOAD] ** 2 / state[j, TENSION])
    while level >= 1:
        closes = turns[j, level - 1, STRETCH] if level >= 2 else state[j, MIRROR]
        if move * (stretch - closes) <= 0.0:
            break
        level -= 2
    state[j, LEVEL] = max(level, 0)
    state[j, DIRECTION] = move
    state[j, STRETCH] = stretch
    state[j, TENSION] = tension


@inlined
def balance(
    table: Floats, state: Floats, turns: Floats, offset: Floats, load: float, theta: float, found: Floats
) -> Any:
    """Drum angle that balances ``load``, from the guess ``theta``, and whether there is one; states do not change.

    ``offset`` (n_cables,) is the stretch from inputs and paths; ``found`` (n_cables, 2) receives the tension of each
    cable at that angle and dT/d(delta).
    """
    n_cables = table.shape[0]
    scale = 0.0
    for j in range(n_cables):
        scale += table[j, PRELOAD] * table[j, DRUM]
    low, high, miss = -math.inf, math.inf, math.inf
    for _ in range(STEPS):
        miss, slope = -load, 0.0
        for j in range(n_cables):
            lever = table[j, SIGMA] * table[j, DRUM]
            pulled, rate = _look(table, state, turns, j, offset[j] - lever * theta)
            found[j, 0], found[j, 1] = pulled, rate
            miss += lever * pulled
            slope += lever * lever * rate
        if abs(miss) <= 1e-13 * scale:
            break
        low, high, following = next_angle(low, high, theta, miss, slope)
        if following == theta or not math.isfinite(following):
            break
        theta = following
    return theta, abs(miss) <= 1e-9 * scale


@inlined
def settle(table: Floats, state: Floats, turns: Floats, offset: Floats, theta: float, found: Floats) -> None:
    """Bring every cable to the state that :func:`balance` found."""
    for j in range(table.shape[0]):
        lever = table[j, SIGMA] * table[j, DRUM]
        _move(table, state, turns, j, offset[j] - lever * theta, found[j, 0])


@compiled
def at_preload(table: Floats) -> Floats:
    """States of cables at their preload before any motion, (n_cables, 5)."""
    state = np.zeros((table.shape[0], 5))
    for j in range(table.shape[0]):
        state[j, TENSION] = table[j, PRELOAD]
    return state


@compiled
def _run(table: Floats, offsets: Floats, load: Floats, drum: Floats, tension: Floats, turns: Floats) -> int:
    """Fill ``drum`` and ``tension``; the first sample that cannot be balanced, or -1."""
    n_cables = table.shape[0]
    state, theta, carried = at_preload(table), 0.0, 0.0
    offset, before, found = np.empty(n_cables), np.zeros(n_cables), np.empty((n_cables, 2))
    for j in range(n_cables):
        found[j, 1] = 1.0 / table[j, FREE]
    for k in range(load.size):
        # Prediction: the cables are as stiff as they were at the sample before.
        push, grip = carried - load[k], 0.0
        for j in range(n_cables):
            offset[j] = offsets[j, k]
            push += table[j, SIGMA] * table[j, DRUM] * found[j, 1] * (offset[j] - before[j])
            grip += table[j, DRUM] ** 2 * found[j, 1]
            before[j] = offset[j]
        carried = load[k]
        theta, balanced = balance(table, state, turns, offset, load[k], theta + push / grip, found)
        if not balanced:
            return k
        settle(table, state, turns, offset, theta, found)
        drum[k] = theta
        for j in range(n_cables):
            tension[j, k] = state[j, TENSION]
    return -1


# Largest numbers of steps to find the position of a floating pulley in one sample, and of rounds over the inputs.
PLAY_STEPS = 40
ROUNDS = 8
# A torque below this share of that from the preload of one cable counts as zero.
NO_TORQUE = 1e-6


def lags(
    d: DriveSI, input_angle_rad: Floats, load_Nm: Floats, path_m: Floats | None, play_rad: Sequence[float]
) -> Floats:
    """How far each pulley lags behind the middle of its play, rad (n_inputs, n), between -play/2 and +play/2.

    ``play_rad`` has one value for each input; other arguments and errors as in
    :func:`mbcdm_cad.model.hysteresis.simulate`. Wraps are taken as longer than any slip zone, and without slip on
    passed bodies. Before the first sample each pulley rests on the flank to which the preload presses it.
    """
    d = d.without_passed_slip if d.slips_on_passed else d
    half = 0.5 * np.asarray(play_rad, dtype=float)
    if d.n_inputs == 1:
        # It turns with the drum and never floats: the sign of its torque gives the flank.
        carried = simulate(d, input_angle_rad, load_Nm, path_m).input_torque_Nm(d)
        return np.asarray(half[:, None] * np.where(carried == 0.0, faces(d)[:, None], np.sign(carried)))
    return lags_and_drum_rad(d, input_angle_rad, load_Nm, path_m, play_rad)[0]


def lags_and_drum_rad(
    d: DriveSI, input_angle_rad: Floats, load_Nm: Floats, path_m: Floats | None, play_rad: Sequence[float]
) -> tuple[Floats, Floats]:
    """The same for a drive of several inputs, and with it the drum angle that this balances, rad (n,).

    The drum angle is that of :func:`mbcdm_cad.model.hysteresis.simulate` with the pulleys in these positions.
    """
    half = 0.5 * np.asarray(play_rad, dtype=float)
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    lever = d.sigma * d.input_radius_m
    begun = half * faces(d)
    offset = lever[:, None] * angle[list(d.input_of)] + path_offset_m(d, path_m, load.size)
    offset += (lever * begun[list(d.input_of)])[:, None]
    found = np.empty((d.n_inputs + 1, load.size))
    turns = np.empty((d.n_cables, load.size + 2, 2))
    pulleys = np.stack([lever, np.array(d.input_of, dtype=float)], axis=1)
    failed = _run_with_play(constants(d), pulleys, np.stack([half, begun], axis=1), offset, load, turns, found)
    if failed >= 0:
        raise ModelError(f"sample {failed}: no drum angle balances a load of {load[failed]:.6g} N m with this play")
    return found[:-1], found[-1]


def faces(d: DriveSI) -> Floats:
    """+1 or -1 for each input: the flank to which the preload presses the pulley, (n_inputs,)."""
    bias = [float(np.sum(d.sigma * d.input_radius_m * d.preload_N * d.of_input(k))) for k in range(d.n_inputs)]
    return np.where(np.array(bias) >= 0.0, 1.0, -1.0)


@compiled
def _run_with_play(
    table: Floats, pulleys: Floats, faces: Floats, offsets: Floats, load: Floats, turns: Floats, found: Floats
) -> int:
    """Fill ``found``, the lag of each pulley and last the drum angle; the first sample that cannot be balanced, or -1.

    ``pulleys`` (n_cables, 2): lever of each cable at its input, and that input; ``faces`` (n_inputs, 2): half the play,
    and where the pulley begins; ``offsets`` (n_cables, n): stretch with all pulleys in the middle of their play.
    """
    n_cables, n_inputs = table.shape[0], faces.shape[0]
    state, theta = at_preload(table), 0.0
    lag, offset, before = faces[:, 1].copy(), np.empty(n_cables), np.zeros(n_cables)
    pulled = np.empty((n_cables, 2))
    least = NO_TORQUE * abs(table[0, PRELOAD] * pulleys[0, 0])
    for k in range(load.size):
        push, grip = 0.0, 0.0
        for j in range(n_cables):
            offset[j] = offsets[j, k] - pulleys[j, 0] * lag[int(pulleys[j, 1])]
            push += table[j, SIGMA] * table[j, DRUM] / table[j, FREE] * (offset[j] - before[j])
            grip += table[j, DRUM] ** 2 / table[j, FREE]
        theta, balanced = balance(table, state, turns, offset, load[k], theta + push / grip, pulled)
        for _ in range(ROUNDS):
            moved = 0
            for i in range(n_inputs):
                half = faces[i, 0]
                low, high = -half, half
                for _ in range(PLAY_STEPS if half > 0.0 and balanced else 0):
                    torque, own, crossed, drum = 0.0, 0.0, 0.0, 0.0
                    for j in range(n_cables):
                        at_drum = table[j, SIGMA] * table[j, DRUM]
                        drum += at_drum * at_drum * pulled[j, 1]
                        if int(pulleys[j, 1]) == i:
                            torque += pulleys[j, 0] * pulled[j, 0]
                            own += pulleys[j, 0] * pulleys[j, 0] * pulled[j, 1]
                            crossed += pulleys[j, 0] * at_drum * pulled[j, 1]
                    if abs(torque) <= least or (torque > 0.0 and lag[i] >= half) or (torque < 0.0 and lag[i] <= -half):
                        break
                    if torque > 0.0:
                        low = lag[i]
                    else:
                        high = lag[i]
                    following = min(max(lag[i] + torque / (own - crossed * crossed / drum), -half), half)
                    if not (low <= following <= high) or following == lag[i]:
                        following = 0.5 * (low + high)
                    if following == lag[i]:
                        break
                    for j in range(n_cables):
                        if int(pulleys[j, 1]) == i:
                            offset[j] -= pulleys[j, 0] * (following - lag[i])
                    lag[i] = following
                    moved += 1
                    theta, balanced = balance(table, state, turns, offset, load[k], theta, pulled)
            if moved == 0 or n_inputs == 1:
                break
        if not balanced:
            return k
        settle(table, state, turns, offset, theta, pulled)
        found[n_inputs, k] = theta
        for j in range(n_cables):
            before[j] = offset[j]
        for i in range(n_inputs):
            found[i, k] = lag[i]
    return -1
