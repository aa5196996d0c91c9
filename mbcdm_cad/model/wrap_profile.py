"""The tension profile along one wrap as a stack of knots: the clip rule in closed form, with cable wound on and off.

In ln(T/T_pre) over the angle x along the pulley an end tension allows a cone of slope +-mu; a profile is therefore a
chain of straight pieces no steeper than mu. A step that moves the end of the wrap from x_0 to x_1 while ln T changes
linearly changes the chain in one of two ways: if ln T changes by less than mu per angle, the cable wound on is one more
piece; else the cone from the new end cuts off all knots outside it. Each knot is added once and removed once, so the
cost of a sample does not grow with the history, and there is no cell length to choose.

Tensions are divided by the preload (u); integrals are of (u - 1) dx from the anchor, in rad; that at knot 0 is 0 unless
the anchor has moved (:mod:`mbcdm_cad.model.through_wrap`).
"""

from __future__ import annotations

import math

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
