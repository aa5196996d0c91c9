"""Lines are told from humps and local textures, and chance peaks are not lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.lines import hotelling, line_of, order_spectrum
from mbcdm_cad.routes import Floats

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
