"""Possible causes of the difference for each published figure, each computed with the model.

Candidates marked ``+`` are plausible (within the bounds below, estimates); a single figure cannot decide between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.measurement.logformat import Unit, unit_of
from mbcdm_cad.measurement.schema import Published
from mbcdm_cad.model.capability import MOTOR, balanced_preload_N, input_ratings_Nm, torque_at_input_limit_Nm
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.stiffness import drum_backlash

# Plausible relative deviation of preload, modulus and friction from the declared values (estimates).
PRELOAD_SHARE, MODULUS_SHARE, FRICTION_SHARE = 0.3, 0.15, 0.5
# Plausible share of the load on the input that carries more of it.
MOST_SHARE = 0.65
# Highest multiple of a shaft's turn that is compared: above it, some multiple is near any order.
MOST_TIMES = 8
SEARCHED = (0.3, 3.0)
WINDING_SAMPLES = 400


@dataclass(frozen=True)
class Candidate:
    """One possible cause. ``effect`` is its name in the vocabulary, None for a cause that is no effect of a run.

    ``needed``: the size with which it alone explains the difference; ``predicted``: the model's figure with this cause
    (SI; None if its size is free); ``plausible``: whether the needed size, or the figure, is usual for such a part.
    """

    cause: str
    effect: str | None
    needed: str
    predicted: float | None
    plausible: bool


@dataclass(frozen=True)
class Judged:
    """One published figure, SI. ``predicted`` is None if the declared model does not contain it."""

    quantity: str
    where: str
    unit: str
    measured: float
    predicted: float | None
    stated_theory: float | None
    candidates: tuple[Candidate, ...]
    told_apart_by: str
    remark: str

    @property
    def residual(self) -> float | None:
        """Measured minus predicted."""
        return None if self.predicted is None else self.measured - self.predicted


Judge = Callable[[Drive, DriveSI, Published, float], Judged]


def _peak_torque(drive: Drive, d: DriveSI, item: Published, measured: float) -> Judged:
    """Load torque at which the first input reaches its motor's limit, in the weaker direction."""
    lossless = input_ratings_Nm(drive)[MOTOR]
    lossy = lossless * drive.gearhead.efficiency

    def limit(d: DriveSI, rating: float) -> float:
        return float(min(torque_at_input_limit_Nm(d, rating, way).min() for way in (1, -1)))

    def of_preload(share: float) -> float:
        return limit(d.with_(preload_N=d.preload_N * share), lossless) - measured

    weaker = limit(d, lossless)
    stronger = float(max(torque_at_input_limit_Nm(d, lossless, way).min() for way in (1, -1)))
    even = limit(d.with_(preload_N=balanced_preload_N(d)), lossless)
    ideal = float(sum(lossless * d.total_ratio[d.input_of.index(i)] for i in range(d.n_inputs)))
    busiest = ideal / d.n_inputs / measured
    needed, plausible = _preload_words(d, _root(of_preload))
    shared = bool(1.0 / d.n_inputs < busiest < MOST_SHARE)
    candidates = (
        Candidate("bias of the preload on the inputs", "preload_error", needed, weaker, plausible),
        Candidate("uneven sharing by the cables alone, without bias", None, "no free size", even, False),
        Candidate(
            "losses in the gearheads on top of the bias",
            None,
            f"efficiency {lossy / lossless * measured / limit(d, lossy):.2f}; the data sheet states "
            f"{lossy / lossless:.2f}",
            limit(d, lossy),
            bool(measured <= limit(d, lossy) * 1.15),
        ),
        Candidate(
            "uneven sharing by the controllers of the two motors",
            None,
            f"one input carries {busiest:.0%} of the load",
            None,
            shared,
        ),
    )
    return Judged(
        "peak_torque",
        item.where,
        "N m",
        measured,
        weaker,
        _stated(item),
        candidates,
        f"the ramp in both directions (bias: {weaker:.2f} and {stronger:.2f} N m; losses and controllers: equal), the "
        "currents of both motors, and a run with preloads T ~ 1/r",
        f"sum of both motors without losses or bias {ideal:.3f} N m, which is the authors' theory",
    )


def _backlash(drive: Drive, d: DriveSI, item: Published, measured: float) -> Judged:
    """The swing of the drum at a reversal of the load, inputs locked."""
    load = item.conditions.load_torque_Nm or drive.loads.test_torque_Nm
    drum = drum_backlash(d, load)
    swing, single = float(drum.reversal_swing_rad), float(drum.first_loading_rad)
    modulus = float(d.modulus_Pa)

    def of(change: Callable[[float], DriveSI]) -> Callable[[float], float]:
        return lambda share: float(drum_backlash(change(share), load).reversal_swing_rad) - measured

    preload = _root(of(lambda share: d.with_(preload_N=d.preload_N * share)))
    friction = _root(of(lambda share: d.with_(friction_coefficient=d.friction_coefficient * share)))
    stiff = swing / measured
    preload_words, preload_plausible = _preload_words(d, preload)
    candidates = [
        Candidate(
            "modulus of the rope",
            "stiffness_error",
            f"E = {stiff * modulus / 1e9:.1f} GPa instead of {modulus / 1e9:.1f}",
            None,
            abs(stiff - 1.0) < MODULUS_SHARE,
        ),
        Candidate("preload", "preload_error", preload_words, None, preload_plausible),
        Candidate(
            "friction of the cable",
            "cable_friction",
            _share_words("mu", float(d.friction_coefficient), friction, ""),
            None,
            friction is not None and abs(friction - 1.0) < FRICTION_SHARE,
        ),
        Candidate(
            "the figure meant as one-sided turn",
            None,
            f"E = {single / measured * modulus / 1e9:.1f} GPa, lower than that of such a rope",
            single,
            abs(single / measured - 1.0) < MODULUS_SHARE,
        ),
    ]
    travel = item.conditions.half_travel_rad
    if travel is not None:
        wound = swing * _winding_factor(d, load, travel)
        words = f"with it, E = {wound / measured * modulus / 1e9:.1f} GPa"
        plausible = abs(wound / measured - 1.0) < MODULUS_SHARE
        candidates.append(Candidate("winding history left out", "winding_history", words, wound, plausible))
    return Judged(
        "backlash",
        item.where,
        "rad",
        measured,
        swing,
        _stated(item),
        tuple(candidates),
        "a run with its torque: the shape of the loop separates E (scales all) from preload and friction (slip part "
        "only); two travels separate winding history (grows with travel); preload and friction cannot be separated "
        "until the tension of a cable is measured",
        "read as the swing at a reversal; a modulus that was calibrated on this figure confirms nothing",
    )


def _ripple_amplitude(drive: Drive, d: DriveSI, item: Published, measured: float) -> Judged:
    """Ripple of the transmission error; the declared model has none."""
    step = drive.encoder.resolution_urad * 1e-6 / _ratio(d)
    stages = f"{measured * _ratio(d) * 1e6:.0f} urad on the input shafts"
    candidates = (
        Candidate("once a turn of a shaft of the chain", "ripple", stages, None, True),
        Candidate(
            "sub-division of the input encoder",
            "ripple",
            f"{measured / step:.2f} of its steps, which is {step * 1e6:.1f} urad at the drum",
            None,
            bool(measured < 2.0 * step),
        ),
    )
    return Judged(
        "ripple_amplitude",
        item.where,
        "rad",
        measured,
        0.0,
        _stated(item),
        candidates,
        "its order: see ripple_order; another input encoder, or the same one turned by a fraction of a line",
        "",
    )


def _ripple_order(drive: Drive, d: DriveSI, item: Published, measured: float) -> Judged:
    """Order of the ripple, with the axis as printed (per rad) and as if it were per turn."""
    motor = _ratio(d) * drive.gearhead.ratio
    shafts = {
        "drum": 1.0,
        **{body.name: abs(body.turns_per_drum) for body in d.routes.passed},
        "input": _ratio(d),
        "motor": motor,
    }
    travel = item.conditions.half_travel_rad
    bin_per_turn = 2.0 * np.pi / (2.0 * travel) if travel else None
    candidates = []
    for word, per_turn in (("axis as printed", measured * 2.0 * np.pi), ("axis a turn, mislabelled", measured)):
        lines = [(name, times, times * order) for name, order in shafts.items() for times in range(1, MOST_TIMES + 1)]
        shaft, times, turns = min(lines, key=lambda line: abs(line[2] - per_turn))
        off = per_turn - turns
        bins = "" if bin_per_turn is None else f", {abs(off) / bin_per_turn:.2f} of a bin of {bin_per_turn:.0f}"
        plausible = bin_per_turn is not None and abs(off) < bin_per_turn
        words = f"{per_turn:.1f} a turn; nearest {times} times the {shaft}'s turn, {turns:.1f}: {off:+.1f} off{bins}"
        candidates.append(Candidate(word, "ripple" if plausible else None, words, None, plausible))
    per_motor = measured * 2.0 * np.pi / motor
    return Judged(
        "ripple_order",
        item.where,
        "cycle/rad",
        measured,
        None,
        _stated(item),
        tuple(candidates),
        "a run over a longer travel, whose bins are narrower, with the motors' angle logged; the ripple's amplitude at "
        "two speeds",
        f"as printed {per_motor:.3f} per turn of the motor, which no stage has",
    )


def _mass(drive: Drive, d: DriveSI, item: Published, measured: float) -> Judged:
    """Mass of the drive; the build computes it from the parts, a run cannot measure it."""
    return Judged(
        "mass",
        item.where,
        "kg",
        measured,
        None,
        _stated(item),
        (),
        "weigh the parts and compare with the bill of materials of 'mbcdm build'",
        "the model of the loop has no mass",
    )


JUDGES: dict[str, Judge] = {
    "peak_torque": _peak_torque,
    "mass": _mass,
    "backlash": _backlash,
    "ripple_amplitude": _ripple_amplitude,
    "ripple_order": _ripple_order,
}


def together(figures: tuple[Judged, ...]) -> tuple[str, ...]:
    """Conclusions from several figures that none of them gives alone."""
    by_name = {figure.quantity: figure for figure in figures}
    lines = []
    if {"peak_torque", "backlash"} <= by_name.keys():
        words = {
            name: next(c.needed for c in by_name[name].candidates if c.effect == "preload_error")
            for name in ("peak_torque", "backlash")
        }
        lines.append(
            f"preload alone does not explain both: it needs {words['peak_torque']} for the torque, but "
            f"{words['backlash']} for the backlash"
        )
    if {"peak_torque", "mass"} <= by_name.keys():
        torque, mass = by_name["peak_torque"], by_name["mass"]
        lines.append(f"torque to weight {torque.measured / mass.measured:.3f} N m/kg")
    return tuple(lines)


def _winding_factor(d: DriveSI, load: float, travel: float) -> float:
    """Factor by which winding history increases the swing at the end of the second sweep, brake against the motion."""
    phase = np.linspace(0.0, 5.0 * np.pi, 5 * WINDING_SAMPLES // 2)
    angle = np.tile(_ratio(d) * travel * np.sin(phase), (d.n_inputs, 1))
    torque = load * np.tanh(np.cos(phase) / 0.02)

    def width(winding: bool) -> float:
        error = simulate_profiles(d, angle, torque, winding=winding).drum_angle_rad - angle[0] / _ratio(d)
        steady = error[phase > np.pi]
        return float(np.ptp(steady))

    return width(True) / width(False)


def _ratio(d: DriveSI) -> float:
    return float(np.mean(d.total_ratio))


def _stated(item: Published) -> float | None:
    if item.stated_theory is None:
        return None
    return item.stated_theory * (unit_of(item.quantity, item.unit) or Unit(1.0)).factor


def _root(of: Callable[[float], float]) -> float | None:
    """The share within SEARCHED at which a function is zero; None if there is none."""
    low, high = SEARCHED
    grid = np.geomspace(low, high, 13)
    values = [of(float(share)) for share in grid]
    for a, b, fa, fb in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if np.isfinite(fa) and np.isfinite(fb) and fa * fb <= 0.0:
            return float(brentq(of, a, b, rtol=1e-6))
    return None


def _share_words(name: str, declared: float, share: float | None, unit: str) -> str:
    suffix = f" {unit}" if unit else ""
    if share is None:
        return f"no {name} from {SEARCHED[0]:g} to {SEARCHED[1]:g} times the declared one explains the difference"
    return f"{name} = {share * declared:.3g}{suffix} instead of {declared:.3g}{suffix}"


def _preload_words(d: DriveSI, share: float | None) -> tuple[str, bool]:
    words = _share_words("preload", float(np.mean(d.preload_N)), share, "N")
    return words, share is not None and abs(share - 1.0) < PRELOAD_SHARE
