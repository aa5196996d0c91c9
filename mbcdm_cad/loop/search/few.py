"""The search on few readings, such as a table of turning points: one value a half cycle instead of thousands.

The fits, effects and results are those of the loop on a log. With a dozen readings nothing can be tested by sweeps and
sectors of angle: an effect is named if it lowers the error of the readings held back as the loop asks, and if an F test
on the others, with the noise as its least scatter, finds it by chance in one of a hundred tables at most. Effects
that fit all readings nearly as well form a set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import exp, log

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import t as t_distribution

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.effects.load_sensor import within_class, within_prior
from mbcdm_cad.loop.prepare.noise import doubt_of, runs_of
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.readings import prepare_creep, prepare_readings
from mbcdm_cad.loop.readable import INTERVAL
from mbcdm_cad.loop.result import Evidence, LoopResult, Named
from mbcdm_cad.loop.search.account import as_named, chain_orders, errors, next_steps
from mbcdm_cad.loop.search.class_of_sensor import WithinClass
from mbcdm_cad.loop.search.evidence import TOLD_APART
from mbcdm_cad.loop.search.few_noise import noise_of, since
from mbcdm_cad.loop.search.few_words import (
    CHANCE,
    HIDDEN_PLAY,
    LOST_TRACK,
    LeftOver,
    hangs_on,
    not_testable,
    pictures_of,
    verdict_of,
)
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.measurement.by_hand import path_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

MOST_EFFECTS = 3
# Candidates of each round that are tested, best first.
MOST_TESTED = 4
# Candidates beside which each other one is tried, where none is supported alone.
MOST_PAIRED = 3
# Fits of a candidate, each from where the last one ended.
REFITS = 2
# Levels of which each is left out once, and the share of its size by which an effect may then change.
LEVELS, STEADY_SHARE = 4, 0.5
# A form is taken in place of a later one of the library unless the odds against it are higher.
SAME_FORM = 10.0
# A parameter that changes no reading by this share of the floor, by its typical size, is not known.
FLAT = 1e-3
ODDS = 1.0 / TOLD_APART - 1.0
PLAY = "lash"


class FewReadings:
    """The loop on tables of one drive."""

    def __init__(self, d: DriveSI | None, ratio: float, runs: Sequence[Prepared], known: Sequence[AsBuilt]) -> None:
        self.d, self.ratio, self.prepared = d, ratio, tuple(runs)
        self.fitter = Fitter(d, ratio, self.prepared, known)
        self.fitter.free[:] = False  # offsets of some counts between two inputs are below what few readings tell
        self.at_rest = self.prepared[0].run.kind == CREEP
        shows = _shows_at_rest if self.at_rest else _shows
        offered = [[e for e in library(d, p) if shows(e)] for p in self.prepared]
        labels = [{e.label for e in one} for one in offered]
        self.library = [e for e in offered[0] if all(e.label in one for one in labels)]
        self.bare = self.fitter.fit()
        self.noise, self.noise_freedom = noise_of(self.fitter, self.bare.residual, self.at_rest)
        self.doubts: list[str] = []

    @property
    def floor_rad(self) -> float:
        """The noise floor."""
        return self.noise.total_rad

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        fit, steps, small = self._selected()
        within = self._within()
        if fit.effects and within is not None and self._odds(within, fit) < ODDS:
            fit, steps = within, []  # what the sensor may be wrong by explains as much
        allowed = fit is within
        whole = self.fitter.fit(fit.effects, fit.values, mask=self.fitter.used)
        whole = whole if allowed else self._best_forms(whole)
        alike = {} if allowed else {effect: self._alike(whole, effect) for effect in whole.effects}
        named, sets = [], []
        for effect, (forms, others) in alike.items():
            first = replace(self._named(effect, whole, self._fall(fit, effect.key)), equivalent=forms)
            if others:
                sets.append((first, *(self._named(one.effects[-1], one, 0.0) for one in others)))
            else:
                named.append(first)
        left = self._left(whole)
        untold = self._untold([*named, *(one for group in sets for one in group)], left)
        if untold:
            fit, whole, steps, small, named, sets, left = self.bare, self.bare, [], [], [], [], None
        found = errors(self.fitter, self.bare, fit, self.floor_rad)
        untested = untold or not self.fitter.test.any()
        sizes = zip(fit.effects, fit.values, strict=True)
        return LoopResult(
            "not_testable" if untested else verdict_of([*named, *sets], left),
            tuple(named),
            tuple(sets),
            left,
            found,
            tuple(steps),
            () if allowed else tuple(small),
            (untold,) if untold else not_testable(self.fitter, self.d is not None, self.at_rest),
            next_steps(named, sets, None),
            chain_orders(self.d, self.ratio),
            noise=self.noise,
            pictures=pictures_of(self.fitter, self.ratio, whole, self.at_rest),
            doubts=tuple(self.doubts)
            + ((doubt_of(self.noise, runs_of(self.prepared)),) if self.noise.far_above and not untold else ()),
            within_class=WithinClass(
                tuple((f"{e.name} {e.parameters[0].name}", float(v[0])) for e, v in sizes),
                self.prepared[0].run.sensors.torque_class,
            ).sentence
            if allowed and not untold
            else "",
        )

    def _untold(self, found: Sequence[Named], left: LeftOver | None) -> str:
        """Why errors of a table tell nothing, in words; empty where they do or there are none."""
        if self.loses_track and (found or left):
            return LOST_TRACK
        return HIDDEN_PLAY if self.hides_play and any(one.name == PLAY for one in found) else ""

    @property
    def loses_track(self) -> bool:
        """Whether the load of a design's cables had extremes that no row has."""
        return self.d is not None and not self.at_rest and any(path_of(p.run).hides_load for p in self.prepared)

    @property
    def hides_play(self) -> bool:
        """Whether a play does not show: the torque of each of several inputs crosses zero with the load between rows,
        and where its pulley then rests within a play depends on all that came before."""
        several = max(len(self.d.input_names) if self.d else 1, *(p.angle_rad.shape[0] for p in self.prepared)) > 1
        crosses = any(p.load_Nm is not None and p.load_Nm.min() < 0.0 < p.load_Nm.max() for p in self.prepared)
        return several and crosses and not self.at_rest

    # Selection.

    def _selected(self) -> tuple[Fit, list[Evidence], list[Evidence]]:
        """The fit with the effects that the readings support; what was accepted, and what was too small."""
        now, steps, small = self.bare, list[Evidence](), list[Evidence]()
        for _ in range(MOST_EFFECTS):
            trials = [t for e in self._candidates(now) if (t := self._best(now, e)) is not None]
            trials.sort(key=self._criterion)
            following = next((t for t in trials[:MOST_TESTED] if self._supported(now, t)), None) or self._pair(
                now, trials
            )
            small = [
                Evidence(
                    t.effects[-1].label,
                    self._held(t),
                    float(np.sqrt(max(0.0, now.square - t.square))),
                    "too small to name",
                )
                for t in trials[:5]
                if t.square < now.square
            ]
            if following is None:
                break
            fall = float(np.sqrt(max(0.0, self._held(now) ** 2 - self._held(following) ** 2)))
            new = " with ".join(e.label for e in following.effects[len(now.effects) :])
            steps.append(Evidence(new, self._held(following), fall, "accepted"))
            now = following
        return self._without_needless(now), steps, small

    def _pair(self, now: Fit, trials: Sequence[Fit]) -> Fit | None:
        """Two effects of which each needs the other, such as a creep and a warming against it: the best that is
        supported; None if there is none."""
        found = []
        for trial in trials[:MOST_PAIRED]:
            for effect in self._candidates(trial):
                one = self._best(trial, effect)
                if one is not None:
                    found.append(one)
        found.sort(key=self._criterion)
        for one in found[:MOST_TESTED]:
            both = one.effects[-2:]
            if all(self._supported(self._without(one, e), one.with_last(e)) for e in both):
                return one
        return None

    def _candidates(self, fit: Fit) -> list[Effect]:
        """Effects that may join a fit: one form of each name."""
        taken = {e.key for e in fit.effects}
        return [e for e in self.library if e.key not in taken and not e.unmeasured]

    def _best(self, fit: Fit, effect: Effect) -> Fit | None:
        """The best fit with one effect more, over its starts; None if it cannot be simulated or no such part exists."""
        found = []
        for start in self.fitter.guesses(effect, fit.residual):
            values: Sequence[Floats | list[float]] = (*fit.values, start)
            for _ in range(REFITS):  # a place has no slope at size zero, where a fit begins
                one = self.fitter.tried((*fit.effects, effect), values, fit.offsets)
                if one is None:
                    break
                found.append(one)
                values = one.values
        best = min(found, key=lambda one: one.square, default=None)
        if best is not None and effect.doubtful and (words := effect.doubtful(best.values[-1])):
            if self._supported(fit, best) and words not in self.doubts:
                self.doubts.append(words)
            return None
        return best

    def _criterion(self, fit: Fit) -> float:
        """Bayes' criterion on the training readings."""
        n = int(self.fitter.train.sum())
        return n * log(max(fit.square, (0.1 * self.floor_rad) ** 2, 1e-40)) + fit.width * log(n)

    def _held(self, fit: Fit) -> float:
        """RMS error of the readings held back."""
        test = fit.residual[self.fitter.test]
        return float(np.sqrt(np.mean(test**2))) if test.size else 0.0

    def _supported(self, less: Fit, more: Fit) -> bool:
        """Whether both the readings held back and the others support the last effect of ``more`` beside ``less``."""
        fall = self._held(less) ** 2 - self._held(more) ** 2
        clear = fall >= (LEAST_FALL * self.floor_rad) ** 2
        return clear and self._by_chance(less, more) < CHANCE / len(self.library) and self._steady(more)

    def _steady(self, fit: Fit) -> bool:
        """Whether the size of the last effect stays within a share of itself whichever level of the readings is left
        out: what only imitates another cause at one level does not."""
        f, sizes = self.fitter, [p.role == "size" for p in fit.effects[-1].parameters]
        at = np.flatnonzero(f.train)
        level = np.argsort(np.argsort(self._level()[at], kind="stable")) * LEVELS // at.size
        for k in range(LEVELS):
            mask = f.train.copy()
            mask[at[level == k]] = False
            other = f.fit(fit.effects, fit.values, fit.offsets, mask=mask)
            moved = np.linalg.norm((other.values[-1] - fit.values[-1])[sizes])
            if moved > STEADY_SHARE * np.linalg.norm(fit.values[-1][sizes]):
                return False
        return True

    def _level(self) -> Floats:
        """What the readings differ by, (n,): the size of the load, or the angle where no load was read; the time."""
        runs = self.fitter.runs
        if self.at_rest:
            return np.concatenate([since(p) for p in runs])
        return np.concatenate([np.abs(p.output_rad) if p.load_Nm is None else np.abs(p.load_Nm) for p in runs])

    def _by_chance(self, less: Fit, more: Fit) -> float:
        """Probability of such a fall of the squares of the training readings without an effect (F test)."""
        n, extra = int(self.fitter.train.sum()), more.width - less.width
        freedom = n - more.width - len(self.prepared)
        if freedom < 1:
            return 1.0
        own = more.square * n / freedom
        scatter, freedom = max((own, freedom), (self.floor_rad**2, self.noise_freedom))
        return float(f_distribution.sf((less.square - more.square) * n / extra / scatter, extra, freedom))

    def _without_needless(self, fit: Fit) -> Fit:
        """The fit without effects that the later ones have made needless."""
        while len(fit.effects) > 1:
            less = {effect: self._without(fit, effect) for effect in fit.effects}
            needless = [one for e, one in less.items() if not self._supported(one, fit.with_last(e))]
            if not needless:
                break
            fit = min(needless, key=lambda one: one.square)
        return fit

    def _without(self, fit: Fit, effect: Effect) -> Fit:
        kept = [(e, v) for e, v in zip(fit.effects, fit.values, strict=True) if e is not effect]
        return self.fitter.fit([e for e, _ in kept], [v for _, v in kept], fit.offsets)

    def _fall(self, fit: Fit, key: object) -> float:
        """How much an effect lowers the error of the readings held back, in any of its forms."""
        less = self._without(fit, next(e for e in fit.effects if e.key == key))
        return float(np.sqrt(max(0.0, self._held(less) ** 2 - self._held(fit) ** 2)))

    # Alternatives.

    def _within(self) -> Fit | None:
        """A fit of what load and figures of the design may be wrong by; None where nothing may be."""
        effects = [e for e in (*within_class(self.prepared), *within_prior(self.prepared)) if "lag" not in e.name]
        return (
            self.fitter.tried(effects, [[0.0] * len(e.parameters) for e in effects], self.bare.offsets)
            if effects
            else None
        )

    def _odds(self, worse: Fit, better: Fit) -> float:
        """Odds of one fit against another by all used readings, each with its number of values counted."""
        used, free = self.fitter.used, better.width + len(self.prepared)
        n = int(used.sum())
        squares = [float(np.sum(self.fitter.centred(one.residual, used)[used] ** 2)) for one in (worse, better)]
        variance = max(squares[1] / max(n - free, 1), self.floor_rad**2)
        return odds_of((squares[0] - squares[1]) / variance, worse.width - better.width, n)

    def _best_forms(self, whole: Fit) -> Fit:
        """The fit of all readings with each effect in the first form of the library that fits them as well as any."""
        for key in [effect.key for effect in whole.effects]:
            rest = self._rest(whole, next(e for e in whole.effects if e.key == key))
            trials = [self._best(rest, other) for other in self.library if other.key == key]
            forms = [self.fitter.fit(t.effects, t.values, mask=self.fitter.used) for t in trials if t is not None]
            best = min([*forms, whole], key=lambda one: self._odds(one, whole))
            whole = next((one for one in forms if self._odds(one, best) < SAME_FORM), best)
        return whole

    def _rest(self, whole: Fit, effect: Effect) -> Fit:
        """The fit of all readings without one of its effects."""
        last = whole.with_last(effect)
        return self.fitter.fit(last.effects[:-1], last.values[:-1], mask=self.fitter.used)

    def _alike(self, whole: Fit, effect: Effect) -> tuple[tuple[str, ...], list[Fit]]:
        """Other forms of an effect, and fits with another effect in its place, that are nearly as good."""
        rest = self._rest(whole, effect)
        keys = {e.key for e in rest.effects}
        forms, fits = list[str](), dict[object, Fit]()
        for other in self.library:
            if other is effect or other.key in keys:
                continue
            one = self._best(rest, other)
            if one is None:
                continue
            one = self.fitter.fit(one.effects, one.values, mask=self.fitter.used)
            if self._odds(one, whole) >= ODDS:
                continue
            if other.key == effect.key:
                forms.append(other.form)
            elif other.key not in fits or one.square < fits[other.key].square:
                fits[other.key] = one
        return tuple(forms), sorted(fits.values(), key=lambda one: one.square)

    # Judgement.

    def _named(self, effect: Effect, whole: Fit, fall: float) -> Named:
        """An effect with the intervals that all used readings give, wider by what the load may be wrong by."""
        f, used = self.fitter, self.fitter.used
        columns = f.centred_on(used, whole.jacobian)
        freedom = max(columns.shape[0] - columns.shape[1] - len(self.prepared), 1)
        square = float(np.sum(f.centred(whole.residual, used)[used] ** 2)) / freedom
        variance, freedom = max((square, freedom), (self.floor_rad**2, self.noise_freedom))
        length = np.linalg.norm(columns, axis=0)
        length[length == 0.0] = 1.0
        scaled = columns / length
        inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-10, hermitian=True) / np.outer(length, length)
        wider = (float(t_distribution.isf(0.025, freedom)) / INTERVAL) ** 2
        covariance = variance * wider * inverse
        for e in (*within_class(self.prepared), *within_prior(self.prepared)):
            at, parameter = [np.zeros(len(e.parameters))], e.parameters[0]
            step = 0.1 * parameter.size
            base = f.predict(whole.effects, whole.values, whole.offsets)
            changed = f.predict((*whole.effects, e), (*whole.values, at[0] + step), whole.offsets)
            turned = inverse @ columns.T @ f.centred_on(used, (changed - base) / step)
            sigma = 0.5 * max(parameter.high, -parameter.low)
            covariance = covariance + sigma**2 * np.outer(turned, turned)
        own, values = whole.columns_of(effect), whole.values_of(effect)
        named = as_named(effect, values, covariance[own, own], fall, "")
        # A place that changes nothing between the readings has no figure; of such a size only a lower bound is known.
        flat = (
            np.linalg.norm(columns[:, own], axis=0) * np.array([p.size for p in effect.parameters])
            < FLAT * self.floor_rad
        )
        figures = dict(named.parameters)
        for p, value, here in zip(effect.parameters, values, flat, strict=True):
            if p.role == "place" and effect.name == PLAY:
                figures.pop(p.name, None)  # where the contact changes sides lies between two rows
            elif here and p.name in figures:
                bound = replace(figures.pop(p.name), low=float(value), high=np.inf)
                figures |= {p.name: bound} if p.role == "size" else {}
        return replace(named, parameters=figures)

    def _left(self, whole: Fit) -> LeftOver | None:
        """What is left of all readings, with all of them fitted; None if it is no more than the noise. Where nothing
        was found, the declared model must also foretell the readings held back as well as that."""
        f, used = self.fitter, self.fitter.used
        r = f.centred(whole.residual, used)[used]
        each = [(r, max(r.size - whole.width - len(self.prepared), 1))]
        if not whole.effects and f.test.any():
            held = self.bare.residual[f.test]
            each.append((held, held.size))
        noise = max(self.floor_rad, 1e-30) ** 2
        chances = [f_distribution.sf(float(e @ e) / n / noise, n, self.noise_freedom) for e, n in each]
        if min(chances) > CHANCE / len(each):
            return None
        rms, peak = float(np.sqrt(np.mean(r**2))), float(np.abs(r).max())
        return LeftOver(rms, peak, self.floor_rad, (), (), 0.0, (), hangs_on=hangs_on(self.fitter, r, self.at_rest))


def odds_of(rise: float, more: int, n: int) -> float:
    """Odds against a fit of n values whose squares, over their variance, are larger by ``rise``, with ``more`` figures,
    by Bayes' criterion."""
    return exp(min(0.5 * (rise + more * log(n)), 700.0))


def prepared_by_hand(run: Run, ratio: float) -> Prepared:
    """A table as its kind needs it."""
    return prepare_creep(run, ratio) if run.kind == CREEP else prepare_readings(run, ratio)


def judged_by_hand(d: DriveSI | None, ratio: float, runs: Sequence[Run], known: Sequence[AsBuilt]) -> LoopResult:
    """The finding from tables of one kind. What begins late at rest, as a warming, is not foretold by what came before:
    where an unknown part is left, every third reading is held back in place of the later ones."""
    first = FewReadings(d, ratio, [prepared_by_hand(run, ratio) for run in runs], known).result()
    if runs[0].kind != CREEP or first.unknown is None:
        return first
    other = FewReadings(d, ratio, [prepare_creep(run, ratio, later=False) for run in runs], known).result()
    return first if other.unknown is not None or other.verdict == "none" else other


def _shows(effect: Effect) -> bool:
    """Whether a table can show an effect: none of time or speed, no line, no event, no shape without a cause."""
    hangs = effect.hangs_on in ("time", "temperature", "speed", "the path travelled") or "lag" in effect.name
    return not (hangs or effect.last or effect.once or effect.base or effect.order_index is not None or effect.inside)


def _shows_at_rest(effect: Effect) -> bool:
    """Whether readings at rest can show an effect: one of time or temperature."""
    return effect.hangs_on in ("time", "temperature") and not (effect.once or effect.base)
