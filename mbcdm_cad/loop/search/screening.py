"""Candidates for an addition to a fit: what each changes there."""

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
    """A candidate at ``guess``: the prediction changes by ``change`` up to it, rad, with the slopes ``columns``."""

    effect: Effect
    columns: Floats
    change: Floats
    guess: Floats


class Screening:
    """The candidates of ``library`` as additions to a fit."""

    def __init__(self, fitter: Fitter, library: Sequence[Effect]) -> None:
        self.fitter, self.library = fitter, tuple(library)
        self.twins = Twins(fitter)
        self._screened: tuple[Fit, list[Screened]] | None = None
        self._columns: dict[tuple[Effect, bytes], tuple[Floats, Floats]] = {}

    def screen(self, fit: Fit) -> list[Screened]:
        """All candidates that ``fit`` does not contain, at each of their starts."""
        if self._screened is not None and self._screened[0] is fit:
            return self._screened[1]
        taken = {e.key for e in fit.effects}
        tasks = []
        for effect in self.library:
            if effect.key in taken and not effect.several:
                continue
            for start in self.fitter.guesses(effect, fit.residual):
                # An effect that may occur several times is screened as one effect for each start.
                one = replace(effect) if effect.several else effect
                tasks.append(partial(self._one, fit, one, np.array(start)))
        found = [one for one in self.twins.each(tasks) if np.isfinite(one.columns).all()]
        self._screened = fit, found
        return found

    def _one(self, fit: Fit, effect: Effect, start: Floats, fitter: Fitter) -> Screened:
        change, columns = self._slopes(fit, effect, start, fitter)
        return Screened(effect, columns, change, start)

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
