"""A part of the reach study: how many random short files of the whole space give a design that passes every check.

The whole: ``python tests/reach.py --count 300 --seed 1``; its figures and what they mean: docs/reach.md.
"""

from __future__ import annotations

import pytest

from tests.random_generator import WHOLE, Passing, passing

# Of seeds 1 to 40; those that fail are mostly files whose requirements exclude each other, which nothing proves yet.
LEAST = 16


@pytest.mark.slow
def test_random_short_files_of_the_whole_space() -> None:
    passed = [seed for seed in range(1, 41) if isinstance(passing(seed, WHOLE), Passing)]
    assert len(passed) >= LEAST, f"{len(passed)} of 40 pass: {passed}"


def test_random_short_files_in_usual_proportions() -> None:
    found = [passing(seed) for seed in (1, 2)]
    assert all(isinstance(p, Passing) for p in found), found
