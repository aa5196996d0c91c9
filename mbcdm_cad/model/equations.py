"""The paper's equations (1) to (20), as corrected and, where it differs, as printed; and its measured figures.

Signs as in :mod:`mbcdm_cad.routes.route`: right-handed about each body's axis; an input's axis points so that
theta_i = +(r_o/r_i) theta_o; a body that the cable passes turns by +-(r_o/r) theta_o, depending on the route.

SI throughout; all arguments broadcast. T_h and T_l are the free-span tensions of the tight and the slack side,
T_pre the preload, mu the friction, EA the axial stiffness in N. Where the print is wrong ``as_printed=True`` gives it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.wrap import excess_minus_log
from mbcdm_cad.routes import Floats

# Figures of the paper, each with its place, for comparison only: the model uses none of them.
BACKLASH_RAD = 0.33e-3  # section 5.3, at the next two
BACKLASH_TORQUE_NM = 0.91
BACKLASH_PRELOAD_N = 70.0
BACKLASH_ERROR = 0.097  # section 5.3, difference of Eq. (20) from the measurement; the sign is not given
PEAK_TORQUE_NM = 3.3  # section 5.1 and Fig. 7
DESIGN_TORQUE_NM = 3.9  # section 5.1, called theoretical
DESIGN_MASS_G = 350.0  # section 4.1
PROTOTYPE_MASS_G = 342.0  # section 5
DESIGN_TORQUE_TO_WEIGHT_NM_KG = 11.14  # section 4.1
TORQUE_TO_WEIGHT_NM_KG = 9.649  # section 5.1
RIPPLE_CYCLES_PER_RAD = 694.3  # section 5.2, Fig. 8 (b)
BEND_RATIO = 14.8  # Table 1
EFFECTIVE_AREA_MM2 = 0.3117  # Table 1
ENCODER_A_RAD = 191.74e-6  # section 5
ENCODER_B_RAD = 1.364e-6  # section 5
MOTOR_TORQUE_MNM = 2.9  # section 4.1
GEAR_RATIO = 76.0  # section 4.1
RMSE_SHARE = 0.0414  # section 5.3
FLAT_FRICTION = 0.3  # section 4.2: the backlash flattens out from here on


def papers_test(load_Nm: float) -> bool:
    """Whether a turn or swing under ``load_Nm`` may stand beside the paper's: only the same load compares."""
    return abs(load_Nm - BACKLASH_TORQUE_NM) < 1e-9


def shaft_angles(d: DriveSI, shaft: str, angle_rad: Any, cable: int = 0, gear_ratio: float = 1.0) -> dict[str, Floats]:
    """Angles of all shafts in rad from that of one of them, along the chain of one cable of a single design.

    Shafts are the drum, the bodies that the cable passes, ``input`` and ``motor``, in this order; the gearhead is
    assumed to keep the sense of rotation. Where Eq. (1) holds the result does not depend on ``cable``. Raises
    ``ModelError`` for an unknown shaft.
    """
    drum = d.drum_radius_m[cable]
    last = d.routes.cables[cable].wraps[-1].turning
    to_drum = {d.routes.drum.name: 1.0}
    for wrap in reversed(d.routes.cables[cable].passed):
        to_drum[wrap.body] = wrap.turning * last * wrap.radius_m / drum
    to_drum["input"] = d.input_radius_m[cable] / drum
    to_drum["motor"] = d.input_radius_m[cable] / drum / gear_ratio
    if shaft not in to_drum:
        raise ModelError(f"shaft {shaft!r} is unknown; use one of {', '.join(to_drum)}")
    turned = np.asarray(angle_rad, dtype=float) * to_drum[shaft]
    return {name: np.asarray(turned / ratio) for name, ratio in to_drum.items()}


def transmission_error(theta_o_rad: Any, theta_i_rad: Any, total_ratio: Any) -> Floats:
    """Eq. (2): theta_e = theta_o - theta_i / i_c, in rad."""
    return np.asarray(np.asarray(theta_o_rad) - np.asarray(theta_i_rad) / np.asarray(total_ratio))


@dataclass(frozen=True, eq=False)
class RatioResiduals:
    """Relative deviation from Eq. (1): each entry is r/r' over the first such ratio, minus 1.

    ``passed`` (n_cables, *batch) compares, for each passed body from the drum on, its radius over that of the body
    before with that of the first cable; ``inputs`` the input's radius over that of the last body before it with that of
    the first cable of the same input; ``between_inputs`` (n_inputs, *batch) the mean total ratio r_i/r_o of an input
    with that of the first input (inputs at one drum must agree).
    """

    passed: tuple[Floats, ...]
    inputs: Floats
    between_inputs: Floats

    @property
    def by_design(self) -> Floats:
        """Largest magnitude of the residuals of each design, (*batch)."""
        worst = [np.abs(a).max(axis=0) for a in (*self.passed, self.inputs, self.between_inputs)]
        return np.asarray(np.max(worst, axis=0))

    @property
    def worst(self) -> float:
        """Largest magnitude of all residuals."""
        return float(np.max(self.by_design))


def eq1_residuals(d: DriveSI) -> RatioResiduals:
    """Residuals of Eq. (1), with its third row corrected: i_mr = r_mr1/r_g3 = r_mr2/r_g4 (printed: r_g1, r_g2)."""
    before, passed = d.drum_radius_m, []
    for radius in d.passed_radii_m:
        ratio = radius / before
        passed.append(ratio / ratio[0] - 1.0)
        before = radius
    inner, total = d.input_radius_m / before, d.input_radius_m / d.drum_radius_m
    first = [d.input_of.index(i) for i in d.input_of]
    cables_of = [[j for j, k in enumerate(d.input_of) if k == i] for i in range(d.n_inputs)]
    per_input = np.stack([total[own].mean(axis=0) for own in cables_of])
    return RatioResiduals(tuple(passed), inner / inner[first] - 1.0, per_input / per_input[0] - 1.0)


def pair_mismatch_m(d: DriveSI, input_angle_rad: Any) -> Floats:
    """Largest mismatch in length between the first cable of each input and its others, in m, shape (n_inputs, ...).

    With the drum at the angle that cable 1 of the input gives, cable k is too long or too short by theta_i (r_ik - r_ok
    r_i1/r_o1). Zero where Eq. (1) holds.
    """
    theta = np.asarray(input_angle_rad, dtype=float)
    rows = []
    for i in range(d.n_inputs):
        own = [j for j, k in enumerate(d.input_of) if k == i]
        drum_per_input = d.input_radius_m[own[0]] / d.drum_radius_m[own[0]]
        apart = [d.input_radius_m[j] - d.drum_radius_m[j] * drum_per_input for j in own]
        rows.append(theta * max(apart, key=lambda length: float(np.max(np.abs(length)))))
    return np.stack(rows)


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
