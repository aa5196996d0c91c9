"""Fits of effects beside others: with one candidate more, without one effect, with another in its place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations, product

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.screening import Screened, Screening


def located(fitter: Fitter, fit: Fit) -> Fit | None:
    """A fit of the same effects that starts with each event where the residual without it shows it best.

    A fit moves the time of an event only a little, because the prediction hardly depends on a time that is far from it.
    ``fitter`` may hold other samples than those of ``fit``. None if the effects cannot be simulated there.
    """
    values = list(fit.values)
    for k, effect in enumerate(fit.effects):
        if not effect.once:
            continue
        rest = [j for j in range(len(values)) if j != k]
        less = fitter.fit([fit.effects[j] for j in rest], [values[j] for j in rest], fit.offsets, fresh=False)
        guess = np.array(fitter.guesses(effect, less.residual)[0])
        values[k] = np.where(guess != 0.0, guess, values[k])
    return fitter.tried(fit.effects, values, fit.offsets)


# Widths from which two plays are fitted together, over the width of one play that would cause the whole residual.
WIDTHS = (0.15, 0.4)
# Of fits whose mean squares differ by less than this share, the one with the smallest plays is taken: where a pulley
# does not reach the far face of its play, any larger play fits as well.
AS_GOOD = 0.01


def both_plays(trials: TrialFits, library: Sequence[Effect], bare: Fit) -> Fit | None:
    """The best fit with play at two inputs at once; None if there are no two inputs, or none can be simulated.

    The search accepts one effect at a time. What two plays do depends on the motion before and does not repeat, so
    either alone explains too little, or makes room for an effect that is not present.
    """
    plays = [effect for effect in library if effect.saturates]
    begun = [
        partial(_begun, pair, widths, bare) for pair in combinations(plays, 2) for widths in product(WIDTHS, WIDTHS)
    ]
    fits = trials.each(begun)
    least = min((one.square for one in fits), default=0.0)
    near = [one for one in fits if one.square <= (1.0 + AS_GOOD) * least]
    if not near:
        return None
    best = min(near, key=lambda one: sum(float(values[0]) for values in one.values))
    return trials.fitter.tried(best.effects, best.values, best.offsets)


def _begun(pair: tuple[Effect, Effect], widths: tuple[float, float], bare: Fit, fitter: Fitter) -> Fit:
    starts = [
        share * np.array(fitter.guesses(effect, bare.residual)[-1]) for effect, share in zip(pair, widths, strict=True)
    ]
    return fitter.fit(pair, starts, bare.offsets, settled=1e-4)


# What sets the slip of the cables.
CABLES_SLIP = ("preload_error", "cable_friction", "passed_slip")
# Candidates whose screened fall of the sum of squares is this share of the best's are refitted, up to a number.
CLOSE_SHARE = 0.3
MOST_REFITS = 7
# Candidates are not refitted if their predicted fall is less than this share of the fall that is needed (calibrated
# on benches).
HOPEFUL_SHARE = 0.25
# A refit that reaches less than this share of its predicted fall is begun again, if that is near the greatest one.
LOST_SHARE = 0.5
# Alternatives to an effect, the best first, that are fitted again beside a line or an event, or if a shared effect has
# moved by more than this share of its size.
MOST_AGAIN, MOVED_SHARE = 4, 0.1


class TrialFits:
    """Fits of a library of effects to one set of runs; each fit without an effect is computed once."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect]) -> None:
        """``library``: the candidates."""
        self.fitter = fitter
        self.screening = Screening(fitter, library)
        self._without: dict[tuple[Fit, Effect], Fit] = {}

    def close(self, fit: Fit, share: float = CLOSE_SHARE, name: str | None = None, first: int = 0) -> list[Screened]:
        """Candidates that are worth a refit, largest predicted fall first.

        Candidates of ``name`` (other stages, other cables; by default the name of the first candidate) are included
        however small their predicted fall. ``first``: rank from which on the others are considered.
        """
        screened = self.screening.screen(fit)
        name = name or screened[first].effect.name
        least = 0.0 if first else share * screened[0].fall
        chosen = [c for c in screened[first : first + MOST_REFITS] if c.fall >= least]
        names = {name, *(other for c in chosen[:1] for other in c.effect.after)}
        return chosen + [c for c in screened if c.effect.name in names and c not in chosen]

    def refits(
        self, fit: Fit, chosen: Sequence[Screened], share: float = CLOSE_SHARE, needed: float = -np.inf
    ) -> list[Fit]:
        """``fit`` with one effect more, for each of ``chosen``; best training mean square first.

        ``needed``: the fall of the mean square below which a candidate is of no use, shapes of the rest apart.
        """
        chosen = [c for c in chosen if _may_do_more(c.effect) or c.fall >= HOPEFUL_SHARE * needed]
        own = fit.width
        greatest = self.screening.screen(fit)[0].fall if chosen else 0.0

        def few_steps(c: Screened, fitter: Fitter) -> Fit:
            """A few steps with the slopes of the screening, or with new ones if those lead to nothing."""
            begin = partial(
                fitter.fit,
                effects=(*fit.effects, c.effect),
                values=(*fit.values, c.start),
                offsets=fit.offsets,
                iterations=4,
                settled=1e-3,
                fresh=False,
            )
            found = begin(slopes=np.hstack([fit.jacobian[:, :own], c.columns, fit.jacobian[:, own:]]))
            # The step to the start may be so long that the slopes of the screening point the wrong way there.
            lost = fit.square - found.square < LOST_SHARE * c.fall and c.fall > LOST_SHARE * greatest
            return min(found, begin(), key=lambda one: one.square) if lost else found

        begun = self.each([partial(few_steps, c) for c in chosen])
        # Fits that are far behind after a few steps cannot win; only the others are continued.
        least = min(one.square for one in begun) if begun else 0.0
        near = [one for one in begun if fit.square - one.square >= share * (fit.square - least)]
        near = [one for one in near if _may_do_more(one.effects[-1]) or fit.square - one.square >= share * needed]
        ended = self.each(
            [
                partial(Fitter.fit, effects=one.effects, values=one.values, offsets=one.offsets, settled=1e-5)
                for one in near
            ]
        )
        return sorted(ended, key=lambda one: one.square)

    def each(self, fits: Sequence[Callable[[Fitter], Fit]]) -> list[Fit]:
        """Run fits in parallel threads; one that cannot be simulated at its start is left out."""
        return self.screening.twins.each(fits)

    def without(self, fit: Fit, effect: Effect) -> Fit:
        """Refit with one effect left out."""
        key = fit, effect
        if key not in self._without:
            rest = [e for e in fit.effects if e is not effect]
            slopes = np.delete(fit.jacobian, fit.columns_of(effect), axis=1)
            self._without[key] = self.fitter.fit(
                rest, [fit.values_of(e) for e in rest], fit.offsets, slopes=slopes, fresh=False
            )
        return self._without[key]

    def alternatives(self, fit: Fit, effect: Effect) -> list[Fit]:
        """Fits in which another effect, or another form of it, replaces ``effect``, best first."""
        less = self.without(fit, effect)
        found = self.refits(less, self.close(less, 0.5, effect.name), 0.5)
        others = [one for one in found if one.effects[-1] is not effect]
        placed = any(one.once or one.order_index is not None for one in less.effects)
        again = [one for one in others[:MOST_AGAIN] if placed or _moved(fit, one)]
        begun = self.each([partial(self._begun_at, fit, one) for one in again])
        return sorted([*begun, *(one for one in others if one not in again)], key=lambda one: one.square)

    @staticmethod
    def _begun_at(fit: Fit, one: Fit, fitter: Fitter) -> Fit:
        """The best of ``one``, a fit begun where the shared effects are in ``fit``, and one with their times searched.

        Without the effect that is replaced, an order, a time, or the friction of the cables may move so far that no fit
        finds the way back.
        """
        shared = [fit.values_of(effect) for effect in one.effects[:-1]]
        begun = fitter.tried(one.effects, (*shared, one.values[-1]), one.offsets)
        best = min(filter(None, (one, begun)), key=lambda each: each.square)
        if not any(effect.once for effect in one.effects):
            return best
        return min(filter(None, (best, located(fitter, best))), key=lambda each: each.square)


def _may_do_more(effect: Effect) -> bool:
    """Whether a fit may explain far more than a linear step of it promises, or the effect is a shape of the rest."""
    return effect.last or effect.saturates or effect.order_index is not None or effect.name in CABLES_SLIP


def _moved(fit: Fit, one: Fit) -> bool:
    """Whether an effect that ``one`` shares with ``fit`` is far from where it is there."""
    return not all(
        np.allclose(one.values_of(effect), fit.values_of(effect), rtol=MOVED_SHARE) for effect in one.effects[:-1]
    )
