"""Bendings of each zone by hand and Miner's sum in closed cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbcdm_cad.model.rope_bendings import Crossing, RopeKind, bendings
from mbcdm_cad.model.rope_zones import Level, RopeInUse, RopeLife, Tangent, rope_life

ROPE = RopeKind("7x7", 1.0, "galvanised", "oiled")
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
LEVEL = Level(np.array([-1.0, 1.0]), np.full((1, 2), 100.0), np.full((1, 2), 100.0))


def tangent(
    body: str, place_mm: float, spans_to: int, normal: tuple[float, float, float] = UP, radius: float = 10.0
) -> Tangent:
    return Tangent(0, body, radius * 1e-3, place_mm * 1e-3, 10e-3, normal, spans_to, 0.53)


def used(*tangents: Tangent) -> RopeInUse:
    return RopeInUse("rope", ROPE, 1000.0, 0.0, tangents)


def stands(radius_mm: float, tension_N: float) -> float:
    where = (2.0 * radius_mm, tension_N / 1000.0, 0.53, 0.0)
    return float(bendings(ROPE, Crossing(*(np.asarray(v) for v in where))))


def zones(life: RopeLife) -> list[tuple[float, float, float]]:
    return [(round(1e3 * z.start_m, 6), round(1e3 * z.end_m, 6), sum(z.bendings.values())) for z in life.zones]


def test_what_winds_on_and_off_bends_once_a_cycle_and_what_never_leaves_not_at_all() -> None:
    # The tangent points move by 10 mm each way; 200 mm of span keep them apart.
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [LEVEL])
    assert zones(life) == [(40.0, 60.0, 1.0), (240.0, 260.0, 1.0)]
    assert life.cycles == pytest.approx(stands(10.0, 100.0))


def test_over_a_pulley_and_back_is_two_bendings() -> None:
    # 4 mm lie on the guide, less than the move of 20 mm: what passes both of its tangent points bends there twice.
    guide = (tangent("guide", 150.0, 0), tangent("guide", 154.0, 3))
    life = rope_life(used(tangent("input", 50.0, 1), *guide, tangent("drum", 300.0, 2)), [LEVEL])
    assert (144.0, 160.0, 2.0) in zones(life)
    assert life.cycles == pytest.approx(0.5 * stands(10.0, 100.0))
    assert life.pulleys[0].body == "guide" and life.pulleys[0].bendings == pytest.approx(2.0)


@pytest.mark.parametrize(("normal", "weight"), [(UP, 1.0), ((1.0, 0.0, 0.0), 1.0), (DOWN, 2.5)])
def test_a_bend_the_other_way_round_next_counts_more(normal: tuple[float, float, float], weight: float) -> None:
    # 5 mm of span: 15 mm of rope pass both of its ends.
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 55.0, 0, normal)), [LEVEL])
    assert zones(life)[1] == (45.0, 60.0, 2.0 * weight)
    assert life.cycles == pytest.approx(stands(10.0, 100.0) / (2.0 * weight))


def test_miners_sum_over_two_loads_and_two_ways() -> None:
    heavy = Level(LEVEL.angle_rad, np.full((1, 2), 200.0), np.full((1, 2), 50.0), count=3.0)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [LEVEL, heavy])
    by_hand = 1.0 / stands(10.0, 100.0) + 3.0 * (0.5 / stands(10.0, 200.0) + 0.5 / stands(10.0, 50.0))
    assert life.cycles == pytest.approx(1.0 / by_hand)
    assert life.sigmas["sum over several loads"] > 0.0
    alone = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [LEVEL])
    assert alone.sigmas["sum over several loads"] == 0.0


def test_the_point_that_passes_most_often_is_the_weakest() -> None:
    small = Level(np.array([0.5, 1.0]), *(np.full((1, 2), 100.0),) * 2, count=4.0)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [LEVEL, small])
    assert 55e-3 < life.place_m[int(np.argmax(life.damage))] < 60e-3
    assert life.cycles == pytest.approx(stands(10.0, 100.0) / 5.0)


def test_the_tension_is_that_at_the_moment_of_passing() -> None:
    rising = Level(LEVEL.angle_rad, *(np.array([[50.0, 250.0]]),) * 2)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [rising])
    assert life.cycles == pytest.approx(stands(10.0, 250.0), rel=1e-6)
    assert life.place_m[int(np.argmax(life.damage))] == pytest.approx(60e-3)


def test_a_move_shorter_than_the_bent_length_bends_less() -> None:
    stiff = replace(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), bend_stiffness_N_m2=100.0 * 0.04)
    # sqrt(EI/T) is 0.2 m, the move 20 mm: D/(1 - e^-0.1) in place of D.
    life = rope_life(stiff, [LEVEL])
    assert life.pulleys[0].bend_ratio == pytest.approx(20.0 / (1.0 - np.exp(-0.1)))


def test_band_and_refusals() -> None:
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [LEVEL])
    assert life.reached(0.5) == pytest.approx(life.cycles)
    assert life.reached(0.1) * life.reached(0.9) == pytest.approx(life.cycles**2)
    assert life.reached(0.9) == pytest.approx(life.cycles * np.exp(1.2816 * life.sigma), rel=1e-3)
    tight = rope_life(used(tangent("input", 50.0, 1, radius=5.0), tangent("drum", 250.0, 0)), [LEVEL])
    assert "D/d of 10" in tight.refused and np.isnan(tight.cycles)
    easy = rope_life(used(tangent("input", 50.0, 1, radius=49.0), tangent("drum", 250.0, 0, radius=49.0)), [LEVEL])
    assert easy.longer and "more than 1000000" in easy.refused
    still = Level(np.array([0.0, 0.0]), *(np.full((1, 2), 100.0),) * 2)
    assert (
        "no part of it bends" in rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [still]).refused
    )
