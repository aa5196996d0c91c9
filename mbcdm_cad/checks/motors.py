"""Motor and gearhead at peak torque in both directions: the bias torque of the preload helps one and hinders the other.

Positive is a load that opposes positive rotation of the drum. Where ``limits.losses`` is ``counted``, all checks count
the losses of gearheads, cables and bearings; where it is ``paper``, losses only give the warning ``motor_losses``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import ceil

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import down
from mbcdm_cad.checks.remedies import floored, rounded
from mbcdm_cad.checks.strength import balanced_preloads, rated_input_Nm
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.losses.train import BEARINGS, MOTOR, ROPE, Train

# Ratings above this multiple of T_pre r_m are not evaluated: cables are slack long before.
_RATING_CAP = 60.0
COUNT_THEM = (
    "set limits.losses to counted, so that the rules choose motor, gearhead and ratio for it where the file leaves "
    "them open, or choose a drive.motor of higher rated torque"
)
STRONGER_GEARHEAD = "choose a stronger drive.gearhead, state what the drive does all day as loads.duty,"
_WORDS = {1: "+", -1: "-"}


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


def motor_torque(direction: int, s: Layout) -> Comparison:
    """The motors hold peak torque in this direction at their rated torque, with losses as ``limits.losses`` says."""
    if s.drive.limits.counts_losses:
        return _moved(s, direction)
    bias = s.loads.input_torque_Nm[0] * 1e3
    listed = ", ".join(f"{name} {value:+.4g}" for name, value in zip(s.drive.input_names, bias, strict=True))
    note = f"no losses counted (limits.losses: paper), preload bias {listed} mN m included"
    return _against_peak(s, "motor's rated torque", rated_input_Nm(s), direction, note)


def motor_losses(s: Layout) -> Comparison:
    """The torque that the motors move with all losses counted, in the worse direction."""
    return worst(_moved(s, direction) for direction in (1, -1))


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
    holds = min(motor_torque(direction, s).actual for direction in (1, -1)) / s.drive.loads.peak_torque_Nm
    if not share * holds >= 1.0:
        return ""
    ratio = float(s.loads.si.input_turns.max())
    return f"lower the ratio of drum to input radius from {ratio:.4g} to about {floored(share * ratio)}, or "


def gearhead_maximum(s: Layout) -> Comparison:
    """Drum torque at the intermittent rating of the gearhead (of the motor if there is none), worse direction."""
    return _mounted(s, "intermittent rating", s.drive.reduction.max_torque_mNm * 1e-3)


def gearhead_continuous(s: Layout) -> Comparison:
    """Drum torque at the continuous rating of the gearhead (of the motor if there is none), against the duty.

    In the worse direction; the cubic mean of the duty's load counts, as gearhead makers do.
    """
    limit, duty = s.drive.reduction.rated_torque_mNm * 1e-3, s.duty
    whose = "loads.duty" if duty.stated else "an assumed duty, as the file has no loads.duty"
    found = _mounted(s, "continuous rating", limit, f"cubic mean of {whose}; hold more only for a short time")
    return found._replace(limit=duty.lasting_torque_Nm)


def continuous_limits(s: Layout) -> Iterator[Comparison]:
    """Drum torque that motors and gearheads keep up, each in both directions, losses as ``limits.losses`` says."""
    for direction in (1, -1):
        yield motor_torque(direction, s)
    if not s.drive.gearhead.absent:
        yield gearhead_continuous(s)


def _mounted(s: Layout, rating: str, limit_Nm: float, note: str = "") -> Comparison:
    """Drum torque at a rating at the inputs, in the worse direction."""
    what = f"{s.drive.mounted}'s {rating}"
    if not s.drive.limits.counts_losses:
        return worst(_against_peak(s, what, limit_Nm, sign, note) for sign in (1, -1))
    return worst(_raised(s, what, limit_Nm, sign, note) for sign in (1, -1))


def _less_torque(measure: Callable[[Layout], Comparison], otherwise: str, s: Layout) -> str:
    reached = measure(s).actual
    return f"{otherwise} or lower loads.peak_torque_Nm to at most {floored(reached)}" if reached > 0.0 else otherwise


def _less_often(s: Layout) -> str:
    """Advice where the duty asks more of the gearhead than it keeps up."""
    found = gearhead_continuous(s)
    if found.actual <= 0.0 or found.limit <= 0.0:
        return f"{STRONGER_GEARHEAD} or lower loads.peak_torque_Nm"
    most = floored(100.0 * found.actual / found.limit)
    return f"{STRONGER_GEARHEAD} or lower the loads of the duty to at most {most} % of what they are"


def _stronger(measure: Callable[[Layout], Comparison], s: Layout) -> str:
    """Preloads without bias; where losses count, the rated torque that a motor needs at least."""
    if not s.drive.limits.counts_losses:
        return balanced_preloads(s)
    reached = measure(s).actual
    if reached <= 0.0:
        return "choose a motor of higher rated torque or a gearhead of higher ratio"
    needed = rounded(s.drive.motor.rated_torque_mNm * s.drive.loads.peak_torque_Nm / reached, ceil)
    raised = ""
    if s.drive.stage is not None:
        ratio = rounded(s.drive.stage.ratio * s.drive.loads.peak_torque_Nm / reached, ceil)
        raised = f", or raise stage.ratio to about {ratio}"
    return f"choose a motor of about {needed} mN m or more, or a gearhead of higher ratio or efficiency{raised}"


_LESS = (down("loads.peak_torque_Nm"),)
_EASIER = (down("rope.preload_N"), down("transmission.input_to_drum"))
_forward: Callable[[Layout], Comparison] = partial(motor_torque, 1)
_back: Callable[[Layout], Comparison] = partial(motor_torque, -1)
CHECKS = (
    Check(
        "motor_torque_forward",
        "Motors hold peak torque, load +",
        "model, paper section 5.1; limits.losses",
        _forward,
        adjust=_LESS,
        advice=partial(_stronger, _forward),
    ),
    Check(
        "motor_torque_back",
        "Motors hold peak torque, load -",
        "model, paper section 5.1; limits.losses",
        _back,
        adjust=_LESS,
        advice=partial(_stronger, _back),
    ),
    Check(
        "gearhead_maximum",
        "Gearhead's intermittent rating at peak torque",
        "gearhead catalogue",
        gearhead_maximum,
        adjust=_LESS,
        advice="choose a stronger drive.gearhead",
    ),
    Check(
        "motor_losses",
        "Motors hold peak torque with losses",
        "gearhead catalogue: efficiency; cables, bearings: docs/losses.md",
        motor_losses,
        "warn",
        applies=lambda drive: not drive.limits.counts_losses,
        advice=partial(_less_torque, motor_losses, COUNT_THEM),
    ),
    Check(
        "gearhead_continuous",
        "Gearhead's continuous rating over the duty",
        "gearhead catalogue; cubic mean of loads.duty: gearhead makers",
        gearhead_continuous,
        "warn",
        applies=lambda drive: drive.loads.continuous_torque_Nm is None,
        advice=_less_often,
    ),
    Check(
        "backdrive",
        "Drum turned from its side",
        "loads.backdrive_Nm; friction by cause: docs/losses.md",
        backdrive,
        adjust=_EASIER,
        advice=_easier_to_turn,
    ),
)
