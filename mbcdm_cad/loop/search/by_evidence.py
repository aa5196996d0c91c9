"""The search by evidence: add, drop or swap one effect while the odds allow it.

The score of a fit is the logarithm of its evidence (:mod:`mbcdm_cad.loop.search.evidence`) and of the prior of its
names, each as likely as each other, so that many candidates do not make a name likely. Candidates are ranked by the
evidence of a linear step, and few of them refitted, each beside a large unknown cause and beside none, since the
evidence has a maximum at either. The noise is found again after each effect that was added. What stands in the place of
one effect, each with its share of the posterior, makes its credible set: the fewest names that together hold 95 %
(G. Wang and others, J. R. Stat. Soc. B 82 (2020) 1273).
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from scipy.special import logsumexp

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.search.account import WithinClass, size_name
from mbcdm_cad.loop.search.evidence import (
    ALIKE_SHARE,
    LEAST_FALL,
    LOG_ODDS,
    ROUNDED,
    SCALES,
    NoiseModel,
    Weighed,
    Whitened,
)
from mbcdm_cad.loop.search.fit import Fit, FitRows, Fitter
from mbcdm_cad.loop.search.problem import LogProblem, Nuisance
from mbcdm_cad.loop.search.screening import Screened, Screening
from mbcdm_cad.routes import Floats

SomeFit = TypeVar("SomeFit", bound=Any)
# The posterior that a set holds.
CREDIBLE = 0.95
MOST_EFFECTS = 6
# Of errors within a class those are told that do at least this share of what the largest does.
TOLD = 0.3
# Refits of the most likely candidates of a linear step, of those of the largest fall, and of those that are finished.
REFITS, BY_FALL, FINISHED = 6, 3, 3
# Candidates that a linear step leaves so far behind the best are not refitted; those that a refit leaves so far behind
# are not finished. Logarithms of odds.
HOPELESS, BEHIND = 100.0, 6.0
# All is weighed anew where the noise floor falls below this share of that at hand.
SAME_NOISE = 0.95
# Of effects that set the slip of the cables a linear step promises little.
CABLES_SLIP = ("preload_error", "cable_friction", "passed_slip")
# Standard deviation of the prior of an order, cycles a turn, which has no bound.
ORDER_SD = 200.0
# Number of the hypothesis that what an unknown cause does is least.
NO_UNKNOWN = 0
# A shape of what changes is the less likely explanation beside a cause.
LOG_SHAPE = float(np.log(20.0))


@dataclass(frozen=True, eq=False)
class CredibleSet(Generic[SomeFit]):
    """One effect of the final fit and what may stand in its place: the fewest names that hold 95 % of the posterior.

    ``probability`` is that of ``effect``. ``alike``: fits that have another effect last in its place, each with its
    probability. ``forms``: other forms of ``effect`` that the data do not tell from it.
    """

    effect: Any
    probability: float
    alike: tuple[tuple[SomeFit, float], ...]
    forms: tuple[str, ...]


def credible_set(
    effect: Any,
    less: SomeFit,
    now: SomeFit,
    others: Sequence[SomeFit],
    score: Callable[[SomeFit], float],
    untold: Callable[[SomeFit], bool] = lambda fit: False,
) -> CredibleSet[SomeFit]:
    """The set of an effect of ``now``, without which the fit is ``less``; ``others`` have another one last in its
    place, likeliest first. A fit that is ``untold`` from ``now`` is in the set, however likely it is."""
    fits, forms = {effect.key: now}, list[str]()
    for one in others:
        last = one.effects[-1]
        if last.key != effect.key:
            fits.setdefault(last.key, one)
        elif last.form != effect.form and score(one) > score(now) - LOG_ODDS:
            forms.append(last.form)
    each = list(fits.values())
    scores = [score(less), *map(score, each)]
    share = np.exp(np.array(scores) - logsumexp(scores))[1:]
    order = np.argsort(-share)
    kept = order[: 1 + int(np.searchsorted(np.cumsum(share[order]), CREDIBLE))].tolist()
    kept += [k for k, one in enumerate(each) if untold(one)]
    alike = tuple((each[k], float(share[k])) for k in dict.fromkeys(kept) if k > 0)
    return CredibleSet(effect, float(share[0]), alike, tuple(dict.fromkeys(forms)))


def bounds_of(effects: Sequence[Effect]) -> Floats:
    """The least and the greatest of each size, (2, k); places and orders have none here, their fit keeps them."""
    own = [p for effect in effects for p in effect.parameters]
    limits = [(p.low, p.high) if p.role == "size" else (-np.inf, np.inf) for p in own]
    return np.array(limits, dtype=float).reshape(-1, 2).T


def spread_of(parameter: Parameter, value: float) -> float:
    """Standard deviation of the prior of a place or an order, near a value."""
    p = parameter
    if p.role == "order":
        return ORDER_SD
    return float(value * np.log(p.high / p.low) if p.low > 0.0 else p.high - p.low) / float(np.sqrt(12.0))


class Posterior:
    """Fits of one set of runs under one noise; ``bare`` is the fit without effects, ``names`` the number of names that
    an effect may have."""

    problem_of: type[LogProblem] = LogProblem

    # Scales of the curves of an unknown cause.
    scales = SCALES

    def __init__(self, fitter: Fitter, bare: Fit, names: int) -> None:
        self.fitter, self.bare, self.names, self.used = fitter, bare, names, fitter.used
        self.problem = self.problem_of(fitter, bare)

    def weigh(self, noise: NoiseModel, nuisances: Sequence[Nuisance]) -> None:
        """Take a noise and nuisances, and forget what was found under others."""
        self.nuisances = tuple(nuisances)
        self.white: Whitened = self.problem.whitened(noise, nuisances, self.names, self.scales)
        self._known: dict[Fit, Weighed] = {}
        self._metrics: dict[int, Callable[[Floats], Floats]] = {}

    @property
    def floor_rad(self) -> float:
        """RMS of the noise model, rad."""
        return self.white.noise.floor_rad

    def prior_sd(self, effects: Sequence[Effect], values: Sequence[Floats], jacobian: Floats) -> Floats:
        """Standard deviation of each value before the run was seen, (k,): as large as the whole error; of a place
        within its bounds, of one above zero, such as a time constant, as likely in each decade."""
        rms = np.sqrt(np.mean((jacobian - jacobian.mean(axis=0)) ** 2, axis=0))
        shown = rms > ROUNDED * np.abs(jacobian).max(axis=0, initial=0.0)  # what only shifts the zero shows nothing
        sd = np.where(shown, self.problem.prior_rad / np.where(shown, rms, 1.0), 0.0)
        own = [p for effect in effects for p in effect.parameters]
        for i, (p, value) in enumerate(zip(own, itertools.chain(*values), strict=True)):
            if p.role != "size":
                sd[i] = spread_of(p, value)
        return sd

    def of(self, fit: Fit) -> Weighed:
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
        return jacobian, fit.residual[self.used] + jacobian @ theta + np.sum(offsets, axis=0)

    def with_offsets(self, fit: Fit) -> Floats:
        """Covariance of the values of a fit and of its free offsets, which are nuisances here."""
        joint, q = self.of(fit).joint, len(self.nuisances)
        offsets = [k for k, one in enumerate(self.nuisances) if one.offset < np.inf]
        order = [*range(q, q + fit.width), *offsets]
        size = np.array([*[1.0] * fit.width, *(self.nuisances[k].offset for k in offsets)])
        return np.asarray(joint[np.ix_(order, order)] * np.outer(size, size))

    def unknown_rad(self, fit: Fit) -> float:
        """RMS of what the unknown cause does beside a fit, nuisances taken into account."""
        return float(np.std(self.white.unknown(self.of(fit), self.problem.curves)))

    def held_rms(self, fit: Fit) -> float:
        """RMS on the held-out samples, rad."""
        return float(np.sqrt(np.mean(fit.residual[self.fitter.test] ** 2)))

    def fall_rad(self, less: Fit, more: Fit) -> float:
        """By how much a fit lowers the error of one with fewer effects, rad: root of the fall of the mean square."""
        return float(np.sqrt(max(0.0, np.mean(less.residual[self.used] ** 2 - more.residual[self.used] ** 2))))

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
        if unknown not in self._metrics:
            self._metrics[unknown] = self.white.metric(unknown)
        rows = FitRows(self.used, self._metrics[unknown])
        return (fitter or self.fitter).fit(effects, values, offsets, rows, **({"settled": 1e-6} | options))

    def within_class(self, fit: Fit) -> list[tuple[Nuisance, float]]:
        """What sensors and figures of the design are wrong by within their class, with the posterior mean in standard
        deviations; empty where all of it together is too small to name."""
        pairs = zip(self.nuisances, self.of(fit).nuisances, strict=True)
        found = [(one, float(mean)) for one, mean in pairs if one.effect]
        whole = np.sum([mean * one.column[self.used] for one, mean in found], axis=0)
        return found if np.std(whole) > LEAST_FALL * self.floor_rad else []

    def within_words(self, fit: Fit) -> str:
        """The same for people, without what does little of it."""
        found = self.within_class(fit)
        does = [abs(mean) * float(np.std(one.column[self.used])) for one, mean in found]
        sizes = tuple(
            (size_name(one.effect), one.size * mean)
            for (one, mean), size in zip(found, does, strict=True)
            if one.effect and size >= TOLD * max(does)
        )
        return WithinClass(sizes, self.fitter.runs[0].run.sensors.torque_class).sentence if sizes else ""

    def beside_nuisances(self, fit: Fit) -> Fit:
        """A fit with that taken off its residual."""
        found = self.within_class(fit)
        if not found:
            return fit
        whole = np.sum([mean * one.column for one, mean in found], axis=0)
        residual = self.fitter.centred(fit.residual - whole, self.fitter.train)
        return replace(fit, residual=residual, square=float(np.mean(residual[self.fitter.train] ** 2)))


class Search(Posterior):
    """The search over one set of runs."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect], bare: Fit) -> None:
        self.library = tuple(e for e in library if not e.inside)
        self.inside = tuple(e for e in library if e.inside)
        super().__init__(fitter, bare, len({effect.key for effect in self.library}))
        self.screening = Screening(fitter, self.library)
        # Reasons why fitted values are impossible: a sentence for each effect's label.
        self.doubts: dict[str, str] = {}
        # Fits by their effects, under any noise: a fit under another one begins there.
        self._reached: dict[tuple[Effect, ...], Fit] = {}
        self._retuned(bare)

    def _retuned(self, fit: Fit) -> None:
        """The noise of a fit, and all that depends on it, unless it is no smaller than that at hand: what a worse model
        leaves is no noise, and the search ends."""
        known = []
        for c in self._screened(fit):
            columns = c.columns[self.used]
            sd = np.append(1.0, self.prior_sd([c.effect], [c.guess], columns))
            known.append((np.column_stack([c.change[self.used], columns]), sd))
        nuisances = self.problem.nuisances_of(self.bare)
        noise = self.problem.noise_of(fit, nuisances, known)
        if fit is not self.bare and noise.floor_rad > SAME_NOISE * self.floor_rad:
            return
        self.weigh(noise, nuisances)

    def weigh(self, noise: NoiseModel, nuisances: Sequence[Nuisance]) -> None:
        """Take a noise and nuisances, and forget what was found under others."""
        super().weigh(noise, nuisances)
        # Fits by what they hold, as they were best beside each other.
        self._without: dict[frozenset[int], Fit] = {}
        self._moves: dict[Fit, list[Fit]] = {}

    def score(self, fit: Fit) -> float:
        """Logarithm of the evidence, times the prior of its effects: each name as likely as each other."""
        return self.of(fit).log - float(sum(np.log(self.names) + (LOG_SHAPE if e.last else 0.0) for e in fit.effects))

    def without(self, fit: Fit, effect: Effect) -> Fit:
        """Refit with one effect left out."""
        rest = tuple(e for e in fit.effects if e is not effect)
        if not rest:
            return self.bare
        key = frozenset(map(id, rest))
        if key not in self._without:
            values = [fit.values_of(e) for e in rest]
            self._without[key] = self.fitted(self.of(fit).unknown, rest, values, fit.offsets)
        return self._without[key]

    def _screened(self, now: Fit) -> list[Screened]:
        """Candidates for an addition to a fit."""
        return [c for c in self.screening.screen(now) if np.isfinite(c.columns).all()]

    def _promises(self, now: Fit) -> list[tuple[float, Screened]]:
        """Candidates by the logarithm of the evidence of a linear step, best first."""
        own, y = self._data(now)
        sd, k = self.prior_sd(now.effects, now.values, own), own.shape[1]
        chosen = self._screened(now)
        # The step goes from the guess, which changes the prediction already.
        blocks = [np.column_stack([c.columns, c.columns @ c.guess - c.change])[self.used] for c in chosen]
        gram, on_z = self.white.parts(np.column_stack([own, y, *blocks]))
        # Nuisances come first.
        q = self.white.bounds.shape[1]
        found, at, k = [], q + k + 1, q + k
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
            begun = np.where(c.start == c.guess, c.start, one.mean[k - q :])
            begun = np.clip(begun, [p.low for p in c.effect.parameters], [p.high for p in c.effect.parameters])
            log = one.log - (LOG_SHAPE if c.effect.last else 0.0)
            found.append((log, replace(c, start=begun)))
            at += m + 1
        return sorted(found, key=lambda pair: -pair[0])

    def additions(self, now: Fit) -> list[Fit]:
        """Refits of ``now`` with one effect more, most evidence first."""
        if now in self._moves:
            return self._moves[now]
        ranked = self._promises(now)
        chosen = [c for log, c in ranked[:REFITS] if log > ranked[0][0] - HOPELESS]
        # A linear step may promise little evidence where it explains most of the error.
        chosen += [c for _, c in sorted(ranked, key=lambda pair: -pair[1].fall)[:BY_FALL] if c not in chosen]
        names = {c.effect.name for c in chosen[:1]}
        left = self.of(now)
        if left.unknown_odds > LOG_ODDS:
            names |= {*CABLES_SLIP}
        chosen += [c for _, c in ranked if c not in chosen and c.effect.name in names]
        promised = {id(c): log for log, c in ranked}
        base = now.width

        # Beside a large unknown, which may stand for what the candidate does, and beside none.
        unknowns = sorted({left.unknown, NO_UNKNOWN if left.unknown_odds > 0.0 else left.unknown})

        def begin(unknown: int, last: Effect, values: Sequence[Floats], fitter: Fitter, slopes: Floats | None) -> Fit:
            options = {"iterations": 4, "settled": 1e-4, "fresh": False, "slopes": slopes}
            return self.fitted(unknown, (*now.effects, last), values, now.offsets, fitter, **options)

        def few(c: Screened, fitter: Fitter) -> Fit:
            near, values = self._reached.get((*now.effects, c.effect)), (*now.values, c.start)
            if near is not None:
                best = begin(self.of(near).unknown, c.effect, near.values, fitter, near.jacobian)
            else:
                slopes = np.hstack([now.jacobian[:, :base], c.columns, now.jacobian[:, base:]])
                best = max((begin(unknown, c.effect, values, fitter, slopes) for unknown in unknowns), key=log_of)
            if log_of(best) < promised[id(c)] - LOG_SHAPE:
                best = max(best, begin(left.unknown, c.effect, values, fitter, None), key=log_of)
            return best

        def log_of(one: Fit) -> float:
            return self.of(one).log

        begun = sorted(self.screening.twins.each([partial(few, c) for c in chosen]), key=log_of, reverse=True)

        # Other forms of the likeliest, while one of them is likelier.
        def other(one: Fit, form: Effect, fitter: Fitter) -> Fit:
            known = dict(zip([p.name for p in one.effects[-1].parameters], one.values[-1], strict=True))
            guesses = fitter.guesses(form, one.residual)
            if not guesses:  # nothing in the data tells of this form
                return one
            values = np.array([known.get(p.name, v) for p, v in zip(form.parameters, guesses[0], strict=True)])
            slopes = one.jacobian if values.size == one.values[-1].size else None
            return begin(self.of(one).unknown, form, (*one.values[:-1], values), fitter, slopes)

        walked: Fit | None = None
        while begun and begun[0] is not walked:
            walked = begun[0]
            forms = [partial(other, walked, form) for form in self._forms(walked.effects[-1])]
            # A term more is taken as an effect more is.
            others = [
                one
                for one in self.screening.twins.each(forms)
                if one.width == walked.width or log_of(one) > log_of(walked) + LOG_ODDS
            ]
            begun = sorted([*begun, *others], key=log_of, reverse=True)
        # What is far from the best, or from what can be added, is not finished.
        least = max([left.log + float(np.log(self.names)) + LOG_ODDS, *map(log_of, begun[:1])]) - BEHIND
        near = [one for k, one in enumerate(begun) if k < FINISHED or log_of(one) > least]

        def finished(one: Fit, fitter: Fitter) -> Fit:
            found = self.fitted(self.of(one).unknown, one.effects, one.values, one.offsets, fitter)
            last, values = one.effects[-1], found.values[-1]
            # A sum of which a term has no size is the sum without it.
            none = [p.role == "size" and p.low == v == 0.0 for p, v in zip(last.parameters, values, strict=True)]
            names = {p.name for p, gone in zip(last.parameters, none, strict=True) if not gone}
            less = next((e for e in self._sums(last) if {p.name for p in e.parameters} == names), None)
            if less is None or not any(none):
                return found
            return begin(self.of(found).unknown, less, (*found.values[:-1], values[~np.array(none)]), fitter, None)

        ended = self.screening.twins.each([partial(finished, one) for one in near])
        # What is alike with and without an effect does not tell its size.
        least = ALIKE_SHARE * self.floor_rad
        told = [one for one in ended if np.std((one.residual - now.residual)[self.used]) > least]
        possible = [one for one in told if not self.impossible(one.effects[-1], one.values[-1])]
        self._reached |= {one.effects: one for one in (*begun, *ended)}
        self._moves[now] = sorted(possible, key=self.score, reverse=True)
        return self._moves[now]

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

    def impossible(self, effect: Effect, values: Floats) -> str:
        """Why no bench can have an effect of these values; an empty text if it can."""
        words = effect.doubtful(values) if effect.doubtful else ""
        if words:
            self.doubts.setdefault(effect.label, words)
        at_bound = [
            p.name
            for p, v in zip(effect.parameters, values, strict=True)
            if v in (p.low, p.high) and p.role == "size" and v != 0.0
        ]
        return words or (f"{at_bound[0]} reaches its bound" if at_bound else "")

    def grown(self, now: Fit) -> Fit:
        """``now`` with every effect that the evidence allows."""
        while len(now.effects) < MOST_EFFECTS:
            more = self.additions(now)
            if not more:
                break
            better = more[0]
            # One more effect is certain if any one is; which one, its credible set says.
            each = {one.effects[-1].label: self.score(one) for one in reversed(more)}
            if logsumexp(list(each.values())) - self.score(now) < LOG_ODDS:
                # One more may make another one needless.
                likelier = [self.pruned(one) for one in more[:FINISHED] if self.of(one).log > self.of(now).log + 1.0]
                fewer = [one for one in likelier if len(one.effects) <= len(now.effects)]
                better = max(fewer, key=self.score, default=now)
                if self.score(better) < self.score(now) + 1.0:
                    break
            # The same effects may have been fitted better beside the new one: then it is not needed yet.
            if better.effects[:-1] == now.effects:
                again = self.fitted(self.of(better).unknown, now.effects, better.values[:-1], better.offsets)
                if self.score(again) > self.score(now) + 1.0:
                    self._without[frozenset(map(id, now.effects))] = now = again
                    continue
            self._retuned(better)
            self._without.setdefault(frozenset(map(id, now.effects)), now)
            now = self.pruned(better)
            now = self.swapped(now) if self.scales is SCALES else now
        return now

    def pruned(self, now: Fit) -> Fit:
        """``now`` without effects that the others explain as well."""
        for effect in now.effects[:-1]:
            less = self.without(now, effect)
            if self.score(now) - self.score(less) < 0.0:
                return self.pruned(less)
        return now

    def swapped(self, now: Fit) -> Fit:
        """``now`` with another effect, or form, in the place of one, while that has more evidence."""
        for effect in now.effects:
            best = next(iter(self.additions(self.without(now, effect))), now)
            if self.score(best) > self.score(now) + 1.0:
                self._retuned(best)
                return self.swapped(self.pruned(best))
        return now

    def found(self) -> tuple[Fit, tuple[CredibleSet[Fit], ...]]:
        """The fit of most evidence and the credible set of each of its effects."""
        now = self.grown(self.bare)
        if self.of(now).unknown_odds > LOG_ODDS:
            # Of several causes none may pay beside an unknown that stands for all: also begun without any.
            names = self.bare
            for self.scales in (SCALES[:1], SCALES):
                self.weigh(self.white.noise, self.nuisances)
                names = self.grown(self.pruned(names))
            now = names if self.score(names) >= self.score(now) + LOG_ODDS else now
        if now.effects:
            now = self.fitted(self.of(now).unknown, now.effects, now.values, now.offsets)
        return now, tuple(self._set_of(now, effect) for effect in now.effects)

    def _set_of(self, now: Fit, effect: Effect) -> CredibleSet[Fit]:
        # What was not measured is in the set if what tells it from the effect is too small to name.
        least, here = (LEAST_FALL * self.floor_rad) ** 2, self.held_rms(now) ** 2

        def untold(one: Fit) -> bool:
            return one.effects[-1].unmeasured and self.held_rms(one) ** 2 - here < least

        less = self.without(now, effect)
        return credible_set(effect, less, now, self.additions(less), self.score, untold)
