"""Backlash and torque with an interval, from the sigmas of the design file."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.layouts.loader import load_text, reference_data
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.capability import Requirements
from mbcdm_cad.model.sensitivity import intervals
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stack_up import BEYOND_THREE_SIGMA, Contribution, StackUp, stack_data, tightest
from mbcdm_cad.report.analysis_report import analyse_design

NEED = Requirements(0.91, np.radians(35.0), 0.2204, 0.81e-3, 106.0, 0.87e-3)


def design(**rope: Any) -> Any:
    data = reference_data()
    data["rope"] |= rope
    return load_text(yaml.safe_dump(data)).drive


def test_no_sigma_no_interval() -> None:
    assert analyse(design()).intervals == ()
    assert "intervals" not in analyse_design(design()).text()


def test_backlash_goes_as_one_over_the_modulus() -> None:
    """Relative sigma of every backlash is that of E; no torque depends on it."""
    found = {x.name: x for x in analyse(design(modulus_GPa={"value": 54.0, "sigma": 0.54})).intervals}
    for name in ("turn", "reversal_swing", "backlash_cable_1", "backlash_cable_4"):
        share = found[name].sigma / found[name].value
        assert share == pytest.approx(0.01, rel=0.03), f"{name}: {share:.4f} of its value"
        low, high = (found[name].low / found[name].value, found[name].high / found[name].value)
        assert (low, high) == (pytest.approx(1 / 1.0196, abs=1e-3), pytest.approx(1 / 0.9804, abs=1e-3))
    for name in ("peak_torque_plus", "peak_torque_minus"):
        assert found[name].sigma < 1e-9, f"{name} moves by {found[name].sigma:.3g} N m"


def test_the_middle_is_the_figure_without_sigmas() -> None:
    a = analyse(design(preload_N={"value": 70.0, "sigma": 2.0}))
    middle = {x.name: x.value for x in a.intervals}
    assert middle["turn"] == pytest.approx(abs(a.test[0].turn_mrad), rel=1e-9)
    assert middle["reversal_swing"] == pytest.approx(a.reversal_swing_mrad, rel=1e-9)
    assert (middle["peak_torque_plus"], middle["peak_torque_minus"]) == pytest.approx(a.peak_torque_Nm, rel=1e-9)
    assert middle["backlash_cable_2"] == pytest.approx(a.cables[1].backlash_mrad, rel=1e-9)


def test_small_sigmas_agree_with_linear_theory() -> None:
    d = paper_drive()
    sigma = {
        "preload_N": [0.1, 0.2, 0.0, 0.1],
        "drum_radius_m": 5e-5,
        "input_radius_m": 5e-6,
        "guide_radius_m": 5e-6,
        "friction_coefficient": 3e-4,
        "area_m2": 1e-9,
        "centre_distance_m": 2e-5,
        "load_Nm": 1e-3,
    }
    for name, x in intervals(d, NEED, sigma, draws=40_000).items():
        assert x.sigma == pytest.approx(x.linear_sigma, rel=0.03), f"{name}: {x.sigma:.4g}, linear {x.linear_sigma:.4g}"


def test_each_cable_is_drawn_on_its_own() -> None:
    """One cable's preload moves its own backlash and no other's."""
    found = intervals(paper_drive(), NEED, {"preload_N": [0.0, 2.0, 0.0, 0.0]}, draws=2000)
    spread = [found[f"backlash_cable_{k}_rad"].sigma for k in range(1, 5)]
    assert spread[1] > 1e-6, spread
    assert max(spread[0], *spread[2:]) < 1e-15, spread


def test_text_and_json_carry_the_intervals() -> None:
    found = analyse_design(design(preload_N={"value": 70.0, "sigma": 3.0}))
    listed = found.to_dict()["intervals"]
    assert [x["name"] for x in listed][-1] == "peak_torque_minus"
    for x in listed:
        assert x["low"] < x["value"] < x["high"], x
        row = next(line.split() for line in found.text().splitlines() if line.split()[:1] == [x["name"]])
        assert {f"{x['low']:.4g}", f"{x['high']:.4g}"} <= set(row), row


def test_too_wide_is_said_with_what_to_do() -> None:
    with pytest.raises(ModelError, match="lower those of centre distance, radii or friction"):
        intervals(paper_drive(), NEED, {"centre_distance_m": 11e-3}, draws=2000)
    with pytest.raises(ModelError, match="no such parameter"):
        intervals(paper_drive(), NEED, {"colour": 1.0})
    with pytest.raises(ModelError, match="is below 0"):
        intervals(paper_drive(), NEED, {"preload_N": [1.0, -1.0, 0.0, 0.0]})


# Stack-ups compared with closed forms.


def _stack(*shifts: float, margin: float = 1.0) -> StackUp:
    return StackUp("gap", margin, tuple(Contribution(f"part {k}", shift) for k, shift in enumerate(shifts)))


def test_three_and_four_make_five_and_seven() -> None:
    stack = StackUp("gap", 6.0, (Contribution("a", 1.5, -2.0), Contribution("b", 4.0)))
    assert (stack.rss, stack.worst_case, stack.spare) == (5.0, 7.0, 1.0)
    assert stack.costliest.name == "b"
    assert [c["name"] for c in stack_data(stack)["contributions"]] == ["b", "a"]


def test_monte_carlo_of_one_and_of_two_parts_is_the_closed_form() -> None:
    """One uniform part reaches (1 - 2p) t; the sum of two equal ones has its quantile at 2t - t sqrt(8p)."""
    p = BEYOND_THREE_SIGMA
    assert _stack(2.0).monte_carlo() == pytest.approx(2.0 * (1 - 2 * p), rel=1e-3)
    assert _stack(1.0, 1.0).monte_carlo() == pytest.approx(2.0 - sqrt(8 * p), rel=5e-3)
    assert _stack(1.0, 1.0).monte_carlo() == _stack(1.0, 1.0).monte_carlo(), "not seeded"


def test_monte_carlo_of_many_parts_is_the_normal_law() -> None:
    many = _stack(*np.full(60, 0.1))
    assert many.monte_carlo() == pytest.approx(3.0 * many.rss / sqrt(3.0), rel=0.02)


@settings(max_examples=30)
@given(st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=8))
def test_the_worst_case_is_never_under_the_others(shifts: list[float]) -> None:
    stack = _stack(*shifts)
    assert max(shifts) <= stack.rss * (1 + 1e-12)
    assert stack.rss <= stack.worst_case * (1 + 1e-12)
    assert stack.monte_carlo(2000) <= stack.worst_case * (1 + 1e-12)


def test_the_tightest_has_the_least_left() -> None:
    assert tightest([_stack(0.1, margin=1.0), _stack(0.5, margin=1.2)]).margin == 1.2
    assert stack_data(StackUp("ratio", float("inf"), ()))["margin"] is None
