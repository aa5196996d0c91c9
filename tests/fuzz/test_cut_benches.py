"""Runs of benches cut anywhere, with wrong zeros and a wrong gain or sign of the load, end in a verdict or a message.

`python tests/support/bench_cut.py --count 300 --workers 2` does it with 300 runs.
"""

from __future__ import annotations

import pytest

from mbcdm_cad.loop.result import VERDICTS
from tests.support.bench_cut import ending

# Causes that a message may name; all others would be a failure of the loop.
CAUSES = ("wrong sign", "cannot follow the run: ")


@pytest.mark.parametrize("seed", [1, 2, *(pytest.param(k, marks=pytest.mark.slow) for k in range(12, 24))])
def test_a_cut_run_ends_in_a_verdict_or_in_a_message_with_a_cause(seed: int) -> None:
    end, words = ending(seed)
    assert end in VERDICTS or any(cause in words for cause in CAUSES), words
