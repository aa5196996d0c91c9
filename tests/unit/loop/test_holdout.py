"""What is held back has both directions and the loads of the whole, whatever the rhythm of the loads."""

import numpy as np
import pytest

from mbcdm_cad.loop.prepare.samples import held_sweeps, held_words
from mbcdm_cad.routes import Floats


def sweeps(loads: list[float], count: int) -> tuple[np.ndarray, Floats, Floats]:
    one = np.linspace(-0.5, 0.5, 50)
    output = np.concatenate([one if k % 2 == 0 else one[::-1] for k in range(count)])
    sweep = np.repeat(np.arange(count), one.size)
    return sweep, output, np.array(loads)[sweep % len(loads)]


@pytest.mark.parametrize("rhythm", [1, 2, 3, 4, 5, 6, 8])
@pytest.mark.parametrize("count", [12, 16, 17, 24])
def test_loads_and_directions_are_those_of_the_whole(rhythm: int, count: int) -> None:
    levels = list(np.cos(np.pi * np.arange(rhythm) * 3 / max(rhythm, 1)) * np.linspace(1.0, 0.3, rhythm))
    sweep, output, load = sweeps([float(v) for v in levels], count)
    held = held_sweeps(sweep, output, load)
    chosen = np.isin(sweep, held)
    assert 0.15 <= chosen.mean() <= 0.35, held
    assert {int(k) % 2 for k in held} == {0, 1}, held
    whole, part = float(np.std(load)), float(np.std(load[chosen]))
    assert part >= 0.5 * whole, (
        f"{count} half sweeps, {held} held back: spread of the load {whole:.3f}, there {part:.3f}"
    )


@pytest.mark.parametrize("seed", range(8))
def test_loads_that_change_within_half_sweeps_are_all_held_back(seed: int) -> None:
    """The loads jump at random times: half sweeps with the same mean load have different loads."""
    rng = np.random.default_rng(seed)
    sweep, output, _ = sweeps([0.0], 20)
    jumps = np.sort(rng.choice(np.arange(1, sweep.size), 30, replace=False))
    load = rng.uniform(-1.0, 1.0, 31)[np.searchsorted(jumps, np.arange(sweep.size), side="right")]
    held = np.isin(sweep, held_sweeps(sweep, output, load))
    edges = np.linspace(load.min(), load.max(), 5)
    whole, there = (np.histogram(part, edges)[0] / part.size for part in (load, load[held]))
    assert 0.15 <= held.mean() <= 0.35, held.mean()
    assert np.abs(whole - there).sum() / 2 < 0.22, f"shares of four bins of the load: all {whole}, held back {there}"


def test_few_or_unused_sweeps() -> None:
    sweep, output, load = sweeps([1.0], 3)
    assert held_sweeps(sweep, output, load).size == 1
    assert held_sweeps(sweep - 2, output, None).size == 0
    assert held_sweeps(sweep, output, None).size == 1


def test_words_name_numbers_of_the_run_and_loads() -> None:
    """The first half sweep of a run is not used, so the first that is has the number 2."""
    sweep, _, load = sweeps([0.9, -0.9], 8)
    assert held_words(np.array([1, 4]), sweep, load, False) == "half sweeps 3, 6 (mean loads -0.9 to 0.9 N m)"
    assert held_words(np.array([2, 6]), sweep, None, True) == "eighths 3, 7 of the time"
    assert held_words(np.array([], dtype=int), sweep, load, False) == "none"
