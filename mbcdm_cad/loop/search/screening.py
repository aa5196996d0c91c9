"""Candidates for an addition to a fit, each with the fall of the sum of squares by one linear step from its start."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
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
    """A candidate and the fall of the training mean square predicted by a linear step from ``guess``, up to which the
    prediction changes by ``change``, rad, with the slopes ``columns`` there; a refit begins at ``start``."""

    effect: Effect
    start: Floats
    fall: float
    columns: Floats
    change: Floats
    guess: Floats


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
        before = float(np.mean(fit.residual[fitter.train] ** 2))
        return Screened(effect, _begun(effect, start, step), before - square, columns, change, start)

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
