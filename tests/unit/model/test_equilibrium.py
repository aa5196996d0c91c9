"""All cables at once: balance, symmetry laws, limits, slack, and an independent solution by bisection."""

from __future__ import annotations

from dataclasses import replace
from math import exp, log, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_case import paper_drive, some_cables, turned_round

from mbcdm_cad.design.bought import CableSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.model import equilibrium
from mbcdm_cad.model.creep import DAY_S, START_S, YEAR_S, creeps, preload_left, relaxation, steady_rate_per_s
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, tension_of_stretch
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.tensioning import (
    balanced_tension_N,
    bedding_loss_N,
    influence,
    limits_of_pitch_Hz,
    plucked_Hz,
    reached_length_m,
    sequence,
    take_up,
    taken_from_others,
    tension_from_pitch_N,
    untensioned_length_m,
)
from mbcdm_cad.model.wrap import slack_stretch_m, stretch_first_loading

loads = st.floats(-12.0, 12.0)
preloads = st.lists(st.floats(20.0, 150.0), min_size=4, max_size=4).map(np.array)


def balance(d: DriveSI, at: Equilibrium) -> Any:
    """sum sigma T r_o, what the cables put on the drum."""
    return np.einsum("j,j...->...", d.sigma * d.drum_radius_m, at.tension_N)


@given(loads, preloads, st.floats(0.02, 0.6))
def test_balance_and_one_drum_angle(load: float, preload: np.ndarray, friction: float) -> None:
    d = paper_drive(preload_N=preload, friction_coefficient=friction)
    at = solve_equilibrium(d, load)
    miss = float(balance(d, at)) - load
    assert abs(miss) < 1e-11, f"the load is missed by {miss:.3g} N m"
    back = tension_of_stretch(d, -d.sigma * d.drum_radius_m * float(at.drum_angle_rad))
    worst = np.abs(back - at.tension_N).max()
    assert worst < 1e-9, f"tensions by bisection at that angle differ by {worst:.3g} N"


@given(loads)
def test_reversed_load_on_the_mirrored_drive(load: float) -> None:
    """Swapping left and right and the sense of every cable turns the load round."""
    d = paper_drive()
    mirrored = turned_round(d)
    one, other = solve_equilibrium(d, load), solve_equilibrium(mirrored, -load)
    assert float(one.drum_angle_rad) == pytest.approx(-float(other.drum_angle_rad), rel=1e-12, abs=1e-18)
    assert one.tension_N == pytest.approx(other.tension_N, rel=1e-12)


@given(loads)
def test_order_of_cables_does_not_matter(load: float) -> None:
    d = paper_drive()
    order = [2, 3, 0, 1]
    swapped = some_cables(d, order)
    one, other = solve_equilibrium(d, load), solve_equilibrium(swapped, load)
    assert float(one.drum_angle_rad) == pytest.approx(float(other.drum_angle_rad), rel=1e-11, abs=1e-18)
    assert one.input_torque_Nm(d) == pytest.approx(other.input_torque_Nm(swapped)[::-1], rel=1e-9, abs=1e-12)


def test_input_torques_add_up_to_the_load() -> None:
    """Total ratio 9 on all cables: the inputs hold exactly M/9 between them."""
    d = paper_drive()
    load = np.array([0.4, -2.0, 3.3])
    total = solve_equilibrium(d, load).input_torque_Nm(d).sum(axis=0)
    assert total == pytest.approx(load / 9.0, rel=1e-12)
    shares = solve_equilibrium(d, load).load_share(d, load).sum(axis=0)
    assert shares == pytest.approx(np.ones(3), rel=1e-12)


def test_small_load_meets_the_sticking_stiffness() -> None:
    d = paper_drive()
    stiffness = (d.drum_radius_m**2 * d.axial_stiffness_N / d.free_span_m).sum()
    turn = float(solve_equilibrium(d, 1e-7).drum_angle_rad)
    assert -1e-7 / turn == pytest.approx(stiffness, rel=1e-6)


def test_one_input_alone_is_softer_and_carries_all() -> None:
    d = paper_drive()
    left = some_cables(d, [0, 1])
    idle = solve_equilibrium(left, 0.0)
    # Alone, the pair's preloads on unequal radii do not balance: the drum first settles.
    assert float(balance(left, idle)) == pytest.approx(0.0, abs=1e-12)
    turn = float(solve_equilibrium(left, 0.91).drum_angle_rad - idle.drum_angle_rad)
    assert abs(turn) > 1.8 * abs(float(solve_equilibrium(d, 0.91).drum_angle_rad)), f"turn {turn:.3g} rad"


def test_turning_an_input_turns_the_drum_by_the_ratio() -> None:
    d = paper_drive()
    at = solve_equilibrium(d, 0.91, input_angle_rad=np.array([0.9, 0.9]))
    still = solve_equilibrium(d, 0.91)
    assert float(at.drum_angle_rad - still.drum_angle_rad) == pytest.approx(0.1, rel=1e-11)
    assert at.tension_N == pytest.approx(still.tension_N, rel=1e-9)


def test_slack_cables_and_wraps_that_run_out() -> None:
    d = paper_drive(input_wrap_rad=np.full(4, 9.0), drum_wrap_rad=np.full(4, 0.43))
    at = solve_equilibrium(d, 25.0)
    assert at.slack.tolist() == [True, False, False, True], at.tension_N
    assert float(balance(d, at)) == pytest.approx(25.0, abs=1e-9)
    taut = at.tension_N[1:3] @ d.drum_radius_m[1:3]
    assert taut == pytest.approx(25.0, abs=1e-9)


def test_what_no_cable_can_hold_is_refused() -> None:
    d = paper_drive(input_wrap_rad=np.full(4, 9.0), drum_wrap_rad=np.full(4, 0.43))
    single = some_cables(d, [1])
    with pytest.raises(ModelError, match="no drum angle balances"):
        solve_equilibrium(single, -1.0)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_a_batch_of_designs_equals_one_by_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 7
    radii = 6e-3 * rng.uniform(0.9, 1.3, (4, n))
    d = paper_drive(
        input_radius_m=radii,
        guide_radius_m=1.5 * radii,
        drum_radius_m=9 * radii,
        preload_N=rng.uniform(40, 120, (4, n)),
        centre_distance_m=rng.uniform(32e-3, 45e-3, n),
        friction_coefficient=rng.uniform(0.05, 0.4, n),
        modulus_Pa=rng.uniform(30e9, 90e9, n),
    )
    load = rng.uniform(-4, 4, n)
    bulk = solve_equilibrium(d, load)
    for k in range(n):
        one = paper_drive(
            input_radius_m=radii[:, k],
            guide_radius_m=1.5 * radii[:, k],
            drum_radius_m=9 * radii[:, k],
            preload_N=d.preload_N[:, k],
            centre_distance_m=d.value("centre_distance_m")[k],
            friction_coefficient=d.friction_coefficient[k],
            modulus_Pa=d.modulus_Pa[k],
        )
        single = solve_equilibrium(one, load[k])
        assert float(bulk.drum_angle_rad[k]) == pytest.approx(float(single.drum_angle_rad), rel=1e-10, abs=1e-16)


def tight(**changes: Any) -> DriveSI:
    """The paper's drive with wraps that run out, so that cables can go slack."""
    return paper_drive(input_wrap_rad=np.full(4, 9.0), drum_wrap_rad=np.full(4, 0.43), **changes)


@given(st.floats(-60.0, 60.0), preloads, st.floats(0.0, 0.4))
def test_balance_through_slack(load: float, preload: np.ndarray, friction: float) -> None:
    """Any load can be held by two taut cables; a slack one is beyond its limit, a taut one on its law."""
    d = tight(preload_N=preload, friction_coefficient=friction)
    at = solve_equilibrium(d, load)
    assert float(balance(d, at)) == pytest.approx(load, abs=1e-8)
    limit = slack_stretch_m(d)
    assert (at.stretch_m[at.slack] <= limit[at.slack] + 1e-15).all(), (at.stretch_m, limit)
    taut = ~at.slack
    miss = np.abs(stretch_first_loading(d, np.maximum(at.tension_N, 1e-100))[0] - at.stretch_m)[taut].max()
    assert miss < 1e-12, f"a taut cable misses its law by {miss:.3g} m at tensions {at.tension_N}"


def test_the_bracketed_route_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """What Newton does not settle is finished by another method, for slack cables and reversals too."""
    load = np.array([0.3, -2.0, 25.0, -40.0])
    quick = solve_equilibrium(tight(), load)
    d = paper_drive()
    turned = solve_equilibrium(d, 1.5).tension_N
    quick_back = solve_equilibrium(d, -0.7, turned_at_N=turned)
    monkeypatch.setattr(equilibrium, "NEWTON_STEPS", 1)
    slow, slow_back = solve_equilibrium(tight(), load), solve_equilibrium(d, -0.7, turned_at_N=turned)
    assert slow.drum_angle_rad == pytest.approx(quick.drum_angle_rad, rel=1e-9)
    assert slow.slack.tolist() == quick.slack.tolist()
    assert float(slow_back.drum_angle_rad) == pytest.approx(float(quick_back.drum_angle_rad), rel=1e-9)


# Preload setting, checked independently: beams by finite differences, friction by integration, springs by hand.


EA_N = 54e9 * 0.3117e-6
LENGTH_M = np.array([0.1815, 0.2219, 0.1943, 0.2380])
LEVER_M = np.array([-1.0, 1.0, 1.0, -1.0]) * np.array([54.0, 57.6, 61.2, 64.8]) * 1e-3
STIFFNESS = EA_N / LENGTH_M


def _beam_Hz(tension: float, mass: float, length: float, bending: float, n: int = 200) -> float:
    """Lowest frequency of a clamped beam under tension by finite differences."""
    h = length / n
    size = n - 1
    second = (np.diag(-2.0 * np.ones(size)) + np.diag(np.ones(size - 1), 1) + np.diag(np.ones(size - 1), -1)) / h**2
    fourth = second @ second
    # A clamped end mirrors the first node behind the wall: w(-h) = w(h).
    fourth[0, 0] += 2.0 / h**4
    fourth[-1, -1] += 2.0 / h**4
    values = np.linalg.eigvalsh((bending * fourth - tension * second) / mass)
    return float(sqrt(values[0]) / (2.0 * pi))


@pytest.mark.parametrize("bending", [1e-5, 3e-5, 6.9e-4, 1.2e-3, 0.1])
def test_clamped_span_sounds_as_the_discretised_beam(bending: float) -> None:
    exact, numeric = plucked_Hz(70.0, 2.5e-3, 0.03, bending), _beam_Hz(70.0, 2.5e-3, 0.03, bending)
    assert abs(exact / numeric - 1.0) < 0.01, (exact, numeric)


def test_limits_of_the_formula() -> None:
    string = plucked_Hz(70.0, 2.5e-3, 0.03)
    assert abs(string - 2788.9) < 0.1, string
    stiff = plucked_Hz(1e-9, 2.5e-3, 0.03, 1.0)
    bare = 4.7300407**2 / (2.0 * pi) * sqrt(1.0 / (2.5e-3 * 0.03**4))
    assert abs(stiff / bare - 1.0) < 1e-6, (stiff, bare)
    assert abs(plucked_Hz(70.0, 2.5e-3, 0.03, 1e-10) / string - 1.0) < 1e-4


def test_wires_free_raise_the_pitch_by_five_percent_bonded_by_forty() -> None:
    loose = 49 * 190e9 * pi / 64 * (0.09e-3) ** 4
    string = plucked_Hz(70.0, 2.5e-3, 0.03)
    clamped = plucked_Hz(70.0, 2.5e-3, 0.03, loose) / string - 1.0
    low, high = (f / string - 1.0 for f in limits_of_pitch_Hz(70.0, 2.5e-3, 0.03, loose, 1.2e-3))
    assert 0.04 < clamped < 0.055, clamped
    assert 0.0 < low < 0.01, low
    assert 0.35 < high < 0.5, high


@given(tension=st.floats(1.0, 500.0), length=st.floats(0.01, 0.3), bending=st.sampled_from([0.0, 3e-5, 1e-3]))
def test_tension_comes_back_from_the_pitch(tension: float, length: float, bending: float) -> None:
    frequency = plucked_Hz(tension, 2.5e-3, length, bending)
    again = tension_from_pitch_N(frequency, 2.5e-3, length, bending)
    assert abs(again - tension) < 1e-4 * tension + 1e-3, (tension, again)


def test_reached_length_is_the_integral_of_the_tension_gained() -> None:
    pieces, mu = ((0.004, 0.0), (0.054 * 0.8, 0.8), (0.03, 0.0), (0.006 * 11.0, 11.0)), 0.15
    numeric, share = 0.0, 1.0
    for length, angle in pieces:
        part = np.linspace(0.0, 1.0, 20001)
        gained = share * np.exp(-mu * angle * part)
        numeric += length * float(np.sum((gained[1:] + gained[:-1]) / 2 * np.diff(part)))
        share *= exp(-mu * angle)
    found = reached_length_m(pieces, mu)
    assert abs(found / numeric - 1.0) < 1e-8, (found, numeric)
    assert abs(reached_length_m(pieces, 0.0) - sum(length for length, _ in pieces)) < 1e-12


def test_elastic_stretch_of_the_reference_cables() -> None:
    """Lengths of the reference's cables give the stretches found apart from the project: 0.755 to 0.990 mm at 70 N."""
    found = [take_up(length, 70.0, EA_N, 0.002, 0.3e-3) for length in LENGTH_M]
    assert np.allclose([t.elastic_m * 1e3 for t in found], [0.755, 0.923, 0.808, 0.990], atol=0.002), found
    assert found[0].total_m == pytest.approx(found[0].elastic_m + 0.002 * LENGTH_M[0] + 0.6e-3)
    assert found[0].total_m - found[0].nominal_m == pytest.approx(0.3e-3)
    assert untensioned_length_m(LENGTH_M[0], 70.0, EA_N) == pytest.approx(LENGTH_M[0] - found[0].elastic_m, abs=4e-6)
    assert bedding_loss_N(0.002, EA_N) == pytest.approx(33.7, abs=0.1)
    with pytest.raises(ValueError, match="below zero"):
        take_up(-1.0, 70.0, EA_N, 0.0, 0.0)


def test_influence_is_the_slope_of_the_balance() -> None:
    drawn = 70.0 / STIFFNESS
    start = balanced_tension_N(STIFFNESS, LEVER_M, drawn)
    assert np.allclose(start, 70.0, atol=1e-6), start
    by_formula = influence(STIFFNESS, LEVER_M)
    for j in range(4):
        step = drawn.copy()
        step[j] += 1e-5
        slope = (balanced_tension_N(STIFFNESS, LEVER_M, step) - start) / 1e-5
        assert np.allclose(slope, by_formula[:, j], rtol=1e-4, atol=1.0), (j, slope, by_formula[:, j])
    assert np.allclose(LEVER_M @ by_formula, 0.0, atol=1e-6)
    assert np.allclose(np.diag(taken_from_others(STIFFNESS, LEVER_M)), -1.0)


@settings(max_examples=30, deadline=None)
@given(order=st.permutations(range(4)), lengths=st.lists(st.floats(0.1, 0.4), min_size=4, max_size=4))
def test_any_order_reaches_the_goal_without_a_torque_on_the_drum(order: list[int], lengths: list[float]) -> None:
    stiffness = EA_N / np.array(lengths)
    done = sequence(stiffness, LEVER_M, [70.0] * 4, tuple(order))
    last = done[-1].tension_N
    assert np.all(np.abs(last - 70.0) <= 0.02 * 70.0), last
    assert abs(float(LEVER_M @ last)) < 1e-6
    assert len(done) <= 40, len(done)


def test_goals_that_cannot_balance_are_refused() -> None:
    with pytest.raises(ValueError, match="do not balance"):
        sequence(STIFFNESS, LEVER_M, [70.0, 140.0, 140.0, 70.0], (0, 1, 2, 3))


def rope(name: str = "uhmwpe-2", **changed: float) -> CableSpec:
    return replace(CableSpec(name=name, **package_entries("ropes")[name]), **changed)  # type: ignore[arg-type]


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0005, 0.01), st.floats(50.0, 1000.0), st.floats(1.0, 3000.0))
def test_log_time_alone_is_a_power_of_time(per_decade: float, preload: float, days: float) -> None:
    """dT/T = -(EA c / F ln 10) dt / (t + t0): T = T0 (1 + t/t0)^-k."""
    own = rope(creep_per_decade=per_decade, creep_per_year=0.0)
    exponent = own.axial_stiffness_N * per_decade / own.breaking_load_N / log(10.0)
    left = relaxation(own, preload, 20.0).at_N(days * DAY_S)
    assert left == pytest.approx(preload * (1.0 + days * DAY_S / START_S) ** -exponent, rel=2e-3)


@settings(max_examples=20, deadline=None)
@given(st.floats(1.5, 6.0), st.floats(100.0, 1000.0), st.floats(0.1, 20.0))
def test_steady_creep_alone(exponent: float, preload: float, years: float) -> None:
    """dT = -EA r (T / 0.3 F)^n dt: T^(1-n) grows linearly."""
    own = rope(creep_per_decade=0.0, creep_load_exponent=exponent)
    at_first = own.axial_stiffness_N * steady_rate_per_s(own, preload, 20.0) * years * YEAR_S / preload
    closed = preload * (1.0 + (exponent - 1.0) * at_first) ** (-1.0 / (exponent - 1.0))
    assert relaxation(own, preload, 20.0).at_N(years * YEAR_S) == pytest.approx(closed, rel=3e-3)


def test_time_until_undoes_tension_after() -> None:
    over_time = relaxation(rope(), 400.0, 20.0)
    for days in (1.0, 40.0, 900.0):
        assert over_time.time_until_s(over_time.at_N(days * DAY_S)) == pytest.approx(days * DAY_S, rel=1e-6)
    assert over_time.time_until_s(500.0) == 0.0 and over_time.time_until_s(1.0) == float("inf")


def test_makers_figure_for_dm20() -> None:
    """0.5 percent in 25 years at 16 degrees C and a fifth of the breaking load."""
    own = rope()
    strain = steady_rate_per_s(own, 0.2 * own.breaking_load_N, 16.0) * 25.0 * YEAR_S
    assert strain == pytest.approx(0.005, rel=0.1), f"{strain:.2%} in 25 years"


def test_warm_and_loaded_ropes_lose_more_and_wire_nothing() -> None:
    cool, warm = preload_left(rope(), 500.0)
    assert all(a > b for a, b in zip(cool.share, warm.share, strict=True)), (cool, warm)
    assert preload_left(rope(), 900.0)[0].share[-1] < cool.share[-1]
    assert not creeps(rope("FF-081")) and preload_left(rope("FF-081"), 70.0) == ()


def test_without_a_preload_nothing_creeps() -> None:
    with pytest.raises(ValueError, match="give it > 0"):
        relaxation(rope(), 0.0, 20.0)
