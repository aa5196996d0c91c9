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
