"""Bendings that a rope stands, against rope makers' rules, hand calculations and laws."""

from __future__ import annotations

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
