"""Equations (3) to (20) of the paper, one function each, as corrected and, where it differs, as printed.

SI throughout; all arguments broadcast. T_h and T_l are the free-span tensions of the tight and the slack side,
T_pre the preload, mu the friction, EA the axial stiffness in N. Where the print is wrong ``as_printed=True`` gives it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.wrap import excess_minus_log
from mbcdm_cad.routes import Floats

SOLVER_STEPS = 100
ROUNDING = 1e-15


def eq3_tension_difference(load_Nm: Any, drum_radius_m: Any, inputs: int = 2) -> Floats:
    """Eq. (3): M_l/2 = (T_h - T_l) r_o, so T_h - T_l = M_l/(2 r_o): each of two inputs takes half of the load.

    ``inputs`` is their number where it is not two as in the paper.
    """
    return np.asarray(np.asarray(load_Nm) / (inputs * np.asarray(drum_radius_m)))


def eq4_tension(preload_N: Any, friction: Any, angle_rad: Any, side: str, as_printed: bool = False) -> Floats:
    """Eq. (4): tension at ``angle_rad`` into the slip zone, counted from its inner end towards the free span.

    T_pre e^{+mu theta} holds on the tight side only; the slack side needs e^{-mu theta}. Printed: + for both.
    """
    if side not in ("tight", "slack"):
        raise ModelError(f"side {side!r} is unknown; use 'tight' or 'slack'")
    sign = -1.0 if side == "slack" and not as_printed else 1.0
    return np.asarray(preload_N * np.exp(sign * np.asarray(friction) * np.asarray(angle_rad)))


def eq5_slip_angle_tight(high_N: Any, preload_N: Any, friction: Any) -> Floats:
    """Eq. (5): ln(T_h/T_pre)/mu, rad, on drum and input alike."""
    return np.asarray(np.log(np.asarray(high_N) / preload_N) / friction)


def eq6_slip_angle_slack(low_N: Any, preload_N: Any, friction: Any) -> Floats:
    """Eq. (6): ln(T_pre/T_l)/mu, rad, on drum and input alike."""
    return np.asarray(np.log(preload_N / np.asarray(low_N)) / friction)


def eq7_slip_stretch_tight(high_N: Any, preload_N: Any, friction: Any, radius_m: Any, axial_stiffness_N: Any) -> Floats:
    """Eq. (7) with r_o, (9) with r_i: stretch > 0 of the tight slip zone, m."""
    zone = preload_N * excess_minus_log(np.asarray(high_N) / preload_N)
    return np.asarray(radius_m / (axial_stiffness_N * np.asarray(friction)) * zone)


def eq8_slip_stretch_slack(
    low_N: Any, preload_N: Any, friction: Any, radius_m: Any, axial_stiffness_N: Any, as_printed: bool = False
) -> Floats:
    """Eq. (8) with r_o, (10) with r_i: stretch < 0 of the slack slip zone, m.

    The printed result is this contraction; the printed integrand d(delta_pre) - d(delta_T) gives its opposite, which
    ``as_printed`` returns. Correct is d(delta_T) - d(delta_pre), as in (7).
    """
    zone = preload_N * excess_minus_log(np.asarray(low_N) / preload_N)
    contraction = -radius_m / (axial_stiffness_N * np.asarray(friction)) * zone
    return np.asarray(-contraction if as_printed else contraction)


def eq11_free_stretch_tight(high_N: Any, preload_N: Any, free_span_m: Any, axial_stiffness_N: Any) -> Floats:
    """Eq. (11): (T_h - T_pre) L_free/(EA) > 0, m."""
    return np.asarray((np.asarray(high_N) - preload_N) * free_span_m / axial_stiffness_N)


def eq12_free_stretch_slack(
    low_N: Any, preload_N: Any, free_span_m: Any, axial_stiffness_N: Any, as_printed: bool = False
) -> Floats:
    """Eq. (12): (T_l - T_pre) L_free/(EA) < 0, m. Printed with the opposite sign, which contradicts (13) and (14)."""
    right = (np.asarray(low_N) - preload_N) * free_span_m / axial_stiffness_N
    return np.asarray(-right if as_printed else right)


def eq13_residual(tight_m: Any, slack_m: Any, drum_radius_tight_m: Any = 1.0, drum_radius_slack_m: Any = 1.0) -> Floats:
    """Eq. (13): compatibility of the anchored cables, delta_tight/r_o,tight + delta_slack/r_o,slack = 0.

    The paper writes it as constant total length, which is the same when both sides run on one drum radius (the
    default 1, 1); with steps the drum's rotation is common, not the length.
    """
    return np.asarray(np.asarray(tight_m) / drum_radius_tight_m + np.asarray(slack_m) / drum_radius_slack_m)


def eq14_residual(low_N: Any, load_Nm: Any, preload_N: Any, drum_radius_m: Any, kappa: Any, inputs: int = 2) -> Floats:
    """Left side of Eq. (14), N: T_pre ln(T_l/(T_l + D)) + (1 + kappa) D + 2 kappa (T_l - T_pre), D = M_l/(2 r_o)."""
    low = np.asarray(low_N, dtype=float)
    difference = eq3_tension_difference(load_Nm, drum_radius_m, inputs)
    return np.asarray(
        preload_N * np.log(low / (low + difference)) + (kappa + 1.0) * difference + 2.0 * kappa * (low - preload_N)
    )


def eq14_tensions(
    load_Nm: Any, preload_N: Any, drum_radius_m: Any, kappa: Any, inputs: int = 2
) -> tuple[Floats, Floats]:
    """(T_l, T_h) in N that solve Eq. (14) exactly, for any load >= 0; vectorised.

    With x = D/T_pre the root T_l/T_pre lies between max(1 - x/2, x e^{-(1+kappa) x}) and the simplified x/(e^x - 1);
    it always exists: on a long wrap friction keeps a tail of tension, T_l falls exponentially but not to zero (for
    x of some hundreds it underflows to 0). Newton in ln T_l, kept inside that bracket.
    """
    x, k = np.broadcast_arrays(
        eq3_tension_difference(load_Nm, drum_radius_m, inputs) / preload_N, np.asarray(kappa, float)
    )
    if not np.all(x >= 0.0):
        raise ModelError(
            f"load_Nm: {np.min(load_Nm):.6g} is negative; Eq. (14) names the sides by the load, use its magnitude"
        )
    safe = np.where(x > 0.0, x, 1.0)
    modest = np.minimum(safe, 600.0)
    high = np.where(safe <= 600.0, -np.log(np.expm1(modest) / modest), np.log(safe) - safe)
    frictionless = np.where(safe < 2.0, np.log1p(-np.where(safe < 2.0, safe / 2.0, 0.0)), -np.inf)
    low = np.maximum(frictionless, np.log(safe) - (1.0 + k) * safe)
    v = high.copy()
    for _ in range(SOLVER_STEPS):
        t = np.exp(v)
        # ln(t/(t + x)) in a form without cancellation where t is near 1 and x small.
        ratio = np.where(t > safe, -np.log1p(safe / np.maximum(t, safe)), v - np.log(t + safe))
        value = ratio + (1.0 + k) * safe + 2.0 * k * np.expm1(v)
        low, high = np.where(value < 0.0, v, low), np.where(value > 0.0, v, high)
        newton = v - value / (safe / (t + safe) + 2.0 * k * t)
        # For small x root and bounds differ by less than their rounding.
        inside = (newton >= low - ROUNDING) & (newton <= high + ROUNDING)
        following = np.where(inside, newton, 0.5 * (low + high))
        settled = (np.abs(following - v) <= 1e-14 * (1.0 + np.abs(v))).all()
        v = following
        if settled:
            break
    low_N = preload_N * np.where(x > 0.0, np.exp(v), 1.0)
    return np.asarray(low_N), np.asarray(low_N + x * preload_N)


def eq15_kappa(friction: Any, free_span_m: Any, drum_radius_m: Any, input_radius_m: Any) -> Floats:
    """Eq. (15): kappa = mu L_free/(r_o + r_i), which the paper sets to 0 in (14) but keeps in (20)."""
    return np.asarray(np.asarray(friction) * free_span_m / (np.asarray(drum_radius_m) + input_radius_m))


def eq16_residual(low_N: Any, load_Nm: Any, preload_N: Any, drum_radius_m: Any, inputs: int = 2) -> Floats:
    """Left side of Eq. (16): Eq. (14) over T_pre with kappa = 0."""
    return np.asarray(eq14_residual(low_N, load_Nm, preload_N, drum_radius_m, 0.0, inputs) / preload_N)


def eq17_low_tension(load_Nm: Any, preload_N: Any, drum_radius_m: Any, inputs: int = 2) -> Floats:
    """Eq. (17): simplified T_l = D/(e^x - 1), N, with x = M_l/(2 T_pre r_o); T_pre at no load."""
    x = np.asarray(eq3_tension_difference(load_Nm, drum_radius_m, inputs) / preload_N, dtype=float)
    moving = np.where(x == 0.0, 1.0, x)
    return np.asarray(preload_N * np.where(x == 0.0, 1.0, moving / np.expm1(np.minimum(moving, 700.0))))


def eq18_high_tension(load_Nm: Any, preload_N: Any, drum_radius_m: Any, inputs: int = 2) -> Floats:
    """Eq. (18): simplified T_h = D e^x/(e^x - 1) = T_l + D, N."""
    return np.asarray(
        eq17_low_tension(load_Nm, preload_N, drum_radius_m, inputs)
        + eq3_tension_difference(load_Nm, drum_radius_m, inputs)
    )


def eq19_backlash(stretch_input_m: Any, stretch_drum_m: Any, stretch_free_m: Any, drum_radius_m: Any) -> Floats:
    """Eq. (19): theta_b = (delta_i,slip + delta_o,slip + delta_free)/r_o, rad."""
    return np.asarray((np.asarray(stretch_input_m) + stretch_drum_m + stretch_free_m) / drum_radius_m)


def eq20_backlash(
    high_N: Any,
    preload_N: Any,
    friction: Any,
    drum_radius_m: Any,
    input_radius_m: Any,
    free_span_m: Any,
    axial_stiffness_N: Any,
    as_printed: bool = False,
) -> Floats:
    """Eq. (20): theta_b = T_pre (r_o + r_i)/(EA mu r_o) [(t - 1)(1 + kappa) - ln t], t = T_h/T_pre, rad.

    With t from (18) it is the paper's formula, with t from (14) the exact one. Printed without mu r_o in the
    denominator, i.e. a length (times mu): ``as_printed`` returns that, in m.
    """
    kappa = eq15_kappa(friction, free_span_m, drum_radius_m, input_radius_m)
    t = np.asarray(high_N) / preload_N
    bracket = excess_minus_log(t) + kappa * (t - 1.0)
    length = preload_N * (np.asarray(drum_radius_m) + input_radius_m) / axial_stiffness_N * bracket
    return np.asarray(length if as_printed else length / (np.asarray(friction) * drum_radius_m))
