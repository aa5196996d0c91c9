"""A compliance that grows with the load is not blamed on a soft shaft."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from confusion import judge


@pytest.mark.slow
@pytest.mark.parametrize("case", ["out_hardening", "out_square"])
def test_a_shape_of_load_without_a_name_is_unknown(case: str) -> None:
    score = judge(case, 0)
    assert score.outcome == "unknown", score.said
