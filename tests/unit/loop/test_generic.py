"""A compliance that grows with the load is not blamed on a soft shaft."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from confusion import judge


@pytest.mark.slow
def test_a_shape_of_load_without_a_name_is_unknown() -> None:
    """Another one, the square of the load: tests/acceptance/test_worked_examples.py."""
    score = judge("out_hardening", 0)
    assert score.outcome == "unknown", score.said
