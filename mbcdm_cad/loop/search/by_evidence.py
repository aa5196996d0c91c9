"""The search by evidence: add, drop or swap one effect while the odds allow it.

The score of a fit is the logarithm of its evidence (:mod:`mbcdm_cad.loop.search.marginal`) and of the prior of its names,
each as likely as each other, so that many candidates do not make a name likely. Candidates are ranked by the evidence
of a linear step, and few of them refitted. The noise is found again after each effect that was added. What stands in
the place of one effect, each with its share of the posterior, makes its credible set: the fewest names that together
hold 95 % (G. Wang and others, J. R. Stat. Soc. B 82 (2020) 1273).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.marginal import Evidence, NoiseModel, Whitened
from mbcdm_cad.loop.search.problem import LogProblem
from mbcdm_cad.loop.search.screening import Screened, Screening, _begun
from mbcdm_cad.routes import Floats

# Odds from which an effect is added, and the posterior that a set holds.
LOG_ODDS, CREDIBLE = float(np.log(99.0)), 0.95
# Least fall of the error by a named effect, RMS over the floor: smaller ones are listed.
LEAST_FALL = 0.45
MOST_EFFECTS = 6
# Standard deviations from which an error within a class is told.
TOLD = 1.0
# Refits of the most likely candidates of a linear step, of those of the largest fall, and of those that are finished.
REFITS, BY_FALL, FINISHED = 6, 3, 3
# Candidates that a linear step leaves so far behind the best are not refitted; those that a refit leaves so far behind
# are not finished. Logarithms of odds.
HOPELESS, BEHIND = 100.0, 6.0
# Relative change of the noise floor from which all is weighed anew.
SAME_NOISE = 0.05
# Of effects that set the slip of the cables a linear step promises little.
CABLES_SLIP = ("preload_error", "cable_friction", "passed_slip")
# Standard deviation of the prior of an order, cycles a turn, which has no bound.
ORDER_SD = 200.0
# Number of the hypothesis that what an unknown cause does is least.
NO_UNKNOWN = 0
# A shape of what changes is the less likely explanation beside a cause.
LOG_SHAPE = float(np.log(20.0))


@dataclass(frozen=True, eq=False)
class CredibleSet:
    """One effect of the final fit and what may stand in its place: the fewest names that hold 95 % of the posterior.

    ``probability`` is that of ``effect``. ``alike``: fits that have another effect last in its place, each with its
    probability. ``forms``: other forms of ``effect`` that the data do not tell from it.
    """

    effect: Effect
    probability: float
    alike: tuple[tuple[Fit, float], ...]
    forms: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Candidate(Screened):
    """A candidate whose ``columns`` are those at ``guess``, up to which the prediction changes by ``change``, rad."""

    change: Floats
    guess: Floats


class Candidates(Screening):
    """The screening of the loop, which keeps where the linear step of each candidate begins."""

    def _promise(self, fit: Fit, effect: Effect, start: Floats, basis: Floats, fitter: Fitter) -> Candidate:
        change, columns = self._slopes(fit, effect, start, fitter)
        square, step = self._projected(fit, change, columns, basis)
        return Candidate(effect, _begun(effect, start, step), fit.square - square, columns, change, start)


def bounds_of(effects: Sequence[Effect]) -> Floats:
    """The least and the greatest of each size, (2, k); places and orders have none here, their fit keeps them."""
    own = [p for effect in effects for p in effect.parameters]
    limits = [(p.low, p.high) if p.role == "size" else (-np.inf, np.inf) for p in own]
    return np.array(limits, dtype=float).reshape(-1, 2).T


class Posterior:
    """Fits of one set of runs under one noise; ``bare`` is the fit without effects, ``names`` the number of names that an
    effect may have."""

    def __init__(self, fitter: Fitter, bare: Fit, names: int) -> None:
        self.fitter, self.bare, self.names, self.used = fitter, bare, names, fitter.used
        self.problem = LogProblem(fitter, bare)

    def weigh(self, noise: NoiseModel) -> None:
        """Take a noise, and forget what was found under another."""
        self.white: Whitened = self.problem.whitened(noise, self.names)
        self._known: dict[Fit, Evidence] = {}
        self._metrics: dict[int, Callable[[Floats], Floats]] = {}

    @property
    def floor_rad(self) -> float:
        """RMS of the noise model, rad."""
        return self.white.noise.floor_rad

    def prior_sd(self, effects: Sequence[Effect], jacobian: Floats) -> Floats:
        """Standard deviation of each value before the run was seen, (k,): as large as the whole error."""
        rms = np.sqrt(np.mean((jacobian - jacobian.mean(axis=0)) ** 2, axis=0))
        sd = np.where(rms > 0.0, self.problem.prior_rad / np.where(rms > 0.0, rms, 1.0), 0.0)
        for i, p in enumerate([p for effect in effects for p in effect.parameters]):
            if p.role != "size":
                sd[i] = (p.high - p.low) / np.sqrt(12.0) if np.isfinite(p.high - p.low) else ORDER_SD
        return sd

    def of(self, fit: Fit) -> Evidence:
        """Evidence of a fit under the present noise."""
        if fit not in self._known:
            jacobian = fit.jacobian[self.used][:, : fit.width]
            theta = np.concatenate(fit.values) if fit.effects else np.zeros(0)
            y = fit.residual[self.used] + jacobian @ theta
            parts = self.white.parts(np.column_stack([jacobian, y]))
            sd, bounds = self.prior_sd(fit.effects, jacobian), bounds_of(fit.effects)
            self._known[fit] = self.white.evidence(parts, sd, bounds, y.size)
        return self._known[fit]

    def unknown_rad(self, fit: Fit) -> float:
        """RMS of what the unknown cause does beside a fit, nuisances taken into account."""
        return float(np.std(self.white.unknown(self.of(fit), self.problem.curves)))

    def held_rms(self, fit: Fit) -> float:
        """RMS on the held-out samples, rad."""
        return float(np.sqrt(np.mean(fit.residual[self.fitter.test] ** 2)))

    def fitted(
        self,
        unknown: int,
        effects: Sequence[Effect],
        values: Sequence[Floats],
        offsets: Floats,
        fitter: Fitter | None = None,
        **more: Any,
    ) -> Fit:
        """The fit of most posterior density, beside nuisances and an unknown cause."""
        if unknown not in self._metrics:
            self._metrics[unknown] = self.white.metric(unknown)
        options: dict[str, Any] = {"mask": self.used, "metric": self._metrics[unknown], "settled": 1e-6} | more
        return (fitter or self.fitter).fit(effects, values, offsets, **options)

    def beside_nuisances(self, fit: Fit) -> Fit:
        """A fit with what sensors and figures of the design are certainly wrong by taken off its residual."""
        pairs = zip(self.problem.nuisances, self.of(fit).nuisances, strict=True)
        told = [mean * one.column for one, mean in pairs if one.of_class and abs(mean) > TOLD]
        if not told:
            return fit
        residual = self.fitter.centred(fit.residual - np.sum(told, axis=0), self.fitter.train)
        return replace(fit, residual=residual, square=float(np.mean(residual[self.fitter.train] ** 2)))

    def mean_of(self, fit: Fit, effect: Effect) -> Floats:
        """Posterior mean of the sizes of an effect, all else integrated out; places and orders keep their fit."""
        sizes = [p.role == "size" for p in effect.parameters]
        return np.where(sizes, self.of(fit).mean[fit.columns_of(effect)], fit.values_of(effect))


class Search(Posterior):
    """The search over one set of runs."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect], bare: Fit) -> None:
        self.library = tuple(e for e in library if not e.inside)
        self.inside = tuple(e for e in library if e.inside)
        super().__init__(fitter, bare, len({effect.key for effect in self.library}))
        self.screening = Candidates(fitter, self.library)
        # Reasons why fitted values are impossible: a sentence for each effect's label.
        self.doubts: dict[str, str] = {}
        self._retuned(bare)

    def _retuned(self, fit: Fit) -> None:
        """The noise of a fit, and all that depends on it, unless it is nearly that at hand."""
        known = []
        for c in self._screened(fit):
            columns = c.columns[self.used]
            known.append(
                (np.column_stack([c.change[self.used], columns]), np.append(1.0, self.prior_sd([c.effect], columns)))
            )
        noise = self.problem.noise_of(fit, known)
        if fit is not self.bare and abs(np.log(noise.floor_rad / self.floor_rad)) < SAME_NOISE:
            return
        self.weigh(noise)
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

    def _screened(self, now: Fit) -> list[Candidate]:
        """Candidates for an addition to a fit."""
        screened = cast("list[Candidate]", self.screening.screen(now))
        return [c for c in screened if np.isfinite(c.columns).all()]

    def _promises(self, now: Fit) -> list[tuple[float, Candidate]]:
        """Candidates by the logarithm of the evidence of a linear step, best first."""
        own = now.jacobian[self.used][:, : now.width]
        theta = np.concatenate(now.values) if now.effects else np.zeros(0)
        y = now.residual[self.used] + own @ theta
        sd, k = self.prior_sd(now.effects, own), own.shape[1]
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
            sds = np.append(sd, self.prior_sd([c.effect], c.columns[self.used]))
            bounds = bounds_of((*now.effects, c.effect))
            one = self.white.evidence((take.T @ gram @ take, on_z @ take), sds, bounds, y.size)
            begun = np.where(c.start == c.guess, c.start, one.mean[k - q :])
            begun = np.clip(begun, [p.low for p in c.effect.parameters], [p.high for p in c.effect.parameters])
            log = one.log - (LOG_SHAPE if c.effect.last else 0.0)
            found.append((log, replace(c, start=begun)))
            at += m + 1
        return sorted(found, key=lambda pair: -pair[0])

    def additions(self, now: Fit, most: int = REFITS) -> list[Fit]:
        """Refits of ``now`` with one effect more, most evidence first."""
        if now in self._moves:
            return self._moves[now]
        ranked = self._promises(now)
        chosen = [c for log, c in ranked[:most] if log > ranked[0][0] - HOPELESS]
        # A linear step may promise little evidence where it explains most of the error.
        chosen += [c for _, c in sorted(ranked, key=lambda pair: -pair[1].fall)[:BY_FALL] if c not in chosen]
        names = {c.effect.name for c in chosen[:1]}
        left = self.of(now)
        if left.unknown_odds > LOG_ODDS:
            names |= {*CABLES_SLIP}
        chosen += [c for _, c in ranked if c not in chosen and c.effect.name in names]
        promised = {id(c): log for log, c in ranked}
        base = now.width

        def begun_at(unknown: int, c: Candidate, fitter: Fitter, **options: Any) -> Fit:
            both = (*now.effects, c.effect), (*now.values, c.start)
            options |= {"iterations": 4, "settled": 1e-4, "fresh": False}
            return self.fitted(unknown, *both, now.offsets, fitter, **options)

        def few(c: Candidate, fitter: Fitter) -> Fit:
            slopes = np.hstack([now.jacobian[:, :base], c.columns, now.jacobian[:, base:]])
            # Beside a large unknown, which may stand for what the candidate does, and beside none.
            found = [begun_at(unknown, c, fitter, slopes=slopes) for unknown in sorted({left.unknown, NO_UNKNOWN})]
            best = max(found, key=lambda one: self.of(one).log)
            if self.of(best).log < promised[id(c)] - 3.0:
                best = max(best, begun_at(left.unknown, c, fitter), key=lambda one: self.of(one).log)
            return best

        begun = sorted(self.screening.twins.each([partial(few, c) for c in chosen]), key=lambda one: -self.of(one).log)
        least = max((self.of(one).log for one in begun), default=0.0)
        near = [one for k, one in enumerate(begun) if k < FINISHED or self.of(one).log > least - BEHIND]

        # A form that moves the cables has the values of the form that only adds to the reading.
        near += [
            replace(one, effects=(*now.effects, form))
            for one in near[:1]
            for form in self.inside
            if form.key == one.effects[-1].key
        ]

        def finished(one: Fit, fitter: Fitter) -> Fit:
            return self.fitted(self.of(one).unknown, one.effects, one.values, one.offsets, fitter)

        ended = self.screening.twins.each([partial(finished, one) for one in near])
        possible = [one for one in ended if not self.impossible(one.effects[-1], one.values[-1])]
        self._moves[now] = sorted(possible, key=self.score, reverse=True)
        return self._moves[now]

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
        seen = set[frozenset[str]]()
        while len(now.effects) < MOST_EFFECTS and (held := frozenset(e.label for e in now.effects)) not in seen:
            seen.add(held)
            more = self.additions(now)
            if not more:
                break
            better = more[0]
            if self.score(better) - self.score(now) < LOG_ODDS:
                # One more may make another one needless.
                likelier = [one for one in more[:FINISHED] if self.of(one).log > self.of(now).log + 1.0]
                better = max(map(self.pruned, likelier), key=self.score, default=now)
                if self.score(better) < self.score(now) + 1.0:
                    break
            self._retuned(better)
            self._without.setdefault(frozenset(map(id, now.effects)), now)
            now = self.swapped(self.pruned(better))
        return now

    def pruned(self, now: Fit) -> Fit:
        """``now`` without effects that the others explain as well."""
        for effect in now.effects[:-1]:
            less = self.without(now, effect)
            if self.score(now) - self.score(less) < 0.0:
                return self.pruned(less)
        return now

    def swapped(self, now: Fit) -> Fit:
        """``now`` with another effect, or form, in the place of one, while that has more evidence.

        The noise is found again after each exchange, so the evidence of what was there before is another number then:
        no set of effects is begun from twice.
        """
        seen = set[frozenset[str]]()
        following: Fit | None = now
        while following is not None and (held := frozenset(e.label for e in following.effects)) not in seen:
            seen.add(held)
            now = following
            following = self._exchanged(now)
        return now

    def _exchanged(self, now: Fit) -> Fit | None:
        for effect in now.effects:
            best = next(iter(self.additions(self.without(now, effect))), now)
            if self.score(best) > self.score(now) + 1.0:
                self._retuned(best)
                return self.pruned(best)
        return None

    def found(self) -> tuple[Fit, tuple[CredibleSet, ...]]:
        """The fit of most evidence and the credible set of each of its effects."""
        now = self.grown(self.bare)
        return now, tuple(self._set_of(now, effect) for effect in now.effects)

    def _set_of(self, now: Fit, effect: Effect) -> CredibleSet:
        less = self.without(now, effect)
        members: dict[object, tuple[float, Fit]] = {effect.key: (self.score(now), now)}
        forms = []
        for one in self.additions(less):
            last = one.effects[-1]
            if last.key == effect.key:
                if self.score(one) > self.score(now) - LOG_ODDS:
                    forms.append(last.form)
            elif last.key not in members:
                members[last.key] = self.score(one), one
        # The first is that nothing stands there.
        scores = np.array([self.score(less), *(score for score, _ in members.values())])
        share = np.exp(scores - scores.max())
        share = share[1:] / share.sum()
        order = np.argsort(-share)
        kept = order[: 1 + int(np.searchsorted(np.cumsum(share[order]), CREDIBLE))]
        fits = [one for _, one in members.values()]
        alike = tuple((fits[k], float(share[k])) for k in kept if k > 0)
        return CredibleSet(effect, float(share[0]), alike, tuple(dict.fromkeys(forms)))
