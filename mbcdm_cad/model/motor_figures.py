"""Limits of the motor itself: torque from current, copper loss, speed at the bus voltage, inertia.

A motor is a DC machine between two terminals (K torque constant, R resistance, V bus voltage, I current):

    torque      M = K I                 copper loss   P = R I^2 = R (M / K)^2
    speed       w <= (V - R I) / K      no load       w_0 = V / K

A sinusoidal drive has the same copper loss for the same torque; inductance, iron losses and friction are left out, so
that the speed at high load is an upper bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

# Largest number of points of torque over speed, including those at which the voltage begins to limit a torque.
CURVE_POINTS = 9


@dataclass(frozen=True)
class SpeedPoint:
    """Torque (N m) that the drum holds in both directions at one speed: continuously, and for a short time."""

    drum_speed_deg_s: float
    continuous_Nm: float
    peak_Nm: float


@dataclass(frozen=True)
class MotorFigures:
    """Figures of one motor of the drive, and of the drum that all inputs turn together.

    Losses are those of one motor. ``at_peak_load_*``: at the required peak torque of the design, the input that
    carries most of it. ``reflected_inertia_kg_m2``: of all rotors, at the drum.
    """

    bus_voltage_V: float
    continuous_torque_mNm: float
    peak_torque_mNm: float
    continuous_loss_W: float
    peak_loss_W: float
    no_load_speed_rad_s: float
    drum_no_load_speed_deg_s: float
    at_peak_load_torque_mNm: float
    at_peak_load_current_A: float
    at_peak_load_loss_W: float
    at_peak_load_drum_speed_deg_s: float
    reflected_inertia_kg_m2: float
    curve: tuple[SpeedPoint, ...]


def motor_figures(drive: Drive, d: DriveSI, peak_input_Nm: float, cap_Nm: float) -> MotorFigures | None:
    """The figures; None where the catalogue holds no electrical values of the motor.

    ``peak_input_Nm``: torque of the input that carries most at the design's peak torque. ``cap_Nm``: limit of the
    torque at the drum from other causes than the motors (strength, slack, slip, gearhead).
    """
    motor, gear, volts = drive.motor, drive.reduction, drive.bus_voltage_V
    constant_mNm_A, ohms = motor.torque_constant_mNm_A, motor.resistance_ohm
    if constant_mNm_A is None or ohms is None or volts is None:
        return None
    constant = constant_mNm_A * 1e-3
    turns = float(np.abs(d.input_turns).max()) * gear.ratio  # of the motor, per turn of the drum
    train = drive.layout.losses.with_drive(d)
    rated, peak = motor.rated_torque_mNm * 1e-3, motor.peak_torque_mNm * 1e-3

    def loss_W(torque_Nm: float) -> float:
        return ohms * (torque_Nm / constant) ** 2

    def speed_rad_s(torque_Nm: float) -> float:
        return max(volts - ohms * torque_Nm / constant, 0.0) / constant

    def held_Nm(speeds_rad_s: Floats, most_Nm: float) -> list[float]:
        """Torque at the drum, weaker direction and input, with ``most_Nm`` limited by the voltage at each speed."""
        left = np.maximum(volts - constant * speeds_rad_s, 0.0) * constant / ohms
        given, most = np.minimum(left, most_Nm), gear.max_torque_mNm * 1e-3
        if drive.limits.counts_losses:
            limit = np.minimum(train.output_Nm(given), most)
            ways = [train.raised_Nm(limit, way).min(axis=0) for way in (1, -1)]
        else:
            limit, many = np.minimum(given * gear.ratio, most), d.spread(len(speeds_rad_s))
            ways = [torque_at_input_limit_Nm(many, limit, way).min(axis=0) for way in (1, -1)]
        return [min(float(torque), cap_Nm) for torque in np.minimum(*ways)]

    no_load, asked = volts / constant, peak_input_Nm / gear.ratio
    if drive.limits.counts_losses:
        peak_load = drive.loads.peak_torque_Nm
        # At the shaft, as the catalogue's torques are: the motor's own friction is in none of them.
        asked = float(train.moving(np.array([peak_load, -peak_load]), 1).motor_Nm.max()) - train.motor_idle_Nm
    to_drum = float(np.degrees(1.0 / turns))
    corners = (speed_rad_s(rated), speed_rad_s(peak))
    speeds = np.unique([*np.linspace(0.0, no_load, CURVE_POINTS - len(corners)), *corners])
    return MotorFigures(
        bus_voltage_V=volts,
        continuous_torque_mNm=rated * 1e3,
        peak_torque_mNm=peak * 1e3,
        continuous_loss_W=loss_W(rated),
        peak_loss_W=loss_W(peak),
        no_load_speed_rad_s=no_load,
        drum_no_load_speed_deg_s=no_load * to_drum,
        at_peak_load_torque_mNm=asked * 1e3,
        at_peak_load_current_A=asked / constant,
        at_peak_load_loss_W=loss_W(asked),
        at_peak_load_drum_speed_deg_s=speed_rad_s(asked) * to_drum,
        reflected_inertia_kg_m2=float(drive.rotor_at_input_kg_m2 * (np.asarray(d.input_turns) ** 2).sum()),
        curve=tuple(
            SpeedPoint(float(speed) * to_drum, continuous, moment)
            for speed, continuous, moment in zip(speeds, held_Nm(speeds, rated), held_Nm(speeds, peak), strict=True)
        ),
    )
