"""The position loop of one input: its reference, and a cascade of P on position and PI on velocity."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi

import numpy as np
from scipy.signal.windows import tukey

from mbcdm_cad.rig.dynamic.train import require_positive
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# Share of a chirp in which it fades in, and out.
FADE_SHARE = 0.02


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


def chirp(acceleration_rad_s2: float, from_Hz: float, to_Hz: float, duration_s: float, rate_Hz: float) -> Floats:
    """A sweep of the drum's angle, (n, 3): its acceleration of one size, its frequency rising or falling evenly.

    It fades in and out over ``FADE_SHARE`` of the time each.
    """
    time = np.arange(round(duration_s * rate_Hz)) / rate_Hz
    phase = 2.0 * pi * (from_Hz + 0.5 * (to_Hz - from_Hz) * time / duration_s) * time
    wave = acceleration_rad_s2 * np.sin(phase) * tukey(time.size, 2.0 * FADE_SHARE)
    rate = 2j * pi * np.fft.rfftfreq(time.size, 1.0 / rate_Hz)
    # Nothing below the sweep: an angle that wanders off would be integrated from the fades.
    spectrum = np.where(np.abs(rate) > pi * min(from_Hz, to_Hz), np.fft.rfft(wave), 0.0)
    rate[0] = 1.0
    return np.stack([np.fft.irfft(spectrum / rate**k, time.size) for k in (2, 1, 0)], axis=1)


# Columns of a row of gains.
POSITION, VELOCITY, INTEGRAL, ACCELERATION, FILTER, PERIOD, LIMIT = range(7)
# Columns of a row of states.
SUM, LAST, SPEED = range(3)
STATES = 3


@dataclass(frozen=True)
class ControllerSpec:
    """A position loop. ``inertia_kg_m2`` is the total inertia that the input moves, reflected to the input."""

    inertia_kg_m2: float
    torque_limit_Nm: float
    bandwidth_Hz: float = 5.0
    rate_Hz: float = 1000.0
    velocity_filter_Hz: float = 100.0

    def __post_init__(self) -> None:
        require_positive(self, "inertia_kg_m2", "torque_limit_Nm", "bandwidth_Hz", "rate_Hz", "velocity_filter_Hz")
        if self.bandwidth_Hz * 20.0 > self.rate_Hz:
            raise ValueError(f"bandwidth_Hz {self.bandwidth_Hz} needs a rate_Hz of 20 times that, got {self.rate_Hz}")

    def gains(self) -> tuple[float, ...]:
        """A row of gains for :func:`control`."""
        p = 2.0 * pi * self.bandwidth_Hz
        w = 3.0 * p
        keep = exp(-2.0 * pi * self.velocity_filter_Hz / self.rate_Hz)
        J = self.inertia_kg_m2
        return (p, 2.0 * w * J, w * w * J, J, keep, 1.0 / self.rate_Hz, self.torque_limit_Nm)


@compiled
def control(gains: Floats, state: Floats, reference: Floats, measured: float) -> float:
    """Torque command at the input, N m, within the limit; ``reference`` is (angle, speed, acceleration)."""
    period = gains[PERIOD]
    raw = (measured - state[LAST]) / period
    state[LAST] = measured
    state[SPEED] = gains[FILTER] * state[SPEED] + (1.0 - gains[FILTER]) * raw
    error = reference[1] + gains[POSITION] * (reference[0] - measured) - state[SPEED]
    change = gains[INTEGRAL] * period * error
    command = gains[ACCELERATION] * reference[2] + gains[VELOCITY] * error + state[SUM] + change
    limit = gains[LIMIT]
    if command > limit:
        state[SUM] += min(change, 0.0)
        return float(limit)
    if command < -limit:
        state[SUM] += max(change, 0.0)
        return float(-limit)
    state[SUM] += change
    return float(command)
