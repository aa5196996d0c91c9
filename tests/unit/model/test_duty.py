"""The duty by rows and by a record: root mean square, movements counted by hand.

Two-node heat of a motor: closed forms, energy, a data sheet, another integrator.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, inf, log, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mbcdm_cad.design.blocks import DutyRow
from mbcdm_cad.design.bought import Motor
from mbcdm_cad.model import heat
from mbcdm_cad.model.duty import default_duty, of_record, of_rows
from mbcdm_cad.model.heat import COPPER_PER_K, MotorHeat, motor_heat


def test_rows_give_mean_square_share_and_movements() -> None:
    rows = (
        DutyRow(torque_Nm=8.0, share=0.4),
        DutyRow(torque_Nm=3.0, share=0.3, speed_deg_s=60.0, range_deg=60.0),
        DutyRow(torque_Nm=-2.0, share=0.2, range_deg=40.0),
        DutyRow(torque_Nm=0.0, share=0.1, speed_deg_s=0.0),
    )
    duty = of_rows(rows, 60.0, 100.0, 35.0)
    assert duty.period_s == pytest.approx(60.0)
    assert duty.rms_torque_Nm == pytest.approx(sqrt(0.4 * 64 + 0.3 * 9 + 0.2 * 4))
    assert duty.peak_torque_Nm == 8.0 and duty.moving_share == pytest.approx(0.5)
    # 18 s at 60 deg/s over 120 deg there and back: 9 a minute; the other row once a minute.
    assert [s.per_h for s in duty.strokes] == pytest.approx([540.0, 60.0])
    assert [s.range_deg for s in duty.strokes] == [60.0, 40.0] and duty.cycles_per_h == pytest.approx(600.0)
    assert duty.largest_speed_deg_s == pytest.approx(60.0)
    assert (duty.speed_deg_s * duty.time_s).sum() == pytest.approx(0.0, abs=1e-9)


def test_shares_count_relative_to_their_sum_and_the_travel_stands_in_for_a_range() -> None:
    rows = (DutyRow(torque_Nm=1.0, share=1.0, speed_deg_s=20.0), DutyRow(torque_Nm=2.0, share=1.0))
    duty = of_rows(rows, 10.0, 100.0, 25.0)
    assert duty.time_s.sum() == pytest.approx(10.0) and duty.rms_torque_Nm == pytest.approx(sqrt(2.5))
    assert duty.strokes[0].range_deg == 100.0 and duty.strokes[0].per_h == pytest.approx(5 * 20 / 200 * 360)


def test_the_assumed_duty_says_what_it_is() -> None:
    duty = default_duty(10.0, 120.0, 25.0)
    assert not duty.stated and len(duty.assumed) == 2
    assert duty.peak_torque_Nm == 10.0 and duty.rms_torque_Nm == pytest.approx(10 * sqrt(0.1 + 0.9 * 0.09))
    assert duty.cycles_per_h == pytest.approx(360.0)


def test_the_assumed_duty_carries_the_payloads_weight() -> None:
    """A weight above the usual share of the peak torque is carried all the time; a smaller one is within it."""
    heavy, light = (default_duty(10.0, 120.0, 25.0, weight) for weight in (6.0, 2.0))
    assert heavy.rms_torque_Nm == pytest.approx(10 * sqrt(0.1 + 0.9 * 0.36))
    assert "weight, 6 N m" in heavy.assumed[0], heavy.assumed
    assert light.rms_torque_Nm == default_duty(10.0, 120.0, 25.0).rms_torque_Nm
    assert "weight, 2 N m" in light.assumed[-1], light.assumed


def test_a_record_gives_what_its_curve_is() -> None:
    """Two periods of a cosine of 30 degrees under a torque of 2 N m with a wave of 1 N m; a tremble is no movement."""
    t = np.linspace(0.0, 10.0, 4001)
    angle = 30.0 * np.cos(2 * np.pi * t / 5.0) + 0.05 * np.sin(2 * np.pi * t * 7.0)
    torque = 2.0 + np.sin(2 * np.pi * t)
    duty = of_record(t, angle, torque, 25.0)
    assert duty.period_s == pytest.approx(10.0)
    assert duty.rms_torque_Nm == pytest.approx(sqrt(4.5), rel=1e-3)
    assert duty.cycles_per_h == pytest.approx(2 * 360.0)
    assert [s.range_deg for s in duty.strokes] == pytest.approx([60.0] * 4, abs=0.2)
    assert all(s.torque_Nm == pytest.approx(3.0, abs=0.01) for s in duty.strokes)


def test_a_record_that_ends_elsewhere_closes_the_cycle() -> None:
    """From 0 to 40 and no way back in the record: the cycle begins anew at 0, so the drum came back."""
    duty = of_record(np.array([0.0, 1.0, 2.0]), np.array([0.0, 20.0, 40.0]), np.ones(3), 25.0)
    assert duty.cycles_per_h == pytest.approx(1800.0) and {s.range_deg for s in duty.strokes} == {40.0}


# maxon RE 25, 118743, as its data sheet states it: 2.18 ohm, 23.4 mN m/A, 1.24 A continuously.
RE25 = Motor(
    name="RE 25",
    diameter_mm=25.0,
    length_mm=54.5,
    rated_torque_mNm=28.6,
    rotor_inertia_g_cm2=10.3,
    mass_g=130.0,
    winding_limit_C=100.0,
    winding_K_W=3.1,
    housing_K_W=14.0,
    winding_time_s=12.0,
    motor_time_s=612.0,
    source="data sheet",
)
OHMS, CONSTANT, CURRENT = 2.18, 23.4e-3, 1.24


def by_time_steps(
    m: MotorHeat, times: list[float], torques: list[float], ambient: float, start: tuple[float, float]
) -> np.ndarray:
    """Temperatures after the pieces, by an integrator that knows only the two equations."""
    at = np.array(start)
    for time, torque in zip(times, torques, strict=True):

        def rates(_: float, t: np.ndarray, torque: float = torque) -> list[float]:
            power = m.loss_W_Nm2 * torque**2 * (1.0 + COPPER_PER_K * (t[0] - 25.0))
            through = (t[0] - t[1]) / m.winding_K_W
            return [
                (power - through) / m.winding_J_K,
                (through - (t[1] - ambient) / (m.housing_K_W * m.mount)) / m.housing_J_K,
            ]

        at = solve_ivp(rates, (0.0, time), at, rtol=1e-9, atol=1e-9).y[:, -1]
    return at


def test_the_data_sheet_of_a_motor_agrees_with_itself() -> None:
    """The heat at the continuous current, by resistance and thermal resistances, is that of the continuous torque."""
    m = motor_heat(RE25)
    hot = 1.0 + COPPER_PER_K * (100.0 - 25.0)
    current = sqrt(75.0 / (OHMS * hot * (3.1 + 14.0)))
    assert current == pytest.approx(CURRENT, rel=0.05), f"{current} A"
    assert m.loss_W_Nm2 * CONSTANT**2 == pytest.approx(OHMS, rel=0.05), m.loss_W_Nm2 * CONSTANT**2
    assert m.estimated == ()


def test_estimates_from_size_and_mass_are_near_the_data_sheet() -> None:
    """Within 2.5 sigma of each estimate."""
    stated = motor_heat(RE25)
    guess = motor_heat(
        replace(RE25, winding_K_W=None, housing_K_W=None, winding_time_s=None, motor_time_s=None, winding_limit_C=None)
    )
    assert abs(log(guess.housing_K_W / stated.housing_K_W)) < 2.5 * heat.AIR_SIGMA, guess
    assert abs(log(guess.winding_K_W / stated.winding_K_W)) < 2.5 * heat.WINDING_SIGMA, guess
    whole = log((guess.winding_J_K + guess.housing_J_K) / (stated.winding_J_K + stated.housing_J_K))
    assert abs(whole) < 2.5 * heat.CAPACITY_SIGMA, guess
    assert set(guess.estimated) == {"winding_K_W", "housing_K_W", "winding_J_K", "housing_J_K", "limit_C"}


def test_a_step_follows_the_closed_form_of_two_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Constant power (no growth of the resistance): two time constants from the quadratic of the network."""
    monkeypatch.setattr(heat, "COPPER_PER_K", 1e-12)
    m = motor_heat(RE25)
    torque, ambient = 0.02, 25.0
    power = m.loss_W_Nm2 * torque**2
    # s^2 C_w C_h + s (C_w (1/R_wh + 1/R_ha) + C_h/R_wh) + 1/(R_wh R_ha) = 0
    a, c = m.winding_J_K * m.housing_J_K, 1.0 / (m.winding_K_W * m.housing_K_W)
    b = m.winding_J_K * (1.0 / m.winding_K_W + 1.0 / m.housing_K_W) + m.housing_J_K / m.winding_K_W
    fast, slow = (-(b + s * sqrt(b * b - 4.0 * a * c)) / (2.0 * a) for s in (1.0, -1.0))
    end = power * (m.winding_K_W + m.housing_K_W)
    # x e^(fast t) + y e^(slow t) + end: rise 0 and rate P/C_w at the start.
    y = (power / m.winding_J_K + fast * end) / (slow - fast)
    x = -end - y
    steps = np.full(200, 3.0)
    turn, add = m._pieces(steps, np.full(200, torque), ambient)
    at, found = np.array([ambient, ambient]), []
    for one, other in zip(turn, add, strict=True):
        at = one @ at + other
        found.append(at[0])
    t = np.cumsum(steps)
    expected = ambient + end + x * np.exp(fast * t) + y * np.exp(slow * t)
    assert found == pytest.approx(expected.tolist(), abs=1e-6)


def test_the_continuous_torque_ends_at_the_windings_limit() -> None:
    m = motor_heat(RE25)
    steady = m.repeated(np.array([10.0]), np.array([0.0286]), 25.0)
    assert steady is not None and steady.hottest_winding_C == pytest.approx(100.0, abs=1e-6)
    assert m.continuous_at_Nm(25.0) == pytest.approx(0.0286, rel=1e-9)
    assert m.continuous_at_Nm(60.0) == pytest.approx(0.0286 * sqrt(40.0 / 75.0), rel=1e-9)
    assert m.continuous_at_Nm(100.0) == 0.0
    assert m.time_to_limit_s(0.0285, 25.0) == inf


@settings(max_examples=25, deadline=None)
@given(
    times=st.lists(st.floats(2.0, 80.0), min_size=2, max_size=4),
    shares=st.lists(st.floats(0.0, 1.2), min_size=4, max_size=4),
    ambient=st.floats(-10.0, 40.0),
)
def test_the_cycle_repeats_and_its_heat_leaves(times: list[float], shares: list[float], ambient: float) -> None:
    """Another integrator, started at the temperatures found, comes back to them; heat in equals heat out."""
    m = motor_heat(RE25)
    torques = [0.0286 * share * 0.8 for share in shares[: len(times)]]
    found = m.repeated(np.array(times), np.array(torques), ambient)
    assert found is not None
    start = float(found.winding_C[0]), float(found.housing_C[0])
    assert by_time_steps(m, times, torques, ambient, start) == pytest.approx(start, abs=1e-4)
    warm = 1.0 + COPPER_PER_K * (_middle(found.winding_C) - 25.0)
    steps = np.diff(found.time_s)
    given_J = float((steps * m.loss_W_Nm2 * _at(times, torques, found.time_s) ** 2 * warm).sum())
    left_J = float((steps * (_middle(found.housing_C) - ambient) / m.housing_K_W).sum())
    assert left_J == pytest.approx(given_J, rel=0.01, abs=0.05), (left_J, given_J)


def _middle(values: np.ndarray) -> np.ndarray:
    return 0.5 * (values[1:] + values[:-1])


def _at(times: list[float], torques: list[float], found_s: np.ndarray) -> np.ndarray:
    """Torque in each piece of the cycle that was cut."""
    return np.array(torques)[np.searchsorted(np.cumsum(times) - 1e-9, _middle(found_s))]


def test_time_to_the_limit_from_cold_and_warm() -> None:
    m = motor_heat(RE25)
    for torque in (0.06, 0.143):
        for start in ((25.0, 25.0), (70.0, 55.0)):
            time = m.time_to_limit_s(torque, 25.0, start)
            assert by_time_steps(m, [time], [torque], 25.0, start)[0] == pytest.approx(100.0, abs=0.01), time
    # Of a short overload the data sheet's time constant of the winding tells: the housing hardly warms.
    torque = 10 * 0.0286
    power = m.loss_W_Nm2 * torque**2
    rate = 1.0 / m.winding_time_s - power * COPPER_PER_K / m.winding_J_K
    rise = power / m.winding_J_K / rate
    alone = -log(1.0 - 75.0 / rise) / rate if rate > 0 else log(1.0 - 75.0 / rise) / -rate
    assert m.time_to_limit_s(torque, 25.0) == pytest.approx(alone, rel=0.02)
    assert m.time_to_limit_s(torque, 25.0, (100.0, 60.0)) == 0.0


def test_overload_for_a_share_of_the_time() -> None:
    m = motor_heat(RE25)
    # A period far shorter than the winding's time constant: only the mean square counts.
    assert m.allowed_Nm(0.25, 0.05, 25.0) == pytest.approx(2 * 0.0286, rel=1e-3)
    # A quarter of a day: the motor is as warm as it gets.
    assert m.allowed_Nm(0.25, 86400.0, 25.0) == pytest.approx(0.0286, rel=1e-3)
    assert m.allowed_Nm(0.25, 60.0, 50.0) < m.allowed_Nm(0.25, 60.0, 25.0)
    # Without an end, but the mean square is too large: the winding gets hotter and hotter, or over its limit.
    times, torques = np.array([15.0, 45.0]), np.array([0.08, 0.0])
    assert m.cycles_to_limit_s(times, torques, 25.0) < 600.0
    assert m.repeated(np.array([1.0]), np.array([0.2]), 25.0) is None


def test_many_short_pieces_heat_as_their_mean_square() -> None:
    m = motor_heat(RE25)
    times, torques = np.full(20000, 0.01), 0.02 * (1.0 + np.sin(np.arange(20000) * 0.1))
    many = m.repeated(times, torques, 25.0)
    mean = m.repeated(np.array([200.0]), np.array([sqrt(float((torques**2).mean()))]), 25.0)
    assert many is not None and mean is not None
    assert many.hottest_winding_C == pytest.approx(mean.hottest_winding_C, abs=0.3)


def test_sigmas_are_those_of_mounting_and_of_estimates() -> None:
    m = motor_heat(RE25)
    assert len(m.sigmas()) == 1 and m.sigmas()[0][0].mount == pytest.approx(exp(heat.MOUNT_SIGMA))
    assert len(motor_heat(replace(RE25, winding_K_W=None, winding_time_s=None)).sigmas()) == 3


def test_mujocos_thermal_motor_warms_alike() -> None:
    """A motor that MuJoCo (``dcmotor`` with ``thermal``, one body) stalls for shares of the time, against two nodes.

    One body is two nodes without a resistance between them. MuJoCo's copper grows with the temperature by its own code.
    """
    mujoco = pytest.importorskip("mujoco")
    ambient, capacity, step, torque = 35.0, 40.0, 0.05, 0.03
    m = MotorHeat(
        continuous_Nm=0.0286,
        limit_C=125.0,
        winding_K_W=1e-3,
        housing_K_W=17.0,
        winding_J_K=0.1 * capacity,
        housing_J_K=0.9 * capacity,
        brushless=False,
    )
    ohms = m.loss_W_Nm2 * CONSTANT**2
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step}"/>
        <worldbody><body><joint name="shaft" frictionloss="10"/><geom size=".05" mass="1"/></body></worldbody>
        <actuator><dcmotor name="motor" joint="shaft" input="ff" motorconst="{CONSTANT} {CONSTANT}" resistance="{ohms}"
          saturation="1 0 0" controller="0 0 0 0 0 400"
          thermal="17 {capacity} 0 {COPPER_PER_K} 25 {ambient}"/></actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    pieces, seen = 20, []
    for k in range(pieces):
        for _ in range(600):
            # It gives the voltage of the cold resistance: more keeps the current, as a current controller does.
            hot = 1.0 + COPPER_PER_K * (ambient + float(data.act[0]) - 25.0)
            data.ctrl[0] = hot * torque if k % 3 else 0.0
            mujoco.mj_step(model, data)
        seen.append(float(data.act[0]))
    turn, add = m._pieces(
        np.full(pieces, 600 * step), np.array([torque if k % 3 else 0.0 for k in range(pieces)]), ambient
    )
    at, found = np.array([ambient, ambient]), []
    for a, b in zip(turn, add, strict=True):
        at = a @ at + b
        found.append(float(at[0]) - ambient)
    assert max(found) > 25.0, found
    assert found == pytest.approx(seen, rel=0.01, abs=0.05), (found, seen)
