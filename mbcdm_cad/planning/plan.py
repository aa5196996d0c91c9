"""Predict the finding of a planned run: the smallest size of each effect that is named, and its rivals.

The same Jacobians as in the loop, on the planned motion and load. An effect is named if it lowers the error of held-out
half sweeps by ``LEAST_FALL`` of the noise and is supported by all sweeps and sectors; two effects are separated if the
part of one that the other cannot imitate is above the noise. Effects of one size that strain the cables are taken at
their size; all else, the rivals too, is linear in the sizes, so valid for small effects.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.quiet import signal_noise
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet_signals import friction_alike, friction_words
from mbcdm_cad.planning.detectable import PlannedEffects, Tried, planned_fitter
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

    ``friction_alike``: parts of a friction that its speeds and loads do not tell from a constant one.
    """

    noise: Noise
    effects: tuple[Foreseen, ...]
    power: float = POWER
    friction_alike: tuple[str, ...] = ()

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
        lines += ["", friction_words(self.friction_alike)]
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
    fitter = planned_fitter(drive, run)
    return replace(_noise_in(fitter, fitter.fit()), signals=signal_noise(fitter.runs[0].run))


def _noise_in(fitter: Fitter, bare: Fit) -> Noise:
    """The floor as the loop has it, and its colour."""
    return coloured(noise_of(fitter.base, [bare.residual]), fitter.base[0], bare.residual)


def plan_of(drive: Drive, run: Run, noise: Noise | None = None, power: float = POWER) -> RunPlan:
    """What ``run``, measured or only planned, can find on ``drive``. ``noise`` is that of a pilot run.

    ``power`` is the probability with which an effect of the smallest size is to be named.
    """
    fitter = planned_fitter(drive, run)
    # Fitted again from where it ended: the slopes by the offsets differ at their bound.
    bare = fitter.fit(offsets=fitter.fit().offsets, iterations=0)
    effects = PlannedEffects(fitter, bare, noise or _noise_in(fitter, bare))
    p = fitter.runs[0]
    alike = tuple(friction_alike(p.speed_rad_s, p.load_Nm))
    return RunPlan(effects.noise, tuple(_foreseen(effects, one, power) for one in effects.tried), power, alike)


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
