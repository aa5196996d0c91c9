"""The moves of the search by evidence: add, drop or swap one effect while the odds allow it.

An effect joins if the odds for it are high enough, counted over all names, so that many candidates do not make a name
likely; then those go that it has made needless, and another is put in the place of one where that is likelier. What may
stand in the place of one effect, each with its share of the posterior, makes its credible set: the fewest names that
together hold 95 % (G. Wang and others, J. R. Stat. Soc. B 82 (2020) 1273).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np
from scipy.special import logsumexp

from mbcdm_cad.loop.result import CandidateRow, Named
from mbcdm_cad.loop.search.account import left_out
from mbcdm_cad.loop.search.evidence import CREDIBLE, LEAST_FALL, LOG_ODDS, SCALES, TRIED, Weighed
from mbcdm_cad.routes import Floats

SomeFit = TypeVar("SomeFit", bound=Any)
MOST_EFFECTS = 6
# Least gain of a move, nats: evidence "not worth more than a bare mention" (R. E. Kass and A. E. Raftery, J. Am. Stat.
# Assoc. 90 (1995) 773).
LEAST_GAIN = 1.0
# A certain unknown part of this share of what a name explains may contain it: found on outside causes of the judge.
BLAME_SHARE = 0.25


@dataclass(frozen=True, eq=False)
class CredibleSet(Generic[SomeFit]):
    """One effect of the final fit and what may stand in its place: the fewest names that hold 95 % of the posterior.

    ``probability`` is that of ``effect``. ``alike``: fits that have another effect last in its place, each with its
    probability. ``forms``: other forms of ``effect`` that the data do not tell from it.
    """

    effect: Any
    probability: float
    alike: tuple[tuple[SomeFit, float], ...]
    forms: tuple[str, ...]

    @property
    def members(self) -> list[Any]:
        """All that may be in this place."""
        return [self.effect, *(one.effects[-1] for one, _ in self.alike)]


def told(
    sets: Sequence[CredibleSet[SomeFit]], first: Callable[[Any], Named], other: Callable[[SomeFit], Named]
) -> tuple[list[Named], list[tuple[Named, ...]]]:
    """Effects with one name, and sets of names; ``first`` describes an effect, ``other`` what may be in its place."""
    outright, groups = list[Named](), list[tuple[Named, ...]]()
    for place in sets:
        named = first(place.effect)
        named = replace(named, equivalent=(*place.forms, *named.equivalent), probability=place.probability)
        others = [replace(other(one), probability=share) for one, share in place.alike]
        if others:
            groups.append((named, *others))
        else:
            outright.append(named)
    return outright, groups


class Moves(ABC, Generic[SomeFit]):
    """The search; a problem says how effects are fitted, and how likely a fit is."""

    # Scales of the curves of an unknown cause, the number of names, the fit without effects.
    scales: Floats = SCALES
    names: int
    bare: SomeFit

    @property
    @abstractmethod
    def floor_rad(self) -> float:
        """The noise floor, rad RMS."""

    @abstractmethod
    def of(self, fit: SomeFit) -> Weighed:
        """Evidence of a fit under the present noise."""

    @abstractmethod
    def trials(self, now: SomeFit) -> Sequence[SomeFit]:
        """Fits of ``now`` with one effect more."""

    @abstractmethod
    def without(self, fit: SomeFit, effect: Any) -> SomeFit:
        """The fit without one of its effects."""

    @abstractmethod
    def rms(self, fit: SomeFit) -> float:
        """Error that a fit leaves, rad RMS."""

    def held_rms(self, fit: SomeFit) -> float:
        """Error of what was held back, rad RMS."""
        return self.rms(fit)

    @abstractmethod
    def named(self, effect: Any, fit: SomeFit, fall: float) -> Named:
        """An effect of a fit with its figures."""

    @abstractmethod
    def rescaled(self, scales: Floats) -> None:
        """Take other scales of an unknown cause, and forget what was found under others."""

    def forget(self) -> None:
        """Forget what was found under another noise."""
        self._without: dict[frozenset[Any], SomeFit] = {}
        self._additions: dict[SomeFit, list[SomeFit]] = {}

    def retuned(self, fit: SomeFit) -> None:
        """Take the noise of a fit, where that is found from one."""

    def ended(self, fit: SomeFit) -> SomeFit:
        """A fit as it is told."""
        return fit

    def untold(self, fit: SomeFit, now: SomeFit) -> bool:
        """Whether a fit is in a set beside ``now`` however unlikely it is."""
        return False

    def log_of(self, fit: SomeFit) -> float:
        """Logarithm of the evidence."""
        return self.of(fit).log

    def score(self, fit: SomeFit) -> float:
        """Logarithm of the evidence, times the prior of the names, each as likely as each other; a shape of what
        changes is the less likely explanation beside a cause."""
        shapes = sum(bool(one.last) for one in fit.effects)
        return self.log_of(fit) - len(fit.effects) * float(np.log(self.names)) - shapes * LOG_ODDS

    def certain(self, fit: SomeFit) -> bool:
        """Whether an unknown cause is certain beside a fit."""
        return self.of(fit).unknown_odds > LOG_ODDS

    def unexplained(self, fit: SomeFit) -> bool:
        """Whether an unknown cause is certain, and does more than what is too small to name."""
        return self.left_rad(fit) > LEAST_FALL * self.floor_rad

    def left_rad(self, fit: SomeFit) -> float:
        """RMS that a fit leaves above the noise, where an unknown cause is certain."""
        return self.above_rad(self.rms(fit)) if self.certain(fit) else 0.0

    def above_rad(self, rms: float) -> float:
        """What of an error stands above the noise, rad RMS."""
        return float(np.sqrt(max(rms**2 - self.floor_rad**2, 0.0)))

    def additions(self, now: SomeFit) -> list[SomeFit]:
        """Fits of ``now`` with one effect more, most likely first."""
        if now not in self._additions:
            self._additions[now] = sorted(self.trials(now), key=self.score, reverse=True)
        return self._additions[now]

    def fall(self, fit: SomeFit, effect: Any) -> float:
        """By how much an effect of a fit lowers the error, rad in quadrature."""
        return float(np.sqrt(max(0.0, self.rms(self.without(fit, effect)) ** 2 - self.rms(fit) ** 2)))

    def found(self) -> SomeFit:
        """The fit of most evidence."""
        now = self.grown(self.bare)
        if not self.certain(now):
            return now
        # Of several causes none may pay beside an unknown that stands for all: also begun without any.
        names = self.bare
        for scales in (SCALES[:1], SCALES):
            self.rescaled(scales)
            names = self.grown(self.pruned(names))
        return names if self.score(names) >= self.score(now) + LOG_ODDS else now

    def grown(self, now: SomeFit) -> SomeFit:
        """``now`` with every effect that the evidence allows."""
        # Each round adds an effect or ends; a few more, since one that is dropped may come back under a lower noise.
        for _ in range(2 * MOST_EFFECTS):
            more = self.additions(now) if len(now.effects) < MOST_EFFECTS else []
            better = more[0] if more else now
            # One more effect is certain if any one is; which one, its credible set says.
            each = {one.effects[-1].label: self.score(one) for one in reversed(more)}
            if logsumexp([*each.values(), -np.inf]) - self.score(now) < LOG_ODDS:
                # One more may make another one needless.
                likelier = [one for one in more[:TRIED] if self.log_of(one) > self.log_of(now) + LEAST_GAIN]
                fewer = [one for one in map(self.pruned, likelier) if len(one.effects) <= len(now.effects)]
                better = max(fewer, key=self.score, default=now)
                if self.score(better) < self.score(now) + LEAST_GAIN:
                    break
            # The same effects may have been fitted better beside the new one: then it is not needed yet.
            own = frozenset(now.effects)
            if better.effects[:-1] == now.effects:
                self._without.pop(own, None)
                again = self.without(better, better.effects[-1])
                if self.score(again) > self.score(now) + LEAST_GAIN:
                    now = again
                    continue
            self.retuned(better)
            self._without[own] = now
            now = self.pruned(better)
            # Names alone are only where a search begins.
            now = self.swapped(now) if self.scales is SCALES else now
        return now

    def pruned(self, now: SomeFit) -> SomeFit:
        """``now`` without effects that the others explain as well."""
        less = max((self.without(now, one) for one in now.effects[:-1]), key=self.score, default=now)
        return self.pruned(less) if self.score(less) > self.score(now) else now

    def swapped(self, now: SomeFit) -> SomeFit:
        """``now`` with another effect, or form, in the place of one, while that is likelier."""
        for effect in now.effects:
            best = next(iter(self.additions(self.without(now, effect))), now)
            if self.score(best) > self.score(now) + LEAST_GAIN:
                self.retuned(best)
                return self.swapped(self.pruned(best))
        return now

    def withdrawn(self, fit: SomeFit) -> tuple[SomeFit, list[tuple[Any, SomeFit]]]:
        """The fit without effects that are too small to name; and those of them that are too small only beside a
        certain unknown part, which may contain them, each with the fit that had it."""
        fit, taken, least_rad = self.ended(fit), list[tuple[Any, SomeFit]](), LEAST_FALL * self.floor_rad
        while fit.effects:
            needed = max(least_rad, self.left_rad(fit) / BLAME_SHARE)
            falls = {effect: self.fall(fit, effect) for effect in fit.effects}
            # Of those that do too little that goes without which the rest is likeliest.
            less = {effect: self.without(fit, effect) for effect in fit.effects if falls[effect] < needed}
            if not less:
                break
            out, rest = max(less.items(), key=lambda pair: self.score(pair[1]))
            taken += [(out, fit)] if falls[out] >= least_rad else []
            fit = self.ended(rest)
        return fit, taken

    def sets_of(self, now: SomeFit) -> list[CredibleSet[SomeFit]]:
        """The credible set of each effect."""
        return [self._set_of(now, effect) for effect in now.effects]

    def _set_of(self, now: SomeFit, effect: Any) -> CredibleSet[SomeFit]:
        less = self.without(now, effect)
        others = self.additions(less)
        if self.certain(now):
            # Beside a certain unknown part what could not be named either is no alternative.
            as_told = sorted(map(self.ended, others), key=self.score, reverse=True)
            most = self.rms(less)
            others = [one for one in as_told if np.hypot(self.rms(one), self.left_rad(one) / BLAME_SHARE) <= most]
        # A fit as it is told may not be the likeliest of its effects.
        best = max([now, *(one for one in others if one.effects[-1].key == effect.key)], key=self.score)
        fits, near = {effect.key: best}, self.score(best) - LOG_ODDS
        for one in others:
            fits.setdefault(one.effects[-1].key, one)
        lasts = [one.effects[-1] for one in others if self.score(one) > near]
        forms = [last.form for last in lasts if last.key == effect.key and last.form != effect.form]
        each = list(fits.values())
        scores = [self.score(less), *map(self.score, each)]
        share = np.exp(np.array(scores) - logsumexp(scores))[1:]
        order = np.argsort(-share)
        kept = order[: 1 + int(np.searchsorted(np.cumsum(share[order]), CREDIBLE))].tolist()
        kept += [k for k, one in enumerate(each) if self.untold(one, now)]
        alike = tuple((each[k], float(share[k])) for k in dict.fromkeys(kept) if k > 0)
        return CredibleSet(effect, float(share[0]), alike, tuple(dict.fromkeys(forms)))

    def told(self, fit: SomeFit) -> tuple[list[Named], list[tuple[Named, ...]]]:
        """Effects of a fit with one name, and sets of names."""

        def first(effect: Any) -> Named:
            return self.named(effect, fit, self.fall(fit, effect))

        return told(self.sets_of(fit), first, lambda one: self.named(one.effects[-1], one, 0.0))

    def candidates(self, now: SomeFit) -> tuple[tuple[CandidateRow, ...], tuple[CandidateRow, ...]]:
        """Effects of a fit, and those that it lacks."""
        steps = [CandidateRow(one.label, self.held_rms(now), self.fall(now, one), "accepted") for one in now.effects]
        falls = {one: self.rms(now) ** 2 - self.rms(one) ** 2 for one in self.additions(now)[:TRIED]}
        small = [
            left_out(one.effects[-1].label, self.rms(one), fall, self.floor_rad)
            for one, fall in falls.items()
            if fall > 0.0
        ]
        return tuple(steps), tuple(small)
