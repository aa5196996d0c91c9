"""Clustered tests hold their level on residuals that repeat in angle or wander; plain ones do not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm

from mbcdm_cad.loop.prepare.lines import hotelling, line_of, order_spectrum
from mbcdm_cad.loop.search.evidence import cell_grams, cluster_estimate, separated
from mbcdm_cad.routes import Floats

SWEEPS, SECTORS, IN_CELL = 20, 8, 40


def layout() -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    one = np.linspace(-1.0, 1.0, SECTORS * IN_CELL)
    angle = np.concatenate([one if k % 2 == 0 else one[::-1] for k in range(SWEEPS)])
    sweep = np.repeat(np.arange(SWEEPS), one.size)
    sector = np.minimum((angle + 1.0) / 2.0 * SECTORS, SECTORS - 1).astype(np.int64)
    return angle, sweep, sector


def residual(rng: np.random.Generator, angle: Floats, sweep: NDArray[np.int64]) -> Floats:
    """Noise, a texture that repeats in angle, a level of each sweep."""
    at = np.linspace(-1.0, 1.0, 60)
    texture = np.interp(angle, at, rng.standard_normal(60))
    return texture + 0.5 * rng.standard_normal(SWEEPS)[sweep] + rng.standard_normal(angle.size)


def test_grams_are_those_of_the_samples() -> None:
    angle, sweep, sector = layout()
    x = np.column_stack([angle, angle**2])
    y = np.cos(5.0 * angle)
    cells = cell_grams(x, y, sweep, sector)
    table = np.column_stack([np.ones(angle.size), x, y])
    assert cells.gram.shape == (SWEEPS * SECTORS, 4, 4)
    np.testing.assert_allclose(cells.total, table.T @ table, rtol=1e-12, atol=1e-9)
    chosen = (sweep == 3) & (sector == 5)
    k = int(np.flatnonzero((cells.sweep == 3) & (cells.sector == 5))[0])
    np.testing.assert_allclose(cells.gram[k], table[chosen].T @ table[chosen], rtol=1e-12, atol=1e-9)


def test_level_on_residuals_that_repeat_in_angle() -> None:
    """A slope in angle, tested at 5 %, on residuals that have none."""
    angle, sweep, sector = layout()
    rng = np.random.default_rng(11)
    clustered = plain = 0
    for _ in range(400):
        y = residual(rng, angle, sweep)
        clustered += cluster_estimate(angle[:, None], y, sweep, sector).probability([0]) < 0.05
        slope = float(angle @ (y - y.mean()) / (angle @ angle))
        left = y - y.mean() - slope * angle
        z = slope / (left.std() / np.sqrt(angle @ angle))
        plain += 2.0 * norm.sf(abs(z)) < 0.05
    assert clustered / 400 < 0.10, clustered
    assert plain / 400 > 0.4, plain


def test_true_slope_is_found_and_covered() -> None:
    angle, sweep, sector = layout()
    rng = np.random.default_rng(5)
    covered = found = 0
    for _ in range(200):
        y = residual(rng, angle, sweep) + 3.0 * angle
        one = cluster_estimate(angle[:, None], y, sweep, sector)
        covered += abs(one.value[0] - 3.0) <= one.half_width()[0]
        found += one.probability([0]) < 0.05 / 14
    assert 0.85 <= covered / 200 <= 0.995, covered
    assert found / 200 > 0.95, found


def test_nuisance_takes_its_part_and_twins_are_not_told_apart() -> None:
    angle, sweep, sector = layout()
    rng = np.random.default_rng(2)
    y = residual(rng, angle, sweep) + 3.0 * angle
    twin = np.column_stack([angle, 2.0 * angle])
    one = cluster_estimate(twin, y, sweep, sector)
    assert one.probability([0]) == one.probability([1]) == 1.0
    beside = cluster_estimate(np.column_stack([angle, angle + 1e-3 * np.sin(9.0 * angle)]), y, sweep, sector)
    assert beside.probability([0]) > 0.01


@pytest.mark.parametrize("reach", [0.5, 1.0, 1.5])
def test_separated_gives_the_share_of_wrong_choices(reach: float) -> None:
    """Two predictions differ by d; the first is true. How often does the second fit white noise better?"""
    rng = np.random.default_rng(8)
    difference = np.sin(np.arange(60))
    difference *= 2.0 * reach / np.linalg.norm(difference)
    noise = rng.standard_normal((20_000, 60))
    wrong = float(np.mean(((noise - difference) ** 2).sum(axis=1) < (noise**2).sum(axis=1)))
    square = float(difference @ difference)
    said = separated(square, float(np.sqrt(square)))
    assert abs(said.probability - wrong) < 0.012, f"said {said.probability:.4f}, happened {wrong:.4f}"
    assert said.factor * reach == pytest.approx(float(norm.isf(0.01)), rel=1e-9)


# Lines are told from humps and local textures, and chance peaks are not lines.


ORDER = 80.0


def sweeps(seed: int, period_s: float = 16.0) -> tuple[np.random.Generator, Floats, NDArray[np.int64]]:
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 160.0, 0.02)
    angle = 0.45 * np.sin(2.0 * np.pi * t / period_s)
    sweep = ((t + period_s / 4.0) // (period_s / 2.0)).astype(np.int64)
    return rng, angle, sweep


def coloured(rng: np.random.Generator, n: int) -> Floats:
    """Noise that is smooth over some tenths of a second."""
    return np.convolve(rng.standard_normal(n + 40), np.hanning(41) / 3.9, "valid")


def test_a_line_is_steady_and_everywhere() -> None:
    for seed in range(5):
        rng, angle, sweep = sweeps(seed)
        r = np.cos(ORDER * angle + 1.0) + coloured(rng, angle.size)
        line = line_of(ORDER, angle, r, sweep)
        assert line.is_line, line
        assert abs(line.amplitude - 1.0) < 0.1, line


def test_a_burst_in_one_place_is_no_line() -> None:
    for seed in range(5):
        rng, angle, sweep = sweeps(seed)
        r = 3.0 * np.exp(-0.5 * ((angle - 0.1) / 0.05) ** 2) * np.cos(ORDER * angle) + 0.3 * coloured(rng, angle.size)
        line = line_of(ORDER, angle, r, sweep)
        assert line.steady, line
        assert not line.everywhere, line


def test_the_highest_peak_of_coloured_noise_is_no_line() -> None:
    named = 0
    for seed in range(60):
        rng, angle, sweep = sweeps(seed)
        r = coloured(rng, angle.size)
        orders, amplitude = order_spectrum(angle, r)
        best = float(orders[np.argmax(amplitude)])
        named += line_of(best, angle, r, sweep).is_line
    assert named <= 2, f"lines named in noise: {named} of 60"


def test_hotelling_has_its_level() -> None:
    rng = np.random.default_rng(7)
    p = np.array([hotelling(rng.standard_normal((10, 2)) @ np.array([[2.0, 0.5], [0.0, 0.3]])) for _ in range(4000)])
    for level in (0.5, 0.1, 0.01):
        share = float(np.mean(p <= level))
        assert abs(share - level) < 4.0 * np.sqrt(level * (1.0 - level) / p.size), (level, share)
    assert hotelling(np.ones((3, 2))) == 1.0
