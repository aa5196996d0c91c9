"""The search on few readings, such as a table of turning points: one value a half cycle instead of thousands.

The fits, effects and results are those of the loop on a log. With a dozen readings nothing can be tested by sweeps and
sectors of angle: an effect is named if it lowers the error of the readings held back as the loop asks, and if an F test
on the others, with the noise as its least scatter, finds it by chance in one of a hundred tables at most. Effects
that fit all readings nearly as well form a set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

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
from mbcdm_cad.loop.result import LoopResult, Named
from mbcdm_cad.loop.search.account import as_named, chain_orders, errors, next_steps
from mbcdm_cad.loop.search.class_of_sensor import WithinClass
from mbcdm_cad.loop.search.evidence import LOG_ODDS
from mbcdm_cad.loop.search.few_readings import (
    CHANCE,
    HIDDEN_PLAY,
    LOST_TRACK,
    LeftOver,
    hangs_on,
    noise_of,
    not_testable,
    pictures_of,
    since,
    verdict_of,
)
from mbcdm_cad.loop.search.fit import Fit, Fitter, Rows
from mbcdm_cad.loop.search.selection import Selection
from mbcdm_cad.measurement.by_hand import path_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# Fits of a candidate, each from where the last one ended.
REFITS = 2
# Levels of which each is left out once, and the share of its size by which an effect may then change.
LEVELS, STEADY_SHARE = 4, 0.5
# A form is taken in place of a later one of the library unless the logarithm of the odds against it is higher.
SAME_FORM = log(10.0)
# A parameter that changes no reading by this share of the floor, by its typical size, is not known.
FLAT = 1e-3
PLAY = "lash"


class FewReadings(Selection[Fit]):
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
        self.floor_rad = self.noise.total_rad
        self.doubts: list[str] = []

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        fit, steps, small = self.selected(self.bare)
        within = self._within()
        if fit.effects and within is not None and self.log_odds(within, fit) < LOG_ODDS:
            fit, steps = within, []  # what the sensor may be wrong by explains as much
        allowed = fit is within
        whole = self.fitter.fit(fit.effects, fit.values, rows=Rows(self.fitter.used))
        whole = whole if allowed else self._best_forms(whole)
        lesser = {e.key: self.without(fit, e) for e in fit.effects}
        named, sets = [], []
        for effect in () if allowed else whole.effects:
            forms, others = self._alike(whole, effect)
            first = replace(self._named(effect, whole, self.fall(lesser[effect.key], fit)), equivalent=forms)
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

    def offered(self, fit: Fit) -> list[Effect]:
        """Effects that may join a fit: one form of each name."""
        taken = {e.key for e in fit.effects}
        return [e for e in self.library if e.key not in taken and not e.unmeasured]

    def best(self, fit: Fit, cause: Effect, whole: bool = False) -> Fit | None:
        """The best fit with one effect more, over its starts; None if it cannot be simulated or no such part exists."""
        found = []
        for start in self.fitter.guesses(cause, fit.residual):
            values: Sequence[Floats | list[float]] = (*fit.values, start)
            for _ in range(REFITS):  # a place has no slope at size zero, where a fit begins
                one = self.fitter.tried((*fit.effects, cause), values, fit.offsets)
                if one is None:
                    break
                found.append(one)
                values = one.values
        best = min(found, key=lambda one: one.square, default=None)
        if best is not None and cause.doubtful and (words := cause.doubtful(best.values[-1])):
            if self.supported(fit, best, cause) and words not in self.doubts:
                self.doubts.append(words)
            return None
        return self.fitter.fit(best.effects, best.values, rows=Rows(self.fitter.used)) if whole and best else best

    def criterion(self, fit: Fit) -> float:
        """Bayes' criterion on the training readings."""
        n = int(self.fitter.train.sum())
        return n * log(max(fit.square, (0.1 * self.floor_rad) ** 2, 1e-40)) + fit.width * log(n)

    def held_rms(self, fit: Fit) -> float:
        """RMS error of the readings held back."""
        test = fit.residual[self.fitter.test]
        return float(np.sqrt(np.mean(test**2))) if test.size else 0.0

    def beyond_chance(self, less: Fit, more: Fit, cause: Effect) -> bool:
        """Whether the other readings support an effect, whichever level of them is left out."""
        return self._by_chance(less, more) < CHANCE / len(self.library) and self._steady(more.with_last(cause))

    def _steady(self, fit: Fit) -> bool:
        """Whether the size of the last effect stays within a share of itself whichever level of the readings is left
        out: what only imitates another cause at one level does not."""
        f, sizes = self.fitter, [p.role == "size" for p in fit.effects[-1].parameters]
        at = np.flatnonzero(f.train)
        level = np.argsort(np.argsort(self._level()[at], kind="stable")) * LEVELS // at.size
        for k in range(LEVELS):
            mask = f.train.copy()
            mask[at[level == k]] = False
            other = f.fit(fit.effects, fit.values, fit.offsets, rows=Rows(mask))
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

    def without(self, fit: Fit, cause: Effect, whole: bool = False) -> Fit:
        """The fit without one of its effects."""
        kept = [(e, v) for e, v in zip(fit.effects, fit.values, strict=True) if e is not cause]
        rows = Rows(self.fitter.used) if whole else None
        return self.fitter.fit([e for e, _ in kept], [v for _, v in kept], fit.offsets, rows)

    # Alternatives.

    def _within(self) -> Fit | None:
        """A fit of what load and figures of the design may be wrong by; None where nothing may be."""
        effects = [e for e in (*within_class(self.prepared), *within_prior(self.prepared)) if "lag" not in e.name]
        return (
            self.fitter.tried(effects, [[0.0] * len(e.parameters) for e in effects], self.bare.offsets)
            if effects
            else None
        )

    def log_odds(self, worse: Fit, better: Fit) -> float:
        """Logarithm of the odds of one fit against another by all used readings, by Bayes' criterion."""
        used, free = self.fitter.used, better.width + len(self.prepared)
        n = int(used.sum())
        squares = [float(np.sum(self.fitter.centred(one.residual, used)[used] ** 2)) for one in (worse, better)]
        variance = max(squares[1] / max(n - free, 1), self.floor_rad**2)
        return 0.5 * ((squares[0] - squares[1]) / variance + (worse.width - better.width) * log(n))

    def _best_forms(self, whole: Fit) -> Fit:
        """The fit of all readings with each effect in the first form of the library that fits them as well as any."""
        for key in [effect.key for effect in whole.effects]:
            rest = self.without(whole, next(e for e in whole.effects if e.key == key), True)
            trials = [self.best(rest, other, True) for other in self.library if other.key == key]
            forms = [one for one in trials if one is not None]
            best = min([*forms, whole], key=lambda one: self.log_odds(one, whole))
            whole = next((one for one in forms if self.log_odds(one, best) < SAME_FORM), best)
        return whole

    def _alike(self, whole: Fit, effect: Effect) -> tuple[tuple[str, ...], list[Fit]]:
        """Other forms of an effect, and fits with another effect in its place, that are nearly as good."""
        fits = self.alike(whole, effect)
        forms = tuple(one.effects[-1].form for one in fits if one.effects[-1].key == effect.key)
        # Of each other effect the best of its forms.
        others = {one.effects[-1].key: one for one in sorted(fits, key=lambda one: -one.square)}
        others.pop(effect.key, None)
        return forms, [*others.values()][::-1]

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
