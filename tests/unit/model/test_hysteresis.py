"""The time-series model: closed form compared with the clip rule on a grid, and the laws of a model with memory."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_case import paper_drive, turned_round

from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from tests.support.clip_grid import simulate_on_grid

loads = st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=12)


def locked(load: Any, **changes: Any) -> Any:
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
    exact = locked(load)
    errors = [
        np.abs(simulate_on_grid(paper_drive(), np.zeros((2, 4)), load, cell_rad=cell).drum_angle_rad - exact).max()
        for cell in (2e-2, 5e-3)
    ]
    assert errors[0] > 8 * errors[1] > 0, f"errors {errors} rad for cells of 20 and 5 mrad"


@given(loads)
def test_first_loading_is_the_static_model(history: list[float]) -> None:
    d = paper_drive()
    assert locked(history[:1])[0] == pytest.approx(float(solve_equilibrium(d, history[0]).drum_angle_rad), rel=1e-9)


def test_reversal_swing_is_that_of_the_static_model() -> None:
    turn = locked([0.91, -0.91])
    assert turn[1] - turn[0] == pytest.approx(float(drum_backlash(paper_drive(), 0.91).reversal_swing_rad), rel=1e-11)
    assert turn[1] - turn[0] == pytest.approx(0.2919e-3, abs=5e-8)


@given(st.floats(0.05, 3.0), st.floats(0.05, 0.95), loads)
def test_return_point_memory(peak: float, depth: float, after: list[float]) -> None:
    """A closed excursion inside a larger one leaves no trace."""
    inner = peak * (1 - 2 * depth)
    plain = locked([peak, *after])
    with_loop = locked([peak, inner, peak, *after])[2:]
    worst = np.abs(plain - with_loop).max()
    assert worst < 1e-15, f"a loop {peak} -> {inner} -> {peak} N m leaves {worst:.3g} rad"


@given(st.floats(0.2, 3.0), st.floats(-0.6, 0.4), st.floats(0.05, 0.5))
def test_nested_loops_are_forgotten_in_turn(peak: float, low: float, size: float) -> None:
    low, high = low * peak, (low + size) * peak
    inner = [high, low + 0.3 * (high - low), high]
    straight, nested = locked([peak, low, peak]), locked([peak, low, *inner, low, peak])
    assert nested[-2] == pytest.approx(straight[1], abs=1e-15)
    assert nested[-1] == pytest.approx(straight[2], abs=1e-15)


@given(loads, st.integers(2, 20))
def test_only_the_turning_points_count(history: list[float], steps: int) -> None:
    """Rate independence: the way from one load to the next may be cut into any number of steps."""
    knots = np.concatenate([[0.0], history])
    fine = np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise(knots)])
    worst = np.abs(locked(fine)[steps - 1 :: steps] - locked(history)).max()
    assert worst < 1e-15, f"{steps} steps instead of 1 change the drum by {worst:.3g} rad"


def test_masing_the_reversal_is_the_first_loading_doubled() -> None:
    """Exact in the logarithm of tension (the reverse slip zone is ln(T/T')/(2 mu)), so exact for the drum as M -> 0."""
    deviations = []
    for load in (0.8, 0.4, 0.2):
        turn = locked([load, -load])
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
    assert moved.drum_angle_rad - angle[0] / 9 == pytest.approx(locked(load), abs=1e-13)


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
        locked([1.0], friction_coefficient=0.0)


@pytest.mark.slow
def test_path_error_is_stretch() -> None:
    """A path error that all cables share in proportion to sigma r_o is a turn of the drum, whatever the history."""
    rng = np.random.default_rng(5)
    d = paper_drive()
    load, turn = rng.normal(0, 1, 30), rng.normal(0, 1e-4, 30)
    path = (d.sigma * d.drum_radius_m)[:, None] * turn
    run = simulate(d, np.zeros((2, 30)), load, path_m=path)
    assert run.drum_angle_rad - turn == pytest.approx(locked(load), abs=1e-15)
    still = solve_equilibrium(d, 0.5, path_m=path)
    assert still.drum_angle_rad - turn == pytest.approx(float(solve_equilibrium(d, 0.5).drum_angle_rad), rel=1e-9)
    with pytest.raises(ModelError, match="path_m has shape"):
        simulate(d, np.zeros((2, 30)), load, path_m=path[:3])
