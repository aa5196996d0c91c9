"""Predict the finding of a planned run: the smallest size of each effect that is named, and its rivals.

The same Jacobians as in the loop, on the planned motion and load. An effect is named if it lowers the error of held-out
half sweeps by ``LEAST_FALL`` of the noise and is supported by all sweeps and sectors; two effects are separated if the
part of one that the other cannot imitate is above the noise. Effects of one size that strain the cables are taken at
their size; all else, the rivals too, is linear in the sizes, so valid for small effects.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncf, norm
from scipy.stats import f as f_distribution

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.quiet import signal_noise
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.search.evidence import LOG_ODDS
from mbcdm_cad.loop.search.few import PLAY, FewReadings, prepared_by_hand
from mbcdm_cad.loop.search.few_readings import CHANCE
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.response import ResponseLoop
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP, FREQUENCY_RESPONSE, MOTION, TURNING_POINTS
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.measurement.vet_signals import friction_alike, friction_words
from mbcdm_cad.planning.detectable import NEVER, PlannedEffects, Tried, planned_fitter
from mbcdm_cad.planning.prediction_noise import coloured
from mbcdm_cad.routes import Floats

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
        loop = ResponseLoop(drive, float(np.mean(layout_of(drive).si.total_ratio)), [arranged(run, drive)])
        return RunPlan(loop.noise, tuple(_of_response(loop, power)), power, moves=False)
    if run.kind != MOTION:
        planned = PlannedReadings(drive, run)
        noise = noise or planned.few.noise
        return RunPlan(noise, tuple(planned.foreseen(noise.total_rad, power)), power, moves=False)
    fitter = planned_fitter(drive, run)
    # Fitted again from where it ended: the slopes by the offsets differ at their bound.
    bare = fitter.fit(offsets=fitter.fit().offsets, iterations=0)
    effects = PlannedEffects(fitter, bare, noise or _noise_in(fitter, bare))
    p = fitter.runs[0]
    alike = tuple(friction_alike(p.speed_rad_s, p.load_Nm))
    found = tuple(_of_motion(effects, one, power) for one in effects.tried)
    return RunPlan(effects.noise, found, power, alike, _proposals(run, found))


def _foreseen(label: str, figure: str, size: float, rivals: Iterable[tuple[str, float]]) -> Foreseen:
    """An effect that is named from ``size`` on, not at all where it is infinite; ``rivals``: from which size on it is
    told from each other one, of which the worst are listed."""
    if not np.isfinite(size):
        return Foreseen(label, figure, None, ())
    near = sorted((rival for rival in rivals if rival[1] > size), key=lambda rival: -rival[1])[:MOST_RIVALS]
    return Foreseen(
        label, figure, size, tuple(Rival(other, at if at <= ANY_SIZE * size else None) for other, at in near)
    )


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


def _of_motion(effects: PlannedEffects, one: Tried, power: float) -> Foreseen:
    """The sizes of one effect, and the effects with which it is confused."""
    signed = effects.sizes(one, power)
    name, size = _size_name(one.effect), max((each for each in signed if np.isfinite(each)), default=None)
    if size is None:
        return Foreseen(one.label, name, None, ())
    strength = size * one.unit / effects.noise.total_rad
    others = [other for other in effects.tried if other.effect.key != one.effect.key and other.unit > 0.0]
    rivals = ((other.label, one.apart(other) / strength * size) for other in others)
    found = _foreseen(one.label, name, size, rivals)
    found = replace(found, rivals=(*_within(effects, one, strength, size), *found.rivals))
    if signed[0] == signed[1] or abs(signed[0] / signed[1] - 1.0) < SAME_SIZE:
        return found
    positive, negative = (each if np.isfinite(each) else None for each in signed)
    return replace(found, if_positive=positive, if_negative=negative)


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


# Noncentrality beyond which nothing is looked for.
MOST_STRENGTH = 1e6


class PlannedReadings:
    """Readings by hand that are planned, or were made, on a drive, and the tests of the loop on them.

    The slopes are those at size zero, so valid for small effects. The F test on the readings that are not held back
    must find the effect with the plan's power, and the readings held back must show it as the loop asks.
    """

    def __init__(self, drive: Drive, run: Run) -> None:
        d = layout_of(drive).si
        ratio = float(np.mean(d.total_ratio))
        self.few = FewReadings(d, ratio, [prepared_by_hand(arranged(run, drive), ratio)], drive.as_built)
        self.effects = [e for e in self.few.library if not e.unmeasured]

    def slopes(self, effect: Effect) -> Floats | None:
        """Derivatives of the prediction by the sizes of an effect, on all samples (n, k); None if nothing shows."""
        if self.few.loses_track or (effect.name == PLAY and self.few.hides_play):
            return None
        f, sizes = self.few.fitter, [p.role == "size" for p in effect.parameters]
        for start in f.guesses(effect, self.few.bare.residual):
            values = np.where(sizes, 0.0, start)
            slopes = f.fit((effect,), (values,), iterations=0).jacobian[:, sizes]
            if np.all(np.linalg.norm(f.centred_on(f.train, slopes), axis=0) > 0.0):
                return slopes
        return None

    def smallest(self, effect: Effect, slopes: Floats, floor_rad: float, power: float) -> float:
        """The smallest size that is named with this power, whatever its phase; infinite if the readings are too few."""
        f = self.few.fitter
        n, test = int(f.train.sum()), int(f.test.sum())
        extra = len(effect.parameters)
        freedom = n - extra - 1
        if freedom < 1 or not test:
            return np.inf
        limit = float(f_distribution.isf(CHANCE / len(self.few.library), extra, freedom))

        def lacks(strength: float) -> float:
            return float(ncf.sf(limit, extra, freedom, strength)) - power

        if lacks(MOST_STRENGTH) < 0.0:
            return np.inf
        strength = float(brentq(lacks, 1e-6, MOST_STRENGTH))
        _, lengths, phases = np.linalg.svd(f.centred_on(f.train, slopes), full_matrices=False)
        found = np.sqrt(strength) / lengths[-1]
        sure = float(norm.isf(1.0 - power)) / np.sqrt(test)
        held = float(np.sqrt(np.mean((f.centred(slopes, f.train)[f.test] @ phases[-1]) ** 2)))
        shown = (sure + np.sqrt(sure**2 + LEAST_FALL**2)) / held if held else np.inf
        return floor_rad * float(max(found, shown))

    def apart(self, one: Floats, other: Floats, floor_rad: float, power: float) -> float:
        """The size from which an effect of slopes ``one`` is told from another with the loop's odds."""
        f = self.few.fitter
        mine, its = (f.centred_on(f.used, columns) for columns in (one, other))
        basis = np.linalg.qr(its)[0]
        _, lengths, phases = np.linalg.svd(mine, full_matrices=False)
        left = mine @ phases[-1]
        left = left - basis @ (basis.T @ left)
        needed = np.sqrt(2.0 * LOG_ODDS) + float(norm.isf(1.0 - power))
        length = float(np.linalg.norm(left))
        return needed * floor_rad / length if length > 1e-9 * float(lengths[-1]) else np.inf

    def foreseen(self, floor_rad: float, power: float) -> Iterator[Foreseen]:
        """What the readings can find. An effect that is never seen is no rival."""
        slopes = {e: s for e in self.effects if (s := self.slopes(e)) is not None}
        least = {e: self.smallest(e, s, floor_rad, power) for e, s in slopes.items()}
        seen = {
            e: at for e, at in least.items() if at <= NEVER * next(p.size for p in e.parameters if p.role == "size")
        }
        for effect in self.effects:
            others = [other for other in seen if other.key != effect.key and effect in seen]
            rivals = ((e.label, self.apart(slopes[effect], slopes[e], floor_rad, power)) for e in others)
            yield _foreseen(effect.label, _size_name(effect), seen.get(effect, np.inf), rivals)


def _of_response(loop: ResponseLoop, power: float) -> Iterator[Foreseen]:
    """What a chirp can find, by the response of a run that was made or simulated: the size from which each suspect is
    told from each other one and from what the design's structure and the declared inertia may be wrong by."""
    free, columns = loop.slopes()
    basis, sure = np.linalg.qr(free)[0], float(norm.isf(1.0 - power))
    left = {name: column - basis @ (basis.T @ column) for name, column in columns.items()}
    # The F test has the averages that are not held back, the odds have all.
    found = (float(np.sqrt(chi2.isf(CHANCE / len(loop.suspects), 1))) + sure) / float(np.sqrt(np.mean(~loop.test)))
    apart, scale = np.sqrt(2.0 * LOG_ODDS) + sure, float(np.sqrt(loop.together))
    for one in loop.suspects:
        mine = left[one.parameter]
        # Named by the F test, and by the error that is held back; beyond what the law, the slip and the sensors may do.
        bare = max(found * scale, LEAST_FALL * float(np.sqrt(mine.size))) / float(np.linalg.norm(mine) + 1e-300)
        least = max(_beside(mine, left[name], bare, 2.0 * sigma) for name, sigma in loop.prior.items())
        rivals = []
        for name, (_, _, most) in loop.tolerances.items():
            if name == one.parameter:
                least += most
            else:
                rivals.append((f"{name} within its figures", _beside(mine, left[name], bare, most)))
        for other in loop.suspects:
            if other.name != one.name:
                alone = _without(mine, left[other.parameter])
                rivals.append((other.label, apart * scale / float(np.linalg.norm(alone) + 1e-300)))
        yield _foreseen(one.label, one.figure, least if least <= NEVER * one.size else np.inf, rivals)


def _without(mine: Floats, its: Floats) -> Floats:
    """What another slope leaves of one."""
    return np.asarray(mine - its * float(its @ mine) / (float(its @ its) + 1e-300))


def _beside(mine: Floats, its: Floats, bare: float, most: float) -> float:
    """The size beside a figure that may be wrong by ``most``, or by anything that the response itself shows; ``bare``
    that without it."""
    square, alone = float(mine @ mine) + 1e-300, float(np.linalg.norm(_without(mine, its))) + 1e-300
    return min(bare + most * abs(float(its @ mine)) / square, bare * float(np.sqrt(square)) / alone)
