"""The selection of causes from few readings: tables by hand, and frequency responses with averages as readings.

A cause joins if the readings held back and the others support it; once no other does, those go that later ones have
made needless. What fits all readings nearly as well in the place of one is not told from it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from mbcdm_cad.loop.result import Evidence
from mbcdm_cad.loop.search.evidence import LOG_ODDS
from mbcdm_cad.loop.search.select import LEAST_FALL

# Candidates that are listed as too small, best first.
LISTED = 5


class SomeFit(Protocol):
    """A fit of causes; ``square``: what it leaves of the readings that are not held back."""

    @property
    def effects(self) -> tuple[Any, ...]: ...
    @property
    def square(self) -> float: ...


AnyFit = TypeVar("AnyFit", bound=SomeFit)


class Selection(ABC, Generic[AnyFit]):
    """The selection of causes; a problem says how they are fitted, and what its readings tell by chance."""

    # Causes of a fit; candidates of a round that are tested, best first; those beside which each other one is tried,
    # where none is supported alone.
    most_effects, most_tested, most_paired = 3, 4, 3
    floor_rad: float

    @abstractmethod
    def offered(self, fit: AnyFit) -> Sequence[Any]:
        """Causes that may join a fit."""

    @abstractmethod
    def best(self, fit: AnyFit, cause: Any, whole: bool = False) -> AnyFit | None:
        """The best fit with one cause more; None if there is none. ``whole``: of all readings, else of those that are
        not held back."""

    @abstractmethod
    def without(self, fit: AnyFit, cause: Any, whole: bool = False) -> AnyFit:
        """The fit without one of its causes."""

    def criterion(self, fit: AnyFit) -> float:
        """What ranks fits: the smaller, the better."""
        return fit.square

    @abstractmethod
    def held_rms(self, fit: AnyFit) -> float:
        """RMS error of the readings held back, rad; 0 where none are."""

    @abstractmethod
    def beyond_chance(self, less: AnyFit, more: AnyFit, cause: Any) -> bool:
        """Whether the readings that are not held back support a cause that ``more`` has beside ``less``."""

    @abstractmethod
    def log_odds(self, worse: AnyFit, better: AnyFit) -> float:
        """Logarithm of the odds of one fit of all readings against another, by Bayes' criterion."""

    def fall(self, less: AnyFit, more: AnyFit) -> float:
        """How much the error of the readings held back falls, rad in quadrature."""
        return float(np.sqrt(max(0.0, self.held_rms(less) ** 2 - self.held_rms(more) ** 2)))

    def supported(self, less: AnyFit, more: AnyFit, cause: Any) -> bool:
        """Whether both the readings held back and the others support a cause that ``more`` has beside ``less``."""
        return self.fall(less, more) >= LEAST_FALL * self.floor_rad and self.beyond_chance(less, more, cause)

    def selected(self, now: AnyFit) -> tuple[AnyFit, list[Evidence], list[Evidence]]:
        """The fit with the causes that the readings support; what was accepted, and what was too small."""
        steps, small = list[Evidence](), list[Evidence]()

        def evidence(trial: AnyFit, words: str) -> Evidence:
            new = " with ".join(one.label for one in trial.effects[len(now.effects) :])
            return Evidence(new, self.held_rms(trial), self.fall(now, trial), words)

        while len(now.effects) < self.most_effects:
            trials = self._ranked(self.best(now, one) for one in self.offered(now))
            tested = (t for t in trials[: self.most_tested] if self.supported(now, t, t.effects[-1]))
            following = next(tested, None) or self._pair(trials)
            small = [evidence(t, "too small to name") for t in trials[:LISTED] if t.square < now.square]
            if following is None:
                break
            steps.append(evidence(following, "accepted"))
            now = following
        while len(now.effects) > 1:
            less = {one: self.without(now, one) for one in now.effects}
            needless = [fit for one, fit in less.items() if not self.supported(fit, now, one)]
            if not needless:
                break
            now = min(needless, key=lambda one: one.square)
        return now, steps, small

    def _ranked(self, trials: Iterable[AnyFit | None]) -> list[AnyFit]:
        return sorted((one for one in trials if one is not None), key=self.criterion)

    def _pair(self, trials: Sequence[AnyFit]) -> AnyFit | None:
        """Two causes of which each needs the other, such as a creep and a warming against it: the best that is
        supported; None if there is none."""
        pairs = self._ranked(self.best(t, one) for t in trials[: self.most_paired] for one in self.offered(t))
        for pair in pairs[: self.most_tested]:
            if all(self.supported(self.without(pair, one), pair, one) for one in pair.effects[-2:]):
                return pair
        return None

    def alike(self, whole: AnyFit, cause: Any) -> list[AnyFit]:
        """Fits of all readings with another cause, or another form of it, last in its place that are nearly as good."""
        rest = self.without(whole, cause, True)
        trials = (self.best(rest, other, True) for other in self.offered(rest) if other is not cause)
        return [one for one in trials if one is not None and self.log_odds(one, whole) < LOG_ODDS]
