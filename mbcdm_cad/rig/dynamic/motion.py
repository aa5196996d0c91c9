"""Reference of the position loops: the drum's angle, speed and acceleration at each period."""

from __future__ import annotations

from math import pi

import numpy as np

from mbcdm_cad.routes import Floats


def standstill(duration_s: float, rate_Hz: float) -> Floats:
    """Hold zero; shape (n, 3)."""
    return np.zeros((round(duration_s * rate_Hz), 3))


def sine(amplitude_rad: float, frequency_Hz: float, cycles: float, rate_Hz: float) -> Floats:
    """A sine of the drum's angle, shape (n, 3). Its first quarter fades in, so that it starts from rest."""
    omega = 2.0 * pi * frequency_Hz
    time = np.arange(round(cycles / frequency_Hz * rate_Hz)) / rate_Hz
    rate = 4.0 * frequency_Hz
    x = np.clip(time * rate, 0.0, 1.0)
    fade = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    fade_1 = rate * 30.0 * x**2 * (1.0 - x) ** 2
    fade_2 = rate**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
    wave, wave_1 = amplitude_rad * np.sin(omega * time), amplitude_rad * omega * np.cos(omega * time)
    acceleration = -(omega**2) * wave * fade + 2.0 * wave_1 * fade_1 + wave * fade_2
    return np.stack([wave * fade, wave_1 * fade + wave * fade_1, acceleration], axis=1)
