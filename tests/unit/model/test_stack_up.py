"""Stack-ups compared with closed forms."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.model.stack_up import BEYOND_THREE_SIGMA, Contribution, StackUp, stack_data, tightest


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
