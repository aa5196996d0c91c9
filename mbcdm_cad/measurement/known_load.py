"""The load of a run that no sensor measured but that is known: none, or a weight on an arm at the output."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from mbcdm_cad.design.blocks import STANDARD_GRAVITY_M_S2
from mbcdm_cad.measurement.schema import Pendulum
from mbcdm_cad.routes import Floats

# The acceleration is that of a curve of fifth order over this share of the motion's period (2 pi times angle over
# speed, RMS): long against noise, and 0.1 % wrong for a sine.
SHARE_OF_PERIOD, ORDER = 0.25, 5
LEAST_SAMPLES = 9


def pendulum_load_Nm(arm: Pendulum, output_rad: Floats, time_s: Floats) -> Floats:
    """Torque of a weight on an arm and of its inertia, N m (n,), > 0 where it opposes positive rotation.

    m g a sin(angle - vertical) + (J + m a^2) times the acceleration, from the measured output (n,) rad at ``time_s``.
    """
    lever = 1e-3 * arm.arm_mm
    weight = arm.mass_kg * STANDARD_GRAVITY_M_S2 * lever * np.sin(output_rad - math.radians(arm.vertical_deg))
    inertia = arm.inertia_kg_m2 + arm.mass_kg * lever**2
    return np.asarray(weight + inertia * acceleration_rad_s2(output_rad, time_s))


def motion_of(angle_rad: Floats, time_s: Floats) -> tuple[Floats, Floats]:
    """Speed and acceleration of a measured angle, (n,): curves over a quarter of the motion's period, on even times."""
    n = time_s.size
    even = np.linspace(float(time_s[0]), float(time_s[-1]), n)
    step = float(even[1] - even[0])
    # A chord between uneven samples would bend at each of them.
    angle = CubicSpline(time_s, angle_rad)(even)
    quiet = savgol_filter(angle, min(LEAST_SAMPLES, n - 1 + n % 2), ORDER, deriv=1, delta=step)
    period = 2.0 * math.pi * float(np.std(angle)) / max(float(np.std(quiet)), 1e-30)
    width = int(np.clip(SHARE_OF_PERIOD * period / step, LEAST_SAMPLES, n // 2)) // 2 * 2 + 1
    speed, acceleration = (
        np.interp(time_s, even, savgol_filter(angle, width, ORDER, deriv=order, delta=step)) for order in (1, 2)
    )
    return speed, acceleration


def acceleration_rad_s2(angle_rad: Floats, time_s: Floats) -> Floats:
    """Second derivative of a measured angle, (n,), as :func:`motion_of`."""
    return motion_of(angle_rad, time_s)[1]
