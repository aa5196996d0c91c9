"""Friction of single parts: rope at a tangent point, ball bearing, gearhead, motor.

All of it is dry: it follows load and direction, not speed. Values that no catalogue entry holds are estimates and carry
a sigma, the standard deviation of their logarithm. Slip on the wraps is not here: what it loses is the area of the loop
that :mod:`mbcdm_cad.model.hysteresis` computes.
"""

from __future__ import annotations

from math import inf

import numpy as np

from mbcdm_cad.routes import Floats

# Loss of a wire rope over a whole sheave, 0.7 (d/D)^1.33 of its tension. Form: Feyrer, Wire Ropes, on the efficiency of
# sheaves. The factor is an estimate: a sheave with its bearing then has an efficiency of 0.98 at D/d from 20 to 25, a
# rule of rope makers.
ROPE_FACTOR, ROPE_EXPONENT = 0.7, 1.33
ROPE_SIGMA, FIBRE_SIGMA = 0.45, 0.7
# Ball bearings with deep grooves and no rubbing seal: 0.0015 (SKF), 0.0010 to 0.0015 (Koyo); at the start up to twice.
BEARING_MU, BEARING_START, BEARING_SIGMA = 0.0015, 2.0, 0.3
# Shares of loss in proportion to load vary between gearheads of one kind (estimate).
GEARHEAD_SIGMA = 0.2
# Torque at its output that turns an unloaded planetary gearhead, over its continuous torque: an estimate.
GEARHEAD_IDLE_SHARE, GEARHEAD_IDLE_SIGMA = 0.03, 0.7
# Friction of a small motor without current, over its continuous torque: an estimate, from no-load currents of some
# catalogue motors (3 to 5 %).
MOTOR_IDLE_SHARE, MOTOR_IDLE_SIGMA = 0.04, 0.5
# The same where the catalogue has the no-load current: brushes and grease vary between motors of one type (estimate).
MOTOR_STATED_SIGMA = 0.3
# Equivalent load of a ball bearing, ISO 281: 0.56 F_r + Y F_a where that is above F_r; Y for a light axial load.
_RADIAL_SHARE, _AXIAL_SHARE = 0.56, 2.0


def tangent_share(rope_mm: Floats | float, pulley_mm: Floats | float) -> Floats:
    """Share of its tension that a rope loses as it bends on to a pulley or off it, half of that of a whole sheave.

    ``pulley_mm``: diameter at the rope's centre line. The two diameters may have any one unit.
    """
    return np.asarray(0.5 * ROPE_FACTOR * (np.asarray(rope_mm, float) / pulley_mm) ** ROPE_EXPONENT)


def bearing_torque_Nm(radial_N: Floats | float, axial_N: float, bore_m: float) -> Floats:
    """Friction of a running ball bearing, (mu/2) P d, N m (SKF)."""
    radial = np.asarray(radial_N, float)
    equivalent = np.maximum(radial, _RADIAL_SHARE * radial + _AXIAL_SHARE * axial_N)
    return np.asarray(0.5 * BEARING_MU * equivalent * bore_m)


def gearhead_share(efficiency: float) -> float:
    """Torque that a gearhead loses over the torque at its output, both at the output, 1/eta - 1; the same both ways."""
    return 1.0 / efficiency - 1.0


def backward_efficiency(efficiency: float) -> float:
    """Share of the power put in at its output that a gearhead gives at its motor's side, 2 - 1/eta.

    It follows from a loss in proportion to the load. At an efficiency of 0.5 and below it is 0: self-locking.
    """
    return max(1.0 - gearhead_share(efficiency), 0.0)


def motor_idle_mNm(rated_mNm: float, stated_mNm: float | None) -> float:
    """Friction of a motor without current: what the catalogue states, else a share of its continuous torque."""
    return MOTOR_IDLE_SHARE * rated_mNm if stated_mNm is None else stated_mNm


def turned_back_mNm(motor_idle_mNm: float, ratio: float, efficiency: float, gear_rated_mNm: float) -> float:
    """Torque at a gearhead's output that turns it and the motor before it; infinite where the gearhead locks.

    A motor without a gearhead has ratio and efficiency 1 and ``gear_rated_mNm`` 0.
    """
    back = backward_efficiency(efficiency)
    return (GEARHEAD_IDLE_SHARE * gear_rated_mNm + ratio * motor_idle_mNm) / back if back > 0.0 else inf
