"""What a duty asks of each motor: torque in each piece of the cycle, temperatures, how long it holds the peak load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, sqrt

import numpy as np

from mbcdm_cad.model.duty.cycle import Duty
from mbcdm_cad.model.duty.heat import STANDSTILL_SHARE, MotorHeat, Temperatures
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.losses.train import Train
from mbcdm_cad.routes import Floats

# Temperature of a seat beside the housing's, a standard deviation of the estimate, K.
SEAT_SIGMA_K = 5.0
# More than so many times the torques of a duty are not looked for.
MOST_SHARE = 10.0


def motor_torques_Nm(train: Train, load_Nm: Floats, speed: Floats) -> Floats:
    """Torque at each motor's shaft, (n_inputs, n), under loads while the drum moves with ``speed``, or holds at zero.

    Moving counts all losses but the motor's own friction, which the catalogue's torques do not contain either. While
    the drum holds, friction may help or hinder, and is left out; the torque that the preload puts on an input is in it.
    """
    load, speed = np.asarray(load_Nm, float), np.asarray(speed, float)
    # Against the load is the way of the motion where load and speed have one sign; see Train.moving without a load.
    way = np.where(speed * np.where(load < 0.0, -1.0, 1.0) >= 0.0, 1, -1)
    kinds, of = np.unique(np.stack([load, np.where(speed == 0.0, 0, way)]), axis=1, return_inverse=True)
    of = np.asarray(of).reshape(-1)
    found = np.zeros((train.d.n_inputs, kinds.shape[1]))
    for sign in (0, 1, -1):
        at = kinds[1] == sign
        if not at.any():
            continue
        if sign == 0:
            held = solve_equilibrium(train.d, kinds[0, at])
            found[:, at] = np.abs(held.input_torque_Nm(train.d)) / train.gear_ratio
        else:
            found[:, at] = np.abs(train.moving(kinds[0, at], sign).motor_Nm - train.motor_idle_Nm)
    return np.asarray(found[:, of])


@dataclass(frozen=True, eq=False)
class MotorDay:
    """One motor over the duty. ``heat_torque_Nm``: in each piece, the torque that heats it as much.

    It is larger than the torque where a brushless motor holds at standstill. ``peak_Nm``: the torque that the drive's
    peak load asks of it, held.
    """

    name: str
    heat: MotorHeat
    duty: Duty
    torque_Nm: Floats
    heat_torque_Nm: Floats
    peak_Nm: float

    @property
    def rms_Nm(self) -> float:
        """Root mean square of the torque that heats it."""
        return sqrt(float((self.duty.time_s * self.heat_torque_Nm**2).sum()) / self.duty.period_s)

    @cached_property
    def repeated(self) -> Temperatures | None:
        """Temperatures of the cycle that repeats; None where the winding would get hotter without end."""
        return self.heat.repeated(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C)

    @property
    def winding_C(self) -> float:
        """Hottest temperature of the winding in the cycle that repeats."""
        return inf if self.repeated is None else self.repeated.hottest_winding_C

    @property
    def housing_C(self) -> float:
        """Hottest temperature of the housing in the cycle that repeats."""
        return inf if self.repeated is None else self.repeated.hottest_housing_C

    @cached_property
    def sigma_K(self) -> tuple[float, float]:
        """Standard deviations of both temperatures, from mounting and from figures that are estimates."""
        found = np.zeros(2)
        for pair in self.heat.sigmas():
            at = [m.repeated(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C) for m in pair]
            if any(t is None for t in at):
                return inf, inf
            high, low = (np.array([t.hottest_winding_C, t.hottest_housing_C]) for t in at if t is not None)
            found += (0.5 * (high - low)) ** 2
        winding, housing = np.sqrt(found)
        return float(winding), float(housing)

    @property
    def peak_from_cold_s(self) -> float:
        """How long it holds the peak load, winding and housing as cold as the air at the start."""
        return self.heat.time_to_limit_s(self.peak_Nm, self.duty.ambient_C)

    @property
    def peak_from_warm_s(self) -> float:
        """How long it holds the peak load from the hottest moment of the duty."""
        if self.repeated is None:
            return 0.0
        k = int(self.repeated.winding_C.argmax())
        start = float(self.repeated.winding_C[k]), float(self.repeated.housing_C[k])
        return self.heat.time_to_limit_s(self.peak_Nm, self.duty.ambient_C, start)

    @cached_property
    def stands_share(self) -> float:
        """Torques of the duty that its winding stands, over those it has; at most :data:`MOST_SHARE`."""
        low, high = 0.0, MOST_SHARE
        for _ in range(24):
            middle = 0.5 * (low + high)
            found = self.heat.repeated(self.duty.time_s, middle * self.heat_torque_Nm, self.duty.ambient_C)
            fits = found is not None and found.hottest_winding_C <= self.heat.limit_C
            low, high = (middle, high) if fits else (low, middle)
        return low

    @property
    def duty_from_cold_s(self) -> float:
        """How long the duty may go on from cold; infinite where it may without end."""
        if self.winding_C <= self.heat.limit_C:
            return inf
        return self.heat.cycles_to_limit_s(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C)


def motor_days(
    train: Train, heat: MotorHeat, duty: Duty, peak_torque_Nm: float, names: Sequence[str]
) -> tuple[MotorDay, ...]:
    """Every motor of a drive over its duty."""
    torque = motor_torques_Nm(train, duty.torque_Nm, duty.speed_deg_s)
    peaks = motor_torques_Nm(train, np.array([peak_torque_Nm, -peak_torque_Nm]), np.zeros(2)).max(axis=1)
    still = 1.0 / STANDSTILL_SHARE if heat.brushless else 1.0
    warms = torque * np.where(duty.speed_deg_s == 0.0, still, 1.0)
    return tuple(
        MotorDay(name, heat, duty, torque[i], warms[i], still * float(peaks[i])) for i, name in enumerate(names)
    )
