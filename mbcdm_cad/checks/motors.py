"""Motor and gearhead at peak torque in both directions: the bias torque of the preload helps one and hinders the other.

Positive is a load that opposes positive rotation of the drum. As in the paper, the checks that can fail assume a
lossless gearhead; losses and its continuous rating only give warnings.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import down
from mbcdm_cad.checks.remedies import floored
from mbcdm_cad.checks.strength import balanced_preloads, rated_input_Nm
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.losses.train import BEARINGS, ROPE

# Ratings above this multiple of T_pre r_m are not evaluated: cables are slack long before.
_RATING_CAP = 60.0
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
    """The motors hold peak torque in this direction at their rated torque, with lossless gearheads."""
    bias = s.loads.input_torque_Nm[0] * 1e3
    listed = ", ".join(f"{name} {value:+.4g}" for name, value in zip(s.drive.input_names, bias, strict=True))
    note = f"preload bias {listed} mN m included"
    return _against_peak(s, "motor's rated torque", rated_input_Nm(s), direction, note)


def raised_Nm(s: Layout, direction: int) -> tuple[float, str]:
    """Drum torque (N m) that the motors still move at their rated torque, all losses counted; the first input."""
    si = s.loads.si
    train = s.losses.with_drive(si)
    loads = train.raised_Nm(train.output_Nm(s.drive.motor.rated_torque_mNm * 1e-3), direction)
    first = int(loads.argmin())
    return float(loads[first]), si.input_names[first]


def motor_losses(s: Layout) -> Comparison:
    """The torque that the motors move with all losses counted, in the worse direction."""
    return worst(_moved(s, direction) for direction in (1, -1))


def _moved(s: Layout, direction: int) -> Comparison:
    reached, name = raised_Nm(s, direction)
    return at_least(
        f"drum torque {_WORDS[direction]} that the {name} input moves at its motor's rated torque, all losses counted",
        reached,
        s.drive.loads.peak_torque_Nm,
        "N m",
        "losses of gearheads, cables and bearings: docs/losses.md",
    )


def backdrive(s: Layout) -> Comparison:
    """Torque at the drum that starts to turn it from its side, motors without current."""
    si, wanted = s.loads.si, s.drive.loads.backdrive_Nm
    found, what = s.losses.with_drive(si).backdrive, "torque at the drum that turns it, motors without current"
    if found is None:
        if wanted is None:
            return noted(f"the gearheads lock; {what}: there is none, and the design file asks for none:", 0.0, "N m")
        raise NoFigureError(
            f"no torque at the drum turns the gearheads: their efficiency of {s.drive.gearhead.efficiency:g} is 0.5 or "
            f"below, and loads.backdrive_Nm asks for {wanted:g} N m; choose a gearhead of higher efficiency"
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
        return "choose a motor of lower rated torque, which has less friction"
    return "choose a gearhead of lower ratio or higher efficiency, or a motor with a shaft of its own and no gearhead"


def gearhead_maximum(s: Layout) -> Comparison:
    """Drum torque at the intermittent rating of the gearhead (of the motor if there is none), worse direction."""
    limit = s.drive.gearhead.max_torque_mNm * 1e-3
    return worst(_against_peak(s, f"{s.drive.mounted}'s intermittent rating", limit, sign) for sign in (1, -1))


def gearhead_continuous(s: Layout) -> Comparison:
    """Drum torque at the continuous rating of the gearhead (of the motor if there is none), worse direction."""
    limit = s.drive.gearhead.rated_torque_mNm * 1e-3
    note = "hold more than this only for a short time"
    return worst(_against_peak(s, f"{s.drive.mounted}'s continuous rating", limit, sign, note) for sign in (1, -1))


def _less_torque(measure: Callable[[Layout], Comparison], otherwise: str, s: Layout) -> str:
    reached = measure(s).actual
    return f"{otherwise} or lower loads.peak_torque_Nm to at most {floored(reached)}" if reached > 0.0 else otherwise


_LESS = (down("loads.peak_torque_Nm"),)
_EASIER = (down("rope.preload_N"), down("transmission.input_to_drum"))
_forward: Callable[[Layout], Comparison] = partial(motor_torque, 1)
_back: Callable[[Layout], Comparison] = partial(motor_torque, -1)
CHECKS = (
    Check(
        "motor_torque_forward",
        "Motors hold peak torque, load +",
        "model, paper section 5.1",
        _forward,
        adjust=_LESS,
        advice=balanced_preloads,
    ),
    Check(
        "motor_torque_back",
        "Motors hold peak torque, load -",
        "model, paper section 5.1",
        _back,
        adjust=_LESS,
        advice=balanced_preloads,
    ),
    Check(
        "gearhead_maximum",
        "Gearhead's intermittent rating at peak torque",
        "gearhead catalogue",
        gearhead_maximum,
        adjust=_LESS,
        advice="choose a stronger gearhead",
    ),
    Check(
        "motor_losses",
        "Motors hold peak torque with losses",
        "gearhead catalogue: efficiency; cables, bearings: docs/losses.md",
        motor_losses,
        "warn",
        advice=partial(_less_torque, motor_losses, "choose a motor of higher rated torque"),
    ),
    Check(
        "gearhead_continuous",
        "Gearhead's continuous rating at peak torque",
        "gearhead catalogue",
        gearhead_continuous,
        "warn",
        advice=partial(_less_torque, gearhead_continuous, "choose a stronger gearhead"),
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
