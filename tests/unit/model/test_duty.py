"""The duty by rows and by a record: root mean square, movements counted by hand.

Two-node heat of a motor: closed forms, energy, a data sheet, another integrator.
"""

from dataclasses import replace
from math import exp, inf, log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mbcdm_cad.design.blocks import DutyRow
from mbcdm_cad.design.bought import Motor
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model import heat, losses
from mbcdm_cad.model.duty import default_duty, of_record, of_rows
from mbcdm_cad.model.heat import COPPER_PER_K, MotorHeat, motor_heat
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.structure import causes
from mbcdm_cad.model.structure.drum_sector import Isotropic
from tests.support.reference import PARAMS


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


REFERENCES = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")


def layout_in(name: str) -> SectorLayout:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    assert isinstance(layout, SectorLayout)
    return layout


def test_a_gearhead_of_half_efficiency_and_below_locks() -> None:
    assert losses.backward_efficiency(0.5) == 0.0
    assert losses.backward_efficiency(0.3) == 0.0
    assert losses.backward_efficiency(0.51) == pytest.approx(2.0 - 1.0 / 0.51)
    assert losses.backward_efficiency(1.0) == 1.0


@given(st.floats(0.5, 1.0), st.floats(0.01, 100.0))
def test_the_same_torque_is_lost_forward_and_backward(efficiency: float, output_Nm: float) -> None:
    forward = output_Nm / efficiency - output_Nm
    backward = output_Nm - output_Nm * losses.backward_efficiency(efficiency)
    assert forward == pytest.approx(backward, rel=1e-9, abs=1e-12)
    assert losses.gearhead_share(efficiency) * output_Nm == pytest.approx(forward, rel=1e-9, abs=1e-12)


def test_a_sheave_of_common_size_loses_what_rope_makers_say() -> None:
    # 0.98 with its bearing at D/d from 20 to 25: the rope takes most of the 2 %, none of it more.
    for ratio in (20.0, 25.0):
        lost = 2.0 * float(losses.tangent_share(1.0, ratio))
        assert 0.009 < lost < 0.02, (ratio, lost)


@given(st.floats(0.1, 10.0), st.floats(5.0, 100.0))
def test_a_pulley_of_twice_the_diameter_loses_2_to_the_1_33_less(rope_mm: float, ratio: float) -> None:
    once, twice = (float(losses.tangent_share(rope_mm, rope_mm * r)) for r in (ratio, 2.0 * ratio))
    assert once / twice == pytest.approx(2.0**1.33)


def test_bearing_by_hand() -> None:
    # 0.5 x 0.0015 x 100 N x 8 mm; under a spring alone the equivalent load is twice its force.
    assert losses.bearing_torque_Nm(100.0, 0.0, 0.008) == pytest.approx(6e-4)
    assert losses.bearing_torque_Nm(0.0, 10.0, 0.008) == pytest.approx(1.2e-4)


def test_friction_of_the_cables_of_the_reference() -> None:
    layout = layout_in("mbcdm")
    moved = layout.losses.moving(0.0, 1)
    rope = sum(float(x.torque_Nm[0]) for x in moved.losses if x.kind == losses.ROPE)
    assert 0.18 < rope < 0.55, rope
    # By hand: one tangent point on input and drum, two on the guide, at the preload.
    d, byhand = layout.drive.cable.diameter_mm, 0.0
    for c in layout.drive.cables:
        ratios = [d / (2.0 * r) for r in (c.input_radius_mm, c.guide_radius_mm, c.drum_radius_mm)]  # type: ignore[attr-defined]
        half = [0.35 * ratio**1.33 for ratio in ratios]
        byhand += (half[0] + 2.0 * half[1] + half[2]) * c.preload_N * c.drum_radius_mm * 1e-3
    # The preload biases the inputs, and cables settle a little beside it.
    assert rope == pytest.approx(byhand, rel=0.01)


def without_constants(train: losses.Train) -> losses.Train:
    """The train with rope and gearhead's efficiency alone."""
    return replace(train, bearings=(), gear_idle_Nm=0.0, motor_idle_Nm=0.0)


@pytest.mark.parametrize("name", REFERENCES)
def test_work_over_a_cycle_is_the_loop_of_the_wraps_and_the_losses(name: str) -> None:
    """The inputs go to and fro under a load that swings with them; the rope's tension is followed point by point.

    Along a cable from the drum, each tangent point multiplies the tension by 1 + s where the rope runs towards the
    input, by 1 - s where it runs off it; a gearhead divides power by its efficiency forward and multiplies it backward.
    """
    layout = layout_in(name)
    train = without_constants(layout.losses)
    d, peak, n = train.d, layout.drive.loads.peak_torque_Nm, 1601
    phase = np.linspace(0.0, 4.0 * pi, n)
    drum = 0.3 * np.sin(phase)
    load = 0.5 * peak * (0.3 + 0.6 * np.cos(phase + 0.5))
    ran = simulate(d, d.input_turns[:, None] * drum, load)
    one = slice((n - 1) // 2, n)  # the second cycle: the loops are closed
    tension = ran.tension_N[:, one]
    tension, step = 0.5 * (tension[:, 1:] + tension[:, :-1]), np.diff(drum[one])
    middle = 0.5 * (load[one][1:] + load[one][:-1])

    lossless = d.sigma[:, None] * tension * d.input_radius_m[:, None]
    followed, work, motor_work = tension.copy(), 0.0, 0.0
    for j, route in enumerate(d.routes.cables):
        towards_input = np.sign(step) * d.sigma[j]
        for at in reversed(list(route.contacts())):
            share = 0.35 * (layout.drive.cable.diameter_mm / (2e3 * at.wrap.radius_m)) ** 1.33
            for _ in range((at.arriving is not None) + (at.leaving is not None)):
                followed[j] *= 1.0 + share * towards_input
    eta = layout.drive.gearhead.efficiency
    for i in range(d.n_inputs):
        own = np.array(d.input_of) == i
        torque = (d.sigma[:, None] * followed * d.input_radius_m[:, None])[own].sum(axis=0)
        power = torque * step * d.input_turns[i]
        work += float(power.sum())
        motor_work += float(np.where(power > 0.0, power / eta, power * (2.0 - 1.0 / eta)).sum())

    turns = d.input_turns[list(d.input_of), None]
    loop = float((lossless * turns * step).sum()) - float((middle * np.diff(ran.drum_angle_rad[one])).sum())
    output = float((middle * np.diff(ran.drum_angle_rad[one])).sum())
    way = np.where(np.sign(step) == np.where(middle < 0.0, -1.0, 1.0), 1, -1)
    lost = dict.fromkeys(("rope", "gearhead"), 0.0)
    for sense in (1, -1):
        moved = train.moving(middle[way == sense], sense)
        for x in moved.losses:
            lost[x.kind] += float((x.torque_Nm * np.abs(step[way == sense])).sum())
    assert loop >= -1e-9, loop
    assert work == pytest.approx(output + loop + lost["rope"], rel=0.005), (work, output, loop, lost)
    assert work - output - loop == pytest.approx(lost["rope"], rel=0.03), (work, output, loop, lost)
    assert motor_work - work == pytest.approx(lost["gearhead"], rel=0.03), (motor_work, work, lost)


@pytest.mark.parametrize("name", REFERENCES)
@pytest.mark.parametrize("direction", [1, -1])
def test_the_torque_that_motors_raise_is_that_at_which_they_give_their_torque(name: str, direction: int) -> None:
    layout = layout_in(name)
    train, rated = layout.losses, layout.drive.motor.rated_torque_mNm * 1e-3
    raised = train.raised_Nm(train.output_Nm(rated), direction)
    for i, load in enumerate(raised):
        asked = float(train.moving(direction * load, 1).motor_Nm[i, 0]) - train.motor_idle_Nm
        assert asked == pytest.approx(rated, rel=0.003), (name, direction, i, load, asked)


@pytest.mark.parametrize("name", REFERENCES)
def test_power_of_the_motors_is_that_of_the_load_and_of_every_cause(name: str) -> None:
    train = layout_in(name).losses
    for way in (1, -1):
        moved = train.moving(np.array([0.5, -0.5]), way)
        turns = train.d.input_turns[:, None] * train.gear_ratio
        given = (moved.motor_Nm * turns).sum(axis=0)
        assert given == pytest.approx(way * np.abs(moved.load_Nm) + moved.lost_Nm, rel=1e-6)


def test_more_preload_loses_more_and_load_hardly_counts_for_the_cables() -> None:
    layout = layout_in("siso_spur")

    def rope(train: losses.Train, load: float) -> float:
        return sum(float(x.torque_Nm[0]) for x in train.moving(load, 1).losses if x.kind == losses.ROPE)

    train = layout.losses
    more = replace(train, d=train.d.with_(preload_N=2.0 * train.d.preload_N))
    assert rope(more, 0.0) == pytest.approx(2.0 * rope(train, 0.0))
    peak = layout.drive.loads.peak_torque_Nm
    assert rope(train, peak) == pytest.approx(rope(train, 0.0), rel=0.05)


def test_back_driving_starts_harder_than_it_runs_by_the_bearings_alone() -> None:
    layout = layout_in("mbcdm")
    back = layout.losses.backdrive
    assert back is not None
    bearings = sum(float(x.torque_Nm) for x in back.losses if x.kind == losses.BEARINGS)
    assert back.start_Nm - back.running_Nm == pytest.approx(bearings)
    # Motor's friction at the drum, by hand: 9 x 76 turns, two motors of 11.5 mN m/A that take 7 mA without load, over
    # 2 - 1/0.68.
    motors = next(float(x.torque_Nm) for x in back.losses if x.name == "motors")
    assert motors == pytest.approx(2 * 684 * 11.5e-3 * 7e-3 / (2.0 - 1.0 / 0.68))


def test_a_gearhead_that_locks_gives_no_back_driving() -> None:
    layout = layout_in("mbcdm")
    locked = replace(layout.losses, gear_share=losses.gearhead_share(0.5))
    assert locked.backdrive is None
    assert float(locked.moving(3.15, -1).efficiency[0]) == 0.0


# Bending and torsion of shafts against closed forms, and the give of ball bearings.


Z = np.array([0.0, 0.0, 1.0])
STEEL_MPA = 210e3
STEEL = Isotropic(STEEL_MPA, 0.3)
# Share of a full circle that carries a force across evenly (Cowper 1966, Poisson's ratio 0.3).
ROUND = 0.886
NONE = np.zeros(3)


def along_x(force_N: float) -> np.ndarray:
    return np.array([force_N, 0.0, 0.0])


def test_a_beam_on_two_supports_bends_as_tables_say() -> None:
    # Point load in the middle: F L^3 / (48 E I) at the load, so that twice the energy is F times that.
    force, length, radius = 10.0, 60.0, 4.0
    acting = [causes.Acting(length / 2, along_x(force), NONE)]
    acting += [causes.Acting(at, along_x(-force / 2), NONE) for at in (0.0, length)]
    found = causes.bending_urad_Nm(Z, acting, [causes.Section(0.0, length, radius)], STEEL)
    table = force**2 * length**3 / (48.0 * STEEL_MPA * pi / 4.0 * radius**4) * causes.URAD_NM
    # Timoshenko's shear: half the force on either side.
    table += force**2 * length / (4.0 * STEEL.shear_MPa * ROUND * pi * radius**2) * causes.URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_an_overhung_load_bends_span_and_overhang() -> None:
    # F a^2 (L + a) / (3 E I) at the load, a beyond the support.
    force, span, overhang, radius, bore = 16.7, 10.0, 4.0, 4.0, 2.0
    acting = [
        causes.Acting(span + overhang, along_x(force), NONE),
        causes.Acting(span, along_x(-force * (span + overhang) / span), NONE),
        causes.Acting(0.0, along_x(force * overhang / span), NONE),
    ]
    found = causes.bending_urad_Nm(Z, acting, [causes.Section(0.0, span + overhang, radius, bore)], STEEL)
    second = pi / 4.0 * (radius**4 - bore**4)
    table = force**2 * overhang**2 * (span + overhang) / (3.0 * STEEL_MPA * second) * causes.URAD_NM
    # Of a tube of twice its bore 0.620 of the area (Cowper 1966).
    area = 0.620 * pi * (radius**2 - bore**2)
    shear = force**2 * (overhang + (overhang / span) ** 2 * span) / (STEEL.shear_MPa * area)
    table += shear * causes.URAD_NM
    assert found == pytest.approx(table, rel=2e-3)


def test_a_couple_at_one_support_bends_the_span() -> None:
    # C L / (3 E I) at the couple.
    couple, length, radius = 100.0, 30.0, 3.0
    reaction = couple / length
    # About y: a force along x at z adds z x F = (0, z Fx, 0).
    acting = [
        causes.Acting(0.0, along_x(reaction), np.array([0.0, couple, 0.0])),
        causes.Acting(length, along_x(-reaction), NONE),
    ]
    found = causes.bending_urad_Nm(Z, acting, [causes.Section(0.0, length, radius)], STEEL)
    table = couple**2 * length / (3.0 * STEEL_MPA * pi / 4.0 * radius**4) * causes.URAD_NM
    table += reaction**2 * length / (STEEL.shear_MPa * ROUND * pi * radius**2) * causes.URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_steps_of_a_shaft_twist_in_series() -> None:
    steps = [causes.Section(0.0, 5.0, 3.0, 1.5), causes.Section(5.0, 12.0, 4.0)]
    polar = [pi / 2.0 * (3.0**4 - 1.5**4), pi / 2.0 * 4.0**4]
    # Inside the thicker step the thin one twists on, over an eighth of its diameter where they are far from alike.
    inside = 6.0 / 8.0 * (1.0 - 0.75**2.6)
    table = 50.0**2 * ((5.0 + inside) / polar[0] + 7.0 / polar[1]) / 80e3 * causes.URAD_NM
    assert causes.torsion_urad_Nm(50.0, steps, 80e3) == pytest.approx(table)
    held = 50.0**2 * 6.0 / 8.0 / polar[0] / 80e3 * causes.URAD_NM
    assert causes.torsion_urad_Nm(50.0, steps, 80e3, collar=True) == pytest.approx(table + held)


def test_a_shaft_without_a_wall_is_refused() -> None:
    with pytest.raises(ValueError, match="bore of radius 3 mm"):
        causes.torsion_urad_Nm(1.0, [causes.Section(0.0, 1.0, 3.0, 3.0)], 80e3)


def test_a_bearing_of_8_by_16_is_as_stiff_as_such_bearings_are() -> None:
    # A ball of 2 mm gives by 6 to 7 um under 90 N (Hertz, steel on steel in a groove): 618/8 under 200 N has about
    # 45 N/um. The factor of two each way covers the balls that catalogues do not give.
    stiffness = causes.ball_bearing_N_mm(8.0, 16.0, 200.0)
    assert 22e3 < stiffness < 90e3, f"{stiffness:.4g} N/mm"


@given(st.floats(1.0, 2000.0), st.floats(1.05, 5.0), st.floats(0.0, 200.0))
def test_a_bearing_stiffens_under_load_and_preload(radial: float, more: float, axial: float) -> None:
    base = causes.ball_bearing_N_mm(8.0, 16.0, radial, axial)
    assert causes.ball_bearing_N_mm(8.0, 16.0, radial * more, axial) >= base
    assert causes.ball_bearing_N_mm(8.0, 16.0, radial, axial * more) >= base


@given(st.floats(0.1, 100.0), st.floats(1e3, 1e6))
def test_the_turn_by_a_bearing_is_force_times_give(reaction: float, stiffness: float) -> None:
    give_mm = reaction / stiffness
    # Reciprocity: the drum turns by force (per N m) times displacement (per N m).
    assert causes.bearing_urad_Nm(reaction, stiffness) == pytest.approx(reaction * give_mm * 1e-3 * 1e6)
