"""A part of benchmarks/studies/advice.py: after one edit the advice leads to a pass or states what still fails."""

import pytest

from benchmarks.studies.advice import PASSES, STAYS, follow, start

# Edits of the complete reference file, and of its requirements alone.
COMPLETE = ("L 38", "scale 1.05", "guide_to_drum 5")
SHORT = ("travel 60",)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "short"), [*((n, False) for n in COMPLETE), *((n, True) for n in SHORT)])
def test_advice_ends_in_a_pass_or_says_what_stays(name: str, short: bool) -> None:
    end = follow(start(name, short=short))
    assert end.kind in (PASSES, STAYS), (end.kind, end.words)
    if end.kind == STAYS:
        assert "mbcdm solve" in end.words, end.words
