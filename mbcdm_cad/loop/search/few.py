"""The search on few readings, such as a table of turning points: one value a half cycle instead of thousands.

The fits, effects, evidence and results are those of the loop on a log. The size of the noise is known to a factor only,
from readings that repeat each other, so the evidence is summed over it; what an unknown cause may do are curves of what
the readings differ by. Every candidate is refitted on all readings; the error is stated on those held back, with the
names that were found fitted to the others.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.readings import prepare_creep, prepare_readings
from mbcdm_cad.loop.result import LoopResult, Named, doubt_of, runs_of, verdict_of
from mbcdm_cad.loop.search import account, few_readings
from mbcdm_cad.loop.search.by_evidence import Runs, spread_of
from mbcdm_cad.loop.search.evidence import LOG_ODDS, ROUNDED, NoiseModel, NoiseOfUnknownSize, Whitened
from mbcdm_cad.loop.search.fit import Fit, FitRows, Fitter
from mbcdm_cad.loop.search.moves import LEAST_GAIN
from mbcdm_cad.loop.search.problem import LogProblem, Nuisance, hats_over, unit_columns
from mbcdm_cad.measurement.by_hand import path_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import CREEP
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

# Knots of the unknown curves over load, angle, order and time.
KNOTS = (3, 5)
PLAY = "lash"


class RowsProblem(LogProblem):
    """Readings of one or more tables of one drive."""

    windows = ()

    @property
    def curves(self) -> tuple[Floats, ...]:
        """What an unknown cause may do."""
        return tuple(self.by_name.values())

    @cached_property
    def by_name(self) -> dict[str, Floats]:
        """Curves of load, angle and order of the rows, by direction; at rest of time, its logarithm and temperature."""
        runs, kept = self.fitter.runs, self.used
        onward = np.concatenate([p.sense for p in runs])[kept] >= 0.0

        def over(values: Sequence[Floats | None], by_sense: bool = False) -> list[Floats]:
            if any(one is None for one in values):
                return []
            at = np.concatenate([one for one in values if one is not None])[kept]
            hats = [hat for knots in KNOTS for hat in hats_over(at, knots)]
            return [hat * way for hat in hats for way in (onward, ~onward)] if by_sense else hats

        families = {
            "the load": over([p.load_Nm for p in runs], True),
            "the angle": over([p.mean_rad for p in runs], True),
            "the order of the rows": over([np.arange(p.time_s.size, dtype=float) for p in runs]),
        }
        if runs[0].run.kind == CREEP:
            families = {
                "the logarithm of time": over([few_readings.since(p) for p in runs]),
                "the time": over([p.time_s for p in runs]),
                "the temperature": over([p.temperature_C for p in runs]),
            }
        return {name: unit_columns(hats)[0] for name, hats in families.items() if hats}

    def whitened(self, noise: NoiseModel, nuisances: Sequence[Nuisance], names: int, scales: Floats) -> Whitened:
        """Nuisances and curves under white noise of about this size."""
        most = np.array([one.most for one in nuisances])
        own = self.columns_of(nuisances), np.stack([-most, most])
        return NoiseOfUnknownSize(noise, *own, self.curves, names, self.least_rad, scales)


class FewReadings(Runs):
    """The loop on tables of one drive."""

    problem_of, iterations = RowsProblem, 30

    def __init__(self, d: DriveSI | None, ratio: float, runs: Sequence[Prepared], known: Sequence[AsBuilt]) -> None:
        self.d, self.ratio, self.prepared = d, ratio, tuple(runs)
        fitter = Fitter(d, ratio, self.prepared, known)
        fitter.free[:] = False  # offsets of some counts between two inputs are below what few readings tell
        self.at_rest = self.prepared[0].run.kind == CREEP
        shows = _shows_at_rest if self.at_rest else _shows
        offered = [[e for e in library(d, p) if shows(e)] for p in self.prepared]
        labels = [{e.label for e in one} for one in offered]
        self.offered = [e for e in offered[0] if all(e.label in one for one in labels) and not e.unmeasured]
        bare = fitter.fit(rows=FitRows(fitter.used))
        # What changes no reading is no candidate.
        self.slopes = {e: slopes for e in self.offered if (slopes := _slopes(fitter, bare, e)) is not None}
        super().__init__(fitter, [*self.slopes], bare)
        self.noise = few_readings.noise_of(fitter, bare.residual, self.at_rest)
        self.weigh(NoiseModel(self.noise.total_rad), self.problem.nuisances_of(bare))

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        fit, _ = self.withdrawn(self.found())
        named, sets = self.told(fit)
        left = self._left(fit)
        untold = self._untold([*named, *(one for group in sets for one in group)], left)
        if untold:
            fit, named, sets, left = self.bare, [], [], None
        steps, small = ((), ()) if untold else self.candidates(fit)
        f = self.fitter
        before, after = (self.beside_nuisances(f.fit(one.effects, one.values)) for one in (self.bare, fit))
        untested = untold or not f.test.any()
        return LoopResult(
            "not_testable" if untested else verdict_of([*named, *sets], left),
            tuple(named),
            tuple(sets),
            left,
            account.errors(f, f.fit(), before if untold else after, self.floor_rad),
            steps,
            small,
            (untold,) if untold else few_readings.not_testable(f, self.d is not None, self.at_rest),
            account.next_steps(named, sets, left),
            account.chain_orders(self.d, self.ratio),
            noise=self.noise,
            pictures=few_readings.pictures_of(f, self.ratio, fit, self.at_rest),
            doubts=tuple(dict.fromkeys(self.doubts.values()))
            + ((doubt_of(self.noise, runs_of(self.prepared)),) if self.noise.far_above and not untold else ()),
            within_class="" if untold else self.within_words(fit),
        )

    def _untold(self, found: Sequence[Named], left: few_readings.LeftOver | None) -> str:
        """Why errors of a table tell nothing, in words; empty where they do or there are none."""
        if self.loses_track and (found or left or self.noise.far_above):
            return few_readings.LOST_TRACK
        return few_readings.HIDDEN_PLAY if self.hides_play and any(one.name == PLAY for one in found) else ""

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

    def trials(self, now: Fit) -> list[Fit]:
        """The best fit with each effect more, over its starts; none that cannot be simulated or is no part."""
        taken = {e.key for e in now.effects}
        found = []
        for effect in self.library:
            if effect.key in taken:
                continue
            ended = []
            for start in self.fitter.guesses(effect, now.residual):
                effects, values = (*now.effects, effect), (*now.values, np.array(start, dtype=float))
                try:
                    fits = [self.fitted(self.white.none, effects, values, now.offsets)]
                    # A place has no slope at size zero, where a fit begins.
                    while len(fits) < 2 or self.log_of(fits[-1]) > self.log_of(fits[-2]) + LEAST_GAIN:
                        fits.append(self.fitted(self.white.none, effects, fits[-1].values, now.offsets))
                except ModelError:
                    continue
                ended.append(fits[-1])
            found += [best for best in [max(ended, key=self.log_of, default=None)] if best and self.possible(best, now)]
        return found

    def found(self) -> Fit:
        """The fit of most evidence, each effect in the first form of the library not told from the likeliest."""
        now = super().found()
        for effect in now.effects:
            others = self.additions(self.without(now, effect))
            forms = {one.effects[-1]: one for one in others} | {effect: now}
            least = self.score(now) - LOG_ODDS
            likely = [e for e, one in forms.items() if e.key == effect.key and self.score(one) > least]
            now = forms[min(likely, key=self.library.index)]
        return now

    def fitted(self, unknown: int, *given: Any, **options: Any) -> Fit:
        """A fit beside no unknown cause: few readings have as many curves as values."""
        return super().fitted(self.white.none, *given, **options)

    def named(self, effect: Effect, whole: Fit, fall: float) -> Named:
        """An effect with the intervals that all readings give, sensors and noise integrated out."""
        named = super().named(effect, whole, fall)
        columns = self.fitter.centred_on(self.used, whole.jacobian[:, whole.columns_of(effect)])
        sizes = np.array([p.size for p in effect.parameters])
        # A place that changes nothing between the readings has no figure; of such a size only a lower bound is known.
        flat = np.linalg.norm(columns, axis=0) * sizes < ROUNDED * self.floor_rad
        figures = dict(named.parameters)
        for p, value, here in zip(effect.parameters, whole.values_of(effect), flat, strict=True):
            if p.role == "place" and effect.name == PLAY:
                figures.pop(p.name, None)  # where the contact changes sides lies between two rows
            elif here and p.name in figures:
                bound = replace(figures.pop(p.name), low=float(value), high=np.inf)
                figures |= {p.name: bound} if p.role == "size" else {}
        return replace(named, parameters=figures)

    def _left(self, whole: Fit) -> few_readings.LeftOver | None:
        """What is left of all readings; None if no unknown cause is certain, or it is no more than the noise."""
        r = self.fitter.centred_on(self.used, self.beside_nuisances(whole).residual)
        rms, peak = float(np.sqrt(np.mean(r**2))), float(np.abs(r).max())
        if not self.unexplained(whole):
            return None
        assert isinstance(self.problem, RowsProblem)
        name = [*self.problem.by_name][self.white.family(self.of(whole).unknown)]
        return few_readings.LeftOver(rms, peak, self.floor_rad, (), (), 0.0, (), hangs_on=f"it goes with {name}")


def _slopes(f: Fitter, bare: Fit, effect: Effect) -> tuple[Floats, Floats, Floats] | None:
    """Derivatives of the readings in use by the sizes of an effect at zero, (n, k), and by its places over its
    size, (n, p), with the priors of these; None if nothing shows."""
    sizes = np.array([p.role == "size" for p in effect.parameters])
    small = np.array([p.size for p in effect.parameters])
    for start in f.guesses(effect, bare.residual):
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


def prepared_by_hand(run: Run, ratio: float) -> Prepared:
    """A table as its kind needs it."""
    return prepare_creep(run, ratio) if run.kind == CREEP else prepare_readings(run, ratio)


def judged_by_hand(d: DriveSI | None, ratio: float, runs: Sequence[Run], known: Sequence[AsBuilt]) -> LoopResult:
    """The finding from tables of one kind."""
    return FewReadings(d, ratio, [prepared_by_hand(run, ratio) for run in runs], known).result()


def _shows(effect: Effect) -> bool:
    """Whether a table can show an effect: none of time or speed, no line, no event, no shape without a cause."""
    hangs = effect.hangs_on in ("time", "temperature", "speed", "the path travelled")
    return not (hangs or effect.last or effect.once or effect.base or effect.order_index is not None or effect.inside)


def _shows_at_rest(effect: Effect) -> bool:
    """Whether readings at rest can show an effect: one of time or temperature."""
    return effect.hangs_on in ("time", "temperature") and not (effect.once or effect.base)
