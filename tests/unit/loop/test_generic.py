"""Curves without a name are not blamed on effects that look like them in one run, nor one effect on two."""

from collections.abc import Callable

import numpy as np

from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run


def found(error: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> LoopResult:
    """The finding on a sine of a drive of which the ratio is known; the error from angle and speed of the output."""
    t = np.arange(0.0, 120.0, 0.04)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 11.0)
    out = angle + error(angle, np.gradient(angle, t)) + 1e-5 * np.random.default_rng(7).standard_normal(t.size)
    return close_loop(None, [Run(t, (5.0 * angle)[None], out, None, input_names=("input",), ratio=5.0)])


def test_the_square_of_the_speed_is_no_wave_that_looks_like_it_on_a_sine() -> None:
    """A wave of the drum has any phase: that of a parabola in the middle of the travel is chance."""
    result = found(lambda angle, speed: 2e-3 * speed**2)
    assert result.verdict == "unknown" and not result.effects and not result.one_of, result.sentence
    wave = found(lambda angle, speed: 2e-3 * np.cos(angle + 1.0))
    named = [one.name for one in wave.effects] + [one.name for group in wave.one_of for one in group]
    assert "once_per_rev" in named, wave.sentence


def test_a_walk_with_the_whole_path_is_not_a_walk_one_way_beside_a_wrong_ratio() -> None:
    def error(angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        path = np.cumsum(np.abs(np.diff(angle, prepend=angle[0])))
        return np.asarray(4e-5 * path + 2e-4 * np.cos(44.0 * angle))

    result = found(error)
    named = [one.name for one in result.effects] + [one.name for group in result.one_of for one in group]
    assert "ripple" in named and "ratio_error" not in named, result.sentence
