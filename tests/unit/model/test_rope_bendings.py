"""Bendings that a rope stands, against rope makers' rules, hand calculations and laws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.model.rope_bendings import (
    Crossing,
    RopeKind,
    bendings,
    fleet_factor,
    groove_factor,
    is_rough,
    sigmas,
    thin_factor,
    too_hard,
)
from mbcdm_cad.model.rope_zones import Level, RopeInUse, RopeLife, Tangent, rope_life

THICK = RopeKind("7x7", 16.0, "galvanised", "oiled")
THIN = RopeKind("7x7", 0.81, "stainless", "oiled")


def at(ratio: float, share: float, groove: float = np.nan, fleet_deg: float = 0.0) -> Crossing:
    return Crossing(*(np.asarray(float(v)) for v in (ratio, share, groove, fleet_deg)))


def stands(rope: RopeKind, *where: float) -> float:
    return float(bendings(rope, at(*where)))


def test_the_base_is_that_of_a_galvanised_rope_of_16_mm_in_a_groove() -> None:
    # D/d 25 over wires of d/9: X is 15.
    assert stands(THICK, 25.0, 0.13, 0.53) == pytest.approx(3.0e4)


def test_a_thin_stainless_rope_by_hand() -> None:
    # X 8.88: 3e4 x 0.1868 x 0.9712 x 3 x 0.4 x 0.45 x 0.9288.
    found = stands(THIN, 14.8, 70.0 / 530.0, np.nan, 1.5)
    assert found == pytest.approx(2738.0, rel=2e-3)
    assert stands(replace(THIN, lubrication="dry"), 14.8, 70.0 / 530.0, np.nan, 1.5) == pytest.approx(0.2 * found)


@pytest.mark.parametrize("construction", ["7x7", "7x19", "1x19"])
def test_twice_the_pulley_gives_at_most_the_13_times_of_laboratory_tests(construction: str) -> None:
    """Sava: up to thirteen times. Another maker's chart of relative lives: 2.1 at D/d 16, 10 at 30."""
    rope = replace(THIN, construction=construction)
    x_15 = 15.0 * 15.0 / rope.over_wire
    gain = stands(rope, 2.0 * x_15, 0.1) / stands(rope, x_15, 0.1)
    assert 4.0 < gain <= 13.0, gain
    chart = 10.0 / 2.1
    assert chart < stands(rope, x_15 * 30.0 / 16.0, 0.1) / stands(rope, x_15, 0.1) < 2.0 * chart


def test_makers_least_pulleys_of_four_constructions_mean_one_ratio_to_the_wire() -> None:
    """Sava's least D/d for 3x7, 7x7, 7x19, 7x49 over the wires' diameters of ISO 2408's geometry."""
    ratios = np.array([50 * 6.46, 40 * 9, 25 * 15, 15 * 27])
    assert np.all(np.abs(ratios / ratios.mean() - 1.0) < 0.15), ratios
    # So 7x7 and 7x19 live about as long there.
    one, other = stands(THIN, 40.0, 0.1), stands(replace(THIN, construction="7x19"), 25.0, 0.1)
    assert other / one == pytest.approx((375 / 360) ** 3.2, rel=1e-6)


def test_thin_ropes_gain_as_feyrer_says_but_not_without_end() -> None:
    assert thin_factor(16.0) == pytest.approx(1.0)
    assert thin_factor(8.0) == pytest.approx(0.52 / (0.5**0.3 - 0.48))
    assert thin_factor(8.0) == pytest.approx(1.56, rel=0.01)
    # His factor grows to 9 at 2 mm and is infinite at 1.385 mm.
    assert thin_factor(2.0) == thin_factor(1.385) == thin_factor(0.3) == 3.0


def test_groove_and_fleet_angle_at_their_ends() -> None:
    assert groove_factor(np.array([0.53, 0.6, 1.0, 2.0, np.nan])).tolist() == [1.0, 0.66, 0.48, 0.48, 0.45]
    assert float(fleet_factor(0.0, 20.0)) == 1.0
    assert float(fleet_factor(2.0, 25.0)) == pytest.approx(1.0 - (0.00863 + 0.06075) * 2.0 - 0.00412)


@given(
    ratio=st.floats(26.0, 60.0),
    share=st.floats(0.02, 0.28),
    more=st.floats(1.01, 2.0),
    groove=st.one_of(st.just(float("nan")), st.floats(0.53, 1.0)),
    fleet=st.floats(0.0, 4.0),
    construction=st.sampled_from(["7x7", "7x19", "1x19"]),
)
def test_life_grows_with_pulley_and_oil_and_falls_with_tension(
    ratio: float, share: float, more: float, groove: float, fleet: float, construction: str
) -> None:
    rope = replace(THIN, construction=construction)
    n = stands(rope, ratio, share, groove, fleet)
    assert n > 0.0
    assert stands(rope, more * ratio, share, groove, fleet) >= n
    assert stands(rope, ratio, min(more * share, 0.3), groove, fleet) < n
    assert stands(replace(rope, lubrication="dry"), ratio, share, groove, fleet) < n
    assert stands(rope, ratio, share, 0.53, fleet) >= n >= stands(rope, ratio, share, float("nan"), fleet) * (1 - 1e-12)
    assert stands(rope, ratio, share, groove, 0.0) >= n


def test_it_refuses_what_the_data_do_not_hold() -> None:
    assert "D/d of 14 is below 14.2" in too_hard(THIN, at(14.0, 0.1))
    assert too_hard(THIN, at(14.2, 0.1)) == ""
    assert "31% of the breaking load" in too_hard(THIN, at(20.0, 0.31))
    assert "fleet angle of 4.5" in too_hard(THIN, at(20.0, 0.1, np.nan, 4.5))
    assert "bronze" in replace(THIN, material="bronze").why_unknown
    assert "life_anchor" in RopeKind("braid", 1.0, "uhmwpe", "oiled").why_unknown
    assert is_rough(THIN, at(16.0, 0.1), np.ones(1)) and not is_rough(THIN, at(17.0, 0.1), np.ones(1))


def anchor(**changes: object) -> SimpleNamespace:
    values = {
        "bendings": 5000.0,
        "bend_ratio": 16.0,
        "load_share": 0.1,
        "groove": None,
        "lubrication": "oiled",
        "count": 4,
    }
    return SimpleNamespace(**(values | changes))


@given(st.floats(12.0, 30.0), st.floats(0.04, 0.25))
def test_a_test_of_ones_own_replaces_all_but_the_exponents(ratio: float, share: float) -> None:
    own = replace(THIN, anchor=anchor())
    assert stands(own, 16.0, 0.1) == pytest.approx(5000.0)
    expected = 5000.0 * (ratio / 16.0) ** 3.2 * (share / 0.1) ** -1.8
    assert stands(own, ratio, share) == pytest.approx(expected, rel=1e-9)
    assert stands(replace(own, lubrication="dry"), ratio, share) == pytest.approx(0.2 * expected, rel=1e-9)


def test_an_anchor_halves_the_band() -> None:
    spread = {
        name: sigmas(rope, at(16.0, 0.1), np.ones(1))
        for name, rope in (("generic", THIN), ("tested", replace(THIN, anchor=anchor())))
    }
    whole = {name: float(np.sqrt(sum(v**2 for v in parts.values()))) for name, parts in spread.items()}
    assert whole["generic"] == pytest.approx(1.25, abs=0.05), whole
    assert whole["tested"] == pytest.approx(0.65, abs=0.05), whole


def test_an_anchor_carries_only_so_far() -> None:
    own = replace(THIN, anchor=anchor())
    assert "below half" in too_hard(own, at(7.9, 0.1))
    assert "three times" in too_hard(own, at(16.0, 0.31))
    assert too_hard(own, at(8.1, 0.29)) == ""


def test_a_fibre_rope_is_scaled_by_load_over_bend_ratio() -> None:
    fibre = RopeKind("braid", 2.0, "uhmwpe", "oiled", anchor(bendings=1.0e4, bend_ratio=10.0, load_share=0.1))
    # q = 100 s/(D/d) is 1 in the test: half of it lasts 2^2.5 as long.
    assert stands(fibre, 20.0, 0.1) == pytest.approx(1.0e4 * 2.0**2.5)
    assert stands(fibre, 10.0, 0.2) == pytest.approx(1.0e4 / 2.0**2.5)
    assert "carries to 2" in too_hard(fibre, at(10.0, 0.21))


ROPE = RopeKind("7x7", 1.0, "galvanised", "oiled")
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)
LEVEL = Level(np.array([-1.0, 1.0]), np.full((1, 2), 100.0), np.full((1, 2), 100.0))


def tangent(
    body: str, place_mm: float, spans_to: int, normal: tuple[float, float, float] = UP, radius: float = 10.0
) -> Tangent:
    return Tangent(0, body, radius * 1e-3, place_mm * 1e-3, 10e-3, normal, spans_to, 0.53)


def used(*tangents: Tangent) -> RopeInUse:
    return RopeInUse("rope", ROPE, 1000.0, 0.0, tangents)


def rope_stands(radius_mm: float, tension_N: float) -> float:
    where = (2.0 * radius_mm, tension_N / 1000.0, 0.53, 0.0)
    return float(bendings(ROPE, Crossing(*(np.asarray(v) for v in where))))


def zones(life: RopeLife) -> list[tuple[float, float, float]]:
    return [(round(1e3 * z.start_m, 6), round(1e3 * z.end_m, 6), sum(z.bendings.values())) for z in life.zones]


def test_what_winds_on_and_off_bends_once_a_cycle_and_what_never_leaves_not_at_all() -> None:
    # The tangent points move by 10 mm each way; 200 mm of span keep them apart.
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [LEVEL])
    assert zones(life) == [(40.0, 60.0, 1.0), (240.0, 260.0, 1.0)]
    assert life.cycles == pytest.approx(rope_stands(10.0, 100.0))


def test_over_a_pulley_and_back_is_two_bendings() -> None:
    # 4 mm lie on the guide, less than the move of 20 mm: what passes both of its tangent points bends there twice.
    guide = (tangent("guide", 150.0, 0), tangent("guide", 154.0, 3))
    life = rope_life(used(tangent("input", 50.0, 1), *guide, tangent("drum", 300.0, 2)), [LEVEL])
    assert (144.0, 160.0, 2.0) in zones(life)
    assert life.cycles == pytest.approx(0.5 * rope_stands(10.0, 100.0))
    assert life.pulleys[0].body == "guide" and life.pulleys[0].bendings == pytest.approx(2.0)


@pytest.mark.parametrize(("normal", "weight"), [(UP, 1.0), ((1.0, 0.0, 0.0), 1.0), (DOWN, 2.5)])
def test_a_bend_the_other_way_round_next_counts_more(normal: tuple[float, float, float], weight: float) -> None:
    # 5 mm of span: 15 mm of rope pass both of its ends.
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 55.0, 0, normal)), [LEVEL])
    assert zones(life)[1] == (45.0, 60.0, 2.0 * weight)
    assert life.cycles == pytest.approx(rope_stands(10.0, 100.0) / (2.0 * weight))


def test_miners_sum_over_two_loads_and_two_ways() -> None:
    heavy = Level(LEVEL.angle_rad, np.full((1, 2), 200.0), np.full((1, 2), 50.0), count=3.0)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [LEVEL, heavy])
    by_hand = 1.0 / rope_stands(10.0, 100.0) + 3.0 * (0.5 / rope_stands(10.0, 200.0) + 0.5 / rope_stands(10.0, 50.0))
    assert life.cycles == pytest.approx(1.0 / by_hand)
    assert life.sigmas["sum over several loads"] > 0.0
    alone = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [LEVEL])
    assert alone.sigmas["sum over several loads"] == 0.0


def test_the_point_that_passes_most_often_is_the_weakest() -> None:
    small = Level(np.array([0.5, 1.0]), *(np.full((1, 2), 100.0),) * 2, count=4.0)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0)), [LEVEL, small])
    assert 55e-3 < life.place_m[int(np.argmax(life.damage))] < 60e-3
    assert life.cycles == pytest.approx(rope_stands(10.0, 100.0) / 5.0)


def test_the_tension_is_that_at_the_moment_of_passing() -> None:
    rising = Level(LEVEL.angle_rad, *(np.array([[50.0, 250.0]]),) * 2)
    life = rope_life(used(tangent("input", 50.0, 1), tangent("drum", 250.0, 0, radius=30.0)), [rising])
    assert life.cycles == pytest.approx(rope_stands(10.0, 250.0), rel=1e-6)
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
