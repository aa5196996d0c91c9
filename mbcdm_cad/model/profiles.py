"""Time series with the tension profile of every wrap in full: finite wraps, slack cables, winding history.

The same physics as :mod:`mbcdm_cad.model.hysteresis`, whose stack of turning points is faster where wraps are longer
than any slip zone and do not move with the pulleys. Here every wrap is a stack of knots, the clip rule in closed form:
exact if, between samples, ln T changes linearly with the angle of the pulley.

With ``winding`` the profiles move with the pulleys: cable wound on keeps the tension it had and brings it back when it
is wound off.

In ln(T/T_pre) over the angle x along the pulley an end tension allows a cone of slope +-mu; a profile is therefore a
chain of straight pieces no steeper than mu. A step that moves the end of the wrap from x_0 to x_1 while ln T changes
linearly changes the chain in one of two ways: if ln T changes by less than mu per angle, the cable wound on is one more
piece; else the cone from the new end cuts off all knots outside it. Each knot is added once and removed once, so the
cost of a sample does not grow with the history, and there is no cell length to choose.

Tensions are divided by the preload (u); integrals are of (u - 1) dx from the anchor, in rad; that at knot 0 is 0 unless
the anchor has moved.

A wrap without an anchor has two profiles with a common beginning, one for each side of the cable. Both begin at the
same place of the pulley, where the rope sticks. After each sample this place moves to the point with the largest
reserve of friction: the reserve towards an end is mu a - |ln(T_end/T)|, a the angle to it. The pieces between the old
and the new place change sides without a change of tension. Their integrals stay with the side that counted them
before, so that no rope is lost; the effect appears when they leave at the other end. This is the creep of a belt. A
point of the pulley at s from the middle of the wrap has the angle s - half in the first profile and -s - half in the
second, half of the wrap at the start.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbcdm_cad.model.equilibrium import sum_per_input
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled, inlined

# Rows of a stack: angle (rad), ln u, u, integral of (u - 1) from the anchor. Knot 0 is the anchor.
ANGLE, LOG, RATIO, SUM = range(4)
SERIES_BELOW = 1e-3


@compiled
def log_mean(u0: float, u1: float, rise: float) -> tuple[float, float]:
    """Mean of u over a piece that is straight in ln u from u0 to u1, ``rise`` = ln(u1/u0), and its slope by u1."""
    if abs(rise) < SERIES_BELOW:
        mean = u0 * (1.0 + rise * (0.5 + rise * (1 / 6 + rise * (1 / 24 + rise / 120))))
        return mean, 0.5 - rise * (1 / 6 - rise * (1 / 24 - rise * (1 / 120 - rise / 720)))
    mean = (u1 - u0) / rise
    return mean, (1.0 - mean / u1) / rise


@inlined
def probe(
    stack: Floats, count: int, x: float, u: float, log_u: float, mu: float
) -> tuple[float, float, int, float, float, float]:
    """The state of the wrap with its end at ``x`` and the tension ``u`` there; the stack does not change.

    Returns the integral of (u - 1) from the anchor and its derivative by u; then the last knot that stays and, where
    the new piece starts beyond it, angle, ln u and integral there. -1 means no knot: slip reaches the anchor.
    """
    top = count - 1
    if x > stack[ANGLE, top]:
        width, rise = x - stack[ANGLE, top], log_u - stack[LOG, top]
        if abs(rise) <= mu * width:
            mean, slope = log_mean(stack[RATIO, top], u, rise)
            start = stack[SUM, top]
            return start + width * (mean - 1.0), width * slope, top, stack[ANGLE, top], stack[LOG, top], start
        sense = 1.0 if rise > 0.0 else -1.0
        k = top - 1
    else:
        k = top - 1
        while k > 0 and stack[ANGLE, k] > x:
            k -= 1
        slope = (stack[LOG, k + 1] - stack[LOG, k]) / (stack[ANGLE, k + 1] - stack[ANGLE, k])
        sense = 1.0 if log_u > stack[LOG, k + 1] + slope * (x - stack[ANGLE, k + 1]) else -1.0
    while k >= 0 and sense * (log_u - stack[LOG, k]) - mu * (x - stack[ANGLE, k]) > 0.0:
        k -= 1
    if k < 0:
        length = x - stack[ANGLE, 0]
        share = -sense * math.expm1(-sense * mu * length) / mu
        start = stack[SUM, 0]
        return start + u * share - length, share, -1, stack[ANGLE, 0], log_u - sense * mu * length, start
    low, high = stack[ANGLE, k], stack[ANGLE, k + 1]
    slope = (stack[LOG, k + 1] - stack[LOG, k]) / (high - low)
    outside = log_u - sense * mu * (x - high) - stack[LOG, k + 1]
    steeper = slope - sense * mu
    # A piece as steep as the cone intersects it at its lower knot or not at all.
    meets = high + outside / steeper if steeper * sense < 0.0 else low
    meets = min(max(meets, low), min(high, x))
    log_meets = stack[LOG, k + 1] + slope * (meets - high)
    u_meets = math.exp(log_meets)
    mean, _ = log_mean(stack[RATIO, k], u_meets, log_meets - stack[LOG, k])
    start = stack[SUM, k] + (meets - low) * (mean - 1.0)
    total = start + sense * (u - u_meets) / mu - (x - meets)
    return total, sense * (1.0 - u_meets / u) / mu, k, meets, log_meets, start


@compiled
def commit(stack: Floats, count: int, x: float, u: float, log_u: float, mu: float) -> int:
    """Bring the wrap to ``x`` and ``u`` and return the new number of knots; the stack must have room for two more."""
    total, _, last, meets, log_meets, start = probe(stack, count, x, u, log_u, mu)
    if last < 0:
        stack[LOG, 0], stack[RATIO, 0] = log_meets, math.exp(log_meets)
        last = 0
    if meets > stack[ANGLE, last]:
        last += 1
        stack[ANGLE, last], stack[LOG, last] = meets, log_meets
        stack[RATIO, last], stack[SUM, last] = math.exp(log_meets), start
    if x > stack[ANGLE, last]:
        last += 1
    stack[ANGLE, last], stack[LOG, last], stack[RATIO, last], stack[SUM, last] = x, log_u, u, total
    return last + 1


# Number of places that are tried for the beginning of both profiles.
PLACES = 48
# Pieces shorter than this get no knot, rad.
_SHORTEST_RAD = 1e-7


class Profile(NamedTuple):
    """A stack of knots of :mod:`mbcdm_cad.model.profiles` and how many it holds."""

    stack: Floats
    knots: int


@compiled
def _log_at(profile: Profile, x: float) -> float:
    """Ln u at the angle ``x`` of a profile."""
    stack, k = profile.stack, 0
    while k < profile.knots - 2 and stack[ANGLE, k + 1] < x:
        k += 1
    width = stack[ANGLE, k + 1] - stack[ANGLE, k]
    share = (x - stack[ANGLE, k]) / width if width > 0.0 else 0.0
    return float(stack[LOG, k] + share * (stack[LOG, k + 1] - stack[LOG, k]))


@compiled
def _best_place(one: Profile, other: Profile, half: float, mu: float, apart: float) -> float:
    """Place of the largest reserve: angle s from the middle of the first wrap. ``apart``: ln of preload 1 over 2."""
    here = one.stack[ANGLE, 0] + half
    top, bottom = one.stack[ANGLE, one.knots - 1] + half, -(other.stack[ANGLE, other.knots - 1] + half)
    upper, lower = one.stack[LOG, one.knots - 1], other.stack[LOG, other.knots - 1] - apart
    best, most = here, -math.inf
    for n in range(1, PLACES):
        s = bottom + (top - bottom) * n / PLACES
        now = _log_at(one, s - half) if s >= here else _log_at(other, -s - half) - apart
        reserve = min(mu * (top - s) - abs(upper - now), mu * (s - bottom) - abs(lower - now))
        if reserve > most:
            best, most = s, reserve
    return float(best)


@compiled
def _hand_over(from_side: Profile, to_side: Profile, turn: float, apart: float) -> tuple[int, int]:
    """Cut the beginning of one profile off at the angle ``turn`` and put it before the other; the new counts.

    ``apart``: what is added to ln u for the taker's preload. The angles of one side count against the other's.
    """
    giver, given, taker, taken = from_side.stack, from_side.knots, to_side.stack, to_side.knots
    at, last = _log_at(from_side, turn), 0
    while last < given - 1 and giver[ANGLE, last + 1] < turn - _SHORTEST_RAD:
        last += 1
    # The taker's own beginning is the giver's; knots 1 to ``last`` and the new place come before it.
    for k in range(taken - 1, -1, -1):
        taker[:, k + last + 1] = taker[:, k]
    origin = taker[ANGLE, last + 1] + giver[ANGLE, 0]
    for n in range(1, last + 2):
        k = last + 1 - n
        angle, log_u = (giver[ANGLE, n], giver[LOG, n]) if n <= last else (turn, at)
        taker[ANGLE, k], taker[LOG, k] = origin - angle, log_u + apart
        taker[RATIO, k] = math.exp(taker[LOG, k])
        mean, _ = log_mean(taker[RATIO, k], taker[RATIO, k + 1], taker[LOG, k + 1] - taker[LOG, k])
        taker[SUM, k] = taker[SUM, k + 1] - (taker[ANGLE, k + 1] - taker[ANGLE, k]) * (mean - 1.0)
    # The giver begins at the new place.
    ratio = math.exp(at)
    mean, _ = log_mean(giver[RATIO, last], ratio, at - giver[LOG, last])
    base = giver[SUM, last] + (turn - giver[ANGLE, last]) * (mean - 1.0)
    for k in range(last + 1, given):
        giver[:, k - last] = giver[:, k]
    giver[ANGLE, 0], giver[LOG, 0], giver[RATIO, 0], giver[SUM, 0] = turn, at, ratio, base
    return given - last, taken + last + 1


@compiled
def go_over(one: Profile, other: Profile, half: float, mu: float, apart: float) -> tuple[int, int]:
    """Let both profiles of one wrap begin at the point with the largest reserve; returns their new numbers of knots.

    Each stack must have room for the knots of both. If the whole wrap slipped in one sample, so that the profiles begin
    with different tensions, both continue from the mean: this slip is not modelled.
    """
    start = 0.5 * (one.stack[LOG, 0] + other.stack[LOG, 0] - apart)
    one.stack[LOG, 0], other.stack[LOG, 0] = start, start + apart
    one.stack[RATIO, 0], other.stack[RATIO, 0] = math.exp(start), math.exp(start + apart)
    s, here = _best_place(one, other, half, mu, apart), one.stack[ANGLE, 0] + half
    if s > here + 10.0 * _SHORTEST_RAD:
        return _hand_over(one, other, s - half, apart)
    if s < here - 10.0 * _SHORTEST_RAD:
        second, first = _hand_over(other, one, -s - half, -apart)
        return first, second
    return one.knots, other.knots


@dataclass(frozen=True, eq=False)
class Response:
    """Drum angle (rad, shape (n,)) and free-span tensions (N, shape (n_cables, n)) at each sample."""

    drum_angle_rad: Floats
    tension_N: Floats

    def input_torque_Nm(self, d: DriveSI) -> Floats:
        """Torque that holds each input at each sample, shape (n_inputs, n)."""
        return sum_per_input(d, self.tension_N, d.input_radius_m[:, None])


def checked_series(d: DriveSI, input_angle_rad: Any, load_Nm: Any) -> tuple[Floats, Floats]:
    """Input angles (n_inputs, n) and load (n,) as contiguous arrays; errors as in :func:`simulate`."""
    angle = np.ascontiguousarray(np.atleast_2d(np.asarray(input_angle_rad, dtype=float)))
    if d.batch_shape:
        raise ModelError(f"a series runs on one design, got a batch of shape {d.batch_shape}; loop over the designs")
    if angle.shape[0] != d.n_inputs or angle.ndim != 2:
        raise ModelError(
            f"input_angle_rad has shape {angle.shape}, the drive needs ({d.n_inputs}, n): one row an input"
        )
    load = np.asarray(load_Nm, dtype=float)
    if load.ndim > 1 or (load.ndim == 1 and load.size != angle.shape[1]):
        raise ModelError(f"load_Nm has shape {load.shape} for {angle.shape[1]} samples; give one value or one a sample")
    if not (np.isfinite(angle).all() and np.isfinite(load).all()):
        raise ModelError("input_angle_rad or load_Nm holds NaN or infinity; clean the series first")
    if not float(d.friction_coefficient) > 0.0:
        friction = float(d.friction_coefficient)
        raise ModelError(f"friction_coefficient {friction:g}: slip zones have no end; give it > 0")
    return angle, np.ascontiguousarray(np.broadcast_to(load, (angle.shape[1],)))


def path_offset_m(d: DriveSI, path_m: Any, samples: int) -> Floats:
    """``path_m`` as an array (n_cables, samples), zeros for None. Errors: ``ModelError`` for a wrong shape or NaN."""
    shape = (d.n_cables, samples)
    if path_m is None:
        return np.zeros(shape)
    path = np.asarray(path_m, dtype=float)
    if path.shape != shape or not np.isfinite(path).all():
        raise ModelError(f"path_m has shape {path.shape} or holds NaN; give finite numbers of shape {shape}")
    return path


# Columns of the table of constants, one row a cable.
FREE, UNIT, PRELOAD, DRUM, SIGMA = range(5)
INPUT_WRAP, DRUM_WRAP = range(2)
# Length of an unlimited wrap, rad: finite, but far longer than any slip zone or travel.
ENDLESS_RAD = 1e6
# A tension below this share of the preload counts as none, as in the static model.
FAINT = 1e-12
STEPS = 200
ROOM = 64
BALANCED, NO_BALANCE, RUN_OFF = 0, 1, 2


def simulate_profiles(
    d: DriveSI,
    input_angle_rad: Any,
    load_Nm: Any,
    path_m: Any = None,
    winding: bool = False,
    through_rad: float | None = None,
) -> Response:
    """Run the model over a series; arguments and shapes as in :func:`mbcdm_cad.model.hysteresis.simulate`.

    Finite ``input_wrap_rad`` and ``drum_wrap_rad`` are the live wraps with all angles zero; slip that reaches the
    anchor stops there, and a cable can go slack (tension 0) and come back. ``through_rad`` is the wrap over each input
    that friction alone holds, for cables that run through there: their two sides then share it, and rope goes over from
    one to the other (:mod:`mbcdm_cad.model.profiles`). Errors besides those of the series:
    ``ModelError`` where a pulley would wind off more than its wrap, and for winding with slip on passed bodies.
    """
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    slipped = [(radius, wrap) for radius, wrap in d.passed_wraps if np.any(wrap > 0.0)]
    if winding and slipped:
        raise ModelError(
            "winding history together with slip on passed bodies is not modelled: the cable there runs on to the drum; "
            "leave passed_wrap_rad at 0 or winding off"
        )
    offset = (d.sigma * d.input_radius_m)[:, None] * angle[list(d.input_of)] + path_offset_m(d, path_m, load.size)
    on_input = d.input_wrap_rad if through_rad is None else np.full(d.n_cables, 0.5 * through_rad)
    wraps = [(d.input_radius_m, on_input), (d.drum_radius_m, d.drum_wrap_rad)]
    # Slip comes from both ends: two wraps of half the angle, which do not move with the pulley.
    wraps += slipped
    radius, length = (np.stack([np.broadcast_to(w[i], (d.n_cables,)) for w in wraps], axis=1) for i in (0, 1))
    if not np.all(length >= 0.0):
        raise ModelError(f"a wrap of {np.min(length):g} rad: give wraps of 0 or more")
    columns = (d.free_span_m, d.axial_stiffness_N / d.preload_N, d.preload_N, d.drum_radius_m, d.sigma)
    table = np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=1))
    drum, tension = np.empty(load.size), np.empty((d.n_cables, load.size))
    wound = _Wraps(
        table,
        np.ascontiguousarray(radius),
        np.minimum(length, ENDLESS_RAD),
        float(d.friction_coefficient),
        winding,
        np.array(d.through_sides if through_rad is not None else (), dtype=np.int64).reshape(-1, 2),
    )
    outcome, k, j = _run(wound, np.ascontiguousarray(angle[list(d.input_of)]), offset, load, drum, tension)
    if outcome == RUN_OFF:
        raise ModelError(
            f"sample {k}: cable {d.cable_names[j]} would wind off more than its wrap "
            f"({float(length[j, 0]):.3g} rad on the input, {float(length[j, 1]):.3g} rad on the drum); "
            "give longer wraps or a shorter travel"
        )
    if outcome == NO_BALANCE:
        raise ModelError(
            f"sample {k}: no drum angle balances a load of {load[k]:.6g} N m; check its unit and sign, and whether "
            "every cable that could hold it is slack"
        )
    return Response(drum, tension)


class _Wraps(NamedTuple):
    """Constants of the cables (n, 5), radius and length of their wraps (n, n_wraps), friction, whether they wind.

    ``through`` (m, 2): the two sides of each cable that has one wrap on its input.
    """

    table: Floats
    radius: Floats
    length: Floats
    mu: float
    winding: bool
    through: Any


@inlined
def next_angle(low: float, high: float, theta: float, miss: float, slope: float) -> Any:
    """The bounds of the drum angle narrowed at ``theta``, which misses the load by ``miss``, and the angle to try next.

    That of Newton's step, or the middle of the bounds where it lies beyond them.
    """
    if miss > 0.0:
        low = theta
    else:
        high = theta
    following = theta + miss / slope
    if not (low < following < high):
        following = 0.5 * (low + high)
    return low, high, following


@inlined
def _pull(
    c: Floats, radius: Floats, stacks: Floats, counts: Any, ends: Floats, mu: float, stretch: float, guess: float
) -> tuple[float, float]:
    """Tension over preload at ``stretch`` (m), and its derivative (1/m); 0 slope where the cable is slack."""
    goal, low, high, u = stretch * c[UNIT], 0.0, math.inf, guess
    rate = c[FREE]
    for _ in range(STEPS):
        log_u = math.log(u)
        miss, rate = c[FREE] * (u - 1.0) - goal, c[FREE]
        for w in range(radius.size):
            total, part, _, _, _, _ = probe(stacks[w], counts[w], ends[w], u, log_u, mu)
            miss += radius[w] * total
            rate += radius[w] * part
        if miss > 0.0:
            high = u
            if u <= FAINT:
                return FAINT, 0.0
        else:
            low = u
        following = u - miss / rate
        if not (low <= following <= high):
            following = max(0.5 * (low + high) if high <= 4.0 * low else math.sqrt(max(low, FAINT) * high), FAINT)
        step = abs(following - u)
        u = max(following, FAINT)
        if step <= 1e-14 * u:
            break
    return u, c[UNIT] / rate


@inlined
def _place(ends: Floats, table: Floats, winding: bool, angle: Floats, theta: float) -> None:
    """End of each wrap, rad, counted from its end with all angles zero; winding on is positive."""
    if winding:
        for j in range(table.shape[0]):
            ends[j, INPUT_WRAP] = table[j, SIGMA] * angle[j]
            ends[j, DRUM_WRAP] = -table[j, SIGMA] * theta


@compiled
def _roomier(stacks: Floats) -> Floats:
    """The stacks with room for twice as many knots."""
    wider = np.zeros((*stacks.shape[:3], 2 * stacks.shape[3]))
    wider[:, :, :, : stacks.shape[3]] = stacks
    return wider


@compiled
def _run(
    wound: _Wraps, angles: Floats, offsets: Floats, load: Floats, drum: Floats, tension: Floats
) -> tuple[int, int, int]:
    """Fill ``drum`` and ``tension`` for input angle and stretch from it of each cable (n, samples), load (samples,).

    Returns the outcome, the sample and the cable where it failed.
    """
    table, radius, length, mu, winding = wound.table, wound.radius, wound.length, wound.mu, wound.winding
    n_cables, n_wraps = radius.shape
    stacks = np.zeros((n_cables, n_wraps, 4, ROOM))
    counts = np.full((n_cables, n_wraps), 2)
    stacks[:, :, RATIO, :2] = 1.0
    stacks[:, :, ANGLE, 0] = -np.maximum(length, 1e-12)
    ends = np.zeros((n_cables, n_wraps))
    pulled, rates, before = np.ones(n_cables), np.zeros(n_cables), np.zeros(n_cables)
    theta, scale = 0.0, 0.0
    for j in range(n_cables):
        scale += table[j, PRELOAD] * table[j, DRUM]
    for k in range(load.size):
        # Prediction: the drum follows the mean of the inputs, weighted by the stiffness of their sticking cables.
        push, grip = 0.0, 0.0
        for j in range(n_cables):
            push += table[j, SIGMA] * table[j, DRUM] / table[j, FREE] * (offsets[j, k] - before[j])
            grip += table[j, DRUM] ** 2 / table[j, FREE]
            before[j] = offsets[j, k]
        theta += push / grip
        low, high, miss = -math.inf, math.inf, math.inf
        for _ in range(STEPS):
            _place(ends, table, winding, angles[:, k], theta)
            for j in range(n_cables):
                for w in range(n_wraps):
                    if ends[j, w] <= stacks[j, w, ANGLE, 0]:
                        return RUN_OFF, k, j
            miss, slope = -load[k], 0.0
            for j in range(n_cables):
                lever = table[j, SIGMA] * table[j, DRUM]
                pulled[j], rates[j] = _pull(
                    table[j], radius[j], stacks[j], counts[j], ends[j], mu, offsets[j, k] - lever * theta, pulled[j]
                )
                if pulled[j] > FAINT:
                    miss += lever * table[j, PRELOAD] * pulled[j]
                slope += lever * lever * table[j, PRELOAD] * rates[j]
            if abs(miss) <= 1e-13 * scale:
                break
            low, high, following = next_angle(low, high, theta, miss, slope)
            if following == theta or not math.isfinite(following):
                break
            theta = following
        if not abs(miss) <= 1e-9 * scale:
            return NO_BALANCE, k, 0
        for j in range(n_cables):
            log_u = math.log(pulled[j])
            for w in range(n_wraps):
                if counts[j, w] + 2 > stacks.shape[3]:
                    stacks = _roomier(stacks)
                counts[j, w] = commit(stacks[j, w], counts[j, w], ends[j, w], pulled[j], log_u, mu)
            tension[j, k] = table[j, PRELOAD] * pulled[j] if pulled[j] > FAINT else 0.0
        for m in range(wound.through.shape[0]):
            one, other = wound.through[m, 0], wound.through[m, 1]
            if counts[one, INPUT_WRAP] + counts[other, INPUT_WRAP] + 2 > stacks.shape[3]:
                stacks = _roomier(stacks)
            counts[one, INPUT_WRAP], counts[other, INPUT_WRAP] = go_over(
                Profile(stacks[one, INPUT_WRAP], counts[one, INPUT_WRAP]),
                Profile(stacks[other, INPUT_WRAP], counts[other, INPUT_WRAP]),
                length[one, INPUT_WRAP],
                mu,
                math.log(table[one, PRELOAD] / table[other, PRELOAD]),
            )
        drum[k] = theta
    return BALANCED, 0, 0
