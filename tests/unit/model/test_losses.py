"""Friction of parts against closed forms and limits, and the train's energy by another route."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.losses import (
    BEARINGS,
    ROPE,
    Train,
    backward_efficiency,
    bearing_torque_Nm,
    gearhead_share,
    tangent_share,
)
from mbcdm_cad.model.structure.causes import (
    URAD_NM,
    Acting,
    Section,
    ball_bearing_N_mm,
    bearing_urad_Nm,
    bending_urad_Nm,
    torsion_urad_Nm,
)
from mbcdm_cad.model.structure.drum_sector import Isotropic

PARAMS = Path(__file__).parents[3] / "params"
REFERENCES = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")


def layout_in(name: str) -> SectorLayout:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    assert isinstance(layout, SectorLayout)
    return layout


def test_a_gearhead_of_half_efficiency_and_below_locks() -> None:
    assert backward_efficiency(0.5) == 0.0
    assert backward_efficiency(0.3) == 0.0
    assert backward_efficiency(0.51) == pytest.approx(2.0 - 1.0 / 0.51)
    assert backward_efficiency(1.0) == 1.0


@given(st.floats(0.5, 1.0), st.floats(0.01, 100.0))
def test_the_same_torque_is_lost_forward_and_backward(efficiency: float, output_Nm: float) -> None:
    forward = output_Nm / efficiency - output_Nm
    backward = output_Nm - output_Nm * backward_efficiency(efficiency)
    assert forward == pytest.approx(backward, rel=1e-9, abs=1e-12)
    assert gearhead_share(efficiency) * output_Nm == pytest.approx(forward, rel=1e-9, abs=1e-12)


def test_a_sheave_of_common_size_loses_what_rope_makers_say() -> None:
    # 0.98 with its bearing at D/d from 20 to 25: the rope takes most of the 2 %, none of it more.
    for ratio in (20.0, 25.0):
        lost = 2.0 * float(tangent_share(1.0, ratio))
        assert 0.009 < lost < 0.02, (ratio, lost)


@given(st.floats(0.1, 10.0), st.floats(5.0, 100.0))
def test_a_pulley_of_twice_the_diameter_loses_2_to_the_1_33_less(rope_mm: float, ratio: float) -> None:
    once, twice = (float(tangent_share(rope_mm, rope_mm * r)) for r in (ratio, 2.0 * ratio))
    assert once / twice == pytest.approx(2.0**1.33)


def test_bearing_by_hand() -> None:
    # 0.5 x 0.0015 x 100 N x 8 mm; under a spring alone the equivalent load is twice its force.
    assert bearing_torque_Nm(100.0, 0.0, 0.008) == pytest.approx(6e-4)
    assert bearing_torque_Nm(0.0, 10.0, 0.008) == pytest.approx(1.2e-4)


def test_friction_of_the_cables_of_the_reference() -> None:
    layout = layout_in("mbcdm")
    moved = layout.losses.moving(0.0, 1)
    rope = sum(float(x.torque_Nm[0]) for x in moved.losses if x.kind == ROPE)
    assert 0.18 < rope < 0.55, rope
    # By hand: one tangent point on input and drum, two on the guide, at the preload.
    d, byhand = layout.drive.cable.diameter_mm, 0.0
    for c in layout.drive.cables:
        ratios = [d / (2.0 * r) for r in (c.input_radius_mm, c.guide_radius_mm, c.drum_radius_mm)]  # type: ignore[attr-defined]
        half = [0.35 * ratio**1.33 for ratio in ratios]
        byhand += (half[0] + 2.0 * half[1] + half[2]) * c.preload_N * c.drum_radius_mm * 1e-3
    # The preload biases the inputs, and cables settle a little beside it.
    assert rope == pytest.approx(byhand, rel=0.01)


def without_constants(train: Train) -> Train:
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

    def rope(train: Train, load: float) -> float:
        return sum(float(x.torque_Nm[0]) for x in train.moving(load, 1).losses if x.kind == ROPE)

    train = layout.losses
    more = replace(train, d=train.d.with_(preload_N=2.0 * train.d.preload_N))
    assert rope(more, 0.0) == pytest.approx(2.0 * rope(train, 0.0))
    peak = layout.drive.loads.peak_torque_Nm
    assert rope(train, peak) == pytest.approx(rope(train, 0.0), rel=0.05)


def test_back_driving_starts_harder_than_it_runs_by_the_bearings_alone() -> None:
    layout = layout_in("mbcdm")
    back = layout.losses.backdrive
    assert back is not None
    bearings = sum(float(x.torque_Nm) for x in back.losses if x.kind == BEARINGS)
    assert back.start_Nm - back.running_Nm == pytest.approx(bearings)
    # Motor's friction at the drum, by hand: 9 x 76 turns, two motors of 11.5 mN m/A that take 7 mA without load, over
    # 2 - 1/0.68.
    motors = next(float(x.torque_Nm) for x in back.losses if x.name == "motors")
    assert motors == pytest.approx(2 * 684 * 11.5e-3 * 7e-3 / (2.0 - 1.0 / 0.68))


def test_a_gearhead_that_locks_gives_no_back_driving() -> None:
    layout = layout_in("mbcdm")
    locked = replace(layout.losses, gear_share=gearhead_share(0.5))
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
    acting = [Acting(length / 2, along_x(force), NONE)]
    acting += [Acting(at, along_x(-force / 2), NONE) for at in (0.0, length)]
    found = bending_urad_Nm(Z, acting, [Section(0.0, length, radius)], STEEL)
    table = force**2 * length**3 / (48.0 * STEEL_MPA * pi / 4.0 * radius**4) * URAD_NM
    # Timoshenko's shear: half the force on either side.
    table += force**2 * length / (4.0 * STEEL.shear_MPa * ROUND * pi * radius**2) * URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_an_overhung_load_bends_span_and_overhang() -> None:
    # F a^2 (L + a) / (3 E I) at the load, a beyond the support.
    force, span, overhang, radius, bore = 16.7, 10.0, 4.0, 4.0, 2.0
    acting = [
        Acting(span + overhang, along_x(force), NONE),
        Acting(span, along_x(-force * (span + overhang) / span), NONE),
        Acting(0.0, along_x(force * overhang / span), NONE),
    ]
    found = bending_urad_Nm(Z, acting, [Section(0.0, span + overhang, radius, bore)], STEEL)
    second = pi / 4.0 * (radius**4 - bore**4)
    table = force**2 * overhang**2 * (span + overhang) / (3.0 * STEEL_MPA * second) * URAD_NM
    # Of a tube of twice its bore 0.620 of the area (Cowper 1966).
    area = 0.620 * pi * (radius**2 - bore**2)
    shear = force**2 * (overhang + (overhang / span) ** 2 * span) / (STEEL.shear_MPa * area)
    table += shear * URAD_NM
    assert found == pytest.approx(table, rel=2e-3)


def test_a_couple_at_one_support_bends_the_span() -> None:
    # C L / (3 E I) at the couple.
    couple, length, radius = 100.0, 30.0, 3.0
    reaction = couple / length
    # About y: a force along x at z adds z x F = (0, z Fx, 0).
    acting = [Acting(0.0, along_x(reaction), np.array([0.0, couple, 0.0])), Acting(length, along_x(-reaction), NONE)]
    found = bending_urad_Nm(Z, acting, [Section(0.0, length, radius)], STEEL)
    table = couple**2 * length / (3.0 * STEEL_MPA * pi / 4.0 * radius**4) * URAD_NM
    table += reaction**2 * length / (STEEL.shear_MPa * ROUND * pi * radius**2) * URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_steps_of_a_shaft_twist_in_series() -> None:
    steps = [Section(0.0, 5.0, 3.0, 1.5), Section(5.0, 12.0, 4.0)]
    polar = [pi / 2.0 * (3.0**4 - 1.5**4), pi / 2.0 * 4.0**4]
    # Inside the thicker step the thin one twists on, over an eighth of its diameter where they are far from alike.
    inside = 6.0 / 8.0 * (1.0 - 0.75**2.6)
    table = 50.0**2 * ((5.0 + inside) / polar[0] + 7.0 / polar[1]) / 80e3 * URAD_NM
    assert torsion_urad_Nm(50.0, steps, 80e3) == pytest.approx(table)
    held = 50.0**2 * 6.0 / 8.0 / polar[0] / 80e3 * URAD_NM
    assert torsion_urad_Nm(50.0, steps, 80e3, collar=True) == pytest.approx(table + held)


def test_a_shaft_without_a_wall_is_refused() -> None:
    with pytest.raises(ValueError, match="bore of radius 3 mm"):
        torsion_urad_Nm(1.0, [Section(0.0, 1.0, 3.0, 3.0)], 80e3)


def test_a_bearing_of_8_by_16_is_as_stiff_as_such_bearings_are() -> None:
    # A ball of 2 mm gives by 6 to 7 um under 90 N (Hertz, steel on steel in a groove): 618/8 under 200 N has about
    # 45 N/um. The factor of two each way covers the balls that catalogues do not give.
    stiffness = ball_bearing_N_mm(8.0, 16.0, 200.0)
    assert 22e3 < stiffness < 90e3, f"{stiffness:.4g} N/mm"


@given(st.floats(1.0, 2000.0), st.floats(1.05, 5.0), st.floats(0.0, 200.0))
def test_a_bearing_stiffens_under_load_and_preload(radial: float, more: float, axial: float) -> None:
    base = ball_bearing_N_mm(8.0, 16.0, radial, axial)
    assert ball_bearing_N_mm(8.0, 16.0, radial * more, axial) >= base
    assert ball_bearing_N_mm(8.0, 16.0, radial, axial * more) >= base


@given(st.floats(0.1, 100.0), st.floats(1e3, 1e6))
def test_the_turn_by_a_bearing_is_force_times_give(reaction: float, stiffness: float) -> None:
    give_mm = reaction / stiffness
    # Reciprocity: the drum turns by force (per N m) times displacement (per N m).
    assert bearing_urad_Nm(reaction, stiffness) == pytest.approx(reaction * give_mm * 1e-3 * 1e6)
