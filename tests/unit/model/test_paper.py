"""The figures fixed in the project's model notes: mu = 0.15, T_pre = 70 N, A = 0.3117 mm^2, E = 60 GPa.

The mistakes of the paper, each shown symbolically: the printed form contradicts itself, the form used does not.
"""

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from mbcdm_cad.model import capability, equations
from mbcdm_cad.model import equations as eq
from mbcdm_cad.model.equations import eq1_residuals, pair_mismatch_m
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import cable_backlash, drum_backlash, implied_modulus_Pa, mean_radii
from mbcdm_cad.model.wrap import slip_angle_rad
from tests.unit.model.paper_case import paper_drive

TEST_LOAD = 0.91
DESIGN_LOAD = 2 * 2.9e-3 * 76 * 9  # 3.967 N m, the sum behind the paper's 3.9
INPUT_RATING = 2.9e-3 * 76


def close(actual: object, expected: object, digits: float) -> None:
    difference = float(np.max(np.abs(np.asarray(actual) - np.asarray(expected))))
    assert difference <= digits, f"got {actual}, expected {expected}: differs by {difference:.3g} > {digits:.3g}"


def test_backlash_of_each_cable() -> None:
    figures = cable_backlash(paper_drive(), TEST_LOAD)
    close(figures.backlash_simplified_rad * 1e3, [0.18288, 0.15872, 0.13870, 0.12190], 5.1e-6)
    close(figures.backlash_rad * 1e3, [0.18033, 0.15665, 0.13699, 0.12049], 5.1e-6)


def test_tensions_of_cable_1() -> None:
    figures = cable_backlash(paper_drive(), TEST_LOAD)
    simplified = (figures.high_simplified_N[0], figures.low_simplified_N[0])
    close(simplified, (74.297, 65.872), 5.1e-4)
    close((figures.high_N[0], figures.low_N[0]), (74.250, 65.824), 5.1e-4)


def test_drum_turn_with_all_cables() -> None:
    drum = drum_backlash(paper_drive(), TEST_LOAD)
    close(drum.first_loading_rad * 1e3, 0.14595, 1.0e-5)
    close(drum.reversal_swing_rad * 1e3, 0.2919, 5.1e-5)


def test_cost_of_the_simplification() -> None:
    """Dropping kappa costs at most about 1.4 % at the test load and 2.8 % at 3.97 N m; means are 1.3 and 2.5 %."""
    found = cable_backlash(paper_drive(), np.array([TEST_LOAD, DESIGN_LOAD]))
    error = found.backlash_simplified_rad / found.backlash_rad - 1.0
    close(error.mean(axis=0), [0.0129, 0.0253], 1e-4)
    close(error.max(axis=0), [0.0142, 0.0278], 1e-4)


def test_kappa_carries_72_percent_of_eq_20() -> None:
    mean = mean_radii(paper_drive())
    whole = cable_backlash(mean, TEST_LOAD).backlash_simplified_rad[0]
    high = cable_backlash(mean, TEST_LOAD).high_simplified_N[0]
    free = (high - 70.0) * mean.free_span_m[0] / mean.axial_stiffness_N / mean.drum_radius_m[0]
    close(free / whole, 0.72, 0.01)


def test_modulus_under_each_reading() -> None:
    d = paper_drive()

    def implied(theta_mrad: float, reading: str) -> float:
        return implied_modulus_Pa(d, theta_mrad * 1e-3, TEST_LOAD, reading) / 1e9  # type: ignore[arg-type]

    close(implied(0.33, "reversal"), 54.0, 0.1)
    close(implied(0.33, "single"), 27.0, 0.1)
    spread = [implied(0.33 * (1 + sign * equations.BACKLASH_ERROR), "reversal") for sign in (1, -1)]
    close(spread, [49.0, 60.0], 0.5)


def test_the_modulus_does_reproduce_the_measurement() -> None:
    d = paper_drive()
    for reading in ("reversal", "single"):
        modulus = implied_modulus_Pa(d, 0.33e-3, TEST_LOAD, reading, "all_cables")
        drum = drum_backlash(d.with_(modulus_Pa=modulus), TEST_LOAD)
        got = drum.reversal_swing_rad if reading == "reversal" else drum.first_loading_rad
        close(got, 0.33e-3, 1e-15)


def test_load_share_and_input_torques() -> None:
    d = paper_drive()
    at = solve_equilibrium(d, np.array([TEST_LOAD, 3.3]))
    close(at.load_share(d, np.array([TEST_LOAD, 3.3]))[0], [0.448, 0.461], 5.1e-4)
    close(at.input_torque_Nm(d)[:, 0] * 1e3, [73.3, 27.8], 0.051)


def test_drive_limits_both_ways() -> None:
    d = paper_drive()
    equal = [capability.torque_at_input_limit_Nm(d, INPUT_RATING, way).min() for way in (1, -1)]
    close(equal, [3.747, 3.194], 5.1e-4)
    even = d.with_(preload_N=capability.balanced_preload_N(d))
    close([capability.torque_at_input_limit_Nm(even, INPUT_RATING, way).min() for way in (1, -1)], [3.69, 3.66], 5.1e-3)


def test_preload_bias_on_the_inputs() -> None:
    d = paper_drive()
    close(capability.input_bias_Nm(d) * 1e3, [28.0, -28.0], 1e-9)
    close(capability.input_bias_Nm(d.with_(preload_N=capability.balanced_preload_N(d))), [0.0, 0.0], 1e-14)


def test_slip_angles_of_the_inner_step() -> None:
    """23, 86 and 105 degrees for the 54 mm step at 0.91, 3.3 and 3.97 N m by (17); a little more by exact (14)."""
    low = cable_backlash(paper_drive(), np.array([0.91, 3.3, DESIGN_LOAD])).low_N[0]
    close(np.degrees(slip_angle_rad(low, 70.0, 0.15)), [23.5, 88.4, 107.2], 0.06)
    simplified = cable_backlash(paper_drive(), np.array([0.91, 3.3, DESIGN_LOAD])).low_simplified_N[0]
    close(np.degrees(slip_angle_rad(simplified, 70.0, 0.15)), [23.2, 86.4, 104.6], 0.06)


def test_free_spans() -> None:
    close(paper_drive().free_span_m * 1e3, [31.18, 30.68, 30.14, 29.55], 5.1e-3)


def test_mismatch_if_the_table_were_surface_radii() -> None:
    half = 0.405e-3
    d = paper_drive()
    wrong = d.with_(input_radius_m=d.input_radius_m + half, drum_radius_m=d.drum_radius_m + half)
    close(wrong.total_ratio, [8.494, 8.524, 8.550, 8.574], 5.1e-4)
    close(abs(pair_mismatch_m(wrong, np.radians(450.0))[0]) * 1e3, 0.19, 5.1e-3)


def test_bearing_loads_at_preload() -> None:
    d = paper_drive()
    loads = bearing_loads(d, d.preload_N)
    close([np.linalg.norm(load.force_N) for load in loads.inputs], [125.2, 120.8], 0.06)
    close(np.linalg.norm(loads.bodies["guide"].force_N), 5.97, 0.01)
    close(np.linalg.norm(loads.bodies["guide"].moment_Nm), 0.917, 0.001)


@pytest.mark.parametrize(
    ("name", "low", "high", "falls"),
    [
        ("preload_N", 40.0, 110.0, True),
        ("friction_coefficient", 0.05, 0.5, True),
        ("modulus_Pa", 30e9, 120e9, True),
        ("centre_distance_m", 30e-3, 60e-3, False),
    ],
)
def test_fig_5_trends(name: str, low: float, high: float, falls: bool) -> None:
    values = np.linspace(low, high, 15)
    turns = []
    for value in values:
        change = np.full(4, value) if name == "preload_N" else value
        turns.append(float(drum_backlash(paper_drive(**{name: change}), TEST_LOAD).first_loading_rad))
    steps = np.diff(turns)
    assert (steps < 0).all() if falls else (steps > 0).all(), f"{name}: {turns}"


def test_fig_5_rises_with_load_and_flattens_with_friction() -> None:
    d = paper_drive()
    turns = [float(drum_backlash(d, load).first_loading_rad) for load in np.linspace(0.1, 3.9, 12)]
    assert (np.diff(turns) > 0).all(), turns
    friction = np.array([0.05, 0.10, 0.30, 0.35])
    theta = [float(drum_backlash(paper_drive(friction_coefficient=mu), TEST_LOAD).first_loading_rad) for mu in friction]
    steep, flat = theta[0] - theta[1], theta[2] - theta[3]
    assert steep > 15 * flat, f"falls by {steep:.3g} rad from 0.05 to 0.10, by {flat:.3g} from 0.30 to 0.35"


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
    design = capability.torque_to_weight_Nm_kg(equations.DESIGN_TORQUE_NM, equations.DESIGN_MASS_G)
    assert design == pytest.approx(equations.DESIGN_TORQUE_TO_WEIGHT_NM_KG, abs=5e-3)
    prototype = capability.torque_to_weight_Nm_kg(equations.PEAK_TORQUE_NM, equations.PROTOTYPE_MASS_G)
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
