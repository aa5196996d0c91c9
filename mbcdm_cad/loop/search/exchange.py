"""Compare each effect of the search's fit with others of a similar signature, and exchange those that fit better.

Effects that the data cannot separate form a group. One effect is exchanged at a time, then two at once: the search
accepts one effect at a time, and the first may be a wrong one that resembles the sum of two. The runout of an input
pulley resembles that of a guide beside a wrong ratio, and no exchange of a single effect leads from there to the two
that are present.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from itertools import combinations
from math import log

import numpy as np
from scipy.stats import t as t_distribution

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.readable import INTERVAL
from mbcdm_cad.loop.search.evidence import (
    LOG_ODDS,
    SAME_FIT,
    TOLD_APART,
    Estimate,
    Separation,
    cluster_estimate,
    log_odds,
    separation_of,
)
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.forms import in_best_form
from mbcdm_cad.loop.search.select import Search
from mbcdm_cad.routes import Floats

# Two fits are alike if their errors differ by less than this share of the floor in quadrature: so small a difference
# may be an error of the model. They are apart if the data can separate them (see ``evidence``) and their errors differ
# by so many standard errors over the cells of sweep and sector; or by fewer, if the odds of the better one are those
# of ``TOLD_APART`` and the data can separate them nearly so well.
ALIKE_SHARE = 0.12
CLEAR_ERRORS, LEAST_ERRORS = 2.0, 1.0
NEARLY_APART = 0.05
# Effects or forms that are exchanged after the search.
MOST_EXCHANGES = 6
# Pairs of which a few steps of a refit are made in place of each two effects, and refits that are finished. What a
# linear step promises ranks the pairs only roughly: a pulley that strains cables with friction is far from linear.
MOST_PAIRS, MOST_FINISHED = 6, 2


@dataclass(frozen=True, eq=False)
class Group:
    """One effect of the final fit, the fits that explain the run as well without it, and other forms of it that do."""

    effect: Effect
    alike: tuple[Fit, ...]
    forms: tuple[str, ...] = ()


class Exchanges:
    """Compares the effects of a search's fit with others, and exchanges them."""

    def __init__(self, search: Search) -> None:
        self.search, self.fitter = search, search.fitter
        self._estimates: dict[Fit, Estimate] = {}

    def settled(self) -> tuple[Fit, tuple[Group, ...]]:
        """The search's fit after each effect was compared with its alternatives."""
        fit = in_best_form(self.search, self.search.forward())
        for _ in range(MOST_EXCHANGES):
            groups, better = [], None
            for effect in fit.effects:
                every = self.search.alternatives(fit, effect)
                # The search chose the form of an effect before it knew the effects that it accepted later.
                forms = [o for o in every if self._in_better_form(o, fit, effect)]
                better = min(forms, key=self.search.held_rms if effect.once else lambda one: one.square, default=None)
                if better is not None:
                    break
                others = [o for o in every if o.effects[-1].key != effect.key]
                if others and others[0].square < fit.square and not self.alike(fit, others[0]):
                    better = others[0]
                    break
                alike = [o for o in others if self.alike(o, fit) or self._by_its_phase(o, fit, effect)]
                better = next((o for o in alike if self._coincidence(o, o.effects[-1], fit, effect)), None)
                if better is not None:
                    break
                alike = [o for o in alike if not self._coincidence(fit, effect, o, o.effects[-1])]
                same = [o for o in every if o.effects[-1].key == effect.key and self.alike(o, fit)]
                possible = [o for o in same if not self.search.impossible(o.effects[-1], o.values[-1])]
                also = dict.fromkeys(o.effects[-1].form for o in possible if not o.effects[-1].inside)
                groups.append(Group(effect, self._by_name(alike, effect), tuple(also)))
            if better is None:
                better = self._with_one_less(fit) or self._other_pair(fit)
            if better is None:
                return fit, tuple(groups)
            # Beside another effect the search may accept one that it withdrew before, and one may no longer be needed.
            fit = self.search.needed(self.search.taken(better) if self.search.too_much(better) else better)
        return fit, tuple(groups)

    def _with_one_less(self, fit: Fit) -> Fit | None:
        """``fit`` with one effect less, where another form of a second one makes up for it.

        A reading that walks one way beside a wrong ratio is one that walks both ways. Of what only adds to the reading.
        """
        for effect in fit.effects if len(fit.effects) > 1 else ():
            forms = [e for e in self.search.library if e.key == effect.key and e.form != effect.form]
            for form in (e for e in forms if e.parameters == effect.parameters and self.fitter.kind(e) == 2):
                for gone in (e for e in fit.effects if e is not effect):
                    kept = [e for e in fit.effects if e not in (effect, gone)]
                    values = [*map(fit.values_of, kept), fit.values_of(effect)]
                    found = self.fitter.tried((*kept, form), values, fit.offsets)
                    if found is not None and not self.search.enough(found, fit) and self.alike(found, fit):
                        return found
        return None

    def _other_pair(self, fit: Fit) -> Fit | None:
        """The best fit with two other effects in place of one or two of ``fit``, if the data separate the two fits."""
        found = next(iter(other_pairs(self.search, fit)), None)
        if found is None or found.square >= fit.square or self.alike(fit, found):
            return None
        if len(found.effects) == len(fit.effects):
            return found
        # One effect more makes it easier to imitate a cause that the library does not have.
        return found if self.search.explained_by(found, fit, self.search.floor_rad) else None

    def _in_better_form(self, other: Fit, fit: Fit, effect: Effect) -> bool:
        """Whether ``other`` has ``effect`` in another form that no bench rules out, and fits better.

        An event within a half sweep held back leaves its time open: of equal fits, that with the lower held-out error.
        """
        last = other.effects[-1]
        if last.key != effect.key or effect.inside:
            return False
        better = other.square < (1.0 - SAME_FIT) * fit.square
        if effect.once:
            alike = self.alike(other, fit)
            better = self.search.enough(fit, other) if alike else better
        return better and not self.search.impossible(last, other.values[-1])

    @staticmethod
    def _by_name(fits: Sequence[Fit], effect: Effect) -> tuple[Fit, ...]:
        """The best fit of each name other than the effect's own."""
        best: dict[object, Fit] = {}
        for one in fits:
            key = one.effects[-1].key
            if key != effect.key and (key not in best or one.square < best[key].square):
                best[key] = one
        return tuple(best.values())

    def _coincidence(self, simpler: Fit, simple: Effect, fit: Fit, two: Effect) -> bool:
        """Whether ``two`` of ``fit`` looks like ``simple`` of ``simpler`` only because of its phase."""
        if len(two.parameters) <= len(simple.parameters):
            return False
        worse, better = (simpler, fit) if fit.square < simpler.square else (fit, simpler)
        wrong = self.apart(worse, better).probability
        odds = (1.0 - wrong) / max(wrong, 1e-300) if better is fit else wrong / (1.0 - wrong)
        return bool(self._phase_likelihood(fit, two) * odds < TOLD_APART)

    def _by_its_phase(self, simpler: Fit, fit: Fit, two: Effect) -> bool:
        """Whether ``two`` of ``fit``, a wave, may look better than the last effect of ``simpler`` only because of its
        phase."""
        wave = [p.role for p in two.parameters] == ["size", "size"] and not two.last
        if not wave or len(simpler.effects[-1].parameters) > 1 or self._failed(simpler, fit):
            return False
        return log_odds(self.fitter, simpler, fit) + log(self._phase_likelihood(fit, two)) < LOG_ODDS

    def _phase_likelihood(self, fit: Fit, wave: Effect) -> float:
        """How likely a phase as near to that of a simpler effect is, over the simpler effect itself.

        All phases of a wave are equally likely. A phase that agrees with the simpler effect within its standard
        deviation s is s / sqrt(2 pi) as likely as the simpler effect itself, times the odds of the two fits (Bayes
        factor).
        """
        sizes = np.array([parameter.size for parameter in wave.parameters[:2]])
        values, spread = fit.values_of(wave)[:2] / sizes, np.diag(self.spread(fit, wave, self.fitter))[:2] / sizes**2
        deviation = np.sqrt(spread.max()) / np.hypot(*values)
        return float(deviation / np.sqrt(2.0 * np.pi))

    def apart(self, worse: Fit, better: Fit) -> Separation:
        """How well two fits are separated."""
        return separation_of(self.fitter, worse, better)

    def alike(self, worse: Fit, better: Fit, against: float = 0.0) -> bool:
        """Whether the first is as good as the second, as far as sweeps and sectors can show.

        ``against``: logarithm of the odds against the first before the run was seen.
        """
        if self._failed(worse, better):
            return False
        used = self.fitter.used
        excess = (worse.residual**2 - better.residual**2)[used]
        if float(np.mean(excess)) < (ALIKE_SHARE * self.search.floor_rad) ** 2:
            return True
        sweep, sector = self.fitter.sweep[used], self.fitter.sector[used]
        cell = np.unique(sweep * (int(sector.max()) + 1) + sector, return_inverse=True)[1]
        sums = np.bincount(cell, excess)
        errors = float(sums.sum() / np.sqrt(np.sum(sums**2)))
        told = self.apart(worse, better)
        if told.apart and errors >= CLEAR_ERRORS:
            return False
        nearly = told.probability <= NEARLY_APART and errors >= LEAST_ERRORS
        return (not nearly and not against) or told.log_odds(float(sums.sum())) + against < LOG_ODDS

    def _failed(self, worse: Fit, better: Fit) -> bool:
        """Whether the first fit leaves far more than the second.

        A failed fit has very large errors in a few cells, and a test by the scatter of the cells would accept it.
        """
        used = self.fitter.used
        left = float(np.mean(better.residual[used] ** 2))
        excess = float(np.mean(worse.residual[used] ** 2)) - left
        return excess > max(self.search.floor_rad**2, left)

    def spread(self, fit: Fit, effect: Effect, fitter: Fitter) -> Floats:
        """Covariance of one effect's parameters, scaled so that 1.96 standard deviations make a 95 % interval.

        Clustered by sweep and sector, on all samples in use.
        """
        block = self.covariance(fit, fitter)[fit.columns_of(effect), fit.columns_of(effect)]
        # A parameter without influence on the prediction has no interval by linear theory; use its own size instead.
        return np.asarray(np.where(np.isfinite(block), block, np.max(np.abs(fit.values_of(effect))) ** 2))

    def covariance(self, fit: Fit, fitter: Fitter) -> Floats:
        """Covariance of all parameters and offsets of a fit, scaled as :meth:`spread`; columns as of the Jacobian."""
        if fit not in self._estimates:
            used = fitter.used
            kept = fit.has_slope
            columns = fitter.centred_on(used, fit.jacobian[:, kept])
            found = cluster_estimate(columns, fit.residual[used], fitter.sweep[used], fitter.sector[used])
            if not kept.all():
                value, covariance = np.zeros(kept.size), np.zeros((kept.size, kept.size))
                value[kept], covariance[np.ix_(kept, kept)] = found.value, found.covariance
                found = replace(found, value=value, covariance=covariance)
            self._estimates[fit] = found
        estimate = self._estimates[fit]
        return np.asarray((float(t_distribution.ppf(0.975, estimate.freedom)) / INTERVAL) ** 2 * estimate.covariance)


def other_pairs(search: Search, fit: Fit) -> list[Fit]:
    """Fits in which two other effects replace two of ``fit``, best first; none that no bench can have.

    Where more than the floor is left, they may also replace one.
    """
    begun = []
    for gone in [*combinations(fit.effects, 2), *([(one,) for one in fit.effects] if search.too_much(fit) else [])]:
        less = reduce(search.without, gone, fit)
        names = {effect.key for effect in gone}
        pairs = [pair for pair in search.screening.pairs(less) if {effect.key for effect in pair.effects} != names]
        begun += [
            partial(
                Fitter.fit,
                effects=(*less.effects, *pair.effects),
                values=(*map(fit.values_of, less.effects), *pair.starts),
                offsets=less.offsets,
                iterations=4,
                settled=1e-3,
                fresh=False,
            )
            for pair in pairs[:MOST_PAIRS]
        ]
    near = sorted(search.each(begun), key=lambda one: one.square)[:MOST_FINISHED]
    ended = search.each(
        [partial(Fitter.fit, effects=one.effects, values=one.values, offsets=one.offsets, settled=1e-5) for one in near]
    )
    possible = [one for one in ended if not any(map(search.impossible, one.effects, one.values))]
    return sorted(possible, key=lambda one: one.square)
