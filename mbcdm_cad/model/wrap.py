"""Stretch of a cable as a function of the tension in its free span: free length plus the slip zones on two wraps.

Classical creep theory: an end tension T admits T e^{-mu s} <= T(s) <= T e^{mu s} along a wrap; what lies outside is
clipped to the bound, what lies inside stays. From a uniform preload that gives Eq. (4) to (12) of the paper with the
signs put right: on the tight side T(s) = T e^{-mu s}, on the slack side T e^{+mu s}, until the preload is met.
The tension does not change on a body that the cable passes, unless its wrap is given (slip then comes from both ends);
bending stiffness is left out.
"""

from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

SERIES_BELOW = 1e-3
# Friction over a wrap beyond this exponent holds any tension; it keeps the exponential finite.
_MOST_EXPONENT = 700.0


def excess_minus_log(ratio: Any) -> Floats:
    """u - 1 - ln u for u = ``ratio`` > 0, by its series near 1 where the difference would lose all digits."""
    u = np.asarray(ratio, dtype=float)
    e = u - 1.0
    near = np.abs(e) < SERIES_BELOW
    excess = np.asarray(e - np.log(u))
    if near.any():
        x = e[near]
        excess[near] = x * x * (0.5 - x * (1 / 3 - x * (0.25 - x * (0.2 - x * (1 / 6)))))
    return excess


def slip_angle_rad(tension_N: Any, preload_N: Any, friction: Any) -> Floats:
    """Eq. (5), (6): theta_slip = |ln(T / T_pre)| / mu, in rad, for first loading of a uniform preload."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.abs(np.log(np.asarray(tension_N) / preload_N)) / friction)


def _positive(x: Floats) -> Floats:
    """``x`` as a divisor: zero friction is replaced, and the branch that would use the quotient is not taken."""
    return np.asarray(np.where(np.asarray(x) > 1e-12, x, 1.0))


def stretch_first_loading(d: DriveSI, tension_N: Floats) -> tuple[Floats, Floats]:
    """Stretch of each cable against its preloaded length, and d(stretch)/dT, on first loading.

    ``tension_N`` (n_cables, ...) is the free-span tension, > 0. Returns metres and m/N. With u = T/T_pre,
    delta = T_pre/(EA) [ L_free (u - 1) +- (r_i + r_o)/mu (u - 1 - ln u) ], + above the preload, - below:
    Eq. (7) to (12).
    Where a slip zone has reached its anchor the whole wrap slips, and the law continues linearly in T.
    """
    u = tension_N / d.preload_N
    e = u - 1.0
    slip = np.copysign(excess_minus_log(u), e)
    span = d.free_span_m
    flexibility = 1.0 / d.axial_stiffness_N
    if d.endless_wraps:
        reach = d.slip_reach_m
        stretch = d.preload_N * flexibility * (span * e + reach * slip)
        slope = flexibility * (span + reach * np.abs(e) / u)
        return np.asarray(stretch), np.asarray(slope)
    total, rate = span * e, span * np.ones_like(e)
    mu = np.asarray(d.friction_coefficient, dtype=float)
    partial, partial_rate = slip / _positive(mu), np.abs(e) / u / _positive(mu)
    slid = np.abs(np.log(u))
    wraps = ((d.input_radius_m, d.input_wrap_rad), (d.drum_radius_m, d.drum_wrap_rad))
    for radius, wrap in (*wraps, *d.passed_wraps):
        limited = np.where(np.isinf(wrap), 0.0, wrap)
        full = slid >= np.where(np.isinf(wrap), np.inf, mu * limited)
        held, held_rate = partial, partial_rate
        if full.any():
            # Integral of (T/T_pre - 1) ds over a wrap that the slip zone covers completely, in rad.
            rising = np.where(u >= 1.0, -1.0, 1.0)
            exponent = rising * mu * limited
            with np.errstate(invalid="ignore", over="ignore"):
                mean = np.where(np.abs(exponent) < 1e-12, limited, rising * np.expm1(exponent) / _positive(mu))
            whole = np.asarray(u * mean - limited)
            held, held_rate = np.where(full, whole, partial), np.where(full, (whole + limited) / u, partial_rate)
        total, rate = total + radius * held, rate + radius * held_rate
    if d.springs:
        # Where slip has reached the end on the drum, its spring gives way by the tension that comes there.
        end, passed = _at_anchor(d, u)
        given = d.anchor_m_N * d.axial_stiffness_N
        total, rate = total + given * (end - 1.0), rate + given * passed
    return np.asarray(d.preload_N * flexibility * total), np.asarray(flexibility * rate)


def _at_anchor(d: DriveSI, u: Floats) -> tuple[Floats, Floats]:
    """Tension at the end on the drum over the preload on first loading to u = T/T_pre, and its slope by u.

    It stays at the preload until slip has reached the end, then T e^(-+mu phi) comes there.
    """
    held = np.asarray(d.friction_coefficient, dtype=float) * d.drum_wrap_rad
    share = np.exp(np.where(u >= 1.0, -held, np.minimum(held, _MOST_EXPONENT)))
    full = np.abs(np.log(u)) >= held
    return np.where(full, u * share, 1.0), np.where(full, share, 0.0)


def slack_stretch_m(d: DriveSI) -> Floats:
    """Stretch (< 0, m) at which a cable goes slack on first unloading: its whole preload strain over span and wraps.

    A spring at its end follows until it is free.

    Minus infinity with unlimited wraps: friction then always keeps some tension in the wraps, and the cable never goes
    completely slack.
    """
    wound = d.input_radius_m * d.input_wrap_rad + d.drum_radius_m * d.drum_wrap_rad
    for radius, wrap in d.passed_wraps:
        wound = wound + radius * wrap
    length = d.free_span_m + wound + d.anchor_m_N * d.axial_stiffness_N
    return np.asarray(-d.preload_N / d.axial_stiffness_N * length)


def stretch_after_reversal(d: DriveSI, tension_N: Floats, turned_at_N: Floats) -> tuple[Floats, Floats]:
    """Stretch and its slope after a first loading to ``turned_at_N`` and a reversal towards ``tension_N``.

    The reverse slip zone is ln(T_r/T)/(2 mu), so the stretch changes by
    L_free (T - T_r)/(EA) -+ (r_i + r_o)/(mu EA) (sqrt T - sqrt T_r)^2, until the zone reaches the end of the first one
    at T T_r = T_pre^2; from there the first-loading law of the other side holds. Wraps that end cut both zones off.
    """
    first, first_slope = stretch_first_loading(d, tension_N)
    flexibility = 1.0 / d.axial_stiffness_N
    if d.endless_wraps:
        turned, _ = stretch_first_loading(d, turned_at_N)
        reach = d.slip_reach_m
        step = np.sqrt(tension_N) - np.sqrt(turned_at_N)
        back = turned + flexibility * (d.free_span_m * (tension_N - turned_at_N) + reach * np.sign(step) * step**2)
        back_slope = flexibility * (d.free_span_m + reach * np.abs(step) / np.sqrt(tension_N))
    else:
        u, v = tension_N / d.preload_N, turned_at_N / d.preload_N
        mu = _positive(np.asarray(d.friction_coefficient, dtype=float))
        total, rate = d.free_span_m * (u - 1.0), d.free_span_m * np.ones_like(u)
        wraps = ((d.input_radius_m, d.input_wrap_rad), (d.drum_radius_m, d.drum_wrap_rad))
        for radius, wrap in (*wraps, *d.passed_wraps):
            held, slope = _reversed_integral(u, v, mu, wrap)
            total, rate = total + radius * held, rate + radius * slope
        if d.springs:
            before, _ = _at_anchor(d, v)
            held = np.asarray(d.friction_coefficient, dtype=float) * d.drum_wrap_rad
            share = np.exp(np.where(v >= 1.0, 1.0, -1.0) * np.minimum(held, _MOST_EXPONENT))
            full = np.abs(np.log(u / v)) >= 2.0 * held
            given = d.anchor_m_N * d.axial_stiffness_N
            total = total + given * (np.where(full, u * share, before) - 1.0)
            rate = rate + given * np.where(full, share, 0.0)
        back, back_slope = d.preload_N * flexibility * total, flexibility * rate
    now, then = np.log(tension_N / d.preload_N), np.log(turned_at_N / d.preload_N)
    beyond = np.where(then >= 0.0, (now > then) | (now < -then), (now < then) | (now > -then))
    return np.where(beyond, first, back), np.where(beyond, first_slope, back_slope)


def _reversed_integral(u: Floats, v: Floats, mu: Floats, wrap_rad: Floats) -> tuple[Floats, Floats]:
    """Integral of (T/T_pre - 1) ds in rad over a wrap of any length, and its slope by u, after a reversal at v.

    From the free span on the tension is u e^(+-mu s), then v e^(-+mu s) as the first loading left it, then T_pre.
    """
    sense = np.where(v >= 1.0, 1.0, -1.0)
    turn = np.minimum(np.abs(np.log(u / v)) / (2.0 * mu), wrap_rad)
    end = np.clip(np.abs(np.log(v)) / mu, turn, np.maximum(wrap_rad, turn))
    gain = np.expm1(sense * mu * turn) / (sense * mu)
    left = v * (np.exp(-sense * mu * turn) - np.exp(-sense * mu * end)) / (sense * mu)
    return np.asarray(u * gain + left - end), np.asarray(gain)
