"""What the drive does for long: continuous torque, speed, temperatures of its motors over the duty."""

from __future__ import annotations

from functools import partial
from math import ceil, degrees, isfinite

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import down
from mbcdm_cad.checks.motors import continuous_limits
from mbcdm_cad.checks.remedies import floored, rounded
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.model.duty.heat import MEANINGLESS_C
from mbcdm_cad.model.duty.motors import SEAT_SIGMA_K, MotorDay
from mbcdm_cad.model.equilibrium import solve_equilibrium


def continuous_torque(s: Layout) -> Comparison:
    """Drum torque that motors and gearheads keep up without end, worse direction, against what the file asks."""
    loads = s.drive.loads
    wanted, stated = float(loads.lasting_Nm or 0.0), float(loads.continuous_torque_Nm or 0.0)
    note = "loads.continuous_torque_Nm" if stated >= wanted else "the payload's weight beside the axis"
    return worst(found._replace(limit=wanted, note=note) for found in continuous_limits(s))


def _longer(s: Layout) -> str:
    """The part that limits it, and the torque that it would need."""
    found = continuous_torque(s)
    if found.actual <= 0.0:
        return "choose a motor of higher rated torque or a gearhead of higher ratio"
    share = found.limit / found.actual
    if "motor's rated" in found.subject:
        needed = rounded(s.drive.motor.rated_torque_mNm * share, ceil)
        return f"choose a motor of about {needed} mN m or more, or lower loads.continuous_torque_Nm"
    needed = rounded(s.drive.gearhead.rated_torque_mNm * share, ceil)
    return (
        f"choose a {s.drive.mounted} of about {needed} mN m or more continuously, or lower loads.continuous_torque_Nm "
        f"to at most {floored(found.actual)}"
    )


def speed(s: Layout) -> Comparison:
    """Speed that the drum reaches at the bus voltage against the continuous torque, or the peak torque without one."""
    drive, wanted = s.drive, float(s.drive.loads.speed_deg_s or 0.0)
    motor, volts = drive.motor, drive.bus_voltage_V
    if motor.torque_constant_mNm_A is None or motor.resistance_ohm is None or volts is None:
        raise NoFigureError(
            f"the catalogue has no torque constant, resistance or voltage of {motor.name}, and loads.speed_deg_s asks "
            f"for {wanted:g} deg/s; choose a motor that has them, or add them under catalogue: motors:"
        )
    load = drive.loads.peak_torque_Nm if drive.loads.continuous_torque_Nm is None else drive.loads.continuous_torque_Nm
    loads, si = np.array([load, -load]), s.loads.si
    if drive.limits.counts_losses:
        train = s.losses.with_drive(si)
        torque = float(train.moving(loads, 1).motor_Nm.max()) - train.motor_idle_Nm
    else:
        torque = float(np.abs(solve_equilibrium(si, loads).input_torque_Nm(si)).max()) / drive.reduction.ratio
    constant = motor.torque_constant_mNm_A * 1e-3
    at_motor = max(volts - motor.resistance_ohm * torque / constant, 0.0) / constant
    turns = float(np.abs(si.input_turns).max()) * drive.reduction.ratio
    note = f"{torque * 1e3:.3g} mN m of the motor, no inductance and no iron losses counted"
    what = f"speed of the drum at {volts:g} V against {load:g} N m"
    return at_least(what, degrees(at_motor / turns), wanted, "deg/s", note)


def hottest_winding(s: Layout) -> Comparison:
    """Hottest winding in the cycle that repeats, against the limit of its insulation."""
    return worst(_winding(s, day) for day in _days(s))


def _days(s: Layout) -> tuple[MotorDay, ...]:
    """Each motor over the duty; raises ``NoFigureError`` where the cables have no tensions."""
    s.loads  # noqa: B018 - raises where there are none
    return s.motor_days


def _winding(s: Layout, day: MotorDay) -> Comparison:
    allowed = day.heat.continuous_at_Nm(s.duty.ambient_C)
    load = f"RMS torque {day.rms_Nm * 1e3:.3g} of {allowed * 1e3:.3g} mN m at {s.duty.ambient_C:g} C"
    if not isfinite(day.winding_C):
        what = f"RMS torque of the {day.name} motor, whose winding would pass {MEANINGLESS_C:g} C under the duty,"
        return at_most(what, day.rms_Nm * 1e3, allowed * 1e3, "mN m", f"too hot after {_told(day.duty_from_cold_s)}")
    note = load
    if isfinite(day.sigma_K[0]):
        note += f", one sigma {day.sigma_K[0]:.2g} K"
    if isfinite(day.duty_from_cold_s):
        note += f", too hot {_told(day.duty_from_cold_s)} after a cold start"
    return at_most(f"winding of the {day.name} motor at its hottest", day.winding_C, day.heat.limit_C, "C", note)


def _told(seconds: float) -> str:
    """A time in words."""
    if not isfinite(seconds):
        return "any time"
    return f"{seconds:.3g} s" if seconds < 120.0 else f"{seconds / 60.0:.3g} min"


def _cooler(s: Layout) -> str:
    """The continuous torque that a motor of the same heat capacity needs, and the loads that this one stands."""
    day = max(s.motor_days, key=lambda d: d.rms_Nm)
    low = day.stands_share
    if low <= 0.0:
        return f"lower loads.duty.ambient_C below the winding's limit of {day.heat.limit_C:g} C"
    needed = rounded(s.drive.motor.rated_torque_mNm / low, ceil)
    return (
        f"choose a motor of about {needed} mN m or more or a gearhead of higher ratio, or lower the torques in "
        f"loads.duty to at most {floored(low * 100.0)} % of what they are"
    )


def seat(s: Layout) -> Comparison:
    """Housing of the hottest motor against the temperature at which the printed frame that holds it creeps."""
    material = s.frame_material
    day = max(_days(s), key=lambda d: d.housing_C)
    what = f"housing of the {day.name} motor in its seat of {material.name}"
    if not isfinite(day.housing_C):
        raise NoFigureError(f"the winding of the {day.name} motor would burn under the duty; see the check duty")
    sigma = float(np.hypot(day.sigma_K[1], SEAT_SIGMA_K))
    note = f"one sigma {sigma:.2g} K" if isfinite(sigma) else "no sigma: a little more heat and the winding burns"
    if not s.duty.stated:
        return noted(
            what, day.housing_C, "C", f"{note}; no loads.duty in the file, assumed: {'; '.join(s.duty.assumed)}"
        )
    return at_most(what, day.housing_C, float(material.seat_limit_C or 0.0), "C", note)


def _asked(field: str, drive: object) -> bool:
    return getattr(getattr(drive, "loads", None), field) is not None


def _has_limit(drive: object) -> bool:
    """Whether the motors sit in a printed frame whose material has a limit."""
    layout: Layout = drive.layout  # type: ignore[attr-defined]
    return layout.printed_frame and layout.frame_material.seat_limit_C is not None


CHECKS = (
    Check(
        "continuous_torque",
        "Torque held continuously",
        "loads.continuous_torque_Nm; motor and gearhead catalogue",
        continuous_torque,
        adjust=(down("loads.continuous_torque_Nm"),),
        advice=_longer,
        applies=lambda drive: drive.loads.lasting_Nm is not None,
    ),
    Check(
        "speed",
        "Speed of the drum under load",
        "loads.speed_deg_s; motor catalogue: constant, resistance, voltage",
        speed,
        adjust=(down("transmission.input_to_drum"), down("loads.speed_deg_s")),
        advice="choose a gearhead of lower ratio, a higher drive.bus_voltage_V or a faster motor",
        applies=partial(_asked, "speed_deg_s"),
    ),
    Check(
        "duty",
        "Windings over the duty",
        "loads.duty; two-node model: docs/heat.md",
        hottest_winding,
        advice=_cooler,
        applies=partial(_asked, "duty"),
    ),
    Check(
        "seat_temperature",
        "Seats of the motors in a printed frame",
        "loads.duty; two-node model: docs/heat.md; material catalogue",
        seat,
        advice="choose a larger motor, a metal frame or a printed material that stands more, or lower loads.duty",
        applies=_has_limit,
    ),
)
