"""Smoothing of a moving signal whose samples are not evenly spaced."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.measurement.run import smoothed, smoothed_at


def test_jitter_and_gaps_of_the_logger_do_not_move_the_mean() -> None:
    rng = np.random.default_rng(5)
    step = 0.02
    times = (np.arange(2000) + 0.2 * rng.uniform(-0.5, 0.5, 2000)) * step
    times = times[(times < 12.0) | (times > 12.3)]
    angle = 0.5 * np.sin(0.8 * times)
    before = np.abs(smoothed(angle, 0.05, step) - angle).max()
    after = np.abs(smoothed_at(angle, times, 0.05, step) - angle)
    # A window of 0.05 s blurs a sine of this speed by 0.5 0.8^2 s^2 / 2 with s^2 = 5.3e-4 s^2 for two means of three.
    blur = 0.5 * 0.8**2 * 5.3e-4 / 2.0
    assert before > 5e-4 and np.quantile(after, 0.99) < 2.0 * blur and after.max() < 0.2 * before, (before, after.max())
