"""Candidates: ranked by the fall of the sum of squares by one linear step from each start, the best refitted.

An effect is fitted beside others as one more, in the place of another, and each fit is made without it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, product
from queue import Queue
from typing import TypeVar

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.fit import DIFFERENCE, Fit, Fitter
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

MOST_THREADS = 4
Found = TypeVar("Found")


class Twins:
    """Twins of a fitter, one a thread."""

    def __init__(self, fitter: Fitter) -> None:
        self._twins = [fitter.twin() for _ in range(min(MOST_THREADS, os.cpu_count() or 1))]

    def each(self, tasks: Sequence[Callable[[Fitter], Found]]) -> list[Found]:
        """What the tasks return, in their order: the simulation runs outside the interpreter's lock.

        A candidate that cannot be simulated at its start (a slack cable, a negative radius) is left out.
        """
        twins = Queue[Fitter]()
        for twin in self._twins:
            twins.put(twin)

        def one(task: Callable[[Fitter], Found]) -> Found | None:
            twin = twins.get()
            try:
                return task(twin)
            except ModelError:
                return None
            finally:
                twins.put(twin)

        with ThreadPoolExecutor(len(self._twins)) as pool:
            return [found for found in pool.map(one, tasks) if found is not None]


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate, its start, the fall of the training mean square predicted by a linear step, its columns."""

    effect: Effect
    start: Floats
    fall: float
    columns: Floats


@dataclass(frozen=True, eq=False)
class ScreenedPair:
    """Two candidates, their starts, and the training mean square predicted by a linear step of both."""

    effects: tuple[Effect, Effect]
    starts: tuple[Floats, Floats]
    square: float


class Screening:
    """Ranks the candidates of ``library`` as additions to a fit."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect]) -> None:
        self.fitter, self.library = fitter, tuple(library)
        self.twins = Twins(fitter)
        self._screened: tuple[Fit, list[Screened]] | None = None
        self._columns: dict[tuple[Effect, bytes], tuple[Floats, Floats]] = {}

    def screen(self, fit: Fit) -> list[Screened]:
        """All candidates that ``fit`` does not contain, largest predicted fall first."""
        if self._screened is not None and self._screened[0] is fit:
            return self._screened[1]
        f = self.fitter
        taken = {e.key for e in fit.effects}
        basis = self._basis(fit)
        promises = []
        for effect in self.library:
            if effect.key in taken and not effect.several:
                continue
            for start in f.guesses(effect, fit.residual):
                # An effect that may occur several times is screened as one effect for each start.
                one = replace(effect) if effect.several else effect
                promises.append(partial(self._promise, fit, one, np.array(start), basis))
        found = self._best_starts(sorted(self.twins.each(promises), key=lambda s: -s.fall))
        self._screened = fit, found
        return found

    def best_known_fall(self, fit: Fit) -> float:
        """The largest fall that a linear step predicts for any addition to ``fit``, without a simulation of the cables.

        Effects that strain the cables use the slopes that were computed for an earlier fit.
        """
        f = self.fitter
        taken = {e.key for e in fit.effects}
        basis = self._basis(fit)
        known: dict[Effect, list[bytes]] = {}
        for effect, start in self._columns:
            known.setdefault(effect, []).append(start)
        falls = [0.0]
        for effect in self.library:
            if effect.key in taken and not effect.several:
                continue
            if f.kind(effect) < 2:
                starts = [np.frombuffer(start) for start in known.get(effect, [])]
            else:
                starts = [np.array(s) for s in f.guesses(effect, fit.residual)]
            for at in starts:
                try:
                    change, columns = self._slopes(fit, effect, at, f)
                except ModelError:
                    continue
                falls.append(fit.square - self._projected(fit, change, columns, basis)[0])
        return max(falls)

    def pairs(self, fit: Fit) -> list[ScreenedPair]:
        """All pairs of causes that ``fit`` does not contain, each pair of names once, least predicted square first.

        Effects that may occur several times, or happened once, are left out: their starts hold only beside the effects
        with which they were found.
        """
        f, mask = self.fitter, self.fitter.train
        taken = {e.key for e in fit.effects}
        offered: list[tuple[Effect, Floats, slice]] = []
        vectors = [f.centred_on(mask, fit.residual)[:, None]]
        wide = 1
        for effect in self.library:
            if effect.key in taken or effect.several or effect.once or effect.last:
                continue
            for guess in f.guesses(effect, fit.residual):
                start = np.array(guess)
                try:
                    change, columns = self._slopes(fit, effect, start, f)
                except ModelError:
                    continue
                vectors.append(f.centred_on(mask, np.column_stack([change, columns])))
                offered.append((effect, start, slice(wide, wide + 1 + columns.shape[1])))
                wide = offered[-1][2].stop
        table, basis = np.hstack(vectors), self._basis(fit)
        table -= basis @ (basis.T @ table)
        gram = table.T @ table / table.shape[0]
        best: dict[frozenset[object], ScreenedPair] = {}
        for (one, start, own), (other, others_start, others) in combinations(offered, 2):
            if one.key == other.key:
                continue
            square, step = _jointly(gram, own, others)
            names = frozenset((one.key, other.key))
            if names not in best or square < best[names].square:
                mine, rest = np.split(step, [start.size])
                starts = _begun(one, start, mine), _begun(other, others_start, rest)
                best[names] = ScreenedPair((one, other), starts, square)
        return sorted(best.values(), key=lambda pair: pair.square)

    def _basis(self, fit: Fit) -> Floats:
        """Orthonormal basis of the changes that the parameters of ``fit`` make, on the training samples."""
        mask = self.fitter.train
        known = self.fitter.centred_on(mask, fit.jacobian)
        return np.asarray(np.linalg.qr(known)[0]) if known.shape[1] else np.zeros((int(mask.sum()), 0))

    @staticmethod
    def _best_starts(found: Sequence[Screened]) -> list[Screened]:
        """The start with the largest predicted fall, of several starts of one effect that differ in its sizes."""
        kept: list[Screened] = []
        for one in found:
            places = any(p.role != "size" for p in one.effect.parameters)
            if places or all(one.effect is not other.effect for other in kept):
                kept.append(one)
        return kept

    def _slopes(self, fit: Fit, effect: Effect, start: Floats, f: Fitter) -> tuple[Floats, Floats]:
        """The change of the prediction by an effect at ``start``, (n,), and its derivatives there, (n, k), added to
        ``fit``.

        For effects that strain the cables this is computed only once: their rank hardly depends on the other effects of
        the fit.
        """
        key = effect, start.tobytes()
        if key in self._columns:
            return self._columns[key]
        effects = (*fit.effects, effect)
        before = f.predict(fit.effects, fit.values, fit.offsets)
        at_start = f.predict(effects, (*fit.values, start), fit.offsets) if start.any() else before
        columns = []
        for i, parameter in enumerate(effect.parameters):
            trial = start.copy()
            trial[i] += DIFFERENCE * parameter.size
            moved = f.predict(effects, (*fit.values, trial), fit.offsets)
            columns.append((moved - at_start) / (DIFFERENCE * parameter.size))
        found = at_start - before, np.stack(columns, axis=1)
        # Without cables an error of the load shows only beside an effect of the load.
        if f.kind(effect) < 2 and f.d is not None:
            self._columns[key] = found
        return found

    def _promise(self, fit: Fit, effect: Effect, start: Floats, basis: Floats, fitter: Fitter) -> Screened:
        change, columns = self._slopes(fit, effect, start, fitter)
        square, step = self._projected(fit, change, columns, basis)
        return Screened(effect, _begun(effect, start, step), fit.square - square, columns)

    def _projected(self, fit: Fit, change: Floats, columns: Floats, basis: Floats) -> tuple[float, Floats]:
        """Mean square after a linear step from ``change`` along ``columns`` added to a fit, and the step."""
        f, mask = self.fitter, self.fitter.train
        new = f.centred_on(mask, columns)
        r = f.centred_on(mask, fit.residual - change)
        new = new - basis @ (basis.T @ new)
        r = r - basis @ (basis.T @ r)
        size = np.linalg.norm(new, axis=0)
        new = new[:, size > 0.0] / size[size > 0.0]
        step = np.zeros(size.size)
        if new.shape[1]:
            solved = np.linalg.lstsq(new, r, rcond=1e-8)[0]
            r = r - new @ solved
            step[size > 0.0] = solved / size[size > 0.0]
        return float(np.mean(r**2)), step


def _jointly(gram: Floats, one: slice, other: slice) -> tuple[float, Floats]:
    """Mean square after a linear step of two candidates, and the step.

    ``gram``: mean products of the residual (first), and of each candidate's change at its start and slopes (its slice).
    """
    known = np.zeros(gram.shape[0])
    known[[0, one.start, other.start]] = 1.0, -1.0, -1.0
    free = [*range(one.start + 1, one.stop), *range(other.start + 1, other.stop)]
    normal, slope = gram[np.ix_(free, free)], gram[free] @ known
    size = np.sqrt(np.diag(normal))
    size[size == 0.0] = 1.0
    step = np.linalg.lstsq(normal / np.outer(size, size), slope / size, rcond=1e-8)[0] / size
    return float(known @ gram @ known - slope @ step), step


def _begun(effect: Effect, start: Floats, step: Floats) -> Floats:
    """Values from which a refit begins, after a linear step from ``start``."""
    low = [p.low for p in effect.parameters]
    high = [p.high for p in effect.parameters]
    # Orders and times are only refined by the fit; a linear step would move them out of their minimum.
    held = np.array([p.low > -np.inf and start[i] != 0.0 for i, p in enumerate(effect.parameters)])
    return np.asarray(np.clip(np.where(held, start, start + step), low, high))


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

    def begun(pair: tuple[Effect, Effect], widths: tuple[float, float], fitter: Fitter) -> Fit:
        starts = [share * np.array(fitter.guesses(e, bare.residual)[-1]) for e, share in zip(pair, widths, strict=True)]
        return fitter.fit(pair, starts, bare.offsets, settled=1e-4)

    fits = trials.each(
        [partial(begun, pair, widths) for pair in combinations(plays, 2) for widths in product(WIDTHS, WIDTHS)]
    )
    least = min((one.square for one in fits), default=0.0)
    near = [one for one in fits if one.square <= (1.0 + AS_GOOD) * least]
    if not near:
        return None
    best = min(near, key=lambda one: sum(float(values[0]) for values in one.values))
    return trials.fitter.tried(best.effects, best.values, best.offsets)


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


def few_steps(effects: Sequence[Effect], values: Sequence[Floats | list[float]], offsets: Floats) -> Callable[..., Fit]:
    """A few steps of a fit by a fitter, good enough to rank candidates."""
    return partial(Fitter.fit, effects=effects, values=values, offsets=offsets, iterations=4, settled=1e-3, fresh=False)


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

        def begun_from(c: Screened, fitter: Fitter) -> Fit:
            """A few steps with the slopes of the screening, or with new ones if those lead to nothing."""
            begin = few_steps((*fit.effects, c.effect), (*fit.values, c.start), fit.offsets)
            found = begin(fitter, slopes=np.hstack([fit.jacobian[:, :own], c.columns, fit.jacobian[:, own:]]))
            # The step to the start may be so long that the slopes of the screening point the wrong way there.
            lost = fit.square - found.square < LOST_SHARE * c.fall and c.fall > LOST_SHARE * greatest
            return min(found, begin(fitter), key=lambda one: one.square) if lost else found

        begun = self.each([partial(begun_from, c) for c in chosen])
        # Fits that are far behind after a few steps cannot win; only the others are continued.
        least = min(one.square for one in begun) if begun else 0.0
        near = [one for one in begun if fit.square - one.square >= share * (fit.square - least)]
        near = [one for one in near if _may_do_more(one.effects[-1]) or fit.square - one.square >= share * needed]
        return sorted(self.finished(near), key=lambda one: one.square)

    def finished(self, fits: Iterable[Fit]) -> list[Fit]:
        """``fits``, each continued until it has settled."""
        return self.each(
            [partial(Fitter.fit, effects=o.effects, values=o.values, offsets=o.offsets, settled=1e-5) for o in fits]
        )

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
