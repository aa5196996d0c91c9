"""The marginal likelihood is that of the dense Gaussian, the noise is found by likelihood, a run is judged by both."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from scipy.stats import multivariate_normal

from benchmarks.judge import judge_rival
from benchmarks.judge_cases import cases
from benchmarks.rival.evidence import SCALES, NoiseModel, Whitened, noise_model


def test_evidence_is_the_dense_gaussian() -> None:
    rng, n = np.random.default_rng(1), 400
    noise = NoiseModel(1.0, 0.8, 0.2, 0.01, (0,))
    t = 0.01 * np.arange(n)
    nuisances, curves = np.stack([np.ones(n), t], axis=1), rng.normal(size=(n, 6))
    jacobian, sd = np.stack([np.sin(3.0 * t), np.cos(3.0 * t)], axis=1), np.array([2.0, 0.5])
    y = jacobian @ [1.5, -0.2] + 0.3 * curves[:, 0] + rng.normal(size=n)
    white = Whitened(noise, nuisances, curves)
    found = white.evidence(white.parts(np.column_stack([jacobian, y])), sd, n)
    dense = noise.white_rad**2 * np.eye(n) + noise.coloured_rad**2 * toeplitz(np.exp(-t / noise.memory_s))
    dense += nuisances @ nuisances.T + (jacobian * sd**2) @ jacobian.T

    def log(scale: float) -> float:
        return float(multivariate_normal(np.zeros(n), dense + scale**2 * curves @ curves.T).logpdf(y))

    constant = 0.5 * n * np.log(2.0 * np.pi)
    # The innovations filter is that of a steady state, which the first samples do not have.
    assert found.log - constant == pytest.approx(log(found.scale_rad), abs=1.0)
    least = SCALES[0] * noise.floor_rad
    assert found.unknown_odds == pytest.approx(log(found.scale_rad) - log(least), abs=0.5)


@pytest.mark.parametrize(("share", "memory_s"), [(0.0, 0.0), (0.3, 0.5), (0.9, 5.0)])
def test_noise_is_found_by_likelihood(share: float, memory_s: float) -> None:
    rng, n, step = np.random.default_rng(2), 20_000, 0.01
    phi = np.exp(-step / memory_s) if memory_s else 0.0
    slow = lfilter([np.sqrt(1.0 - phi**2)], [1.0, -phi], rng.normal(size=n)) * np.sqrt(share)
    found = noise_model(slow + np.sqrt(1.0 - share) * rng.normal(size=n), step, (0,), 0.0)
    assert found.white_rad == pytest.approx(np.sqrt(1.0 - share), rel=0.1)
    assert found.floor_rad == pytest.approx(1.0, rel=0.3)
    # Of a long memory only the square over the memory is known.
    if share:
        assert found.coloured_rad**2 / found.memory_s == pytest.approx(share / memory_s, rel=0.4)


def test_a_run_is_judged_by_evidence() -> None:
    row = judge_rival(next(case for case in cases() if case.name == "null: clean"))
    assert (row["score"], row["said"], row["intervals"]) == ("right", "none", [0, 0]), row
