"""A wrap without an anchor: two profiles of :mod:`mbcdm_cad.model.wrap_profile` with a common beginning.

Each side of a cable that runs over its input without an anchor has a profile, and both begin at the same place of the
pulley, where the rope sticks. After each sample this place moves to the point with the largest reserve of friction: the
reserve towards an end is mu a - |ln(T_end/T)|, a the angle to it. The pieces between the old and the new place change
sides without a change of tension. Their integrals stay with the side that counted them before, so that no rope is lost;
the effect appears when they leave at the other end. This is the creep of a belt.

A point of the pulley at s from the middle of the wrap has the angle s - half in the first profile and -s - half in the
second, half of the wrap at the start.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mbcdm_cad.model.wrap_profile import ANGLE, LOG, RATIO, SUM, log_mean
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

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
