"""What a design's drive does all day and how warm it gets: its duty from the file, its motors from the catalogue."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.design.duty_record import RecordedDuty
from mbcdm_cad.model.duty import DEFAULT_PERIOD_S, Duty, MotorDay, default_duty, motor_days, of_record, of_rows
from mbcdm_cad.model.heat import RATED_AT_C, motor_heat

if TYPE_CHECKING:
    from mbcdm_cad.layouts.base import Layout


def duty_of(layout: Layout) -> Duty:
    """The duty that the design file states, or the assumed one."""
    drive = layout.drive
    stated, travel = drive.loads.duty, 2.0 * drive.half_travel_deg
    if stated is None:
        return default_duty(drive.loads.peak_torque_Nm, travel, RATED_AT_C, drive.loads.carried.weight_torque_Nm)
    assumed = []
    period, ambient = stated.period_s, stated.ambient_C
    recorded = isinstance(stated, RecordedDuty)
    if period is None and not recorded:
        period = DEFAULT_PERIOD_S
        assumed.append(f"a cycle takes {period:g} s")
    if ambient is None:
        ambient = RATED_AT_C
        assumed.append(f"ambient {ambient:g} C")
    if isinstance(stated, RecordedDuty):
        found = stated.samples
        time, angle, torque = (np.array(values) for values in (found.time_s, found.angle_deg, found.torque_Nm))
        return of_record(time, angle, torque, ambient, assumed)
    return of_rows(stated.rows, period or DEFAULT_PERIOD_S, travel, ambient, assumed)


def motors_of(layout: Layout) -> tuple[MotorDay, ...]:
    """Each motor of a design over its duty. Raises ``ModelError`` where the routes have no free span."""
    drive = layout.drive
    peak = drive.loads.peak_torque_Nm
    return motor_days(layout.losses, motor_heat(drive.motor), layout.duty, peak, drive.input_names)
