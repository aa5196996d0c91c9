"""Which of several plans says most: sizes are compared effect by effect, what a run cannot show counts against it."""

from math import inf, sqrt
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.design.blocks import TORQUE_MAX_NM
from mbcdm_cad.loop.result import Noise
from mbcdm_cad.planning.best_run import BLIND, alone_from, candidates, rated
from mbcdm_cad.planning.plan import Foreseen, Rival, RunPlan
from mbcdm_cad.rig.bench import BenchLimits, MotorCurrent

NOISE = Noise(0.0, 0.0, 0.0, 0.0, 0.0, "test")


def plan(**sizes: float | None) -> RunPlan:
    return RunPlan(NOISE, tuple(Foreseen(label, "turn_rad", size, ()) for label, size in sizes.items()))


def test_an_effect_is_alone_from_its_worst_rival_on() -> None:
    assert alone_from(Foreseen("a", "turn_rad", 1.0, ())) == 1.0
    assert alone_from(Foreseen("a", "turn_rad", 1.0, (Rival("b", 3.0), Rival("c", 2.0)))) == 3.0
    assert alone_from(Foreseen("a", "turn_rad", 1.0, (Rival("b", None),))) == inf
    assert alone_from(Foreseen("a", "turn_rad", None, ())) == inf


def test_the_run_that_shows_more_from_smaller_sizes_is_rated_better() -> None:
    fine, coarse, blind = rated([plan(a=1.0, b=1.0), plan(a=4.0, b=1.0), plan(a=1.0, b=None)])
    assert (fine.mean_multiple, fine.blind) == (1.0, 0)
    assert coarse.mean_multiple == pytest.approx(2.0) and coarse.blind == 0
    assert blind.mean_multiple == pytest.approx(sqrt(BLIND)) and blind.blind == 1


def test_what_no_run_shows_and_what_a_run_lacks() -> None:
    with_load, without = rated([plan(a=1.0, b=2.0, c=None), plan(a=1.0, c=None)])
    assert with_load.mean_multiple == 1.0 and with_load.blind == 0
    assert without.mean_multiple == pytest.approx(sqrt(BLIND)) and without.blind == 1


@given(st.lists(st.lists(st.floats(1e-9, 1e3), min_size=3, max_size=3), min_size=1, max_size=5))
def test_rating_does_not_hang_on_units_and_is_never_under_one(sizes: list[list[float]]) -> None:
    plans = [plan(a=a, b=b, c=c) for a, b, c in sizes]
    scaled = [plan(a=1e3 * a, b=b, c=c) for a, b, c in sizes]
    for one, other in zip(rated(plans), rated(scaled), strict=True):
        assert one.mean_multiple >= 1.0 - 1e-12, one
        assert other.mean_multiple == pytest.approx(one.mean_multiple, rel=1e-9)


@pytest.mark.parametrize("most", [1e-3, 0.91, TORQUE_MAX_NM])
def test_the_smallest_and_the_largest_load_have_runs_on_the_shortest_travel(most: float) -> None:
    loads = ("brake", "weight", "torque_motor")
    bench = BenchLimits(torque_Nm=most, half_travel_deg=0.01, loads=loads, motor_current=MotorCurrent())
    runs = candidates(SimpleNamespace(half_travel_deg=1.0), bench)
    levels = next(run.load.levels_Nm for run in runs if len(run.load.levels_Nm) == 4)
    assert levels == pytest.approx([0.15 * most, 0.4 * most, 0.7 * most, most], rel=0.004)


def test_a_bench_too_slow_for_the_travel_has_no_runs() -> None:
    assert not candidates(SimpleNamespace(half_travel_deg=1000.0), BenchLimits(drum_speed_max_deg_s=0.01))
