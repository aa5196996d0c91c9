"""Exchange two effects of a fit at once.

The search accepts one effect at a time, and the first may be a wrong one that resembles the sum of two: the runout of
an input pulley resembles that of a guide beside a wrong ratio. No exchange of a single effect leads from there to the
two that are present.
"""

from __future__ import annotations

from functools import partial, reduce
from itertools import combinations

from mbcdm_cad.identification.fit import Fit, Fitter
from mbcdm_cad.identification.select import Search

# Pairs of which a few steps of a refit are made in place of each two effects, and refits that are finished. What a
# linear step promises ranks the pairs only roughly: a pulley that strains cables with friction is far from linear.
MOST_PAIRS, MOST_FINISHED = 6, 2


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
