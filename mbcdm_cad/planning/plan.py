"""Predict the finding of a planned run: the smallest size of each effect that is named, and its rivals.

The Jacobians, the noise and the evidence are those of the loop, on the planned motion and load. The data of an effect
of size s are s times a column, beside the noise, so that the logarithm of the evidence of every model is quadratic in
s, and follows from one Gram matrix of all whitened columns with nuisances and each hypothesis of an unknown cause
integrated out. The noise makes the odds a noncentral chi-square. Effects of one size that strain the cables are taken
at their size; all else, the rivals too, is linear in the sizes, so valid for small effects.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import chndtrix, logsumexp
from scipy.stats import norm

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.effects.load_sensor import UNPLANNED
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.result import Named, Noise
from mbcdm_cad.loop.search.account import stated
from mbcdm_cad.loop.search.by_evidence import Posterior, spread_of
from mbcdm_cad.loop.search.evidence import CREDIBLE, FREEDOM, LEAST_FALL, LOG_ODDS, NoiseModel, Whitened
from mbcdm_cad.loop.search.few import PLAY, FewReadings, prepared_by_hand
from mbcdm_cad.loop.search.fit import DIFFERENCE, FitRows, Fitter
from mbcdm_cad.loop.search.response import ResponseLoop
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP, FREQUENCY_RESPONSE, MOTION, TURNING_POINTS
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.measurement.vet_signals import friction_alike, friction_words
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

# Effects that may stand for one, the likeliest where it does as much as the noise.
NEAR = 3
# The least size that is looked for, over that which does as much as the noise; the greatest over the least, and over
# that which is named; the factor between two that are tried.
LEAST, MOST, FACTOR = 1e-2, 1e8, 3.0


@dataclass(frozen=True, eq=False)
class Shown:
    """How an effect shows: derivatives of the prediction by its sizes and then by its places over its size, (n, k + p);
    ``place_sd`` (p,): priors of the places; ``log_prior``: logarithm of the odds against an effect of its kind;
    ``data`` (n,): what it does at size 1, None: at the phase that shows least."""

    columns: Floats
    place_sd: Floats = field(default_factory=lambda: np.zeros(0))
    log_prior: float = 0.0
    data: Floats | None = None

    @property
    def sizes(self) -> int:
        """Number of its sizes."""
        return int(self.columns.shape[1]) - self.place_sd.size


class Foresight:
    """Effects on the rows of one run; ``freedom``: degrees of freedom with which the size of the noise is known;
    ``floor``: of the error, if it is another than that of the whitened noise."""

    def __init__(
        self, white: Whitened, shown: Sequence[Shown], names: int, freedom: float = np.inf, floor: float | None = None
    ) -> None:
        self.white, self.shown, self.names, self.freedom = white, tuple(shown), names, freedom
        self.floor = white.noise.floor_rad if floor is None else floor
        each = [one.columns for one in self.shown]
        ends = np.cumsum([0, *(one.shape[1] for one in each)])
        self.own = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        given = [one.data for one in self.shown if one.data is not None]
        columns = np.column_stack([*each, *given])
        gram, self.logs = self._beyond(columns)
        # Least at every phase, in the likeliest case that nothing else is there.
        data = np.zeros((columns.shape[1], len(self.shown)))
        extra = iter(range(int(ends[-1]), columns.shape[1]))
        for i, (one, own) in enumerate(zip(self.shown, self.own, strict=True)):
            if one.data is not None:
                data[next(extra), i] = 1.0
                continue
            sizes = slice(own.start, own.start + one.sizes)
            data[sizes, i] = np.linalg.eigh(gram[0][sizes, sizes])[1][:, 0]
        # Of the data with each other's columns and with themselves, under each hypothesis of the unknown (h, ...).
        self.gram, self.on_data = gram, gram @ data
        self.square = np.einsum("mi,hmi->hi", data, self.on_data)
        self.rms = np.sqrt(np.mean((columns - columns.mean(axis=0)) ** 2, axis=0))
        made = columns @ data
        self.does = np.sqrt(np.mean((made - made.mean(axis=0)) ** 2, axis=0))

    def _beyond(self, columns: Floats) -> tuple[Floats, Floats]:
        """Products of whitened columns with nuisances and an unknown cause integrated out, for each hypothesis of it
        (h, m, m), and the logarithm of its prior over its Occam factor (h,), with what the noise alone gives it."""
        white = self.white
        gram, on_z = white.parts(columns)
        q = white.bounds.shape[1]
        found, logs = [], -np.array(white.log_curves)
        for h in range(logs.size):
            axes, weights = white.hypothesis(h)
            inner = gram - on_z[axes].T @ (weights[:, None] * on_z[axes])
            root = np.linalg.cholesky(np.eye(q) + inner[:q, :q])
            across = np.linalg.solve(root, inner[:q, q:])
            found.append(inner[q:, q:] - across.T @ across)
            freedom = float(weights @ np.sum(white.curves[:, axes] ** 2, axis=0))
            logs[h] += 0.5 * freedom - float(np.log(np.diag(root)).sum())
        return np.array(found), logs

    def _evidence(self, i: int, j: int | None, size: float) -> tuple[Floats, Floats]:
        """Logarithm of the evidence of data of effect ``i`` of a size without noise, under each hypothesis of the
        unknown, with effect ``j`` or none fitted; and what that leaves of half the square of the data."""
        left = 0.5 * size**2 * self.square[:, i]
        if j is None:
            return self.logs - left, left
        one, own = self.shown[j], self.own[j]
        whole = float(np.hypot(self.white.noise.floor_rad, size * self.does[i]))
        # A place moves more data, the larger the effect is.
        sd = np.append(whole / np.maximum(self.rms[own][: one.sizes], 1e-300), one.place_sd * size)
        inner = np.eye(sd.size) + self.gram[:, own, own] * np.outer(sd, sd)
        root = np.linalg.cholesky(inner)
        across = np.linalg.solve(root, (sd * size * self.on_data[:, own, i])[..., None])[..., 0]
        left = np.maximum(left - 0.5 * np.sum(across**2, axis=1), 0.0)
        occam = np.log(np.einsum("hii->hi", root)).sum(axis=1)
        return self.logs - left - occam - one.log_prior, left

    def log_odds(self, i: int, mine: Sequence[int], its: int | None, size: float, power: float) -> float:
        """Logarithm of the odds of effects, each as likely beforehand, against another one or none, that data of effect
        ``i`` of a size give with this probability."""
        each, other = [self._evidence(i, j, size) for j in mine], self._evidence(i, its, size)
        plain = float(logsumexp([logs for logs, _ in each]) - logsumexp(other[0]))
        least = min(float(left[np.argmax(logs)]) for logs, left in each)
        strength = max(float(other[1][np.argmax(other[0])]) - least, 1e-12)
        width = self.shown[i].columns.shape[1] if its is None else 1
        drawn = 0.5 * float(chndtrix(1.0 - power, width, 2.0 * strength))
        if np.isfinite(self.freedom):  # of a noise of unknown size
            drawn = 0.5 * self.freedom * float(np.log1p(2.0 * drawn / self.freedom))
        return plain - strength + drawn

    def smallest(self, i: int, power: float) -> float:
        """Size from which an effect is named, by its name or in a set: by its odds, and by the fall of the error;
        infinite if there is none."""
        if not self.does[i] > 0.0:
            return np.inf
        sure = float(norm.isf(1.0 - power)) / np.sqrt(max(float(self.square[0, i]), 1e-300))
        return max(self.likely(i, power), LEAST_FALL * self.floor / float(self.does[i]) + float(sure))

    def likely(self, i: int, power: float) -> float:
        """Size from which an effect, or one of those that stand for it, is likely enough, counted over all names, and
        it is itself in the set of these."""
        needed = LOG_ODDS + float(np.log(self.names))
        least = self.floor / float(self.does[i])
        logs = {j: float(logsumexp(self._evidence(i, j, least)[0])) for j in range(len(self.shown))}
        near = sorted(logs, key=lambda j: -logs[j])[:NEAR]
        own = sorted({i, *near})

        def beyond(size: float) -> float:
            mine = float(logsumexp(self._evidence(i, i, size)[0]))
            best = max(float(logsumexp(self._evidence(i, j, size)[0])) for j in own)
            return min(self.log_odds(i, own, None, size, power) - needed, mine - best - float(np.log(1.0 - CREDIBLE)))

        return _least(beyond, LEAST * least, MOST)

    def apart(self, i: int, j: int, power: float, named: float) -> float:
        """Size, from that with which it is named, from which an effect is told from another; infinite if there is
        none."""
        return _least(lambda s: self.log_odds(i, [i], j, s, power) - LOG_ODDS, named, ANY_SIZE)

    def wrong(self, i: int, j: int) -> float:
        """Probability to take effect ``j`` for effect ``i`` of size 1."""
        left = self._evidence(i, j, 1.0)[1][0] - self._evidence(i, i, 1.0)[1][0]
        return float(norm.sf(0.5 * np.sqrt(2.0 * max(left, 0.0))))


def _least(beyond: Callable[[float], float], first: float, most: float) -> float:
    """The least size, from ``first`` up to so many times it, with which a function is above zero."""
    low = high = first
    while beyond(high) <= 0.0:
        low, high = high, FACTOR * high
        if high > most * first:
            return np.inf
    if high == first:
        return first
    return float(np.exp(brentq(lambda x: beyond(float(np.exp(x))), np.log(low), np.log(high), xtol=1e-2)))


POWER = 0.9
# Orders of ripple that are planned, cycles a turn of the output.
ORDERS = (20.0, 200.0)
# A size that strains the cables is found in so many rounds, each at the size of the last, to within this share.
ROUNDS, SETTLED = 8, 0.02
# An effect that would have to be so many times its typical size, or beyond its bound, is never seen in the run.
NEVER = 1e4
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
    friction_alike: tuple[str, ...] = ()
    proposals: tuple[str, ...] = ()
    moves: bool = True

    def to_json(self) -> dict[str, Any]:
        """For a file."""
        told = {"effects": [asdict(one) for one in self.effects], "friction_alike": list(self.friction_alike)}
        return {"power": POWER, "noise": self.noise.to_json(), **told}

    def text(self) -> str:
        """For the terminal."""
        width = max(len(one.label) for one in self.effects)
        lines = [
            f"noise floor {1e6 * self.noise.total_rad:.3g} urad ({self.noise.source})",
            "",
            f"{'effect':<{width}}  {f'named from (power {POWER:g})':<34}  not told from, below",
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
    shown = [(sign, *readable(one.parameter, [size])) for sign, size in signed if size is not None]
    return f"{shown[0][1]} " + " or ".join(sign + words[0] for sign, _, words in shown)


def _words(parameter: str, size: float | None) -> str:
    if size is None:
        return "at any size"
    word, shown = readable(parameter, [size])
    return f"{word} {shown[0]}"


def noise_from(drive: Drive, run: Run) -> Noise:
    """The noise of a measured run, for planning other runs."""
    return _planned(drive, run).noise


def plan_of(drive: Drive, run: Run, noise: Noise | None = None, power: float = POWER) -> RunPlan:
    """What a run can find on a drive, with the ``noise`` of a pilot run; named with the probability ``power``."""
    planned = _planned(drive, run, noise)
    found = tuple(planned.foreseen(power))
    if not isinstance(planned, PlannedMotion):
        return RunPlan(planned.noise, found, moves=False)
    p = planned.fitter.runs[0]
    return RunPlan(planned.noise, found, tuple(friction_alike(p.speed_rad_s, p.load_Nm)), _proposals(run, found))


def _planned(drive: Drive, run: Run, noise: Noise | None = None) -> "PlannedMotion | PlannedReadings | PlannedResponse":
    if run.kind == MOTION:
        return PlannedMotion(drive, run, noise)
    return (PlannedResponse if run.kind == FREQUENCY_RESPONSE else PlannedReadings)(drive, run, noise)


@dataclass(frozen=True, eq=False)
class Planned:
    """An effect at the place ``at``, with its ``label`` in the plan; ``key`` is its name, ``parameter`` its first size,
    of which ``size`` is typical and ``most`` the greatest."""

    label: str
    key: object
    parameter: str
    size: float
    most: float


def _first_size(effect: Effect) -> int:
    return next(k for k, p in enumerate(effect.parameters) if p.role == "size")


def _candidate(effect: Effect, label: str) -> Planned:
    first = effect.parameters[_first_size(effect)]
    # The amplitude of a wave has the same unit.
    name = first.name.replace("cosine_", "amplitude_")
    return Planned(label, effect.key, name, first.size, min(max(first.high, -first.low), NEVER * first.size))


def _foreseen(
    effects: Foresight, candidates: Sequence[Planned], power: float, sizes: Sequence[tuple[float, float]] | None = None
) -> Iterator[Foreseen]:
    """What is foreseen of each candidate; ``sizes``: the positive and the negative one from which each is named."""
    both = sizes or [(effects.smallest(i, power),) * 2 for i in range(len(candidates))]
    possible = [[each for each in signed if each <= one.most] for one, signed in zip(candidates, both, strict=True)]
    least = [max(signed, default=np.inf) for signed in possible]
    for i, (one, size, signed) in enumerate(zip(candidates, least, both, strict=True)):
        if not np.isfinite(size):
            yield Foreseen(one.label, one.parameter, None, ())
            continue
        others = [j for j, other in enumerate(candidates) if other.key != one.key and np.isfinite(least[j])]
        from_size = {j: effects.apart(i, j, power, size) for j in others}
        worst = sorted((j for j in others if from_size[j] > size), key=lambda j: -from_size[j])[:MOST_RIVALS]
        rivals = [Rival(candidates[j].label, at if (at := from_size[j]) < np.inf else None) for j in worst]
        found = Foreseen(one.label, one.parameter, size, tuple(rivals))
        positive, negative = (each if each <= one.most else None for each in signed)
        if positive is None or negative is None or abs(positive / negative - 1.0) > SAME_SIZE:
            found = replace(found, if_positive=positive, if_negative=negative)
        yield found


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


class PlannedMotion:
    """The effects of the library on one planned motion; ``noise`` of a pilot run, else of this one."""

    def __init__(self, drive: Drive, run: Run, noise: Noise | None = None) -> None:
        self.fitter = planned_fitter(drive, run)
        self.bare = self.fitter.fit(rows=FitRows(self.fitter.used))
        p = self.fitter.runs[0]
        self.library = [effect for effect in library(self.fitter.d, p) if not effect.inside]
        posterior = Posterior(self.fitter, self.bare, len({effect.key for effect in self.library}))
        problem = posterior.problem
        nuisances = problem.nuisances_of(self.bare)
        if noise is None:
            rms = [np.sqrt(np.mean(one.columns**2, axis=0)) for *_, one in self.shown]
            sizes = [problem.prior_rad / np.maximum(row, 1e-300) for row in rms]
            known = [(one.columns, sd) for (*_, one), sd in zip(self.shown, sizes, strict=True)]
            noise = stated(problem.noise_of(self.bare, nuisances, known), p.floor_rad)
        self.noise = noise
        model = NoiseModel(noise.white_rad, noise.coloured_rad, noise.memory_s, problem.step_s, problem.starts)
        posterior.weigh(model, nuisances)
        self.white, self.names = posterior.white, posterior.names

    @cached_property
    def shown(self) -> list[tuple[Effect, str, Floats, Shown]]:
        """Each effect, its label, the place that is planned, and how it shows there."""
        found = []
        for effect in self.library:
            if effect.base is not None or effect.name in UNPLANNED:
                continue
            places: Sequence[Sequence[float]] = [[0.0] * len(effect.parameters)]
            labels = [effect.label]
            if effect.order_index is not None:
                places = [[0.0] * effect.order_index + [order] for order in ORDERS]
                labels = [f"{effect.name} of order {order:g}" for order in ORDERS]
            elif any(p.role == "place" for p in effect.parameters):
                guesses = effect.first_guesses(self.fitter.base[0], self.bare.residual)
                places = [guesses[len(guesses) // 2]]
            for place, label in zip(places, labels, strict=True):
                at = np.where([p.role == "size" for p in effect.parameters], 0.0, place)
                try:
                    found.append((effect, label, at, self.at(effect, at, [p.size for p in effect.parameters])))
                except ModelError:
                    continue
        return found

    def change(self, effect: Effect, values: Floats) -> Floats:
        """What an effect with these values does to the rows in use, rad."""
        f, used = self.fitter, self.fitter.used
        base = f.output - self.bare.residual
        return np.asarray(f.centred(f.predict([effect], [values], self.bare.offsets) - base, used)[used])

    def at(self, effect: Effect, at: Floats, steps: Sequence[float]) -> Shown:
        """How an effect shows by changes of each of its sizes by ``steps``."""
        columns, places, spreads, first = [], [], [], _first_size(effect)
        for k, parameter in enumerate(effect.parameters):
            moved = at.copy()
            if parameter.role == "size":
                moved[k] += steps[k]
                columns.append(self.change(effect, moved) / steps[k])
                continue
            moved[first] += steps[first]
            before = self.change(effect, moved)
            step = DIFFERENCE * parameter.size
            moved[k] += step if at[k] + step <= parameter.high else -step
            places.append((self.change(effect, moved) - before) / (moved[k] - at[k]) / steps[first])
            spreads.append(spread_of(parameter, at[k]))
        return Shown(np.stack([*columns, *places], axis=1), np.array(spreads), LOG_ODDS * effect.last)

    def found(self, named: Named) -> Shown | None:
        """How an effect shows that a loop named, at the size that was found; None where the run does not allow it."""
        key = named.name, named.stage, named.cables
        effect = next((one for one in self.library if one.key[:3] == key and one.form == named.form), None)
        if effect is None:
            return None
        at, steps = (
            np.array([named.fitted[p.name] for p in effect.parameters]),
            [0.1 * p.size for p in effect.parameters],
        )
        data = self.change(effect, at)
        slopes = [(self.change(effect, at + moved) - data) / moved.max() for moved in np.diag(steps)]
        return Shown(np.stack(slopes, axis=1), data=data - self.change(effect, 0.0 * at))

    def foreseen(self, power: float) -> Iterator[Foreseen]:
        """What the motion can find."""
        effects = Foresight(self.white, [one for *_, one in self.shown], self.names)
        sizes = [
            self._sizes(effect, at, effects.smallest(i, power), power)
            for i, (effect, _, at, _) in enumerate(self.shown)
        ]
        return _foreseen(effects, [_candidate(effect, label) for effect, label, *_ in self.shown], power, sizes)

    def _sizes(self, effect: Effect, at: Floats, start: float, power: float) -> tuple[float, float]:
        """The positive and the negative size from which an effect is named; equal where the sign makes none."""
        several = sum(p.role == "size" for p in effect.parameters) > 1
        # A play at an input has no slope: it is taken as it shows at its usual size.
        if several or self.fitter.kind(effect) or effect.saturates or not np.isfinite(start):
            return start, start
        positive = self._bent(effect, at, 1.0, start, power)
        signed = effect.parameters[_first_size(effect)].low < 0.0
        return positive, self._bent(effect, at, -1.0, start, power) if signed else positive

    def _bent(self, effect: Effect, at: Floats, sign: float, start: float, power: float) -> float:
        """Size of one sign of an effect that strains the cables, taken as it shows at that size: a low preload shows
        more than a high one. Infinite if no part can have it."""
        parameter = effect.parameters[_first_size(effect)]
        most = min(parameter.high if sign > 0.0 else -parameter.low, NEVER * parameter.size)
        size = min(start, most)
        for _ in range(ROUNDS):
            try:
                shown = self.at(effect, at, [sign * size] * len(effect.parameters))
            except ModelError:  # a cable is slack: far more than has to be shown
                most = size = 0.7 * size
                continue
            found = Foresight(self.white, [shown], self.names).smallest(0, power)
            if abs(found / size - 1.0) < SETTLED:
                return found
            if found > size == most:
                return np.inf
            size = min(found, most)
        return np.inf if size == most else size


def planned_fitter(drive: Drive, run: Run) -> Fitter:
    """The fitter of one run, measured or planned."""
    d = layout_of(drive).si
    ratio = float(np.mean(d.total_ratio))
    return Fitter(d, ratio, [prepare(arranged(run, drive), ratio)[0]], drive.as_built)


class PlannedReadings:
    """Readings by hand that are planned, or were made, on a drive; slopes are those at size zero."""

    def __init__(self, drive: Drive, run: Run, noise: Noise | None = None) -> None:
        d = layout_of(drive).si
        ratio = float(np.mean(d.total_ratio))
        self.few = FewReadings(d, ratio, [prepared_by_hand(arranged(run, drive), ratio)], drive.as_built)
        self.noise = noise or self.few.noise
        self.few.weigh(NoiseModel(self.noise.total_rad), self.few.nuisances)

    def foreseen(self, power: float) -> Iterator[Foreseen]:
        """What the readings can find."""
        few, told = self.few, {}
        hidden = [e for e in few.slopes if few.loses_track or (few.hides_play and e.name == PLAY)]
        if slopes := {e: one for e, one in few.slopes.items() if e not in hidden}:
            shown = [Shown(np.hstack([sizes, places]), sd) for sizes, places, sd in slopes.values()]
            freedom = int(few.used.sum()) - len(few.prepared) - 1 + FREEDOM
            each = _foreseen(
                Foresight(few.white, shown, few.names, freedom), [_candidate(e, e.label) for e in slopes], power
            )
            told = dict(zip(slopes, each, strict=True))
        for e in few.offered:
            yield told.get(e) or Foreseen(e.label, _candidate(e, e.label).parameter, None, ())


class PlannedResponse:
    """What a chirp can find, by the response of a run that was made or simulated, with its own noise."""

    def __init__(self, drive: Drive, run: Run, _: Noise | None = None) -> None:
        self.loop = ResponseLoop(drive, float(np.mean(layout_of(drive).si.total_ratio)), [arranged(run, drive)])
        self.noise = self.loop.noise

    def foreseen(self, power: float) -> Iterator[Foreseen]:
        """What the chirp can find."""
        white, slopes = self.loop.planned()
        shown = [Shown(row[:, None]) for row in slopes.values()]
        sizes = {one: one.shapes[one.parameter][0] for one in slopes}
        each = [Planned(one.label, one.key, one.figure, size, NEVER * size) for one, size in sizes.items()]
        return _foreseen(Foresight(white, shown, self.loop.names, floor=1.0), each, power)
