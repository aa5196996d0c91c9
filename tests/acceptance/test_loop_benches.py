"""The loop on simulated benches with realistic noise; the whole study is in docs/loop-benches.md."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from bench_study import judge

SLOW = [
    # The pulley does not reach the far face of its play, so that the size of the play has no scatter.
    ("lash_left", 3003, "exact"),
    # 2000 samples a second: the search uses a part of the run, and the load that moves the pulley occurs only once.
    ("lash_input_left", 3100, "exact"),
    # A wave of the drum stands for the ratio until the time of the slip is searched again beside the ratio.
    ("slip_mount+ratio_encoder", 3102, "exact"),
    # The ripple is withdrawn together with a form that moves the cables, and is accepted again.
    ("ripple_fast+friction", 3100, "exact"),
    # Runout of both inputs resembles the guide beside a wrong ratio: both names have to be exchanged at once.
    ("pulley_guide+ratio_encoder", 12008, "exact"),
    # The search uses a part of the run; the half sweeps held back in it had one load only.
    ("stiffness_modulus", 12003, "exact"),
    # Half sweeps of 2000 samples: half of them say too little of the ripple, all of them thinned say enough.
    ("stiffness_modulus+ripple_slow", 12008, "exact"),
    # Ten half sweeps cannot support each of two large effects, but nothing above the noise is left beside both.
    ("modulus_low+encoder_left", 18000, "exact"),
    # Without the ratio the friction moves so far that a fit with the ratio has to begin where the friction was.
    ("mu_low+ratio_radii", 18001, "set"),
    # The odds of the right input are some 1e3 to 1, though its errors differ by less than two standard errors.
    ("encoder_left", 17003, "exact"),
    # A viscous drag is accepted before the late sensor, and beside it a wrong friction: friction of the cables stays in
    # the set with the preload.
    ("preload_low+ratio_encoder+delay", 19004, "set"),
    # The odds are 670 to 1 for a wave of the drum in place of the ratio, but only at one phase.
    ("pulley_guide+ratio_encoder", 19004, "set"),
    # The odds are above 99 to 1 for the wrong input, but such runs confuse the two in 8 %.
    ("pulley_input_right", 19003, "set"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "seed", "outcome"), SLOW)
def test_the_loop_says_what_is_true_of_a_bench(case: str, seed: int, outcome: str) -> None:
    row = judge((case, seed))
    assert row["outcome"] == outcome, f"true: {row['true']}; said: {row['said']}"
