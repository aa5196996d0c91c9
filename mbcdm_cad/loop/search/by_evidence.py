"""Fits of logs weighed by their evidence, and the search over them.

The score of a fit is the logarithm of its evidence (:mod:`mbcdm_cad.loop.search.evidence`) and of the prior of its
names (:mod:`mbcdm_cad.loop.search.moves`). Candidates are ranked by the evidence of a linear step, and few of them
refitted, each beside a large unknown cause and beside none, since the evidence has a maximum at either. The noise is
found again after each effect that was added.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.result import NEAR_FLOOR, Named
from mbcdm_cad.loop.search import account, evidence, screening
from mbcdm_cad.loop.search.fit import Fit, FitRows, Fitter
from mbcdm_cad.loop.search.moves import Moves
from mbcdm_cad.loop.search.problem import LogProblem, Nuisance
from mbcdm_cad.routes import Floats


def bounds_of(effects: Sequence[Effect]) -> Floats:
    """The least and the greatest of each size, (2, k); places and orders have none here, their fit keeps them."""
    own = [p for effect in effects for p in effect.parameters]
    limits = [(p.low, p.high) if p.role == "size" else (-np.inf, np.inf) for p in own]
    return np.array(limits, dtype=float).reshape(-1, 2).T


def spread_of(parameter: Parameter, value: float) -> float:
    """Standard deviation of the prior of a place or an order, near a value."""
    p = parameter
    return float(value * np.log(p.high / p.low) if p.low > 0.0 else p.high - p.low) / float(np.sqrt(12.0))


class Posterior:
    """Fits of one set of runs under one noise; ``bare`` is the fit without effects, ``names`` the number of names that
    an effect may have."""

    problem_of: type[LogProblem] = LogProblem

    # Scales of the curves of an unknown cause, and iterations of a fit.
    scales: Floats = evidence.SCALES
    iterations = 8

    def __init__(self, fitter: Fitter, bare: Fit, names: int) -> None:
        self.fitter, self.bare, self.names, self.used = fitter, bare, names, fitter.used
        self.problem = self.problem_of(fitter, bare)

    def weigh(self, noise: evidence.NoiseModel, nuisances: Sequence[Nuisance]) -> None:
        """Take a noise and nuisances, and forget what was found under others."""
        self.nuisances = tuple(nuisances)
        self.white: evidence.Whitened = self.problem.whitened(noise, nuisances, self.names, self.scales)
        self._known: dict[Fit, evidence.Weighed] = {}
        self._metric = cache(self.white.metric)

    @property
    def floor_rad(self) -> float:
        """RMS of the noise model, rad."""
        return self.white.noise.floor_rad

    def prior_sd(self, effects: Sequence[Effect], values: Sequence[Floats], jacobian: Floats) -> Floats:
        """Standard deviation of each value before the run was seen, (k,): as large as the whole error; of a place
        within its bounds, of one above zero, such as a time constant, as likely in each decade."""
        rms = np.sqrt(np.mean((jacobian - jacobian.mean(axis=0)) ** 2, axis=0))
        # What only shifts the zero shows nothing.
        shown = rms > evidence.ROUNDED * np.abs(jacobian).max(axis=0, initial=0.0)
        sd = np.where(shown, self.problem.prior_rad / np.where(shown, rms, 1.0), 0.0)
        own = [p for effect in effects for p in effect.parameters]
        for i, (p, value) in enumerate(zip(own, itertools.chain(*values), strict=True)):
            if p.role != "size":
                sd[i] = spread_of(p, value)
        return sd

    def of(self, fit: Fit) -> evidence.Weighed:
        """Evidence of a fit under the present noise."""
        if fit not in self._known:
            jacobian, y = self._data(fit)
            sd, bounds = self.prior_sd(fit.effects, fit.values, jacobian), bounds_of(fit.effects)
            self._known[fit] = self.white.evidence_of(np.column_stack([jacobian, y]), sd, bounds)
        return self._known[fit]

    def _data(self, fit: Fit) -> tuple[Floats, Floats]:
        """Jacobian of the effects of a fit, and the data of the linear model there, on the samples in use."""
        jacobian = fit.jacobian[self.used][:, : fit.width]
        theta = np.concatenate(fit.values) if fit.effects else np.zeros(0)
        free = iter(fit.offsets[self.fitter.free])
        offsets = [next(free) / one.offset * one.column[self.used] for one in self.nuisances if one.offset < np.inf]
        y = fit.residual[self.used] + jacobian @ theta + np.sum(offsets, axis=0)
        # Where nothing can be predicted, the error is large and nothing moves it.
        return np.nan_to_num(jacobian, posinf=0.0, neginf=0.0), np.nan_to_num(y, nan=1e6, posinf=1e6, neginf=-1e6)

    def with_offsets(self, fit: Fit) -> Floats:
        """Covariance of the values of a fit and of its free offsets, which are nuisances here."""
        joint, q = self.of(fit).joint, len(self.nuisances)
        offsets = [k for k, one in enumerate(self.nuisances) if one.offset < np.inf]
        order = [*range(q, q + fit.width), *offsets]
        size = np.array([*[1.0] * fit.width, *(self.nuisances[k].offset for k in offsets)])
        return np.asarray(joint[np.ix_(order, order)] * np.outer(size, size))

    def held_rms(self, fit: Fit) -> float:
        """RMS on the held-out samples, rad."""
        rows = self.fitter.test if self.fitter.test.any() else self.used
        return float(np.sqrt(np.mean(fit.residual[rows] ** 2)))

    def rms(self, fit: Fit) -> float:
        """RMS on the samples in use, rad."""
        return float(np.sqrt(np.mean(fit.residual[self.used] ** 2)))

    def fitted(
        self,
        unknown: int,
        effects: Sequence[Effect],
        values: Sequence[Floats],
        offsets: Floats,
        fitter: Fitter | None = None,
        **options: Any,
    ) -> Fit:
        """The fit of most posterior density, beside nuisances and an unknown cause."""
        rows = FitRows(self.used, self._metric(unknown))
        options = {"iterations": self.iterations} | options
        return (fitter or self.fitter).fit(effects, values, offsets, rows, **options)

    def lowers(self, more: Fit, less: Fit) -> bool:
        """Whether a fit leaves less than one that it contains, as it does unless it has ended beside its minimum."""
        independent = self._metric(self.of(more).unknown)
        left = [independent(self.fitter.centred_on(self.used, one.residual)) for one in (more, less)]
        return float(np.sum(left[0] ** 2)) <= float(np.sum(left[1] ** 2))

    def within_class(self, fit: Fit) -> list[tuple[Nuisance, float]]:
        """What sensors and figures of the design are wrong by within their class, with the posterior mean in standard
        deviations; empty where all of it together is too small to name."""
        pairs = zip(self.nuisances, self.of(fit).nuisances, strict=True)
        found = [(one, float(mean)) for one, mean in pairs if one.effect]
        whole = np.sum([mean * one.column[self.used] for one, mean in found], axis=0)
        return found if np.std(whole) > evidence.LEAST_FALL * self.floor_rad else []

    def within_words(self, fit: Fit) -> str:
        """The same for people, without what does little of it."""
        found = self.within_class(fit)
        does = [abs(mean) * float(np.std(one.column[self.used])) for one, mean in found]
        sizes = [
            (one.effect, one.size * mean)
            for (one, mean), size in zip(found, does, strict=True)
            if one.effect and size >= evidence.LEAST_FALL * max(does)
        ]
        return account.within_words(sizes, self.fitter.runs[0].run.sensors.torque_class)

    def beside_nuisances(self, fit: Fit) -> Fit:
        """A fit with that taken off its residual."""
        found = self.within_class(fit)
        if not found:
            return fit
        whole = np.sum([mean * one.column for one, mean in found], axis=0)
        residual = self.fitter.centred(fit.residual - whole, self.fitter.train)
        return replace(fit, residual=residual, square=float(np.mean(residual[self.fitter.train] ** 2)))


class Runs(Posterior, Moves[Fit]):
    """The search over one set of runs; how candidates are fitted is said for logs, and for tables by hand."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect], bare: Fit) -> None:
        super().__init__(fitter, bare, max(1, len({effect.key for effect in library})))
        self.library = tuple(library)
        # Reasons why fitted values are impossible: a sentence for each effect's label.
        self.doubts: dict[str, str] = {}

    def rescaled(self, scales: Floats) -> None:
        """Take other scales of an unknown cause, and forget what was found under others."""
        self.scales = scales
        self.weigh(self.white.noise, self.nuisances)

    def weigh(self, noise: evidence.NoiseModel, nuisances: Sequence[Nuisance]) -> None:
        """Take a noise and nuisances, and forget what was found under others."""
        super().weigh(noise, nuisances)
        self.forget()

    def without(self, fit: Fit, effect: Effect) -> Fit:
        """Refit with one effect left out."""
        rest = tuple(e for e in fit.effects if e is not effect)
        if not rest:
            return self.bare
        key = frozenset(rest)
        if key not in self._without:
            values = [fit.values_of(e) for e in rest]
            self._without[key] = self.fitted(self.of(fit).unknown, rest, values, fit.offsets)
        return self._without[key]

    def possible(self, fit: Fit, now: Fit) -> bool:
        """Whether a bench can have the last effect of a fit, which ``now`` lacks, with these values."""
        effect, values = fit.effects[-1], fit.values[-1]
        words = effect.doubtful(values) if effect.doubtful else ""
        if words and self.score(fit) - self.score(now) > evidence.LOG_ODDS:
            self.doubts.setdefault(effect.label, words)
        each = zip(effect.parameters, values, strict=True)
        return not words and not any(p.role == "size" and v in (p.low, p.high) and v != 0.0 for p, v in each)

    def named(self, effect: Effect, fit: Fit, fall: float) -> Named:
        """An effect of a fit with its figures, nuisances integrated out."""
        own = fit.columns_of(effect)
        block = self.of(fit).covariance[own, own]
        return account.as_named(effect, fit.values_of(effect), block, fall, self.fitter.run_name(effect))


@dataclass(frozen=True, eq=False)
class Promise(screening.Screened):
    """A candidate, where its refit begins, and the logarithm of the evidence of its linear step: beside an unknown
    cause, and ``alone``."""

    start: Floats
    log: float
    alone: float


class Search(Runs):
    """The search over logs."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect], bare: Fit) -> None:
        super().__init__(fitter, [e for e in library if not e.inside], bare)
        self.inside = tuple(e for e in library if e.inside)
        self.screening = screening.Screening(fitter, self.library)
        # Fits by their effects, under any noise: a fit under another one begins there.
        self._reached: dict[tuple[Effect, ...], Fit] = {}
        self.retuned(bare)

    def retuned(self, fit: Fit) -> None:
        """The noise of a fit, and all that depends on it, unless it is no smaller than that at hand: what a worse
        model leaves is no noise, and the search ends."""
        known = []
        for c in self.screening.screen(fit):
            columns = c.columns[self.used]
            sd = np.append(1.0, self.prior_sd([c.effect], [c.guess], columns))
            known.append((np.column_stack([c.change[self.used], columns]), sd))
        nuisances = self.problem.nuisances_of(self.bare)
        noise = self.problem.noise_of(fit, nuisances, known)
        if fit is self.bare or noise.floor_rad < self.floor_rad:
            self.weigh(noise, nuisances)

    def left_rad(self, fit: Fit) -> float:
        """RMS that the sweeps held back have above the noise, where it is more than chance; nuisances may be none."""
        held = min(map(self.held_rms, (fit, self.beside_nuisances(fit))))
        return self.above_rad(held) if self.certain(fit) or held > NEAR_FLOOR * self.floor_rad else 0.0

    def untold(self, fit: Fit, now: Fit) -> bool:
        """What was not measured is in the set if what tells it from the effect is too small to name."""
        least = (evidence.LEAST_FALL * self.floor_rad) ** 2
        return fit.effects[-1].unmeasured and self.held_rms(fit) ** 2 - self.held_rms(now) ** 2 < least

    def _promises(self, now: Fit) -> list[Promise]:
        """Candidates with the evidence of a linear step, best first; of starts that differ in sizes the best."""
        own, y = self._data(now)
        sd, k = self.prior_sd(now.effects, now.values, own), own.shape[1]
        chosen = self.screening.screen(now)
        # The step goes from the guess, which changes the prediction already.
        blocks = [np.column_stack([c.columns, c.columns @ c.guess - c.change])[self.used] for c in chosen]
        gram, on_z = self.white.parts(np.column_stack([own, y, *blocks]))
        # Nuisances come first.
        q = self.white.bounds.shape[1]
        found, at, k = list[Promise](), q + k + 1, q + k
        for c in chosen:
            m = c.columns.shape[1]
            # Columns of the effects, of the candidate, and the data beside it, in terms of all columns.
            take = np.zeros((gram.shape[0], k + m + 1))
            take[np.arange(k), np.arange(k)] = 1.0
            take[at + np.arange(m), k + np.arange(m)] = 1.0
            take[[k, at + m], k + m] = 1.0
            sds = np.append(sd, self.prior_sd([c.effect], [c.guess], c.columns[self.used]))
            bounds = bounds_of((*now.effects, c.effect))
            one = self.white.evidence((take.T @ gram @ take, on_z @ take), sds, bounds, y.size)
            p = c.effect.parameters
            # Orders and times are only refined by the fit; a linear step would move them out of their minimum.
            held = np.array([q.low > -np.inf for q in p]) & (c.guess != 0.0)
            start = np.clip(np.where(held, c.guess, one.mean[k - q :]), [q.low for q in p], [q.high for q in p])
            log = one.log - evidence.LOG_ODDS * c.effect.last
            found.append(Promise(c.effect, c.columns, c.change, c.guess, start, log, one.alone))
            at += m + 1
        found.sort(key=lambda one: one.log)
        places = {id(one): any(p.role != "size" for p in one.effect.parameters) for one in found}
        best = {(one.effect, id(one) if places[id(one)] else 0): one for one in found}
        return sorted(best.values(), key=lambda one: -one.log)

    def _rough(
        self, unknown: int, effects: Sequence[Effect], values: Sequence[Floats], near: Fit, fitter: Fitter, **own: Any
    ) -> Fit:
        """A fit good enough to rank candidates."""
        options = {"iterations": 4, "settled": 1e-4, "fresh": False} | own
        return self.fitted(unknown, effects, values, near.offsets, fitter, **options)

    def _begun(self, now: Fit, c: Promise, fitter: Fitter) -> Fit:
        """A rough fit of a candidate, beside a large unknown, which may stand for what it does, and beside none."""
        left, effects, values = self.of(now), (*now.effects, c.effect), (*now.values, c.start)
        near = self._reached.get(effects)
        if near is not None:
            best = self._rough(self.of(near).unknown, effects, near.values, now, fitter, slopes=near.jacobian)
        else:
            slopes = np.hstack([now.jacobian[:, : now.width], c.columns, now.jacobian[:, now.width :]])
            unknowns = {left.unknown, self.white.none if left.unknown_odds > 0.0 else left.unknown}
            rough = (self._rough(one, effects, values, now, fitter, slopes=slopes) for one in sorted(unknowns))
            best = max(rough, key=self.log_of)
        if self.log_of(best) < c.log - evidence.LOG_ODDS:
            best = max(best, self._rough(left.unknown, effects, values, now, fitter), key=self.log_of)
        return best

    def _in_form(self, one: Fit, form: Effect, fitter: Fitter) -> Fit:
        """A rough fit with another form of the last effect; the same fit where nothing in the data tells of it."""
        known = dict(zip([p.name for p in one.effects[-1].parameters], one.values[-1], strict=True))
        guesses = fitter.guesses(form, one.residual)
        if not guesses:
            return one
        values = np.array([known.get(p.name, v) for p, v in zip(form.parameters, guesses[0], strict=True)])
        slopes = one.jacobian if values.size == one.values[-1].size else None
        effects = (*one.effects[:-1], form)
        return self._rough(self.of(one).unknown, effects, (*one.values[:-1], values), one, fitter, slopes=slopes)

    def _finished(self, one: Fit, fitter: Fitter) -> Fit:
        """A rough fit brought to its end; a sum of which a term has no size is the sum without it."""
        found = self.fitted(self.of(one).unknown, one.effects, one.values, one.offsets, fitter)
        last, values = one.effects[-1], found.values[-1]
        none = [p.role == "size" and p.low == v == 0.0 for p, v in zip(last.parameters, values, strict=True)]
        names = {p.name for p, gone in zip(last.parameters, none, strict=True) if not gone}
        less = next((e for e in self._sums(last) if {p.name for p in e.parameters} == names), None)
        if less is None or not any(none):
            return found
        values = values[~np.array(none)]
        effects = (*found.effects[:-1], less)
        return self._rough(self.of(found).unknown, effects, (*found.values[:-1], values), found, fitter)

    def trials(self, now: Fit) -> list[Fit]:
        """Refits of ``now`` with one effect more."""
        each = self.screening.twins.each
        begun, ranked = list[Fit](), self._promises(now)
        # The likeliest beside an unknown, and beside none, at all their starts.
        alone = sorted(ranked, key=lambda one: -one.alone)
        first = {one.effect for one in (*ranked[: evidence.TRIED], *alone[: evidence.TRIED])}
        chosen = [one for one in ranked if one.effect in first]
        while chosen:
            ranked = [one for one in ranked if one not in chosen]
            begun += each([partial(self._begun, now, c) for c in chosen])
            begun.sort(key=self.log_of, reverse=True)
            # A linear step says little where friction is worked: all names that a set may hold are refitted.
            least = max(map(self.log_of, begun), default=np.inf) - evidence.LOG_ODDS
            names = {one.effects[-1].name for one in begun if self.log_of(one) > least}
            chosen = [one for one in ranked if one.effect.name in names]
        # Other forms of the likeliest, while one of them is likelier; a term more is taken as an effect more is.
        walked: Fit | None = None
        while begun and begun[0] is not walked:
            walked = begun[0]
            for one in each([partial(self._in_form, walked, form) for form in self._forms(walked.effects[-1])]):
                if one.width == walked.width or self.log_of(one) > self.log_of(walked) + evidence.LOG_ODDS:
                    begun.append(one)
            begun.sort(key=self.log_of, reverse=True)
        # What is far from the best, or from what can be added, is not finished.
        needed = self.log_of(now) + float(np.log(self.names)) + evidence.LOG_ODDS
        least = max([needed, *map(self.log_of, begun[:1])]) - evidence.LOG_ODDS
        likely = [*dict.fromkeys(one.effects[-1] for one in begun)][: evidence.TRIED]
        near = [one for one in begun if one.effects[-1] in likely or self.log_of(one) > least]
        ended = each([partial(self._finished, one) for one in near])
        self._reached |= {one.effects: one for one in (*begun, *ended)}
        # What is alike with and without an effect does not tell its size.
        least = evidence.ALIKE_SHARE * self.floor_rad
        told = [one for one in ended if np.std((one.residual - now.residual)[self.used]) > least]
        return [one for one in told if self.lowers(one, now) and self.possible(one, now)]

    def _forms(self, effect: Effect) -> list[Effect]:
        """Forms that are tried once an effect is: those that move the cables where it only adds to the reading, and
        sums of the same terms and one more."""
        forms = [one for one in self.inside if one.key == effect.key and one.form != effect.form]
        own = {p.name for p in effect.parameters}
        more = {one: {p.name for p in one.parameters} for one in self._sums(effect)}
        more = {one: names for one, names in more.items() if own < names}
        return [*forms, *(one for one, names in more.items() if not any(less < names for less in more.values()))]

    def _sums(self, effect: Effect) -> list[Effect]:
        """All sums of terms that an effect may be one of."""
        place = effect.form.split(":")[0]
        return [f for e in self.library if e.key == effect.key and e.form == place and e.richer for f in e.richer()]

    def ended(self, fit: Fit) -> Fit:
        """A fit whose effects do all that they can: an unknown cause is what they leave."""
        if not fit.effects:
            return fit
        ended = self.fitted(self.white.none, fit.effects, fit.values, fit.offsets)
        if fit in self._additions:
            self._additions[ended] = self._additions[fit]
        return ended
