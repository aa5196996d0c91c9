"""All cables at once: balance, symmetry laws, limits, slack, and an independent solution by bisection."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_case import paper_drive, some_cables, turned_round

from mbcdm_cad.model import equilibrium
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, tension_of_stretch
from mbcdm_cad.model.si import DriveSI, ModelError
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
