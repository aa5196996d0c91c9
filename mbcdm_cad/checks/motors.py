"""Motor and gearhead at peak torque in both directions, and over the duty: lasting torque, speed, temperatures.

The bias torque of the preload helps one direction and hinders the other. Positive is a load that opposes positive
rotation of the drum. Where ``limits.losses`` is ``counted``, all checks count the losses of gearheads, cables and
bearings; where it is ``paper``, losses only give the warning ``motor_losses``.
"""

from math import ceil, degrees, isfinite

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Family, at_least, at_most, check, noted, worst
from mbcdm_cad.checks.design_variables import LESS_TORQUE, down
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.checks.strength import balanced_preloads, rated_input_Nm
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.duty import SEAT_SIGMA_K, MotorDay
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.heat import MEANINGLESS_C
from mbcdm_cad.model.losses import BEARINGS, MOTOR, ROPE, Train

# Ratings above this multiple of T_pre r_m are not evaluated: cables are slack long before.
_RATING_CAP = 60.0
COUNT_THEM = (
    "set limits.losses to counted, so that the rules choose motor, gearhead and ratio for it where the file leaves "
    "them open, or choose a drive.motor of higher rated torque"
)
STRONGER_GEARHEAD = "choose a stronger drive.gearhead, state what the drive does all day as loads.duty,"
_WORDS = {1: "+", -1: "-"}

AT_PEAK = Family(
    "Motor and gearhead at peak torque in both directions: the bias torque of the preload helps one and hinders the "
    "other."
)


def saturation_Nm(s: Layout, limit_Nm: float, direction: int) -> tuple[float, str]:
    """Drum torque (N m) at which the first input reaches ``limit_Nm``, and that input's name."""
    si = s.loads.si
    limit = min(limit_Nm, _RATING_CAP * float((si.preload_N * si.input_radius_m).min()))
    loads = s.once(
        f"saturation {limit!r} {direction}", lambda s: torque_at_input_limit_Nm(s.loads.si, limit, direction)
    )
    first = int(loads.argmin())
    return float(loads[first]), si.input_names[first]


def _against_peak(s: Layout, what: str, limit_Nm: float, direction: int, note: str = "") -> Comparison:
    reached, name = saturation_Nm(s, limit_Nm, direction)
    return at_least(
        f"drum torque {_WORDS[direction]} at which the {name} input reaches its {what} of {limit_Nm * 1e3:.4g} mN m",
        reached,
        s.drive.loads.peak_torque_Nm,
        "N m",
        note,
    )


def motor_torque(s: Layout, direction: int) -> Comparison:
    """Peak torque in one direction against what the motors hold."""
    if s.drive.limits.counts_losses:
        return _moved(s, direction)
    bias = s.loads.input_torque_Nm[0] * 1e3
    listed = ", ".join(f"{name} {value:+.4g}" for name, value in zip(s.drive.input_names, bias, strict=True))
    note = f"no losses counted (limits.losses: paper), preload bias {listed} mN m included"
    return _against_peak(s, "motor's rated torque", rated_input_Nm(s), direction, note)


def _stronger(s: Layout, found: Comparison) -> str:
    """Preloads without bias; where losses count, the rated torque that a motor needs at least."""
    if not s.drive.limits.counts_losses:
        return balanced_preloads(s)
    reached = found.actual
    if reached <= 0.0:
        return "choose a motor of higher rated torque or a gearhead of higher ratio"
    needed = rounded(s.drive.motor.rated_torque_mNm * s.drive.loads.peak_torque_Nm / reached, ceil)
    raised = ""
    if s.drive.stage is not None:
        ratio = rounded(s.drive.stage.ratio * s.drive.loads.peak_torque_Nm / reached, ceil)
        raised = f", or raise stage.ratio to about {ratio}"
    return f"choose a motor of about {needed} mN m or more, or a gearhead of higher ratio or efficiency{raised}"


@check("Motors hold peak torque, load +", "model, paper section 5.1; limits.losses", *LESS_TORQUE, advice_on=_stronger)
def motor_torque_forward(s: Layout) -> Comparison:
    """The motors hold peak torque in this direction at their rated torque, with losses as ``limits.losses`` says."""
    return motor_torque(s, 1)


@check("Motors hold peak torque, load -", "model, paper section 5.1; limits.losses", *LESS_TORQUE, advice_on=_stronger)
def motor_torque_back(s: Layout) -> Comparison:
    """The motors hold peak torque in this direction at their rated torque, with losses as ``limits.losses`` says."""
    return motor_torque(s, -1)


@check(
    "Gearhead's intermittent rating at peak torque",
    "gearhead catalogue",
    *LESS_TORQUE,
    advice="choose a stronger drive.gearhead",
)
def gearhead_maximum(s: Layout) -> Comparison:
    """Drum torque at the intermittent rating of the gearhead (of the motor if there is none), worse direction."""
    return _mounted(s, "intermittent rating", s.drive.reduction.max_torque_mNm * 1e-3)


def _train(s: Layout) -> Train:
    """Friction between motors and payload; raises ``NoFigureError`` where the cables have no tensions."""
    si = s.loads.si
    return s.losses.with_drive(si)


def _moved(s: Layout, direction: int) -> Comparison:
    output = float(_train(s).output_Nm(s.drive.motor.rated_torque_mNm * 1e-3))
    note = "all losses counted: gearheads, cables, bearings"
    return _raised(s, f"motor's rated torque of {s.drive.motor.rated_torque_mNm:.4g} mN m", output, direction, note)


def _raised(s: Layout, what: str, output_Nm: float, direction: int, note: str) -> Comparison:
    """Drum torque that the inputs still move with ``output_Nm`` at the gearheads, against the peak torque."""
    train = _train(s)
    loads = train.raised_Nm(output_Nm, direction)
    first = int(loads.argmin())
    subject = f"drum torque {_WORDS[direction]} that the {train.d.input_names[first]} input moves at its {what}"
    return at_least(subject, float(loads[first]), s.drive.loads.peak_torque_Nm, "N m", note)


def _count_losses(_: Layout, found: Comparison) -> str:
    reached = found.actual
    return f"{COUNT_THEM} or lower loads.peak_torque_Nm to at most {rounded(reached)}" if reached > 0.0 else COUNT_THEM


@check(
    "Motors hold peak torque with losses",
    "gearhead catalogue: efficiency; cables, bearings: docs/losses.md",
    advice_on=_count_losses,
    applies=lambda drive: not drive.limits.counts_losses,
    warn=True,
)
def motor_losses(s: Layout) -> Comparison:
    """The torque that the motors move with all losses counted, in the worse direction."""
    return worst(_moved(s, direction) for direction in (1, -1))


def _easier_to_turn(s: Layout) -> str:
    """What turns more easily, by the largest cause."""
    found = s.losses.backdrive
    if found is None:
        return ""
    most = max(found.losses, key=lambda x: float(x.torque_Nm)).kind
    if most in (ROPE, BEARINGS):
        return "choose a thinner rope"
    if s.drive.gearhead.absent:
        return (
            f"{_lower_ratio(s)}choose a motor of lower rated torque, which has less friction, or state "
            "no_load_current_A of yours in its entry under catalogue: motors"
        )
    return (
        "leave drive.motor and drive.gearhead to the rules, which choose them for loads.backdrive_Nm, or choose a "
        "gearhead of lower ratio or higher efficiency, or a motor with a shaft of its own and no gearhead"
    )


def _lower_ratio(s: Layout) -> str:
    """The ratio with which a motor on its own shaft turns as easily as asked, where it then still holds the torque."""
    found, wanted = s.losses.backdrive, s.drive.loads.backdrive_Nm
    if found is None or wanted is None:
        return ""
    motors = found.start_of_Nm(MOTOR)
    share = (wanted - (found.start_Nm - motors)) / motors
    holds = min(motor_torque(s, direction).actual for direction in (1, -1)) / s.drive.loads.peak_torque_Nm
    if not share * holds >= 1.0:
        return ""
    ratio = float(s.loads.si.input_turns.max())
    return f"lower the ratio of drum to input radius from {ratio:.4g} to about {rounded(share * ratio)}, or "


def _less_often(_: Layout, found: Comparison) -> str:
    """Advice where the duty asks more of the gearhead than it keeps up."""
    if found.actual <= 0.0 or found.limit <= 0.0:
        return f"{STRONGER_GEARHEAD} or lower loads.peak_torque_Nm"
    most = rounded(100.0 * found.actual / found.limit)
    return f"{STRONGER_GEARHEAD} or lower the loads of the duty to at most {most} % of what they are"


@check(
    "Gearhead's continuous rating over the duty",
    "gearhead catalogue; cubic mean of loads.duty: gearhead makers",
    advice_on=_less_often,
    applies=lambda drive: drive.loads.continuous_torque_Nm is None,
    warn=True,
)
def gearhead_continuous(s: Layout) -> Comparison:
    """Drum torque at the continuous rating of the gearhead (of the motor if there is none), against the duty.

    In the worse direction; the cubic mean of the duty's load counts, as gearhead makers do.
    """
    limit, duty = s.drive.reduction.rated_torque_mNm * 1e-3, s.duty
    whose = at.loads.duty if duty.stated else "an assumed duty, as the file has no loads.duty"
    found = _mounted(s, "continuous rating", limit, f"cubic mean of {whose}; hold more only for a short time")
    return found._replace(limit=duty.lasting_torque_Nm)


@check(
    "Drum turned from its side",
    "loads.backdrive_Nm; friction by cause: docs/losses.md",
    *down(at.rope.preload_N, at.transmission.input_to_drum),
    advice=_easier_to_turn,
)
def backdrive(s: Layout) -> Comparison:
    """Torque at the drum that starts to turn it from its side, motors without current."""
    found, wanted = _train(s).backdrive, s.drive.loads.backdrive_Nm
    what = "torque at the drum that turns it, motors without current"
    if found is None:
        if wanted is None:
            return noted(f"the gearheads lock; {what}: there is none, and the design file asks for none:", 0.0, "N m")
        raise NoFigureError(
            f"no torque at the drum turns the gearheads: their efficiency of {s.drive.reduction.efficiency:g} is 0.5 "
            f"or below, and loads.backdrive_Nm asks for {wanted:g} N m; choose a gearhead of higher efficiency"
        )
    most = max(found.losses, key=lambda x: float(x.torque_Nm))
    note = f"{most.name} take {float(most.torque_Nm):.3g} N m of it; one sigma of it all is {found.sigma_Nm:.2g} N m"
    if wanted is None:
        return noted(what, found.start_Nm, "N m", f"{note}; the design file asks for none")
    return at_most(what, found.start_Nm, wanted, "N m", note)


def _mounted(s: Layout, rating: str, limit_Nm: float, note: str = "") -> Comparison:
    """Drum torque at a rating at the inputs, in the worse direction."""
    what = f"{s.drive.mounted}'s {rating}"
    if not s.drive.limits.counts_losses:
        return worst(_against_peak(s, what, limit_Nm, sign, note) for sign in (1, -1))
    return worst(_raised(s, what, limit_Nm, sign, note) for sign in (1, -1))


FOR_LONG = Family("What the drive does for long: continuous torque, speed, temperatures of its motors over the duty.")


def _longer(s: Layout, found: Comparison) -> str:
    """The part that limits it, and the torque that it would need."""
    if found.actual <= 0.0:
        return "choose a motor of higher rated torque or a gearhead of higher ratio"
    share = found.limit / found.actual
    if "motor's rated" in found.subject:
        needed = rounded(s.drive.motor.rated_torque_mNm * share, ceil)
        return f"choose a motor of about {needed} mN m or more, or lower loads.continuous_torque_Nm"
    needed = rounded(s.drive.gearhead.rated_torque_mNm * share, ceil)
    return (
        f"choose a {s.drive.mounted} of about {needed} mN m or more continuously, or lower loads.continuous_torque_Nm "
        f"to at most {rounded(found.actual)}"
    )


@check(
    "Torque held continuously",
    "loads.continuous_torque_Nm; motor and gearhead catalogue",
    *down(at.loads.continuous_torque_Nm),
    advice_on=_longer,
    applies=lambda drive: drive.loads.lasting_Nm is not None,
)
def continuous_torque(s: Layout) -> Comparison:
    """Drum torque that motors and gearheads keep up without end, worse direction, against what the file asks."""
    loads = s.drive.loads
    wanted, stated = float(loads.lasting_Nm or 0.0), float(loads.continuous_torque_Nm or 0.0)
    note = at.loads.continuous_torque_Nm if stated >= wanted else "the payload's weight beside the axis"
    limits = [motor_torque(s, direction) for direction in (1, -1)]
    if not s.drive.gearhead.absent:
        limits.append(gearhead_continuous(s))
    return worst(found._replace(limit=wanted, note=note) for found in limits)


@check(
    "Speed of the drum under load",
    "loads.speed_deg_s; motor catalogue: constant, resistance, voltage",
    *down(at.transmission.input_to_drum, at.loads.speed_deg_s),
    advice="choose a gearhead of lower ratio, a higher drive.bus_voltage_V or a faster motor",
    applies=lambda drive: drive.loads.speed_deg_s is not None,
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


def _cooler(s: Layout) -> str:
    """The continuous torque that a motor of the same heat capacity needs, and the loads that this one stands."""
    day = max(s.motor_days, key=lambda d: d.rms_Nm)
    low = day.stands_share
    if low <= 0.0:
        return f"lower loads.duty.ambient_C below the winding's limit of {day.heat.limit_C:g} C"
    needed = rounded(s.drive.motor.rated_torque_mNm / low, ceil)
    return (
        f"choose a motor of about {needed} mN m or more or a gearhead of higher ratio, or lower the torques in "
        f"loads.duty to at most {rounded(low * 100.0)} % of what they are"
    )


@check(
    "Windings over the duty",
    "loads.duty; two-node model: docs/heat.md",
    advice=_cooler,
    applies=lambda drive: drive.loads.duty is not None,
)
def duty(s: Layout) -> Comparison:
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


@check(
    "Seats of the motors in a printed frame",
    "loads.duty; two-node model: docs/heat.md; material catalogue",
    advice="choose a larger motor, a metal frame or a printed material that stands more, or lower loads.duty",
    applies=lambda drive: (s := layout_of(drive)).printed_frame and s.frame_material.seat_limit_C is not None,
)
def seat_temperature(s: Layout) -> Comparison:
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
