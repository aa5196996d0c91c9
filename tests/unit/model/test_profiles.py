"""Wrap profiles in closed form: compared with turning points, the grid and the static model, and their own laws."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.wrap import slack_stretch_m
from tests.support.clip_grid import simulate_on_grid
from tests.unit.model.paper_case import paper_drive, turned_round

loads = st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=12)


def short(input_rad: float, drum_rad: float, **changes: Any) -> Any:
    """The paper's drive with finite wraps."""
    return paper_drive(input_wrap_rad=np.full(4, input_rad), drum_wrap_rad=np.full(4, drum_rad), **changes)


def locked(d: Any, load: Any) -> Any:
    """The answer for a load history with both inputs at zero."""
    history = np.asarray(load, dtype=float)
    return simulate_profiles(d, np.zeros((2, history.size)), history)


@given(loads)
@settings(max_examples=60)
def test_long_wraps_give_the_turning_points_answer(history: list[float]) -> None:
    d = paper_drive(preload_N=[62.0, 71.0, 75.0, 66.0])
    rng = np.random.default_rng(len(history))
    angle, load = rng.normal(0, 1e-3, (2, len(history))), np.array(history)
    knots, turning = simulate_profiles(d, angle, load), simulate(d, angle, load)
    worst = np.abs(knots.drum_angle_rad - turning.drum_angle_rad).max()
    assert worst < 1e-12, f"drum angles differ by {worst:.3g} rad"
    pull = np.abs(knots.tension_N - turning.tension_N).max()
    assert pull < 1e-7, f"tensions differ by {pull:.3g} N"


@given(st.integers(0, 10**9))
@settings(max_examples=80)
def test_any_series_is_balanced_or_refused_for_its_travel(seed: int) -> None:
    """Random frictions, moduli, wraps, steps from microns to radians and loads through slack."""
    rng = np.random.default_rng(seed)
    d = paper_drive(
        friction_coefficient=10 ** rng.uniform(-2.5, -0.1),
        modulus_Pa=10 ** rng.uniform(9.0, 11.3),
        preload_N=rng.uniform(5.0, 150.0, 4),
    )
    if rng.random() < 0.6:
        d = d.with_(input_wrap_rad=rng.uniform(0.05, 30.0, 4), drum_wrap_rad=rng.uniform(0.02, 3.0, 4))
    n, step = int(rng.integers(5, 60)), 10 ** rng.uniform(-7.0, 0.3)
    angle = np.tile(np.cumsum(rng.normal(0, step, n)), (2, 1)) + rng.normal(0, 1e-4, (2, n))
    load = rng.normal(0, 10 ** rng.uniform(-3.0, 0.6), n)
    try:
        answer = simulate_profiles(d, angle, load, winding=bool(rng.random() < 0.7))
    except ModelError as error:
        if "would wind off more than its wrap" not in str(error):
            raise
        return
    assert (answer.tension_N >= 0.0).all()
    missed = np.abs((d.sigma * d.drum_radius_m) @ answer.tension_N - load).max()
    assert missed < 1e-9, f"balance missed by {missed:.3g} N m"


def test_slip_on_the_guide_is_the_third_wrap() -> None:
    d, load = paper_drive().with_passed_slip, np.array([0.91, -0.91, 0.4, -0.2])
    endless = d.with_(passed_wrap_rad=[np.full(4, np.inf)])
    ours, closed = locked(endless, load), simulate(endless, np.zeros((2, 4)), load)
    assert ours.drum_angle_rad == pytest.approx(closed.drum_angle_rad, rel=1e-9)


@pytest.mark.parametrize("load", [0.3, 2.0, -3.5, 6.0])
def test_run_out_wraps_first_loading_is_the_static_model(load: float) -> None:
    d = short(1.0, 0.4)
    static = solve_equilibrium(d, load)
    series = locked(d, [load])
    assert series.drum_angle_rad[0] == pytest.approx(float(static.drum_angle_rad), rel=1e-9)
    assert series.tension_N[:, 0] == pytest.approx(static.tension_N, rel=1e-9)
    endless = locked(paper_drive(), [load]).drum_angle_rad[0]
    assert abs(series.drum_angle_rad[0]) <= abs(endless), "a short wrap cannot make the drum softer"


def test_finite_wraps_equal_the_grid_after_reversals() -> None:
    """Slip zones that reach the anchor, then turn: cell by cell and in closed form."""
    load = np.array([3.5, -3.0, 3.2, -1.0, 2.5, 0.0])
    d, angle = short(1.0, 0.4), np.zeros((2, 6))
    exact = simulate_profiles(d, angle, load).drum_angle_rad
    grid = simulate_on_grid(paper_drive(), angle, load, cell_rad=5e-4, input_wrap_rad=1.0, drum_wrap_rad=0.4)
    worst = np.abs(exact - grid.drum_angle_rad).max() / np.abs(exact).max()
    assert worst < 1e-6, f"differs by {worst:.3g}"


def test_a_cable_goes_slack_and_comes_back() -> None:
    """The path of cable 1 shortens by twice its slack stretch: no tension, and on the way back it is taut again."""
    d = short(2.0, 0.5)
    lost = float(slack_stretch_m(d)[0])
    path = np.zeros((4, 5))
    path[0] = [0.5 * lost, 2 * lost, 3 * lost, 0.5 * lost, 0.0]
    answer = simulate(d, np.zeros((2, 5)), 0.0, path_m=path)
    slack = answer.tension_N[0]
    assert slack[0] > 0 and slack[1] == slack[2] == 0.0, f"tension {slack} N"
    assert 0 < slack[3] < slack[4], f"tension {slack} N"
    torque = (d.sigma * d.drum_radius_m) @ answer.tension_N
    assert np.abs(torque).max() < 1e-9, f"balance missed by {np.abs(torque).max():.3g} N m"


def test_all_cables_slack_is_said() -> None:
    d = short(1.0, 0.4)
    path = np.full((4, 1), 3 * float(slack_stretch_m(d).min()))
    with pytest.raises(ModelError, match="every cable that could hold it is slack"):
        simulate(d, np.zeros((2, 1)), 0.5, path_m=path)


def brake(amplitude_rad: float, per_cycle: int, cycles: int = 2) -> tuple[Any, Any, Any]:
    phase = 2 * np.pi * np.arange(1, cycles * per_cycle + 1) / per_cycle
    drum = amplitude_rad * np.sin(phase)
    return drum, np.tile(9 * drum, (2, 1)), 0.91 * np.where(np.cos(phase) >= 0, 1.0, -1.0)


def test_winding_grid_converges_to_the_knots() -> None:
    """The error of the grid falls with its cell, towards this answer and no other.

    Samples lie closer than cells: the grid refines a wider step for itself and lets the brake turn at its start.
    """
    _, angle, load = brake(0.05, 4000, cycles=1)
    exact = simulate(paper_drive(), angle, load, winding=True).drum_angle_rad
    errors = [
        np.abs(simulate_on_grid(paper_drive(), angle, load, True, cell).drum_angle_rad - exact).max()
        for cell in (8e-3, 4e-3, 2e-3)
    ]
    assert errors[0] > 1.5 * errors[1] > 2.25 * errors[2], f"errors {errors} rad for cells of 8, 4 and 2 mrad"
    assert errors[2] < 3e-8, f"error {errors[2]:.3g} rad at 2 mrad"


def test_winding_converges_with_the_sampling() -> None:
    """Nothing but the steps between samples is left to refine: the error falls with their square."""
    extremes = []
    for per_cycle in (200, 400, 800, 12_800):
        drum, angle, load = brake(0.05, per_cycle)
        extremes.append(np.abs(simulate(paper_drive(), angle, load, winding=True).drum_angle_rad - drum).max())
    errors = np.abs(np.array(extremes[:3]) - extremes[3])
    assert errors[0] > 2 * errors[1] > 4 * errors[2], f"errors of the extreme {errors} rad"
    assert errors[2] < 5e-9, f"{errors[2]:.3g} rad at 800 samples a cycle"


def test_winding_reversed_in_sign_and_mirrored() -> None:
    """Angles and loads of the other sign, and cables pulling the other way: the answer with its sign changed."""
    rng = np.random.default_rng(5)
    angle, load = np.cumsum(rng.normal(0, 0.02, (2, 150)), axis=1), rng.normal(0, 0.8, 150)
    d = paper_drive()
    there = simulate(d, angle, load, winding=True)
    back = simulate(turned_round(d), -angle, -load, winding=True)
    assert back.drum_angle_rad == pytest.approx(-there.drum_angle_rad, abs=1e-12)
    assert back.tension_N == pytest.approx(there.tension_N, abs=1e-7)


def test_cable_wound_on_brings_its_tension_back() -> None:
    """Wound on under load and off again without reversal of the load: the way back meets the tension stored."""
    drum = 0.3 * np.concatenate([np.linspace(0, 1, 301)[1:], np.linspace(1, 0, 301)[1:]])
    angle, load = np.tile(9 * drum, (2, 1)), np.full(600, 0.91)
    wound = simulate(paper_drive(), angle, load, winding=True).drum_angle_rad - drum
    still = simulate(paper_drive(), angle, load).drum_angle_rad - drum
    assert np.abs(still - still[0]).max() < 1e-9, "without winding a steady load leaves a steady error"
    assert abs(wound[299] - wound[0]) > 20e-6, f"winding on moves the drum by {wound[299] - wound[0]:.3g} rad"


def test_winding_off_more_than_the_wrap_is_refused() -> None:
    _, angle, load = brake(2.0, 400)
    with pytest.raises(ModelError, match=r"sample \d+: cable cable_\d would wind off more than its wrap"):
        simulate(short(16.0, 3.0), angle, load, winding=True)


def test_winding_with_slip_on_the_guide_is_refused() -> None:
    with pytest.raises(ModelError, match="slip on passed bodies is not modelled"):
        simulate(paper_drive().with_passed_slip, np.zeros((2, 2)), 0.1, winding=True)


def locked_inputs(load: Any, **changes: Any) -> Any:
    """Drum angle for a load history with both inputs at zero."""
    history = np.asarray(load, dtype=float)
    return simulate(paper_drive(**changes), np.zeros((2, history.size)), history).drum_angle_rad


def test_closed_form_equals_the_grid() -> None:
    rng = np.random.default_rng(3)
    decaying = 2.0 * np.sin(np.linspace(0, 40, 200)) * np.exp(-np.linspace(0, 3, 200))
    load = np.concatenate([[0.91, -0.91, 0.91, 0.0], rng.normal(0, 1.5, 60), decaying])
    angle = rng.normal(0, 1e-3, (2, load.size))
    d = paper_drive(preload_N=[62.0, 71.0, 75.0, 66.0])
    exact, grid = simulate(d, angle, load), simulate_on_grid(d, angle, load)
    size = np.abs(exact.drum_angle_rad).max()
    worst = np.abs(exact.drum_angle_rad - grid.drum_angle_rad).max() / size
    assert worst < 1e-6, f"drum angles differ by {worst:.3g} of {size:.3g} rad"
    tension = np.abs(exact.tension_N - grid.tension_N).max()
    assert tension < 1e-4, f"tensions differ by {tension:.3g} N"


def test_grid_error_falls_with_the_square_of_the_cell() -> None:
    load = np.array([2.0, -1.5, 1.0, -0.3])
    exact = locked_inputs(load)
    errors = [
        np.abs(simulate_on_grid(paper_drive(), np.zeros((2, 4)), load, cell_rad=cell).drum_angle_rad - exact).max()
        for cell in (2e-2, 5e-3)
    ]
    assert errors[0] > 8 * errors[1] > 0, f"errors {errors} rad for cells of 20 and 5 mrad"


@given(loads)
def test_first_loading_is_the_static_model(history: list[float]) -> None:
    d = paper_drive()
    assert locked_inputs(history[:1])[0] == pytest.approx(
        float(solve_equilibrium(d, history[0]).drum_angle_rad), rel=1e-9
    )


def test_reversal_swing_is_that_of_the_static_model() -> None:
    turn = locked_inputs([0.91, -0.91])
    assert turn[1] - turn[0] == pytest.approx(float(drum_backlash(paper_drive(), 0.91).reversal_swing_rad), rel=1e-11)
    assert turn[1] - turn[0] == pytest.approx(0.2919e-3, abs=5e-8)


@given(st.floats(0.05, 3.0), st.floats(0.05, 0.95), loads)
def test_return_point_memory(peak: float, depth: float, after: list[float]) -> None:
    """A closed excursion inside a larger one leaves no trace."""
    inner = peak * (1 - 2 * depth)
    plain = locked_inputs([peak, *after])
    with_loop = locked_inputs([peak, inner, peak, *after])[2:]
    worst = np.abs(plain - with_loop).max()
    assert worst < 1e-15, f"a loop {peak} -> {inner} -> {peak} N m leaves {worst:.3g} rad"


@given(st.floats(0.2, 3.0), st.floats(-0.6, 0.4), st.floats(0.05, 0.5))
def test_nested_loops_are_forgotten_in_turn(peak: float, low: float, size: float) -> None:
    low, high = low * peak, (low + size) * peak
    inner = [high, low + 0.3 * (high - low), high]
    straight, nested = locked_inputs([peak, low, peak]), locked_inputs([peak, low, *inner, low, peak])
    assert nested[-2] == pytest.approx(straight[1], abs=1e-15)
    assert nested[-1] == pytest.approx(straight[2], abs=1e-15)


@given(loads, st.integers(2, 20))
def test_only_the_turning_points_count(history: list[float], steps: int) -> None:
    """Rate independence: the way from one load to the next may be cut into any number of steps."""
    knots = np.concatenate([[0.0], history])
    fine = np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(knots)])
    worst = np.abs(locked_inputs(fine)[steps - 1 :: steps] - locked_inputs(history)).max()
    assert worst < 1e-15, f"{steps} steps instead of 1 change the drum by {worst:.3g} rad"


def test_masing_the_reversal_is_the_first_loading_doubled() -> None:
    """Exact in the logarithm of tension (the reverse slip zone is ln(T/T')/(2 mu)), so exact for the drum as M -> 0."""
    deviations = []
    for load in (0.8, 0.4, 0.2):
        turn = locked_inputs([load, -load])
        deviations.append(abs((turn[1] - turn[0]) / (-2 * turn[0]) - 1))
    assert deviations[0] < 1e-3, deviations
    assert deviations[0] > 1.8 * deviations[1] > 3 * deviations[2], f"not vanishing with the load: {deviations}"


def test_reverse_slip_zone_has_half_the_angle() -> None:
    """Read off the grid: after T_1 -> T_2 the profile turns round at sqrt(T_1 T_2), ln(T_1/T_2)/(2 mu) from the end."""
    high, low = 90.0, 65.0
    s = np.linspace(0.0, 3.0, 30001)
    first = np.clip(np.full_like(s, 70.0), high * np.exp(-0.15 * s), high * np.exp(0.15 * s))
    second = np.clip(first, low * np.exp(-0.15 * s), low * np.exp(0.15 * s))
    turn = s[np.argmax(second != low * np.exp(0.15 * s))]
    assert turn == pytest.approx(np.log(high / low) / 0.3, abs=2e-4)


def test_common_turn_of_the_inputs_is_a_rigid_turn() -> None:
    rng = np.random.default_rng(0)
    load = rng.normal(0, 1, 50)
    angle = np.tile(np.linspace(0, 4.5, 50), (2, 1))
    moved = simulate(paper_drive(), angle, load)
    assert moved.drum_angle_rad - angle[0] / 9 == pytest.approx(locked_inputs(load), abs=1e-13)


def test_inputs_against_each_other_leave_hysteresis() -> None:
    """Left minus right works the friction without any load."""
    apart = np.array([0.0, 2e-3, -2e-3, 0.0])
    run = simulate(paper_drive(), np.stack([apart, -apart]), 0.0)
    assert abs(run.tension_N[0, -1] - 70.0) > 0.1, run.tension_N[:, -1]
    torque = run.input_torque_Nm(paper_drive())
    assert torque.sum(axis=0) == pytest.approx(np.zeros(4), abs=1e-12)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_mirror(seed: int) -> None:
    """Turning the sense of every cable, of the load and of the inputs turns the drum's answer."""
    rng = np.random.default_rng(seed)
    angle, load = rng.normal(0, 2e-3, (2, 40)), rng.normal(0, 1, 40)
    d = paper_drive()
    one = simulate(d, angle, load).drum_angle_rad
    other = simulate(turned_round(d), -angle, -load).drum_angle_rad
    assert other == pytest.approx(-one, abs=1e-15)


@pytest.mark.parametrize(
    ("angle", "load", "message"),
    [
        (np.zeros((3, 4)), np.zeros(4), r"needs \(2, n\)"),
        (np.zeros((2, 4)), np.zeros(5), "for 4 samples"),
        (np.full((2, 4), np.nan), np.zeros(4), "NaN or infinity"),
    ],
)
def test_series_that_do_not_fit(angle: Any, load: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        simulate(paper_drive(), angle, load)


def test_no_friction_is_refused() -> None:
    with pytest.raises(ModelError, match="give it > 0"):
        locked_inputs([1.0], friction_coefficient=0.0)


@pytest.mark.slow
def test_path_error_is_stretch() -> None:
    """A path error that all cables share in proportion to sigma r_o is a turn of the drum, whatever the history."""
    rng = np.random.default_rng(5)
    d = paper_drive()
    load, turn = rng.normal(0, 1, 30), rng.normal(0, 1e-4, 30)
    path = (d.sigma * d.drum_radius_m)[:, None] * turn
    run = simulate(d, np.zeros((2, 30)), load, path_m=path)
    assert run.drum_angle_rad - turn == pytest.approx(locked_inputs(load), abs=1e-15)
    still = solve_equilibrium(d, 0.5, path_m=path)
    assert still.drum_angle_rad - turn == pytest.approx(float(solve_equilibrium(d, 0.5).drum_angle_rad), rel=1e-9)
    with pytest.raises(ModelError, match="path_m has shape"):
        simulate(d, np.zeros((2, 30)), load, path_m=path[:3])
