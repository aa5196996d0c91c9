"""The mistakes of the paper, each shown symbolically: the printed form contradicts itself, the form used does not."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.model import equations
from mbcdm_cad.model import equations as eq
from mbcdm_cad.model.capability import torque_to_weight_Nm_kg
from mbcdm_cad.model.equations import eq1_residuals
from mbcdm_cad.model.si import ModelError

Tp, Tl, Th, mu, EA, ro, ri, Lf, M = sp.symbols("T_pre T_l T_h mu EA r_o r_i L_free M_l", positive=True)
s = sp.symbols("s", nonnegative=True)
DIFFERENCE = M / (2 * ro)


def zone(radius: sp.Expr, tension: sp.Expr) -> sp.Expr:
    """r/(EA mu) (T - T_pre - T_pre ln(T/T_pre)), the bracket of Eq. (7) to (10)."""
    return radius / (EA * mu) * (tension - Tp - Tp * sp.log(tension / Tp))


def test_eq1_third_row_uses_steps_3_and_4() -> None:
    d = paper_drive()
    right, guide = d.input_radius_m[2:], d.value("guide_radius_m")
    assert right / guide[2:] == pytest.approx([2 / 3, 2 / 3]), "r_mr/r_g3, r_mr/r_g4"
    printed = right / guide[:2]
    assert abs(printed[0] - printed[1]) > 0.004, f"as printed the row reads {printed}: not one ratio"
    assert eq1_residuals(d).worst < 1e-15


def test_eq4_sign_on_the_slack_side() -> None:
    """Only e^{-mu theta} runs from T_pre down to T_l over the slip angle of Eq. (6)."""
    angle = eq.eq6_slip_angle_slack(60.0, 70.0, 0.15)
    assert eq.eq4_tension(70.0, 0.15, angle, "slack") == pytest.approx(60.0, rel=1e-14)
    assert eq.eq4_tension(70.0, 0.15, angle, "slack", as_printed=True) == pytest.approx(70.0**2 / 60.0)
    tight = eq.eq5_slip_angle_tight(80.0, 70.0, 0.15)
    assert eq.eq4_tension(70.0, 0.15, tight, "tight") == pytest.approx(80.0, rel=1e-14)
    with pytest.raises(ModelError, match="side 'left' is unknown"):
        eq.eq4_tension(70.0, 0.15, angle, "left")


def test_eq7_is_the_integral_of_the_tight_profile() -> None:
    angle = sp.log(Th / Tp) / mu
    integral = sp.integrate((Th * sp.exp(-mu * s) - Tp) * ro / EA, (s, 0, angle))
    assert sp.simplify(integral - zone(ro, Th)) == 0


@pytest.mark.parametrize("radius", [ro, ri], ids=["Eq. (8), drum", "Eq. (10), input"])
def test_eq8_and_eq10_printed_integrand_has_the_wrong_sign(radius: sp.Symbol) -> None:
    angle = sp.log(Tp / Tl) / mu
    contraction = sp.integrate((Tl * sp.exp(mu * s) - Tp) * radius / EA, (s, 0, angle))
    printed_integrand = sp.integrate((Tp - Tl * sp.exp(mu * s)) * radius / EA, (s, 0, angle))
    printed_result = -zone(radius, Tl)
    assert sp.simplify(contraction - printed_result) == 0, "the printed result is d(delta_T) - d(delta_pre)"
    assert sp.simplify(printed_integrand + printed_result) == 0, "the printed integrand gives its opposite"
    value = float(contraction.subs({Tp: 70, Tl: 60, mu: 0.15, radius: 0.054, EA: 18702}))
    assert eq.eq8_slip_stretch_slack(60.0, 70.0, 0.15, 0.054, 18702.0) == pytest.approx(value, rel=1e-12)
    printed = eq.eq8_slip_stretch_slack(60.0, 70.0, 0.15, 0.054, 18702.0, as_printed=True)
    assert printed == pytest.approx(-value, rel=1e-12)


def eq13_sum(free_slack: sp.Expr) -> sp.Expr:
    tight = zone(ro, Th) + zone(ri, Th) + (Th - Tp) * Lf / EA
    return tight - zone(ro, Tl) - zone(ri, Tl) + free_slack


def eq14_left() -> sp.Expr:
    kappa = mu * Lf / (ro + ri)
    return Tp * sp.log(Tl / (Tl + DIFFERENCE)) + (kappa + 1) * DIFFERENCE + 2 * kappa * (Tl - Tp)


def test_eq14_follows_only_from_the_corrected_eq12() -> None:
    scale = EA * mu / (ro + ri)
    corrected = eq13_sum((Tl - Tp) * Lf / EA).subs(Th, Tl + DIFFERENCE) * scale
    printed = eq13_sum((Tp - Tl) * Lf / EA).subs(Th, Tl + DIFFERENCE) * scale
    assert sp.simplify(sp.expand_log(corrected - eq14_left(), force=True)) == 0
    rest = sp.simplify(sp.expand_log(printed - eq14_left(), force=True))
    assert sp.simplify(rest - 2 * Lf * mu * (Tp - Tl) / (ro + ri)) == 0, f"left over: {rest}"


def test_eq12_signs() -> None:
    right = eq.eq12_free_stretch_slack(60.0, 70.0, 0.03, 18702.0)
    assert right < 0.0 < eq.eq11_free_stretch_tight(80.0, 70.0, 0.03, 18702.0)
    assert eq.eq12_free_stretch_slack(60.0, 70.0, 0.03, 18702.0, as_printed=True) == -right


def test_eq13_with_steps_is_about_angle_not_length() -> None:
    """Tight cable on r_o2, slack cable on r_o1: one drum angle, so the stretches are as the radii."""
    tight, slack = 57.6e-3 * 1e-4, -54.0e-3 * 1e-4
    assert eq.eq13_residual(tight, slack, 57.6e-3, 54.0e-3) == pytest.approx(0.0, abs=1e-18)
    assert abs(eq.eq13_residual(tight, slack)) > 3e-7, "constant total length would be missed by 0.36 um"


def test_eq16_to_18_solve_eq14_without_kappa() -> None:
    x = DIFFERENCE / Tp
    low = DIFFERENCE / (sp.exp(x) - 1)
    left = sp.log(low / (low + DIFFERENCE)) + x
    assert sp.simplify(sp.expand_log(sp.simplify(left), force=True)) == 0
    load = np.array([0.0, 0.3, 3.0])
    low_N, high_N = eq.eq17_low_tension(load, 70.0, 0.054), eq.eq18_high_tension(load, 70.0, 0.054)
    assert np.abs(eq.eq16_residual(low_N, load, 70.0, 0.054)).max() < 1e-15
    assert (high_N - low_N) * 2 * 0.054 == pytest.approx(load)


def test_eq20_as_printed_is_a_length() -> None:
    """theta_b must not change when all lengths and M are scaled alike at fixed EA; the print scales with them."""

    def both(scale: float) -> tuple[float, float]:
        arguments = (74.3, 70.0, 0.15, 0.054 * scale, 0.006 * scale, 0.03118 * scale, 18702.0)
        return float(eq.eq20_backlash(*arguments)), float(eq.eq20_backlash(*arguments, as_printed=True))

    (angle, length), (angle_2, length_2) = both(1.0), both(2.0)
    assert angle_2 == pytest.approx(angle, rel=1e-14)
    assert length_2 == pytest.approx(2.0 * length, rel=1e-14)
    assert angle == pytest.approx(length / (0.15 * 0.054), rel=1e-14)


def test_eq20_is_eq19_of_eq7_9_and_11() -> None:
    high, preload, friction, drum, inner, free, stiffness = 74.3, 70.0, 0.15, 0.054, 0.006, 0.03118, 18702.0
    parts = (
        eq.eq7_slip_stretch_tight(high, preload, friction, inner, stiffness),
        eq.eq7_slip_stretch_tight(high, preload, friction, drum, stiffness),
        eq.eq11_free_stretch_tight(high, preload, free, stiffness),
    )
    whole = eq.eq20_backlash(high, preload, friction, drum, inner, free, stiffness)
    assert eq.eq19_backlash(*parts, drum) == pytest.approx(float(whole), rel=1e-12)


def test_the_texts_torque() -> None:
    two_inputs = 2 * equations.MOTOR_TORQUE_MNM * 1e-3 * equations.GEAR_RATIO * 9
    assert two_inputs == pytest.approx(3.967, abs=5e-4), "the paper rounds it down to 3.9"
    design = torque_to_weight_Nm_kg(equations.DESIGN_TORQUE_NM, equations.DESIGN_MASS_G)
    assert design == pytest.approx(equations.DESIGN_TORQUE_TO_WEIGHT_NM_KG, abs=5e-3)
    prototype = torque_to_weight_Nm_kg(equations.PEAK_TORQUE_NM, equations.PROTOTYPE_MASS_G)
    assert prototype == pytest.approx(equations.TORQUE_TO_WEIGHT_NM_KG, abs=5e-4)


# Exact Eq. (14): a root for every load, in its bracket, with the right limits.


shares = st.floats(1e-6, 50.0)
kappas = st.floats(0.0, 20.0)


@given(shares, kappas)
def test_eq14_root_satisfies_the_equation(share: float, kappa: float) -> None:
    assume(share * (1.0 + kappa) < 600.0)  # beyond, T_l underflows to zero
    preload, radius = 70.0, 0.054
    load = share * 2 * preload * radius
    low, high = eq.eq14_tensions(load, preload, radius, kappa)
    residual = float(eq.eq14_residual(low, load, preload, radius, kappa)) / preload
    assert abs(residual) < 1e-14 * (1 + share) * (1 + kappa), f"x {share}, kappa {kappa}: residual {residual:.3g} T_pre"
    assert float(high - low) * 2 * radius == pytest.approx(load, rel=1e-9)
    assert 0.0 <= low < preload < high, f"T_l {low}, T_h {high}"


@given(shares)
def test_eq14_tends_to_the_simplified_form(share: float) -> None:
    load = share * 2 * 70.0 * 0.054
    low, _ = eq.eq14_tensions(load, 70.0, 0.054, 0.0)
    assert float(low) == pytest.approx(float(eq.eq17_low_tension(load, 70.0, 0.054)), rel=1e-12)


@given(st.floats(1e-3, 1.9))
def test_eq14_tends_to_a_frictionless_span_for_large_kappa(share: float) -> None:
    """kappa -> inf: all stretch is in the free span, so both sides change by half of the difference."""
    low, _ = eq.eq14_tensions(share * 2 * 70.0 * 0.054, 70.0, 0.054, 1e9)
    assert float(low) == pytest.approx(70.0 * (1 - share / 2), rel=1e-6)


def test_eq14_at_no_load_and_in_bulk() -> None:
    low, high = eq.eq14_tensions(np.zeros(3), 70.0, 0.054, 0.08)
    assert (low == 70.0).all() and (high == 70.0).all()
    loads = np.linspace(0.0, 30.0, 50)[:, None]
    kappa = np.array([0.0, 0.06, 0.4])
    bulk, _ = eq.eq14_tensions(loads, 70.0, 0.054, kappa)
    one_by_one = [[float(eq.eq14_tensions(float(m[0]), 70.0, 0.054, k)[0]) for k in kappa] for m in loads]
    worst = np.abs(bulk / np.array(one_by_one) - 1).max()
    assert worst < 1e-12, f"bulk differs from one by one by {worst:.3g}"


def test_eq14_refuses_a_negative_load() -> None:
    with pytest.raises(ModelError, match="load_Nm: -1 is negative"):
        eq.eq14_tensions(-1.0, 70.0, 0.054, 0.08)


def test_kappa_of_the_paper() -> None:
    assert eq.eq15_kappa(0.15, 31.18e-3, 54e-3, 6e-3) == pytest.approx(0.07795, abs=5e-6)
