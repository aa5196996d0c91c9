"""The independent search of the reach study, with a few starts instead of some hundred."""

from __future__ import annotations

from tests.support.random_generator import requirements
from tests.support.random_search import Draw, missed, search


def test_a_file_that_passes_needs_no_move() -> None:
    assert search(requirements(1), starts=1) == {}


def test_a_requirement_that_is_left_out_is_drawn_and_the_same_search_ends_alike() -> None:
    data = requirements(1)
    del data["loads"]["peak_torque_Nm"]
    found = search(data, starts=12)
    assert found is not None and found["loads.peak_torque_Nm"] > 0.0
    assert search(data, starts=12) == found


def test_a_miss_counts_failing_checks_and_stops_at_what_is_bad_enough() -> None:
    thin = requirements(1) | {"transmission": {"ratio": 20.0, "drum_radius_mm": 34.0}}
    whole = missed(thin, Draw())
    assert whole > 3.0
    assert missed(thin, Draw(), most=0.5) < whole
