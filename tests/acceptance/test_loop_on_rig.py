"""The loop on a few experiments of the rig's library; all of them are in docs/loop-on-rig.md."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from rig_study import judge

SLOW = [
    ("null-long-levels", "none"),
    ("preload-one-low-long", "exact"),
    ("eccentric-right-long", "exact"),
    ("ratio-encoder-long", "exact"),
    ("pair-slip-friction", "exact"),
    ("pair-winding-guide", "exact"),
    ("out-wear", "unknown"),
    ("out-strand", "unknown"),
]


def expect(name: str, outcome: str) -> None:
    """Judge one experiment."""
    row = judge((name, 0))
    print(f"{name}: true {row.true}; said {row.said}; {1e6 * row.before_rad:.1f} to {1e6 * row.after_rad:.1f} urad")
    assert row.outcome == outcome, f"true: {row.true}; said: {row.said}"
    assert row.right


def test_nothing_is_named_where_nothing_is_missing() -> None:
    expect("null-long-brake", "none")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "outcome"), SLOW)
def test_the_loop_says_what_the_rig_did(name: str, outcome: str) -> None:
    expect(name, outcome)
