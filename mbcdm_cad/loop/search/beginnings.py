"""A search that begins with play at two inputs at once.

The search accepts one effect at a time. What two plays do depends on the motion before and does not repeat, so either
alone explains too little, or makes room for an effect that is not present.
"""

from __future__ import annotations

from functools import partial
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.evidence import supported
from mbcdm_cad.loop.search.fit import Fit, Fitter

if TYPE_CHECKING:
    from mbcdm_cad.loop.search.select import Search

# Widths from which two plays are fitted together, over the width of one play that would cause the whole residual.
WIDTHS = (0.15, 0.4)
# Of fits whose mean squares differ by less than this share, the one with the smallest plays is taken: where a pulley
# does not reach the far face of its play, any larger play fits as well.
AS_GOOD = 0.01


def with_both_plays(search: Search, now: Fit) -> Fit:
    """``now``, or play at two inputs at once if that leaves clearly less, or as little with fewer effects."""
    found = _both_plays(search)
    if found is None or any(map(search.impossible, found.effects, found.values)):
        return now
    for effect in found.effects:
        less = search.without(found, effect)
        if not (search.enough(less, found) or search.enough_beside(less, found)):
            return now
        if not supported(search.fitter, less, found.with_last(effect), len(search.library)):
            return now
    fewer = len(found.effects) < len(now.effects) and not search.enough(found, now)
    if not (fewer or search.enough(now, found) or search.enough_beside(now, found)):
        return now
    search.note("play at both inputs at once", found.effects[-1], now, found)
    return search.taken(found)


def _both_plays(search: Search) -> Fit | None:
    """The best fit with play at two inputs; None if there are no two inputs, or none can be simulated."""
    plays = [effect for effect in search.library if effect.saturates]
    begun = [
        partial(_begun, pair, widths, search.bare)
        for pair in combinations(plays, 2)
        for widths in product(WIDTHS, WIDTHS)
    ]
    fits = search.each(begun)
    least = min((one.square for one in fits), default=0.0)
    near = [one for one in fits if one.square <= (1.0 + AS_GOOD) * least]
    if not near:
        return None
    best = min(near, key=lambda one: sum(float(values[0]) for values in one.values))
    return search.fitter.tried(best.effects, best.values, best.offsets)


def _begun(pair: tuple[Effect, Effect], widths: tuple[float, float], bare: Fit, fitter: Fitter) -> Fit:
    residual = bare.residual[fitter.parts[0]]
    starts = [
        share * np.array(effect.first_guesses(fitter.base[0], residual)[-1])
        for effect, share in zip(pair, widths, strict=True)
    ]
    return fitter.fit(pair, starts, bare.offsets, settled=1e-4)
