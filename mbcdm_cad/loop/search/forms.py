"""Forms of an effect that is a sum of terms: terms are added while the data pay for them.

A form with more terms never fits worse, so each term has to lower the error of the half sweeps held back, to be told
from zero by sweeps and sectors, and to have odds beyond a penalty for its parameters: that of the information criterion
of Schwarz, with cells of sweep and sector as the number of independent data.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product
from math import log

import numpy as np
from scipy.stats import t as t_distribution

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.evidence import LOG_ODDS, SAME_FIT, TOLD_APART, cluster_estimate, log_odds
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.select import Search
from mbcdm_cad.routes import Floats

# Least fall of the held-out RMS by a term, in quadrature, over the floor: less than for an effect, since a term that is
# left out is found in the figures of the others.
LEAST_TERM = 0.2
# Terms that one step may add or take in exchange: those of a form that differs in more are reached over others.
MOST_NEW, MOST_GONE = 2, 1


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
            begun.append(
                partial(
                    Fitter.fit,
                    effects=(*kept, form),
                    values=(*map(fit.values_of, kept), own),
                    offsets=fit.offsets,
                    iterations=4,
                    settled=1e-3,
                    fresh=False,
                )
            )
    best: dict[tuple[int, int], Fit] = {}
    for one in sorted(search.each(begun), key=lambda one: one.square):
        best.setdefault(_width(one), one)
    ended = [
        partial(Fitter.fit, effects=o.effects, values=o.values, offsets=o.offsets, settled=1e-5) for o in best.values()
    ]
    return sorted(search.each(ended), key=_width)


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
    used, kept = fitter.used, fit.has_slope
    columns = fitter.centred_on(used, fit.jacobian[:, kept])
    found = cluster_estimate(columns, fit.residual[used], fitter.sweep[used], fitter.sector[used])
    own = np.arange(kept.size)[fit.columns_of(effect)]
    sizes = [k for k, p in zip(own, effect.parameters, strict=True) if p.role == "size"]
    at = np.searchsorted(np.flatnonzero(kept), sizes)
    strength = np.concatenate(fit.values)[sizes] / np.sqrt(np.diag(found.covariance)[at])
    return np.asarray(2.0 * t_distribution.sf(np.abs(strength), found.freedom))
