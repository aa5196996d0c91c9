"""Slip on the input, equilibrium, symmetry and loads of the plain capstan drive, each computed independently."""

from dataclasses import replace
from math import exp, pi, radians, tanh

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import analyse_many
from mbcdm_cad.model.capability import requirements, torque_at_slip_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.routes.route import contact_point_m
from tests.support.sliced_cables import by_bisection


def belt_tensions_N(preload_N: float, mu: float, wrap_rad: float, pulled_N: float) -> tuple[float, float]:
    """(tight, slack) end tensions of an elastic belt over a held pulley, by nodes that each obey Coulomb's law.

    Both sides are equal springs (unit stiffness, so that a way is a force); one end is pulled, the other let go, by
    ``pulled_N`` in steps. Nothing says where the belt sticks: every node moves until friction on its own few degrees
    holds it.
    """
    nodes, cell = 12, 150.0
    hold = exp(mu * wrap_rad / nodes)
    moved = [0.0] * nodes
    for pulled in np.linspace(0.0, pulled_N, 9)[1:].tolist():
        for _ in range(3000):
            worst = 0.0
            for k in (*range(nodes), *range(nodes - 2, -1, -1)):
                left_k, right_k = (1.0 if k == 0 else cell), (1.0 if k == nodes - 1 else cell)
                left = preload_N + left_k * (moved[k] + pulled if k == 0 else moved[k] - moved[k - 1])
                right = preload_N + right_k * (-pulled - moved[k] if k == nodes - 1 else moved[k + 1] - moved[k])
                step = 0.0
                if left > right * hold:
                    step = (right * hold - left) / (left_k + right_k * hold)
                elif right > left * hold:
                    step = (right - left * hold) / (right_k + left_k * hold)
                moved[k] += step
                worst = max(worst, abs(step))
            if worst < 1e-7:
                break
    return preload_N + moved[0] + pulled_N, preload_N - pulled_N - moved[-1]


@pytest.mark.parametrize(("mu", "wrap"), [(0.15, 2.0), (0.15, 6.0), (0.3, 4.0)])
def test_belt_of_nodes_slips_where_the_closed_form_says(mu: float, wrap: float) -> None:
    """T_h - T_l = 2 T_pre tanh(mu theta/2) with equal linear sides; pulled further it carries no more."""
    limit = 2 * 70.0 * tanh(mu * wrap / 2)
    tight, slack = belt_tensions_N(70.0, mu, wrap, 0.6 * limit / 2)
    assert tight - slack == pytest.approx(0.6 * limit, rel=0.03)
    tight, slack = belt_tensions_N(70.0, mu, wrap, 1.6 * limit / 2)
    assert tight / slack == pytest.approx(exp(mu * wrap), rel=1e-3)
    assert tight - slack == pytest.approx(limit, rel=0.03)


@settings(max_examples=40, deadline=None)
@given(mu=st.floats(0.05, 0.4), turns=st.integers(1, 5), way=st.sampled_from((1, -1)))
def test_slip_begins_where_the_tensions_differ_by_the_capstan_factor(
    drive: SpurDrive, mu: float, turns: int, way: int
) -> None:
    d = layout_of(replace(drive, friction_coefficient=mu, turns=turns)).si
    load = float(torque_at_slip_Nm(d, way)[0])
    tension = solve_equilibrium(d, way * load).tension_N
    factor = exp(mu * replace(drive, turns=turns).wrap_rad)
    assert float(tension.max() / tension.min()) == pytest.approx(factor, rel=1e-6)


def test_short_wraps_on_the_drum_leave_the_linear_law(drive: SpurDrive) -> None:
    """With next to nothing on the drum both sides are almost linear, and the torque at slip that of the tanh."""
    d = layout_of(drive).si.with_(drum_wrap_rad=[1e-3] * 2, input_wrap_rad=[1e-3] * 2)
    expected = 2 * 70.0 * tanh(0.15 * drive.wrap_rad / 2) * 59.4e-3
    assert float(torque_at_slip_Nm(d, 1)[0]) == pytest.approx(expected, rel=1e-3)


def test_wrap_is_what_both_contact_points_leave_of_the_turns(drive: SpurDrive) -> None:
    """By the angle between the points where the spans leave, seen from the input's axis."""
    d = layout_of(drive).si
    through = d.through_wrap_rad
    assert through is not None
    axis = d.routes.inputs[0]
    at = [contact_point_m(axis, route.wraps[0], route.spans[0].direction) for route in d.routes.cables]
    points = [point - np.array(axis.point_m) for point in at]
    angles = [np.arctan2(p[0], -p[2]) for p in points]
    assert float(through[0]) == pytest.approx(2 * pi * 3 - abs(angles[0] - angles[1]), rel=1e-12)
    assert float(through[0]) == pytest.approx(drive.wrap_rad, rel=1e-12)


def test_spans_touch_both_pulleys_where_the_path_does(drive: SpurDrive) -> None:
    for route in layout_of(drive).si.routes.cables:
        ends = [
            contact_point_m(layout_of(drive).si.routes.body(wrap.body), wrap, route.spans[0].direction)
            for wrap in route.wraps
        ]
        across = (ends[1] - ends[0]) * np.array([1.0, 0.0, 1.0])
        assert np.linalg.norm(across) == pytest.approx(route.spans[0].length_m, rel=1e-12)
        assert across / np.linalg.norm(across) == pytest.approx(route.spans[0].direction, abs=1e-12)


def test_equilibrium_is_that_of_cables_summed_up_in_slices(drive: SpurDrive) -> None:
    at = solve_equilibrium(layout_of(drive).si, 2.15)
    angle, tensions = by_bisection(drive, drive.free_span_mm * 1e-3, 2.15)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N == pytest.approx(tensions, rel=1e-5)


@settings(max_examples=30, deadline=None)
@given(load=st.floats(0.05, 3.0))
def test_both_senses_are_alike(drive: SpurDrive, load: float) -> None:
    d = layout_of(drive).si
    one, other = (solve_equilibrium(d, way * load) for way in (1.0, -1.0))
    assert float(one.drum_angle_rad) == pytest.approx(-float(other.drum_angle_rad), rel=1e-9)
    assert one.tension_N == pytest.approx(other.tension_N[::-1], rel=1e-9)


def test_input_holds_the_load_over_the_ratio(drive: SpurDrive) -> None:
    d = layout_of(drive).si
    for load in (0.3, -0.8):
        assert float(solve_equilibrium(d, load).input_torque_Nm(d)[0]) == pytest.approx(load / 9.9, rel=1e-9)


def test_spans_pull_input_and_drum_together(drive: SpurDrive) -> None:
    """Both spans point to the drum: their parts along the line of centres add up, across it they cancel."""
    loads = bearing_loads(layout_of(drive).si, np.array([70.0, 70.0]))
    pull = 2 * 70.0 * drive.free_span_mm / drive.centre_distance_mm
    assert loads.inputs[0].force_N == pytest.approx([0.0, 0.0, -pull], abs=1e-9)
    assert loads.drum.force_N == pytest.approx([0.0, 0.0, pull], abs=1e-9)


def test_slip_limits_the_torque_in_the_analysis_and_in_bulk(drive: SpurDrive) -> None:
    """One turn on a pulley of low friction: the cable slips before the motor reaches its limit."""
    slippery = replace(drive, turns=1, friction_coefficient=0.05)
    found = analyse(layout_of(slippery))
    slip = {limit.direction: limit.torque_Nm for limit in found.limits if limit.cause == "slip"}
    assert found.peak_torque_Nm == pytest.approx((slip[1], slip[-1]))
    assert slip[1] < 1.5
    d = layout_of(slippery).si
    figures = analyse_many(d.spread(2), requirements(layout_of(slippery)))
    # Many designs at once have no terminals, so that their wraps have no end: they slip a little later.
    endless = float(torque_at_slip_Nm(d, 1)[0])
    assert figures.peak_torque_Nm[0] == pytest.approx([endless] * 2, rel=1e-6)
    assert slip[1] < endless, f"{slip[1]} N m with wraps that end, {endless} without"
    assert "slip" in {limit.cause for limit in analyse(layout_of(drive)).limits}


def test_limited_wraps_at_the_end_of_travel_turn_the_drum_less(drive: SpurDrive) -> None:
    even = layout_of(drive).si
    short = even.with_(drum_wrap_rad=[radians(20.0)] * 2)
    turned = [abs(float(solve_equilibrium(d, 2.15).drum_angle_rad)) for d in (even, short)]
    assert turned[1] < turned[0], turned
