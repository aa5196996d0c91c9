"""The moves of the search by evidence where every candidate is refitted: tables by hand, and frequency responses.

A cause joins if the odds for it are high enough, counted over all names; then those go that it has made needless, and
another is put in the place of one where that is likelier. What may stand in the place of one cause, each with its share
of the posterior, makes its credible set.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Generic

import numpy as np
from scipy.special import logsumexp

from mbcdm_cad.loop.result import Evidence, Named
from mbcdm_cad.loop.search.account import left_out
from mbcdm_cad.loop.search.by_evidence import CredibleSet, SomeFit, credible_set
from mbcdm_cad.loop.search.evidence import LEAST_FALL, LOG_ODDS

# Candidates that are listed as too small, best first; those that are tried with fewer others.
LISTED, EXCHANGED = 5, 3


class Moves(ABC, Generic[SomeFit]):
    """The search; a problem says how causes are fitted, and how likely a fit is."""

    # Causes of a fit; candidates beside which each other one is tried, where none is likely alone.
    most_effects, paired = 4, 3
    # A form is taken in place of a later one of the library unless the logarithm of the odds against it is higher.
    same_form = float(np.log(10.0))
    names: int
    library: Sequence[Any]
    bare: SomeFit

    @property
    @abstractmethod
    def floor_rad(self) -> float:
        """The noise floor, rad RMS."""

    @abstractmethod
    def trials(self, now: SomeFit) -> Sequence[SomeFit]:
        """Fits of ``now`` with one cause more."""

    @abstractmethod
    def without(self, fit: SomeFit, cause: Any) -> SomeFit:
        """The fit without one of its causes."""

    @abstractmethod
    def log_of(self, fit: SomeFit) -> float:
        """Logarithm of the evidence of a fit."""

    @abstractmethod
    def rms(self, fit: SomeFit) -> float:
        """Error that a fit leaves, rad RMS."""

    @abstractmethod
    def named(self, cause: Any, fit: SomeFit, fall: float) -> Named:
        """A cause of a fit with its figures."""

    def told(self, fit: SomeFit, places: Sequence[CredibleSet[SomeFit]]) -> tuple[list[Named], list[tuple[Named, ...]]]:
        """Causes of a fit with one name, and sets of names."""
        outright, sets = list[Named](), list[tuple[Named, ...]]()
        for place in places:
            first = self.named(place.effect, fit, self.fall(fit, place.effect))
            first = replace(first, equivalent=place.forms, probability=place.probability)
            others = [replace(self.named(one.effects[-1], one, 0.0), probability=share) for one, share in place.alike]
            if others:
                sets.append((first, *others))
            else:
                outright.append(first)
        return outright, sets

    def score(self, fit: SomeFit) -> float:
        """Logarithm of the evidence, times the prior of its names, each as likely as each other."""
        return self.log_of(fit) - len(fit.effects) * float(np.log(self.names))

    def additions(self, now: SomeFit) -> list[SomeFit]:
        """Fits of ``now`` with one cause more, most likely first."""
        known: dict[SomeFit, list[SomeFit]] = self.__dict__.setdefault("_additions", {})
        if now not in known:
            known[now] = sorted(self.trials(now), key=self.score, reverse=True)
        return known[now]

    def fall(self, fit: SomeFit, cause: Any) -> float:
        """How much a cause of a fit lowers the error, rad in quadrature."""
        return float(np.sqrt(max(0.0, self.rms(self.without(fit, cause)) ** 2 - self.rms(fit) ** 2)))

    def found(self) -> tuple[SomeFit, list[CredibleSet[SomeFit]], list[Evidence], list[Evidence]]:
        """The likeliest fit without causes that are too small to name, what may stand in the place of each, what was
        accepted, and what is too small."""
        now = self.bare
        while len(now.effects) < self.most_effects and (better := self._better(now)) is not None:
            now = self._exchanged(self._pruned(better))
        for cause in now.effects:
            now = self._in_first_form(now, cause)
        while now.effects:
            falls = {cause: self.fall(now, cause) for cause in now.effects}
            least = min(falls, key=falls.__getitem__)
            if falls[least] >= LEAST_FALL * self.floor_rad:
                break
            now = self.without(now, least)
        steps = [Evidence(one.label, self.rms(now), self.fall(now, one), "accepted") for one in now.effects]
        left = self.rms(now) ** 2
        small = [
            left_out(one.effects[-1].label, self.rms(one), left - self.rms(one) ** 2, self.floor_rad)
            for one in self.additions(now)[:LISTED]
            if self.rms(one) ** 2 < left
        ]
        places = []
        for cause in now.effects:
            less = self.without(now, cause)
            places.append(credible_set(cause, less, now, self.additions(less), self.score))
        return now, places, steps, small

    def _better(self, now: SomeFit) -> SomeFit | None:
        """``now`` with one cause more, or with others, that is likely enough; else with two of which each needs the
        other, such as a creep and a warming against it."""
        more = self.additions(now)
        # One more cause is certain if any one is; which one, its credible set says.
        if more and logsumexp([self.score(one) for one in more]) - self.score(now) >= LOG_ODDS:
            return more[0]
        fewer = max((self._pruned(one) for one in more[:EXCHANGED]), key=self.score, default=now)
        if len(fewer.effects) <= len(now.effects) and self.score(fewer) > self.score(now) + 1.0:
            return fewer
        pair = max((two for one in more[: self.paired] for two in self.additions(one)[:1]), key=self.score, default=now)
        return pair if self.score(pair) - self.score(now) >= LOG_ODDS else None

    def _pruned(self, now: SomeFit) -> SomeFit:
        """``now`` without causes that the others explain as well."""
        less = max((self.without(now, one) for one in now.effects[:-1]), key=self.score, default=now)
        return self._pruned(less) if self.score(less) > self.score(now) else now

    def _exchanged(self, now: SomeFit) -> SomeFit:
        """``now`` with another cause, or form, in the place of one, while that is likelier."""
        for cause in now.effects:
            others = self.additions(self.without(now, cause))
            if others and self.score(others[0]) > self.score(now) + 1.0:
                return self._exchanged(self._pruned(others[0]))
        return now

    def _in_first_form(self, now: SomeFit, cause: Any) -> SomeFit:
        """``now`` with a cause in the first form of the library that is about as likely as any."""
        fits = [one for one in self.additions(self.without(now, cause)) if one.effects[-1].key == cause.key]
        near = [one for one in (now, *fits) if self.score(one) >= self.score(now) - self.same_form]
        form = {id(one): cause if one is now else one.effects[-1] for one in near}
        return min(near, key=lambda one: self.library.index(form[id(one)]))
