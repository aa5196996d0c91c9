"""A part of the reach study: the share of random short files whose design passes every check.

The whole study: ``python -m benchmarks.studies.reach --count 300 --seed 1``; its figures: docs/reach.md.
"""

from __future__ import annotations

import pytest

from tests.support.random_generator import WHOLE, Passing, passing, requirements
from tests.support.reach_bound import asked, excluding

# Of seeds 1 to 40: files that pass, and files that do or whose requirements are proved to exclude each other.
LEAST_PASSING, LEAST_SETTLED = 20, 38


@pytest.mark.slow
def test_random_short_files_of_the_whole_space_pass_or_are_proved_to_exclude_each_other() -> None:
    passed, excluded, left = list[int](), list[int](), list[int]()
    for seed in range(1, 41):
        passes = isinstance(passing(seed, WHOLE), Passing)
        proved = bool(excluding(asked(requirements(seed, WHOLE))))
        assert not (passes and proved), f"seed {seed} passes, and the bound says that it cannot"
        (passed if passes else excluded if proved else left).append(seed)
    assert len(passed) >= LEAST_PASSING, f"{len(passed)} of 40 pass: {passed}"
    assert len(passed) + len(excluded) >= LEAST_SETTLED, f"neither pass nor proved: {left}"


def test_random_short_files_in_usual_proportions() -> None:
    found = [passing(seed) for seed in (1, 2)]
    assert all(isinstance(p, Passing) for p in found), found
