"""All cables at once: balance, symmetry laws, limits, slack, and an independent solution by bisection."""

from dataclasses import replace
from math import exp, log, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.bought import CableSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model import equilibrium, tensioning
from mbcdm_cad.model.analysis import pair_mismatch
from mbcdm_cad.model.creep import DAY_S, START_S, YEAR_S, creeps, preload_left, relaxation, steady_rate_per_s
from mbcdm_cad.model.equations import eq1_residuals, shaft_angles, transmission_error
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, tension_of_stretch
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.wrap import excess_minus_log, slack_stretch_m, stretch_after_reversal, stretch_first_loading
from mbcdm_cad.routes import Floats
from tests.support.clip_grid import simulate_on_grid
from tests.unit.model.paper_case import paper_drive, some_cables, turned_round

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
    exact, numeric = tensioning.plucked_Hz(70.0, 2.5e-3, 0.03, bending), _beam_Hz(70.0, 2.5e-3, 0.03, bending)
    assert abs(exact / numeric - 1.0) < 0.01, (exact, numeric)


def test_limits_of_the_formula() -> None:
    string = tensioning.plucked_Hz(70.0, 2.5e-3, 0.03)
    assert abs(string - 2788.9) < 0.1, string
    stiff = tensioning.plucked_Hz(1e-9, 2.5e-3, 0.03, 1.0)
    bare = 4.7300407**2 / (2.0 * pi) * sqrt(1.0 / (2.5e-3 * 0.03**4))
    assert abs(stiff / bare - 1.0) < 1e-6, (stiff, bare)
    assert abs(tensioning.plucked_Hz(70.0, 2.5e-3, 0.03, 1e-10) / string - 1.0) < 1e-4


def test_wires_free_raise_the_pitch_by_five_percent_bonded_by_forty() -> None:
    loose = 49 * 190e9 * pi / 64 * (0.09e-3) ** 4
    string = tensioning.plucked_Hz(70.0, 2.5e-3, 0.03)
    clamped = tensioning.plucked_Hz(70.0, 2.5e-3, 0.03, loose) / string - 1.0
    low, high = (f / string - 1.0 for f in tensioning.limits_of_pitch_Hz(70.0, 2.5e-3, 0.03, loose, 1.2e-3))
    assert 0.04 < clamped < 0.055, clamped
    assert 0.0 < low < 0.01, low
    assert 0.35 < high < 0.5, high


@given(tension=st.floats(1.0, 500.0), length=st.floats(0.01, 0.3), bending=st.sampled_from([0.0, 3e-5, 1e-3]))
def test_tension_comes_back_from_the_pitch(tension: float, length: float, bending: float) -> None:
    frequency = tensioning.plucked_Hz(tension, 2.5e-3, length, bending)
    again = tensioning.tension_from_pitch_N(frequency, 2.5e-3, length, bending)
    assert abs(again - tension) < 1e-4 * tension + 1e-3, (tension, again)


def test_reached_length_is_the_integral_of_the_tension_gained() -> None:
    pieces, mu = ((0.004, 0.0), (0.054 * 0.8, 0.8), (0.03, 0.0), (0.006 * 11.0, 11.0)), 0.15
    numeric, share = 0.0, 1.0
    for length, angle in pieces:
        part = np.linspace(0.0, 1.0, 20001)
        gained = share * np.exp(-mu * angle * part)
        numeric += length * float(np.sum((gained[1:] + gained[:-1]) / 2 * np.diff(part)))
        share *= exp(-mu * angle)
    found = tensioning.reached_length_m(pieces, mu)
    assert abs(found / numeric - 1.0) < 1e-8, (found, numeric)
    assert abs(tensioning.reached_length_m(pieces, 0.0) - sum(length for length, _ in pieces)) < 1e-12


def test_elastic_stretch_of_the_reference_cables() -> None:
    """Lengths of the reference's cables give the stretches found apart from the project: 0.755 to 0.990 mm at 70 N."""
    found = [tensioning.take_up(length, 70.0, EA_N, 0.002, 0.3e-3) for length in LENGTH_M]
    assert np.allclose([t.elastic_m * 1e3 for t in found], [0.755, 0.923, 0.808, 0.990], atol=0.002), found
    assert found[0].total_m == pytest.approx(found[0].elastic_m + 0.002 * LENGTH_M[0] + 0.6e-3)
    assert found[0].total_m - found[0].nominal_m == pytest.approx(0.3e-3)
    assert tensioning.untensioned_length_m(LENGTH_M[0], 70.0, EA_N) == pytest.approx(
        LENGTH_M[0] - found[0].elastic_m, abs=4e-6
    )
    with pytest.raises(ValueError, match="below zero"):
        tensioning.take_up(-1.0, 70.0, EA_N, 0.0, 0.0)


def test_influence_is_the_slope_of_the_balance() -> None:
    drawn = 70.0 / STIFFNESS
    start = tensioning.balanced_tension_N(STIFFNESS, LEVER_M, drawn)
    assert np.allclose(start, 70.0, atol=1e-6), start
    by_formula = tensioning.influence(STIFFNESS, LEVER_M)
    for j in range(4):
        step = drawn.copy()
        step[j] += 1e-5
        slope = (tensioning.balanced_tension_N(STIFFNESS, LEVER_M, step) - start) / 1e-5
        assert np.allclose(slope, by_formula[:, j], rtol=1e-4, atol=1.0), (j, slope, by_formula[:, j])
    assert np.allclose(LEVER_M @ by_formula, 0.0, atol=1e-6)
    assert np.allclose(np.diag(tensioning.taken_from_others(STIFFNESS, LEVER_M)), -1.0)


@settings(max_examples=30, deadline=None)
@given(order=st.permutations(range(4)), lengths=st.lists(st.floats(0.1, 0.4), min_size=4, max_size=4))
def test_any_order_reaches_the_goal_without_a_torque_on_the_drum(order: list[int], lengths: list[float]) -> None:
    stiffness = EA_N / np.array(lengths)
    done = tensioning.sequence(stiffness, LEVER_M, [70.0] * 4, tuple(order))
    last = done[-1].tension_N
    assert np.all(np.abs(last - 70.0) <= 0.02 * 70.0), last
    assert abs(float(LEVER_M @ last)) < 1e-6
    assert len(done) <= 40, len(done)


def test_goals_that_cannot_balance_are_refused() -> None:
    with pytest.raises(ValueError, match="do not balance"):
        tensioning.sequence(STIFFNESS, LEVER_M, [70.0, 140.0, 140.0, 70.0], (0, 1, 2, 3))


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


def brake(amplitude_rad: float, per_cycle: int = 400, cycles: int = 3) -> tuple[Any, Any, Any]:
    """Drum angle wanted, input angles, and a load of 0.91 N m against the motion."""
    phase = 2 * np.pi * np.arange(1, cycles * per_cycle + 1) / per_cycle
    drum = amplitude_rad * np.sin(phase)
    speed = np.cos(phase)
    return drum, np.tile(9 * drum, (2, 1)), 0.91 * np.where(speed >= 0, 1.0, -1.0)


@pytest.mark.parametrize(("amplitude", "extreme"), [(0.05, 167.5e-6), (0.6, 398.2e-6)])
def test_extremes_of_the_transmission_error(amplitude: float, extreme: float) -> None:
    """12 to 15 % above the 145.9 urad without winding at +-50 mrad, nearly three times it at +-0.6 rad."""
    drum, angle, load = brake(amplitude)
    routes = (
        simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=4e-3),
        simulate(paper_drive(), angle, load, winding=True),
    )
    for answer in routes:
        error = (answer.drum_angle_rad - drum)[400:]
        assert error.max() == pytest.approx(extreme, rel=3e-3), f"+{error.max() * 1e6:.2f} urad"
        assert error.min() == pytest.approx(-extreme, rel=3e-3), f"{error.min() * 1e6:.2f} urad"
    still = simulate(paper_drive(), angle, load).drum_angle_rad - drum
    assert np.abs(still).max() == pytest.approx(145.96e-6, rel=1e-3)


def test_short_travel_has_no_history() -> None:
    drum, angle, load = brake(1e-5)
    error = simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=1e-3).drum_angle_rad - drum
    still = simulate(paper_drive(), angle, load).drum_angle_rad - drum
    worst = np.abs(error - still).max()
    assert worst < 3e-8, f"differs by {worst:.3g} rad over a travel of 10 urad"


def test_halving_the_cell_changes_little() -> None:
    _, angle, load = brake(0.05)
    fine, coarse = (
        simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=cell).drum_angle_rad
        for cell in (2e-3, 8e-3)
    )
    worst = np.abs(fine - coarse)[400:].max()
    assert worst < 1e-7, f"drum angle moves by {worst:.3g} rad"


class PlainWrap:
    """Cable on a pulley as a list of (length, tension) from the anchor outwards; slow, and with no shared code."""

    def __init__(self, radius: float, wrap: float, preload: float, cell: float) -> None:
        self.radius, self.cell = radius, cell
        self.length = np.full(round(wrap / cell), cell)
        self.tension = np.full(self.length.size, preload)

    def after(self, wind: float, end: float) -> tuple[Any, Any]:
        """Lengths and tensions if ``wind`` rad are wound on (off if negative) and the end tension is ``end``."""
        length, tension = self.length.copy(), self.tension.copy()
        if wind > 0:
            length, tension = np.append(length, wind), np.append(tension, end)
        while wind < 0:
            cut = min(-wind, length[-1])
            length[-1] -= cut
            wind += cut
            if length[-1] <= 1e-15:
                length, tension = length[:-1], tension[:-1]
        distance = np.cumsum(length[::-1])[::-1] - 0.5 * length
        return length, np.clip(tension, end * np.exp(-0.15 * distance), end * np.exp(0.15 * distance))


@pytest.mark.slow
def test_against_a_plain_implementation() -> None:
    """One input pair, few samples, everything by nested bisection on explicit lists."""
    d = paper_drive()
    # Four cables alike in pairs by symmetry of a one-cable-each-way drive: use mean radii so one pair tells all.
    alike = d.with_(
        input_radius_m=np.full(4, 6.6e-3), guide_radius_m=np.full(4, 9.9e-3), drum_radius_m=np.full(4, 59.4e-3)
    )
    drum, angle, load = brake(0.01, per_cycle=20, cycles=1)
    fast = simulate_on_grid(alike, angle, load, winding=True, cell_rad=8e-3).drum_angle_rad - drum
    # The knots take each step straight, so they get the same sub-steps under the same load.
    ends = np.concatenate([[0.0], angle[0]])
    parts_of = np.maximum(1, np.ceil(np.abs(np.diff(ends)) / 16e-3).astype(int))
    fine = np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b, n in zip(ends, ends[1:], parts_of, strict=False)])
    knots = simulate(alike, np.tile(fine, (2, 1)), np.repeat(load, parts_of), winding=True).drum_angle_rad
    closed = knots[np.cumsum(parts_of) - 1] - drum
    span, stiffness = float(alike.free_span_m[0]), float(alike.axial_stiffness_N)
    wraps = {s: (PlainWrap(6.6e-3, 1.2, 70.0, 8e-3), PlainWrap(59.4e-3, 1.2, 70.0, 8e-3)) for s in (1, -1)}
    theta, inner, plain = 0.0, 0.0, []
    for k in range(load.size):
        start, parts = theta, int(parts_of[k])
        for target in np.linspace(inner, angle[0, k], parts + 1)[1:]:

            def tension(
                sigma: int, turned: float, at: float = target, was: float = inner, base: float = start
            ) -> float:
                wanted = sigma * (6.6e-3 * at - 59.4e-3 * turned)
                low, high = 20.0, 200.0
                for _ in range(44):
                    middle = 0.5 * (low + high)
                    total = (middle - 70.0) * span
                    for wrap, wind in zip(wraps[sigma], (sigma * (at - was), -sigma * (turned - base)), strict=True):
                        length, values = wrap.after(wind, middle)
                        total += wrap.radius * float(length @ (values - 70.0))
                    low, high = (middle, high) if total / stiffness < wanted else (low, middle)
                return 0.5 * (low + high)

            low, high = target / 9 - 4e-4, target / 9 + 4e-4
            for _ in range(36):
                theta = 0.5 * (low + high)
                torque = 2 * 59.4e-3 * (tension(1, theta) - tension(-1, theta))
                low, high = (theta, high) if torque > load[k] else (low, theta)
            for sigma in (1, -1):
                end = tension(sigma, theta)
                for wrap, wind in zip(wraps[sigma], (sigma * (target - inner), -sigma * (theta - start)), strict=True):
                    wrap.length, wrap.tension = wrap.after(wind, end)
            inner, start = float(target), theta
        plain.append(theta - drum[k])
    for name, answer in (("the grid", fast), ("the knots", closed)):
        worst = np.abs(np.array(plain) - answer).max()
        assert worst < 3e-7, f"differs from {name} by {worst:.3g} rad, of {np.abs(fast).max():.3g}"


def test_wraps_too_short_for_the_travel_are_refused() -> None:
    _, angle, load = brake(2.0)
    with pytest.raises(ModelError, match="winds off up to 18 rad of an input"):
        simulate_on_grid(paper_drive(), angle, load, winding=True)


# Angles of the rigid chain and Eq. (1), (2).


def test_one_radian_of_the_drum() -> None:
    angles = shaft_angles(paper_drive(), "drum", 1.0, gear_ratio=76.0)
    assert float(angles["guide"]) == pytest.approx(-6.0)
    assert float(angles["input"]) == pytest.approx(9.0)
    assert float(angles["motor"]) == pytest.approx(684.0)


SHAFTS = ("drum", "guide", "input", "motor")


@given(st.sampled_from(SHAFTS), st.floats(-50, 50), st.integers(0, 3))
def test_every_angle_from_any(shaft: str, angle: float, cable: int) -> None:
    d = paper_drive()
    there = shaft_angles(d, shaft, angle, cable, 76.0)
    assert float(there[shaft]) == pytest.approx(angle, rel=1e-12, abs=1e-15)
    for other in SHAFTS:
        back = shaft_angles(d, other, there[other], cable, 76.0)
        assert float(back["drum"]) == pytest.approx(float(there["drum"]), rel=1e-12, abs=1e-15)


def test_unknown_shaft_is_refused() -> None:
    with pytest.raises(ModelError, match="use one of drum, guide, input, motor"):
        shaft_angles(paper_drive(), "wheel", 1.0)


def test_transmission_error_of_a_perfect_drive_is_zero() -> None:
    assert transmission_error(0.1, 0.9, 9.0) == pytest.approx(0.0, abs=1e-17)
    assert transmission_error(0.1002, 0.9, 9.0) == pytest.approx(2e-4)


@pytest.mark.parametrize("field", ["input_radius_m", "guide_radius_m", "drum_radius_m"])
@pytest.mark.parametrize("cable", [0, 1, 2, 3])
def test_eq1_residual_shows_a_wrong_radius(field: str, cable: int) -> None:
    d = paper_drive()
    radii = d.value(field).copy()
    radii[cable] *= 1.001
    residuals = eq1_residuals(d.with_(**{field: radii}))
    assert 4e-4 < residuals.worst < 1.1e-3, f"{field}[{cable}] + 0.1 %: worst residual {residuals.worst:.3g}"


def test_mismatch_in_newtons() -> None:
    """0.19 mm between two cables of one input is shared with the rest of the drive, and costs tens of newtons."""
    d = paper_drive()
    half = 0.405e-3
    wrong = d.with_(input_radius_m=d.input_radius_m + half, drum_radius_m=d.drum_radius_m + half)
    millimetres, newtons = pair_mismatch(wrong, np.radians(50.0))
    assert millimetres[0] == pytest.approx(0.176, abs=0.01)
    assert newtons > 20.0, f"largest change of tension {newtons:.3g} N"
    right_mm, right_N = pair_mismatch(d, np.radians(50.0))
    assert max(right_mm) < 1e-12 and right_N < 1e-9, f"{right_mm} mm, {right_N} N where Eq. (1) holds"


# The stretch law of one cable compared with numerical integration of the clipped profile, and its limits.


FINITE = {"input_wrap_rad": np.full(4, 9.0), "drum_wrap_rad": np.full(4, 0.43)}
GUIDE = {"passed_wrap_rad": [np.radians([25.7, 207.5, 29.4, 211.3])]}


def integrated(d: Any, end: np.ndarray, old: Any, cells: int = 40001) -> np.ndarray:
    """Stretch by Simpson's rule over both wraps of the profile ``old`` (a function of s) clipped to the end tension."""
    total = (end - d.preload_N) * d.free_span_m
    # Two zones creep in from the ends of the guide's wrap, up to its middle.
    wraps = ((d.input_radius_m, d.input_wrap_rad), (d.drum_radius_m, d.drum_wrap_rad))
    for radius, wrap in (*wraps, (2 * d.passed_radii_m[0], d.passed_wrap_rad[0] / 2)):
        for j in range(4):
            s = np.linspace(0.0, min(wrap[j], 6.0), cells)
            bound = np.exp(d.friction_coefficient * s)
            profile = np.clip(old(s, j), end[j] / bound, end[j] * bound) - d.preload_N[j]
            weights = np.ones(cells)
            weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
            total[j] += radius[j] * (weights @ profile) * (s[1] - s[0]) / 3.0
    return np.asarray(total / d.axial_stiffness_N)


@pytest.mark.parametrize("limits", [{}, FINITE, GUIDE], ids=["endless", "finite", "guide"])
@pytest.mark.parametrize("end", [40.0, 69.0, 70.0, 70.001, 95.0])
def test_first_loading_against_integration(limits: dict[str, Any], end: float) -> None:
    d = paper_drive(**limits)
    tension = np.array([end, end + 0.5, end * 1.01, end])
    stretch, _ = stretch_first_loading(d, tension)
    reference = integrated(d, tension, lambda s, j: np.full_like(s, d.preload_N[j]))
    worst = np.abs(stretch - reference).max()
    assert worst < 1e-12, f"stretch differs from the integrated profile by {worst:.3g} m"


@pytest.mark.parametrize("turned", [85.0, 58.0])
@pytest.mark.parametrize("end", [50.0, 60.0, 70.0, 75.0, 84.0, 95.0])
def test_reversal_against_integration(turned: float, end: float) -> None:
    d = paper_drive()
    at, tension = np.full(4, turned), np.full(4, end)

    def old(s: np.ndarray, j: int) -> np.ndarray:
        bound = np.exp(0.15 * s)
        return np.asarray(np.clip(np.full_like(s, 70.0), turned / bound, turned * bound))

    stretch, _ = stretch_after_reversal(d, tension, at)
    worst = np.abs(stretch - integrated(d, tension, old)).max()
    assert worst < 1e-12, f"{turned} N -> {end} N: differs by {worst:.3g} m"


@given(st.floats(20.0, 200.0), st.sampled_from([{}, FINITE]))
def test_slope_is_the_derivative(tension: float, limits: dict[str, Any]) -> None:
    d = paper_drive(**limits)
    step = 1e-4
    ends = [stretch_first_loading(d, np.full(4, tension + sign * step))[0] for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    slope = stretch_first_loading(d, np.full(4, tension))[1]
    worst = np.abs(difference / slope - 1).max()
    # At the preload itself the second derivative jumps, and central differences see half of that jump.
    assert worst < 2e-5, f"at {tension} N the slope is off by {worst:.3g}"


@given(st.floats(-5e-4, 2e-3), st.sampled_from([{}, FINITE]))
def test_inverse(stretch: float, limits: dict[str, Any]) -> None:
    d = paper_drive(**limits)
    wanted = np.full(4, stretch)
    tension = tension_of_stretch(d, wanted)
    back = stretch_first_loading(d, np.maximum(tension, 1e-150))[0]
    taut = tension > 0.0
    worst = np.abs(back - wanted)[taut].max(initial=0.0)
    assert worst < 1e-15, f"inverse misses by {worst:.3g} m"
    assert (wanted[~taut] <= slack_stretch_m(d)[~taut]).all()


def test_no_friction_spreads_the_tension_over_the_whole_cable() -> None:
    d = paper_drive(**FINITE, friction_coefficient=0.0)
    tension = np.array([60.0, 80.0, 70.0, 71.0])
    length = d.free_span_m + d.input_radius_m * 9.0 + d.drum_radius_m * 0.43
    stretch, slope = stretch_first_loading(d, tension)
    assert stretch == pytest.approx((tension - 70.0) * length / d.axial_stiffness_N, rel=1e-12)
    assert slope == pytest.approx(length / d.axial_stiffness_N, rel=1e-12)
    tiny = stretch_first_loading(paper_drive(**FINITE, friction_coefficient=1e-7), tension)[0]
    assert tiny == pytest.approx(stretch, rel=1e-4)


def test_no_friction_without_wraps_is_refused() -> None:
    with pytest.raises(ModelError, match="friction_coefficient 0 with unlimited wraps"):
        stretch_first_loading(paper_drive(friction_coefficient=0.0), np.full(4, 80.0))


@given(st.floats(1e-9, 1e3))
def test_excess_minus_log_keeps_its_digits(ratio: float) -> None:
    exact = sp.Rational(ratio) - 1 - sp.log(sp.Rational(ratio))
    expected = float(exact.evalf(30))
    got = float(excess_minus_log(ratio))
    assert got == pytest.approx(expected, rel=2e-9, abs=1e-300), f"u = {ratio}: {got} against {expected}"


def test_no_span_is_refused() -> None:
    with pytest.raises(ModelError, match="raise centre_distance_mm"):
        _ = paper_drive(centre_distance_m=17.9e-3).free_span_m


def test_slip_on_the_guide_adds_about_8_percent() -> None:
    """With wraps long enough for both zones; the true wraps of 25.7 and 29.4 degrees are short and add less."""
    d = paper_drive()
    plain = float(drum_backlash(d, 0.91).first_loading_rad)
    long = float(drum_backlash(d.with_(passed_wrap_rad=[np.full(4, np.inf)]), 0.91).first_loading_rad)
    true = abs(float(solve_equilibrium(d.with_passed_slip, 0.91).drum_angle_rad))
    assert long / plain - 1 == pytest.approx(0.08, abs=0.01), f"{long / plain - 1:.2%} more"
    assert plain < true < long, f"{plain:.4g}, {true:.4g}, {long:.4g} rad"
    assert np.degrees(d.with_passed_slip.passed_wrap_rad[0]) == pytest.approx([25.7, 207.5, 29.4, 211.3], abs=0.06)


def test_closed_forms_refuse_finite_wraps() -> None:
    with pytest.raises(ModelError, match="a wrap is finite"):
        _ = paper_drive(**FINITE).slip_reach_m


@given(st.floats(0.05, 3.5), st.sampled_from([FINITE, GUIDE, {**FINITE, **GUIDE}]))
def test_a_reversal_with_wraps_that_end_is_that_of_the_time_series(load_Nm: float, limits: dict[str, object]) -> None:
    """Closed form of the profiles after a reversal, against the profiles that the series carries along."""
    d = paper_drive(**limits)
    found = drum_backlash(d, load_Nm)
    series = simulate(d, np.zeros((2, 2)), np.array([load_Nm, -load_Nm])).drum_angle_rad
    assert float(found.reversal_swing_rad) == pytest.approx(abs(series[1] - series[0]), rel=1e-7)


def test_a_wrap_longer_than_its_zones_is_an_endless_one() -> None:
    long = paper_drive(drum_wrap_rad=np.full(4, 300.0))
    for load in (0.4, 3.0):
        endless, found = drum_backlash(paper_drive(), load), drum_backlash(long, load)
        assert float(found.reversal_swing_rad) == pytest.approx(float(endless.reversal_swing_rad), rel=1e-10)


# A wrap without an anchor, compared with the same wrap anchored and with its mirror image.


TIME = np.linspace(0.0, 3.0, 241)
TURNED = 5.9 * np.sin(2 * pi * TIME)[None]
LOAD = 0.9 * np.sin(2 * pi * 0.6 * TIME) + 0.3


@pytest.fixture(scope="module")
def drive() -> DriveSI:
    """The reference of siso_spur."""
    return layout_of(load_design(Path(__file__).parents[3] / "params" / "siso_spur.yaml").drive).si


def drum_rad(drive: DriveSI, turned: Floats, load: Floats, through_rad: float | None) -> Floats:
    return simulate_profiles(drive, turned, load, None, True, through_rad).drum_angle_rad


def test_a_wrap_longer_than_travel_and_slip_acts_as_if_anchored(drive: DriveSI) -> None:
    """11.8 rad of travel and at most 3.3 of slip are less than the 18.1 of the design."""
    assert drive.through_wrap_rad is not None
    found = drum_rad(drive, TURNED, LOAD, float(drive.through_wrap_rad[0]))
    assert np.abs(found - drum_rad(drive, TURNED, LOAD, None)).max() < 1e-9


def test_a_short_wrap_lets_the_drum_creep_the_way_the_load_pushes(drive: DriveSI) -> None:
    steady = np.full_like(LOAD, 0.9)
    at_rest = [60 * n + 20 for n in range(1, 4)]
    for way in (1.0, -1.0):
        found = drum_rad(drive, TURNED, way * steady, 2 * pi) - TURNED[0] / 9.9
        crept = -way * np.diff(found[[n for n in at_rest if n < found.size]])
        assert (crept > 1e-4).all(), crept


def test_motion_and_load_turned_round_turn_the_creep_round(drive: DriveSI) -> None:
    one, other = drum_rad(drive, TURNED, LOAD, 3 * pi), drum_rad(drive, -TURNED, -LOAD, 3 * pi)
    assert np.ptp(one - drum_rad(drive, TURNED, LOAD, None)) > 1e-4
    assert np.abs(one + other).max() < 1e-9
