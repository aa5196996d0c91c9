"""Relaxation of a rope between fixed ends compared with closed forms, and the figures of the catalogue."""

from __future__ import annotations

from dataclasses import replace
from math import log

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.bought import CableSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.model.creep import DAY_S, START_S, YEAR_S, creeps, preload_left, relaxation, steady_rate_per_s


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
