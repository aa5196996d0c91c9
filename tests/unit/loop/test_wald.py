"""Clustered tests hold their level on residuals that repeat in angle or wander; plain ones do not."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from benchmarks.studies.clustered import cell_grams, cluster_estimate
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
