"""The tension profile along one wrap as a stack of knots: the clip rule in closed form, with cable wound on and off.

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
from typing import NamedTuple

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
    """A stack of knots of :mod:`mbcdm_cad.model.wrap_profile` and how many it holds."""

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
