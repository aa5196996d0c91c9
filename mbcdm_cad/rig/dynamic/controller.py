"""The position loop of one input: a cascade of P on position and PI on velocity, with feed-forward.

    v_command = v_ref + p (x_ref - x)
    torque    = J (a_ref + 2 w (v_command - v) + w^2 integral(v_command - v)),  p = 2 pi f,  w = 3 p

so with a free inertia J the poles are those of s^3 + 6 p s^2 + 15 p^2 s + 9 p^3 and ``f``, the position bandwidth, is
the only figure to choose. v is the difference of the encoder's samples after a first-order filter. While the command is
beyond the torque limit the integral does not grow (anti-windup).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, pi

from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

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
        for name in ("inertia_kg_m2", "torque_limit_Nm", "bandwidth_Hz", "rate_Hz", "velocity_filter_Hz"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it > 0")
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
