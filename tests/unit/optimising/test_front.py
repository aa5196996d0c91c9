"""The front and its volume, against brute force and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.optimising.front import front_of, hypervolume, reference_of

POINTS = st.lists(st.tuples(*[st.integers(0, 6).map(float)] * 3), min_size=1, max_size=40)


@given(POINTS)
@settings(max_examples=60, deadline=None)
def test_no_point_of_the_front_is_dominated_and_every_other_is(points: list[tuple[float, ...]]) -> None:
    found = np.array(points)
    front = front_of(found)
    for k, point in enumerate(found):
        better = [n for n, other in enumerate(found) if (other <= point).all() and (other < point).any()]
        equal_before = [n for n in range(k) if (found[n] == point).all()]
        assert (k in front) == (not better and not equal_before), (k, point, better)


def test_volume_of_two_points_is_that_of_their_rectangles() -> None:
    points = np.array([[0.0, 2.0], [1.0, 0.0]])
    reference, scale = np.array([2.0, 3.0]), np.ones(2)
    assert hypervolume(points, reference, scale) == pytest.approx(2.0 * 1.0 + 1.0 * 3.0 - 1.0 * 1.0)
    assert hypervolume(points, reference, np.array([2.0, 3.0])) == pytest.approx(4.0 / 6.0)
    assert hypervolume(np.zeros((0, 2)), reference, scale) == 0.0


def test_the_reference_lies_beyond_the_worst_point_also_without_a_spread() -> None:
    reference, scale = reference_of(np.array([[1.0, 5.0], [3.0, 5.0]]))
    assert reference == pytest.approx([3.2, 5.5]) and scale == pytest.approx([2.0, 5.0])
