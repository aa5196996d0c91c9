"""Compare each effect of the search's fit with others of a similar signature, and exchange those that fit better.

Effects that the data cannot separate form a group. One effect is exchanged at a time, then two at once: the search
accepts one effect at a time, and the first may be a wrong one that resembles the sum of two. The runout of an input
pulley resembles that of a guide beside a wrong ratio, and no exchange of a single effect leads from there to the two
that are present.

Of an effect that is a sum of terms, terms are added while the data pay for them. A form with more terms never fits
worse, so each term has to lower the error of the half sweeps held back, to be told from zero by sweeps and sectors, and
to have odds beyond a penalty for its parameters: that of the information criterion of Schwarz, with cells of sweep and
sector as the number of independent data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial, reduce
from itertools import combinations, product
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
    estimate_of,
    log_odds,
    separation_of,
)
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.screening import few_steps
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
# Least fall of the held-out RMS by a term, in quadrature, over the floor: less than for an effect, since a term that is
# left out is found in the figures of the others.
LEAST_TERM = 0.2
# Terms that one step may add or take in exchange: those of a form that differs in more are reached over others.
MOST_NEW, MOST_GONE = 2, 1


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
        wrong = separation_of(self.fitter, worse, better).probability
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
        told = separation_of(self.fitter, worse, better)
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
            self._estimates[fit] = estimate_of(fitter, fit)
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
            few_steps((*less.effects, *pair.effects), (*map(fit.values_of, less.effects), *pair.starts), less.offsets)
            for pair in pairs[:MOST_PAIRS]
        ]
    near = sorted(search.each(begun), key=lambda one: one.square)[:MOST_FINISHED]
    possible = [one for one in search.finished(near) if not any(map(search.impossible, one.effects, one.values))]
    return sorted(possible, key=lambda one: one.square)


def in_best_form(search: Search, fit: Fit) -> Fit:
    """``fit`` with its sums of terms in the forms for which the data pay; effects that are then not needed are gone."""
    for effect in [effect for effect in fit.effects if effect.richer]:
        fit = _walked(search, fit, effect)
    return fit


def _walked(search: Search, fit: Fit, now: Effect) -> Fit:
    """``fit`` with ``now``, one of its effects, in its best form."""
    forms = now.richer() if now.richer else []
    while now in fit.effects:
        paying = [one for one in _tried(search, fit, now, forms) if pays(search, fit, one)]
        if not paying:
            break
        better = paying[0]
        for one in paying[1:]:
            if pays(search, better, one):
                better = one
        search.note("with other terms", better.effects[-1], fit, better)
        now, fit = better.effects[-1], search.needed(better)
    return _apart(search, fit, now, forms) if now in fit.effects else fit


def _apart(search: Search, fit: Fit, now: Effect, forms: Sequence[Effect]) -> Fit:
    """``fit``, or the same with one term of ``now`` as an effect of its own, where another form of that is as good.

    A drag is told from a late sensor only beside the rest of the friction.
    """
    names = {p.name for p in now.parameters}
    single = [e for e in search.library if len(e.parameters) == 1 and e.base is None]
    for term in (e for e in single if e.name != now.name):
        least = next((e for e in forms if {p.name for p in e.parameters} == names - {term.parameters[0].name}), None)
        if term.parameters[0].name not in names or least is None:
            continue
        known = dict(zip([p.name for p in now.parameters], fit.values_of(now), strict=True))
        rest = [e for e in fit.effects if e is not now]
        own: list[Floats | list[float]] = [*map(fit.values_of, rest), [known[p.name] for p in least.parameters]]
        alike = [e for e in single if e.key == term.key and e is not term]
        begun = [
            partial(Fitter.fit, effects=(*rest, least, e), values=(*own, [0.0]), offsets=fit.offsets) for e in alike
        ]
        if any(log_odds(search.fitter, one, fit) < LOG_ODDS for one in search.each(begun)):
            return search.fitter.fit((*rest, least, term), (*own, [known[term.parameters[0].name]]), fit.offsets)
    return fit


def _tried(search: Search, fit: Fit, now: Effect, forms: Sequence[Effect]) -> list[Fit]:
    """Fits with a form of a few terms more in place of ``now``, and of another effect too that such a term resembles.

    The best of each number of parameters and effects, fewest first.
    """
    known = dict(zip([p.name for p in now.parameters], fit.values_of(now), strict=True))
    rest = [e for e in fit.effects if e is not now]
    begun = []
    for form, gone in product(forms, [None, *(e for e in rest if e.generic)]):
        names = {p.name for p in form.parameters}
        new, less = len(names - {*known}), len({*known} - names)
        if not (0 < new <= MOST_NEW and less <= MOST_GONE and len(names) >= len(known)):
            continue
        kept = [e for e in rest if e is not gone]
        for start in search.fitter.guesses(form, fit.residual):
            own = [known.get(p.name, v) for p, v in zip(form.parameters, start, strict=True)]
            begun.append(few_steps((*kept, form), (*map(fit.values_of, kept), own), fit.offsets))
    best: dict[tuple[int, int], Fit] = {}
    for one in sorted(search.each(begun), key=lambda one: one.square):
        best.setdefault(_width(one), one)
    return sorted(search.finished(best.values()), key=_width)


def _width(fit: Fit) -> tuple[int, int]:
    """Numbers of its parameters and effects."""
    return fit.width, len(fit.effects)


def pays(search: Search, fit: Fit, other: Fit) -> bool:
    """Whether the data pay for ``other``, a fit with another form of an effect as its last one, in place of ``fit``.

    One that needs no more parameters and fewer effects has only to fit better.
    """
    form, values, f = other.effects[-1], other.values[-1], search.fitter
    if search.impossible(form, values):
        return False
    (wide, many), (before, least) = _width(other), _width(fit)
    if wide <= before and many < least:
        return other.square < (1.0 + SAME_FIT) * fit.square and _sure(search, other)
    if search.held_rms(fit) ** 2 - search.held_rms(other) ** 2 < (LEAST_TERM * search.floor_rad) ** 2:
        return False
    cells = np.unique(f.sweep[f.used] * (int(f.sector.max()) + 1) + f.sector[f.used]).size
    if log_odds(f, fit, other) < LOG_ODDS + 0.5 * max(0, wide - before) * log(cells):
        return False
    return _sure(search, other)


def _sure(search: Search, fit: Fit) -> bool:
    """Whether each size of its last effect is told from zero."""
    return all(chance < TOLD_APART for chance in chances(search.fitter, fit, fit.effects[-1]))


def chances(fitter: Fitter, fit: Fit, effect: Effect) -> Floats:
    """Probability of each size of an effect if that size alone is zero."""
    found, first = estimate_of(fitter, fit), fit.columns_of(effect).start
    sizes = [first + k for k, p in enumerate(effect.parameters) if p.role == "size"]
    strength = np.concatenate(fit.values)[sizes] / np.sqrt(np.diag(found.covariance)[sizes])
    return np.asarray(2.0 * t_distribution.sf(np.abs(strength), found.freedom))
