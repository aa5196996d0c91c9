"""The search on few readings, such as a table of turning points: one value a half cycle instead of thousands.

The fits, effects, evidence and results are those of the loop on a log. The size of the noise is known to a factor only,
from readings that repeat each other, so the evidence is summed over it; what an unknown cause may do are curves of what
the readings differ by. Every candidate is refitted on all readings; the error is stated on those held back, with the
names that were found fitted to the others.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.readings import prepare_creep, prepare_readings
from mbcdm_cad.loop.result import NEAR_FLOOR, LoopResult, Named, doubt_of, runs_of
from mbcdm_cad.loop.search.account import as_named, chain_orders, errors, next_steps
from mbcdm_cad.loop.search.by_evidence import NO_UNKNOWN, Posterior, spread_of
from mbcdm_cad.loop.search.evidence import LOG_ODDS, NoiseModel, NoiseOfUnknownSize, Whitened
from mbcdm_cad.loop.search.few_readings import (
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
from mbcdm_cad.loop.search.fit import Fit, FitRows, Fitter
from mbcdm_cad.loop.search.problem import LogProblem, Nuisance, hats_over
from mbcdm_cad.loop.search.selection import Moves
from mbcdm_cad.measurement.by_hand import path_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

# Fits of a candidate, each from where the last one ended, and iterations of each.
REFITS, ITERATIONS = 3, 30
# Knots of the unknown curves over load, angle, order and time.
KNOTS = (3, 5)
# A parameter that changes no reading by this share of the floor, by its typical size, is not known.
FLAT = 1e-3
PLAY = "lash"


class RowsProblem(LogProblem):
    """Readings of one or more tables of one drive."""

    windows = ()

    @cached_property
    def curves(self) -> tuple[Floats, ...]:
        """Curves of load, angle and order of the rows, by direction; at rest of time and its logarithm."""
        runs, kept = self.fitter.runs, self.used

        def over(values: Sequence[Floats | None], by_sense: bool) -> list[Floats]:
            if any(one is None for one in values):
                return []
            at = np.concatenate([one for one in values if one is not None])[kept]
            hats = [hat for knots in KNOTS for hat in hats_over(at, knots)]
            onward = np.concatenate([p.sense for p in runs])[kept] >= 0.0
            return [hat * way for hat in hats for way in (onward, ~onward)] if by_sense else hats

        if runs[0].run.kind == CREEP:
            families = [over([since(p) for p in runs], False), over([p.time_s for p in runs], False)]
        else:
            order = over([np.arange(p.time_s.size, dtype=float) for p in runs], False)
            families = [over([p.load_Nm for p in runs], True), over([p.mean_rad for p in runs], True), order]
        return tuple(one for family in families if (one := self._unit(family)).size)

    def whitened(self, noise: NoiseModel, nuisances: Sequence[Nuisance], names: int, scales: Floats) -> Whitened:
        """Nuisances and curves under white noise of about this size."""
        most = np.array([one.most for one in nuisances])
        own = self.columns_of(nuisances), np.stack([-most, most])
        return NoiseOfUnknownSize(noise, *own, self.curves, names, self.least_rad)


class FewReadings(Posterior, Moves[Fit]):
    """The loop on tables of one drive."""

    problem_of = RowsProblem

    def __init__(self, d: DriveSI | None, ratio: float, runs: Sequence[Prepared], known: Sequence[AsBuilt]) -> None:
        self.d, self.ratio, self.prepared = d, ratio, tuple(runs)
        fitter = Fitter(d, ratio, self.prepared, known)
        fitter.free[:] = False  # offsets of some counts between two inputs are below what few readings tell
        self.at_rest = self.prepared[0].run.kind == CREEP
        shows = _shows_at_rest if self.at_rest else _shows
        offered = [[e for e in library(d, p) if shows(e)] for p in self.prepared]
        labels = [{e.label for e in one} for one in offered]
        self.offered = [e for e in offered[0] if all(e.label in one for one in labels) and not e.unmeasured]
        super().__init__(fitter, fitter.fit(rows=FitRows(fitter.used)), 1)
        # What changes no reading is no candidate.
        self.slopes = {e: slopes for e in self.offered if (slopes := self._slopes(e)) is not None}
        self.library = [*self.slopes]
        self.names = max(1, len({e.key for e in self.library}))
        self.noise = noise_of(fitter, self.bare.residual, self.at_rest)
        self.weigh(NoiseModel(self.noise.total_rad), self.problem.nuisances_of(self.bare))
        self.doubts: list[str] = []

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        fit, places, steps, small = self.found()
        named, sets = self.told(fit, places)
        left = self._left(fit)
        untold = self._untold([*named, *(one for group in sets for one in group)], left)
        if untold:
            fit, steps, small, named, sets, left = self.bare, [], [], [], [], None
        f = self.fitter
        before, after = (self.beside_nuisances(f.fit(one.effects, one.values)) for one in (self.bare, fit))
        untested = untold or not f.test.any()
        return LoopResult(
            "not_testable" if untested else verdict_of([*named, *sets], left),
            tuple(named),
            tuple(sets),
            left,
            errors(f, f.fit(), before if untold else after, self.floor_rad),
            tuple(steps),
            tuple(small),
            (untold,) if untold else not_testable(f, self.d is not None, self.at_rest),
            next_steps(named, sets, None),
            chain_orders(self.d, self.ratio),
            noise=self.noise,
            pictures=pictures_of(f, self.ratio, fit, self.at_rest),
            doubts=tuple(self.doubts)
            + ((doubt_of(self.noise, runs_of(self.prepared)),) if self.noise.far_above and not untold else ()),
            within_class="" if untold else self.within_words(fit),
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

    def _slopes(self, effect: Effect) -> tuple[Floats, Floats, Floats] | None:
        """Derivatives of the readings in use by the sizes of an effect at zero, (n, k), and by its places over its
        size, (n, p), with the priors of these; None if nothing shows."""
        f, sizes = self.fitter, np.array([p.role == "size" for p in effect.parameters])
        small = np.array([p.size for p in effect.parameters])
        for start in f.guesses(effect, self.bare.residual):
            try:
                none, some = (
                    f.centred_on(f.used, f.fit((effect,), (np.where(sizes, at, start),), iterations=0).jacobian)
                    for at in (0.0 * small, small)
                )
            except ModelError:
                continue
            if np.all(np.linalg.norm(none[:, sizes], axis=0) > 0.0):
                each = zip(effect.parameters, start, sizes, strict=True)
                spreads = np.array([spread_of(p, value) for p, value, size in each if not size])
                return none[:, sizes], some[:, ~sizes] / small[sizes][0], spreads
        return None

    def trials(self, now: Fit) -> list[Fit]:
        """The best fit with each effect more, over its starts; none that cannot be simulated or is no part."""
        taken = {e.key for e in now.effects}
        found = []
        for effect in self.library:
            if effect.key in taken:
                continue
            ended = []
            for start in self.fitter.guesses(effect, now.residual):
                one, values = None, (*now.values, np.array(start, dtype=float))
                for _ in range(REFITS):  # a place has no slope at size zero, where a fit begins
                    try:
                        one = self._fitted((*now.effects, effect), values)
                    except ModelError:
                        break
                    values = one.values
                if one is not None:
                    ended.append(one)
            best = max(ended, key=self.log_of, default=None)
            words = "" if best is None or effect.doubtful is None else effect.doubtful(best.values[-1])
            if words and best is not None and self.score(best) - self.score(now) > LOG_ODDS:
                self.doubts += [words] if words not in self.doubts else []
            if best is not None and not words:
                found.append(best)
        return found

    def _fitted(self, effects: Sequence[Effect], values: Sequence[Floats]) -> Fit:
        return self.fitted(NO_UNKNOWN, effects, values, self.bare.offsets, iterations=ITERATIONS)

    def without(self, fit: Fit, cause: Effect) -> Fit:
        """The fit without one of its effects."""
        kept = [(e, v) for e, v in zip(fit.effects, fit.values, strict=True) if e is not cause]
        if not kept:
            return self.bare
        known: dict[frozenset[str], Fit] = self.__dict__.setdefault("_without", {})
        key = frozenset(e.label for e, _ in kept)
        if key not in known:
            known[key] = self._fitted([e for e, _ in kept], [v for _, v in kept])
        return known[key]

    def log_of(self, fit: Fit) -> float:
        """Logarithm of the evidence of a fit."""
        return self.of(fit).log

    def rms(self, fit: Fit) -> float:
        """Error of all readings, rad RMS."""
        return float(np.sqrt(np.mean(fit.residual[self.used] ** 2)))

    def named(self, effect: Effect, whole: Fit, fall: float) -> Named:
        """An effect with the intervals that all readings give, sensors and noise integrated out."""
        own = whole.columns_of(effect)
        named = as_named(effect, whole.values_of(effect), self.of(whole).covariance[own, own], fall, "")
        columns = self.fitter.centred_on(self.used, whole.jacobian[:, own])
        sizes = np.array([p.size for p in effect.parameters])
        # A place that changes nothing between the readings has no figure; of such a size only a lower bound is known.
        flat = np.linalg.norm(columns, axis=0) * sizes < FLAT * self.floor_rad
        figures = dict(named.parameters)
        for p, value, here in zip(effect.parameters, whole.values_of(effect), flat, strict=True):
            if p.role == "place" and effect.name == PLAY:
                figures.pop(p.name, None)  # where the contact changes sides lies between two rows
            elif here and p.name in figures:
                bound = replace(figures.pop(p.name), low=float(value), high=np.inf)
                figures |= {p.name: bound} if p.role == "size" else {}
        return replace(named, parameters=figures)

    def _left(self, whole: Fit) -> LeftOver | None:
        """What is left of all readings; None if no unknown cause is certain, or it is no more than the noise."""
        r = self.fitter.centred_on(self.used, self.beside_nuisances(whole).residual)
        rms, peak = float(np.sqrt(np.mean(r**2))), float(np.abs(r).max())
        if self.of(whole).unknown_odds < LOG_ODDS or rms < NEAR_FLOOR * self.floor_rad:
            return None
        return LeftOver(rms, peak, self.floor_rad, (), (), 0.0, (), hangs_on=hangs_on(self.fitter, r, self.at_rest))


def prepared_by_hand(run: Run, ratio: float) -> Prepared:
    """A table as its kind needs it."""
    return prepare_creep(run, ratio) if run.kind == CREEP else prepare_readings(run, ratio)


def judged_by_hand(d: DriveSI | None, ratio: float, runs: Sequence[Run], known: Sequence[AsBuilt]) -> LoopResult:
    """The finding from tables of one kind."""
    return FewReadings(d, ratio, [prepared_by_hand(run, ratio) for run in runs], known).result()


def _shows(effect: Effect) -> bool:
    """Whether a table can show an effect: none of time or speed, no line, no event, no shape without a cause."""
    hangs = effect.hangs_on in ("time", "temperature", "speed", "the path travelled") or "lag" in effect.name
    return not (hangs or effect.last or effect.once or effect.base or effect.order_index is not None or effect.inside)


def _shows_at_rest(effect: Effect) -> bool:
    """Whether readings at rest can show an effect: one of time or temperature."""
    return effect.hangs_on in ("time", "temperature") and not (effect.once or effect.base)
