"""Predict the finding of a planned run: the smallest size of each effect that is named, and its rivals.

The same Jacobians as in the loop, on the planned motion and load. An effect is named if it lowers the error of held-out
half sweeps by ``LEAST_FALL`` of the noise and is supported by all sweeps and sectors; two effects are separated if the
part of one that the other cannot imitate is above the noise. Effects of one size that strain the cables are taken at
their size; all else, the rivals too, is linear in the sizes, so valid for small effects.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.quiet import signal_noise
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.response import ResponseLoop
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP, FREQUENCY_RESPONSE, MOTION, TURNING_POINTS
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.measurement.vet_signals import friction_alike, friction_words
from mbcdm_cad.model.si import to_si
from mbcdm_cad.planning.by_hand import PlannedReadings, sizes_by_hand, sizes_of_response
from mbcdm_cad.planning.detectable import NEVER, PlannedEffects, Tried, planned_fitter
from mbcdm_cad.planning.prediction_noise import coloured

POWER = 0.9
# A rival is listed if the effect can be confused with it up to so many times its smallest named size; worst first.
MOST_RIVALS = 4
ANY_SIZE = 1e3
# Sizes of the two signs that differ by less than this share are given as one.
SAME_SIZE = 0.03


@dataclass(frozen=True)
class Rival:
    """Another effect that fits as well up to ``from_size`` (in the unit of the effect's own size; None: at any
    size)."""

    label: str
    from_size: float | None


@dataclass(frozen=True)
class Foreseen:
    """One effect: the smallest size that is named with the plan's power, whatever its sign and phase; None if the run
    cannot show it.

    ``if_positive`` and ``if_negative``: that size for one sign, where they differ and the run can show it.
    """

    label: str
    parameter: str
    smallest: float | None
    rivals: tuple[Rival, ...]
    if_positive: float | None = None
    if_negative: float | None = None


@dataclass(frozen=True)
class RunPlan:
    """What a planned run can find, with the noise that was assumed.

    ``friction_alike``: parts of a friction that its speeds and loads do not tell from a constant one. ``proposals``:
    runs by hand that show more. ``moves``: it is a motion, and not readings by hand.
    """

    noise: Noise
    effects: tuple[Foreseen, ...]
    power: float = POWER
    friction_alike: tuple[str, ...] = ()
    proposals: tuple[str, ...] = ()
    moves: bool = True

    def to_json(self) -> dict[str, Any]:
        """For a file."""
        effects = [asdict(one) for one in self.effects]
        alike = list(self.friction_alike)
        return {"power": self.power, "noise": self.noise.to_json(), "effects": effects, "friction_alike": alike}

    def text(self) -> str:
        """For the terminal."""
        width = max(len(one.label) for one in self.effects)
        lines = [
            f"noise floor {1e6 * self.noise.total_rad:.3g} urad ({self.noise.source})",
            "",
            f"{'effect':<{width}}  {f'named from (power {self.power:g})':<34}  not told from, below",
        ]
        for one in self.effects:
            rivals = "; ".join(f"{rival.label}: {_words(one.parameter, rival.from_size)}" for rival in one.rivals)
            size = "this run cannot show it" if one.smallest is None else _size_words(one)
            lines.append(f"{one.label:<{width}}  {size:<34}  {rivals}".rstrip())
        lines += ["", friction_words(self.friction_alike)] if self.moves else []
        lines += [f"{'a run by hand shows':<{width}}  {words} (docs/other-runs.md)" for words in self.proposals]
        return "\n".join(lines)


def _size_words(one: Foreseen) -> str:
    if one.if_positive is None and one.if_negative is None:
        return _words(one.parameter, one.smallest)
    signed = [("+", one.if_positive), ("-", one.if_negative)]
    word = _words(one.parameter, one.smallest).rsplit(" ", 2)[0]
    return f"{word} " + " or ".join(
        sign + _words(one.parameter, size).removeprefix(f"{word} ") for sign, size in signed if size is not None
    )


def _words(parameter: str, size: float | None) -> str:
    if size is None:
        return "at any size"
    word, shown = readable(parameter, [size])
    return f"{word} {shown[0]}"


def noise_from(drive: Drive, run: Run) -> Noise:
    """The noise of a measured run, for planning other runs."""
    if run.kind != MOTION:
        return PlannedReadings(drive, run).few.noise
    fitter = planned_fitter(drive, run)
    return replace(_noise_in(fitter, fitter.fit()), signals=signal_noise(fitter.runs[0].run))


def _noise_in(fitter: Fitter, bare: Fit) -> Noise:
    """The floor as the loop has it, and its colour."""
    return coloured(noise_of(fitter.base, [bare.residual]), fitter.base[0], bare.residual)


def plan_of(drive: Drive, run: Run, noise: Noise | None = None, power: float = POWER) -> RunPlan:
    """What ``run``, measured or only planned, can find on ``drive``. ``noise`` is that of a pilot run.

    ``power`` is the probability with which an effect of the smallest size is to be named.
    """
    if run.kind == FREQUENCY_RESPONSE:
        return _of_response(
            ResponseLoop(drive, float(np.mean(to_si(drive).total_ratio)), [arranged(run, drive)]), power
        )
    if run.kind != MOTION:
        return _by_hand(PlannedReadings(drive, run), noise, power)
    fitter = planned_fitter(drive, run)
    # Fitted again from where it ended: the slopes by the offsets differ at their bound.
    bare = fitter.fit(offsets=fitter.fit().offsets, iterations=0)
    effects = PlannedEffects(fitter, bare, noise or _noise_in(fitter, bare))
    p = fitter.runs[0]
    alike = tuple(friction_alike(p.speed_rad_s, p.load_Nm))
    found = tuple(_foreseen(effects, one, power) for one in effects.tried)
    return RunPlan(effects.noise, found, power, alike, _proposals(run, found))


def _proposals(run: Run, found: Sequence[Foreseen]) -> tuple[str, ...]:
    """Runs by hand that show what this one cannot."""
    proposed = []
    if run.load_Nm is None or not np.ptp(run.load_Nm):
        what = "play and stiffness" if len(run.input_rad) == 1 else "stiffness"
        proposed.append(f"{what}: push the locked drive to and fro by hand, record: {TURNING_POINTS}")
    creep = [one for one in found if one.label.startswith("creep")]
    blind = [one for one in creep if one.smallest is None or any("thermal" in r.label for r in one.rivals)]
    if creep and len(blind) == len(creep):
        proposed.append(f"creep, told from a warming: readings at rest under a load and after it, record: {CREEP}")
    return tuple(proposed)


def _by_hand(planned: PlannedReadings, noise: Noise | None, power: float) -> RunPlan:
    """What readings by hand can find."""
    noise, found = noise or planned.few.noise, []
    sizes = sizes_by_hand(planned, noise.total_rad, power)
    usual = {effect: next(p.size for p in effect.parameters if p.role == "size") for effect, _, _ in sizes}
    seen = {effect for effect, size, _ in sizes if size <= NEVER * usual[effect]}
    for effect, size, rivals in sizes:
        name = _size_name(effect)
        if effect not in seen:
            found.append(Foreseen(effect.label, name, None, ()))
            continue
        near = [(e, at) for e, at in rivals if e in seen and at > size]
        worse = [Rival(e.label, at if at <= ANY_SIZE * size else None) for e, at in near]
        found.append(Foreseen(effect.label, name, size, tuple(worse[:MOST_RIVALS])))
    return RunPlan(noise, tuple(found), power, moves=False)


def _of_response(loop: ResponseLoop, power: float) -> RunPlan:
    """What a chirp can find, by the response of a run that was made or simulated."""
    found = []
    for one, size, rivals in sizes_of_response(loop, power):
        near = tuple(Rival(label, at if at <= ANY_SIZE * size else None) for label, at in rivals if at > size)
        seen = size <= NEVER * one.size
        found.append(Foreseen(one.label, one.figure, size if seen else None, near[:MOST_RIVALS] if seen else ()))
    return RunPlan(loop.noise, tuple(found), power, moves=False)


def _foreseen(effects: PlannedEffects, one: Tried, power: float) -> Foreseen:
    """The sizes of one effect, and the effects with which it is confused."""
    signed = effects.sizes(one, power)
    name = _size_name(one.effect)
    size = max((each for each in signed if np.isfinite(each)), default=None)
    if size is None:
        return Foreseen(one.label, name, None, ())
    strength = size * one.unit / effects.noise.total_rad
    rivals = []
    for other in effects.tried:
        if other.effect.key == one.effect.key or other.unit <= 0.0:
            continue
        wanted = one.apart(other)
        if wanted > strength:
            from_size = None if wanted > ANY_SIZE * strength else wanted / strength * size
            rivals.append((wanted, Rival(other.label, from_size)))
    rivals.sort(key=lambda rival: -rival[0])
    worst = (*_within(effects, one, strength, size), *(rival for _, rival in rivals[:MOST_RIVALS]))
    if signed[0] == signed[1] or abs(signed[0] / signed[1] - 1.0) < SAME_SIZE:
        return Foreseen(one.label, name, size, worst)
    return Foreseen(one.label, name, size, worst, *(each if np.isfinite(each) else None for each in signed))


def _within(effects: PlannedEffects, one: Tried, strength: float, size: float) -> Iterator[Rival]:
    """What the load may be wrong by, where it imitates the effect at its smallest size."""
    for other, bound in effects.within:
        if other.unit > 0.0:
            wanted = one.apart_within(other, bound * other.unit / effects.noise.total_rad)
            if wanted > strength:
                name, shown = readable(_size_name(other.effect), [bound])
                yield Rival(f"{other.effect.name} within {name} {shown[0]}", wanted / strength * size)


def _size_name(effect: Effect) -> str:
    """Name of the first size; the amplitude of a wave has the same unit."""
    name = next(p.name for p in effect.parameters if p.role == "size")
    return name.replace("cosine_", "amplitude_")
