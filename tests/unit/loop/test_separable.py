"""How often the wrong one of two effects fits better, predicted against counted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, norm

from mbcdm_cad.loop.search.evidence import separation

N = 1600
SWEEP = np.arange(N) // 80
ANGLE = np.where(SWEEP % 2 == 0, np.arange(N) % 80, 79 - np.arange(N) % 80) / 79.0 * 2.0 - 1.0
SECTOR = np.minimum((ANGLE + 1.0) * 4.0, 7).astype(np.int64)


def pair(likeness: float, strength: float) -> tuple[np.ndarray, np.ndarray]:
    """Two waves of the given cosine, each ``strength`` standard deviations of unit noise strong."""
    one = np.cos(6.0 * np.pi * ANGLE)
    two = np.cos(9.0 * np.pi * ANGLE)
    two -= one * (one @ two) / (one @ one)
    one, two = strength * one / np.linalg.norm(one), strength * two / np.linalg.norm(two)
    return one, likeness * one + np.sqrt(1.0 - likeness**2) * two


@pytest.mark.parametrize(("likeness", "strength"), [(0.5, 2.0), (0.8, 3.0), (0.9, 6.0)])
def test_wrong_choices_happen_as_often_as_said(likeness: float, strength: float) -> None:
    first, second = pair(likeness, strength)
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((4000, N))
    wrong = float(np.mean(((first + noise - second) ** 2).sum(axis=1) < (noise**2).sum(axis=1)))
    white = float(norm.sf(np.sqrt(strength**2 * (1.0 - likeness) / 2.0)))
    said = [separation(first, second, one, SWEEP, SECTOR).probability for one in noise[:200]]
    figures = f"counted {wrong:.4f}, white formula {white:.4f}, clustered {np.median(said):.4f}"
    assert abs(wrong - white) < 4.0 * np.sqrt(white * (1.0 - white) / 4000), figures
    assert 0.6 * white - 0.01 < np.median(said) < 1.6 * white + 0.01, figures


def test_factor_is_what_would_separate() -> None:
    rng = np.random.default_rng(1)
    residual = rng.standard_normal(N)
    first, second = pair(0.9, 4.0)
    now = separation(first, second, residual, SWEEP, SECTOR)
    assert not now.apart, now
    assert "times as large" in now.words
    larger = 1.01 * now.factor
    assert separation(larger * first, larger * second, residual, SWEEP, SECTOR).apart


def test_noise_of_whole_sweeps_makes_it_harder() -> None:
    rng = np.random.default_rng(2)
    first = ANGLE * 0.5
    second = np.zeros(N)
    white = rng.standard_normal(N)
    tilted = white + rng.standard_normal(20)[SWEEP] * ANGLE
    assert (
        separation(first, second, tilted, SWEEP, SECTOR).factor
        > 2.0 * separation(first, second, white, SWEEP, SECTOR).factor
    )


def test_twins_are_never_told() -> None:
    first, _ = pair(0.5, 5.0)
    twins = separation(first, first.copy(), np.ones(N), SWEEP, SECTOR)
    assert twins.probability == 0.5
    assert "at any size" in twins.words


@pytest.mark.parametrize("strength", [2.0, 3.5, 5.0])
def test_of_choices_at_odds_of_99_to_1_at_most_one_in_a_hundred_is_wrong(strength: float) -> None:
    """Either effect may be true; the odds are counted where they are large enough, over 4000 runs."""
    effects = pair(0.8, strength)
    rng = np.random.default_rng(5)
    right = wrong = 0
    for k in range(4000):
        noise = rng.standard_normal(N)
        true, other = effects if k % 2 else effects[::-1]
        squares = float((noise**2).sum()), float(((true + noise - other) ** 2).sum())
        better = noise if squares[0] < squares[1] else true + noise - other
        told = separation(true, other, better, SWEEP, SECTOR)
        if told.log_odds(abs(squares[1] - squares[0])) >= np.log(99.0):
            right, wrong = right + (squares[0] < squares[1]), wrong + (squares[0] > squares[1])
    exact = sum(abs(squares_difference(effects, rng)) >= 2.0 * np.log(99.0) for _ in range(4000))
    figures = f"right {right}, wrong {wrong}; decided with the noise known exactly {exact}"
    print(figures)
    assert wrong <= binom.ppf(0.999, right + wrong, 0.01), figures
    # Noise that is estimated from clusters decides less often, not more often.
    assert 0.25 * exact - 10 < right + wrong < 1.1 * exact + 20, figures


def squares_difference(effects: tuple[np.ndarray, np.ndarray], rng: np.random.Generator) -> float:
    """Sum of squares that the wrong effect leaves, less that of the right one, with white noise of one."""
    first, second = effects
    noise = rng.standard_normal(N)
    return float(((first + noise - second) ** 2).sum() - (noise**2).sum())


def test_twins_have_even_odds() -> None:
    first, _ = pair(0.5, 5.0)
    assert separation(first, first.copy(), np.ones(N), SWEEP, SECTOR).log_odds(0.0) == 0.0
