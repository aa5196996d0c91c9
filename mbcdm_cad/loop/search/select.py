"""Selection of effects: forward by nonlinear refits of the best candidates, and backward removal.

A linear screening only says which candidates are worth a refit; it may rank the wrong pulley first. An effect is
accepted only if the RMS on held-out samples falls by a stated share of the noise floor, in quadrature.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import log

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.evidence import log_odds, noise_left, supported
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.screening import CABLES_SLIP, MOST_REFITS, Screened, TrialFits, both_plays
from mbcdm_cad.routes import Floats

# Least fall of the held-out RMS, in quadrature, over the noise floor (trial study: closed-loop notes).
LEAST_FALL = 0.45
# After a better candidate was rejected, another is accepted only if it causes this share of the fall of the better one.
RUNNER_UP = 0.8
MOST_EFFECTS = 6
# If no more than the floor is left, a candidate is refitted if its predicted fall is this share of the required one.
PROMISED_SHARE = 0.25
# Of two fits that differ by less than the required fall that with fewer effects is preferred, unless the odds against
# it are larger.
FEWER_LOG_ODDS = log(1e5)
# Number of effects that were rejected alone and are tried again together with a second one.
MOST_FIRST = 3
# Number of other forms of accepted effects from which the search is begun again.
MOST_FORMS = 2
# A search from there with as many effects and so many times the error of the one before tries only what is close.
FAR_BEHIND = 2.0
# Largest error beyond the floor that such a pair may leave, over the error that it explains.
MOST_LEFT = 0.1
# Fall of the held-out RMS, over the floor, from which an effect supported by one place only is accepted if it leaves
# nothing above the noise.
MUCH = 1.25
# An effect reduces noise, and does not only fit it, if at most this share of the noise is left.
QUIETER = 0.9


@dataclass(frozen=True, eq=False)
class Step:
    """One line of the record of the search: the decision, the effect, and the held-out RMS before and after (rad)."""

    action: str
    effect: Effect
    before_rad: float
    after_rad: float


class Search(TrialFits):
    """The search over one set of runs; ``bare`` is the fit without effects.

    ``noise`` does not repeat; falls of the error are compared with it. An effect that is not yet accepted may cause an
    error that does not repeat (because the friction depends on earlier loads), so the noise is computed again with each
    accepted effect.
    """

    def __init__(self, fitter: Fitter, library: Sequence[Effect], bare: Fit) -> None:
        self.library = tuple(effect for effect in library if not effect.inside)
        super().__init__(fitter, self.library)
        self.bare = bare
        self.inside = tuple(effect for effect in library if effect.inside)
        self.noise = noise_left(self.fitter, bare)
        self.steps: list[Step] = []
        # Reasons why fitted values are impossible: a sentence for each effect's label.
        self.doubts: dict[str, str] = {}
        self._leaning: dict[Fit, list[Fit]] = {}
        self._tried: dict[Fit, list[Fit]] = {}
        self._other_forms: list[Fit] = []

    @property
    def floor_rad(self) -> float:
        """The noise floor, rad RMS."""
        return self.noise.total_rad

    @property
    def least_floor_rad(self) -> float:
        """Lower bound of the floor from the declared errors of the sensors; rad RMS."""
        return self.noise.declared_rad or self.noise.white_rad

    def held_rms(self, fit: Fit) -> float:
        """RMS on the held-out samples, rad, minus the mean of each run over its training samples."""
        return float(np.sqrt(np.mean(fit.residual[self.fitter.test] ** 2)))

    def enough(self, before: Fit, after: Fit) -> bool:
        """Whether the held-out RMS falls by enough."""
        fall = self.held_rms(before) ** 2 - self.held_rms(after) ** 2
        return bool(fall >= (LEAST_FALL * self.floor_rad) ** 2)

    def forward(self) -> Fit:
        """Accept effects while the held-out RMS falls by enough, and withdraw those that are no longer needed."""
        now = self._grown(self.bare)
        now = self._from_inside(now)
        now = self._gone_on(now)
        # What sets the slip of the cables may stand for a wrong form.
        if self.too_much(now) or any(effect.name in CABLES_SLIP for effect in now.effects):
            now = self._in_other_forms(now)
        if self._plays_suspected(now):
            now = self._with_both_plays(now)
        return now

    def _plays_suspected(self, now: Fit) -> bool:
        """Whether play at two inputs is worth a trial: one is in the fit, or an effect that two plays resemble, or more
        than the floor is left, or one play promises to explain a part of it.

        The noise floor alone cannot tell, because what two plays do does not repeat and stands in it.
        """
        alike = {effect.name for effect in self.library if effect.saturates}
        if self.too_much(now) or any(effect.saturates or alike & {*effect.after} for effect in now.effects):
            return True
        least = PROMISED_SHARE * (LEAST_FALL * self.least_floor_rad) ** 2
        return not now.effects and any(c.effect.saturates and c.fall > least for c in self.screening.screen(now))

    def _with_both_plays(self, now: Fit) -> Fit:
        """``now``, or play at two inputs at once if that leaves clearly less, or as little with fewer effects."""
        found = both_plays(self, self.library, self.bare)
        if found is None or any(map(self.impossible, found.effects, found.values)):
            return now
        for effect in found.effects:
            less = self.without(found, effect)
            if not (self.enough(less, found) or self.enough_beside(less, found)):
                return now
            if not supported(self.fitter, less, found.with_last(effect), len(self.library)):
                return now
        fewer = len(found.effects) < len(now.effects) and not self.enough(found, now)
        if not (fewer or self.enough(now, found) or self.enough_beside(now, found)):
            return now
        self.note("play at both inputs at once", found.effects[-1], now, found)
        return self.taken(found)

    def _grown(self, now: Fit, against: Fit | None = None) -> Fit:
        """``now`` with all effects that can be accepted; ``against``: where the search ended from another beginning."""
        while len(now.effects) < MOST_EFFECTS:
            better = self._best(now, against)
            if better is None:
                break
            self.note("accepted", better.effects[-1], now, better)
            now = self._reckoned(self.backward(better))
        return now

    def _reckoned(self, now: Fit) -> Fit:
        """``now``, after the noise was computed again with its effects."""
        self.noise = min(self.noise, noise_left(self.fitter, now), key=lambda noise: noise.total_rad)
        return now

    def taken(self, found: Fit) -> Fit:
        """``found`` in place of the present fit, with all effects that can be accepted beside its own."""
        return self._grown(self._reckoned(found))

    def _from_inside(self, now: Fit) -> Fit:
        """``now`` with a line that moves the cables, if the effect that seemed to ease their friction is then not
        needed.

        A ripple inside the drive moves the cables to and fro and eases their friction. As an error of the reading it
        does not, so another effect has to explain the lower friction.
        """
        for line in now.effects:
            forms = [effect for effect in self.inside if effect.key == line.key]
            kept = [effect for effect in now.effects if effect is not line and not effect.generic]
            if not forms or len(kept) + 1 == len(now.effects):
                continue
            values = [now.values_of(effect) for effect in (*kept, line)]
            begun = self.each(
                [
                    partial(Fitter.fit, effects=(*kept, form), values=values, offsets=now.offsets, settled=1e-4)
                    for form in forms
                ]
            )
            if not begun:
                continue
            best = min(begun, key=lambda one: one.square)
            found = self._grown(best) if self.enough(best, now) else best
            fewer = len(found.effects) < len(now.effects) and not self.enough(found, now)
            if fewer and log_odds(self.fitter, found, now) < FEWER_LOG_ODDS:
                self.note("moves the cables", best.effects[-1], now, found)
                return self._from_inside(found)
        return now

    def _gone_on(self, now: Fit) -> Fit:
        """``now``, or the fit that a beginning leads to which was refused alone.

        Where more than the floor is left, the beginnings are pairs of which the first is not supported without the
        second. And what a wrong effect leaves seems not to repeat, so the floor rises with it and cannot tell that it
        is wrong: a candidate that was refused though it leaves less than all of ``now`` is a beginning too.
        """
        much = self.too_much(now)
        for one in sorted(self._leaning.get(now, []), key=lambda one: one.square) if much else ():
            # With a large fall and nothing left above the noise no other explanation is left. What the effect does may
            # not repeat and stand in the floor, so the noise that it leaves counts where that is less.
            floor = min(self.floor_rad, noise_left(self.fitter, one).total_rad)
            if self.explained_by(one, now, floor):
                self.note("leaves only noise", one.effects[-1], now, one)
                return self.backward(one)
        refused = [one for each in self._leaning.values() for one in each if self.held_rms(one) < self.held_rms(now)]
        refused = sorted(refused, key=lambda one: one.square)[:MOST_FORMS]
        for one in self._promising(now)[:MOST_FIRST] if much else refused:
            noise, grown = self.noise, self._grown(one, against=now)
            explained = self.held_rms(now) ** 2 - self.held_rms(grown) ** 2
            leaves = self.too_much(grown) and self.held_rms(grown) ** 2 - self.floor_rad**2 > MOST_LEFT**2 * explained
            borne = (
                supported(self.fitter, less, grown.with_last(e), len(self.library))
                or self.explained_by(grown, less, self.floor_rad)
                for e in grown.effects
                for less in [self.without(grown, e)]
            )
            if self.enough(now, grown) and not leaves and all(borne):
                self.note("supported together with the others", one.effects[-1], now, grown)
                return grown
            self.noise = self.noise if much else noise
        return now

    def _in_other_forms(self, now: Fit) -> Fit:
        """``now``, or a better fit, or one as good with fewer effects, that the search reaches from another form of an
        effect that it accepted.

        A viscous drag strains the cables, a late sensor does not; a soft rope widens the loop, a soft shaft does not.
        Beside the wrong form the search accepts a wrong friction of the cables, and then no exchange of a single effect
        or form leads to the right ones.
        """
        for one in sorted(self._other_forms, key=lambda one: one.square)[:MOST_FORMS]:
            grown = self._grown(one, against=now)
            fewer = len(grown.effects) < len(now.effects) and not self.enough(grown, now)
            if self.enough(now, grown) or (fewer and log_odds(self.fitter, grown, now) < FEWER_LOG_ODDS):
                self.note("begun again with another form", one.effects[-1], now, grown)
                now = grown
        return now

    def _promising(self, now: Fit) -> list[Fit]:
        """Tried fits of ``now`` with one effect more, each name once, in the order of the fall predicted with a second
        one.

        An effect that explains little alone may be half of a pair that explains all, so the order is that of the pairs.
        """
        each: dict[object, Fit] = {}
        for one in sorted(self._tried.get(now, []), key=lambda one: one.square):
            possible = not one.effects[-1].last and not self.impossible(one.effects[-1], one.values[-1])
            if possible and self.enough(now, one):
                each.setdefault(one.effects[-1].key, one)

        def promised(one: Fit) -> float:
            return one.square - self.screening.best_known_fall(one)

        return sorted(each.values(), key=promised)

    def explained_by(self, fit: Fit, less: Fit, floor_rad: float) -> bool:
        """Whether ``fit`` leaves nothing above the noise and explains much that ``less`` does not, compared with a
        floor."""
        fall = self.held_rms(less) ** 2 - self.held_rms(fit) ** 2
        return fall > (MUCH * floor_rad) ** 2 and not self.too_much(fit)

    def _best(self, now: Fit, against: Fit | None) -> Fit | None:
        """``now`` with the best effect that can be accepted; None if there is none.

        If all close candidates are rejected, those with a smaller predicted fall are refitted too: for a large preload
        error a linear step predicts little, although the refit may explain everything. A search that is begun again
        leaves out those that can only end far behind the best one that was rejected, and all of them where it is itself
        far behind the one before.
        """
        done = list[Screened]()
        tried = list[Fit]()
        found: Fit | None = None
        for first in range(0, len(self.screening.screen(now)), MOST_REFITS):
            chosen = [c for c in self.close(now, first=first) if c not in done]
            if first or not self.too_much(now):
                floor = self.floor_rad if first else self.least_floor_rad
                chosen = [c for c in chosen if c.fall > PROMISED_SHARE * (LEAST_FALL * floor) ** 2]
            done += chosen
            needed = -np.inf
            if against and first:
                causes = [one.square for one in tried if not one.effects[-1].last]
                needed = RUNNER_UP * (now.square - min(causes, default=now.square))
            new = self.refits(now, chosen, needed=needed)
            tried += new
            found = self._first_acceptable(now, new, [one for one in tried if not one.effects[-1].last])
            # It has as many effects as the one before and leaves far more.
            far_behind = (
                against is not None
                and len(now.effects) >= len(against.effects)
                and self.held_rms(now) > FAR_BEHIND * self.held_rms(against)
            )
            if found is not None or not self.too_much(now) or far_behind:
                break
        if found is None:
            self._tried[now] = tried
            shapes = sorted((one for one in tried if one.effects[-1].last), key=lambda one: one.square)
            found = self._first_acceptable(now, shapes, shapes)
        return found

    def _first_acceptable(self, now: Fit, new: Sequence[Fit], among: Sequence[Fit]) -> Fit | None:
        """The first of ``new`` that can be accepted and that is not far behind the best of ``among``."""
        least = min((one.square for one in among), default=now.square)
        for one in new:
            # A candidate far behind a rejected better one only explains a small part of the same error.
            crumbs = now.square - one.square < RUNNER_UP * (now.square - least)
            if one in among and not crumbs and self.acceptable(now, one):
                self._other_forms += [o for o in new if o is not one and self._in_other_form(o, one, now)]
                return one
        return None

    def _in_other_form(self, other: Fit, one: Fit, now: Fit) -> bool:
        """Whether ``other`` has the last effect of ``one`` in another form that also explains much of ``now``."""
        last = other.effects[-1]
        same = last.key == one.effects[-1].key and last is not one.effects[-1]
        return same and self.enough(now, other) and not self.impossible(last, other.values[-1])

    def too_much(self, fit: Fit) -> bool:
        """Whether more than the floor is left on held-out samples."""
        return self.held_rms(fit) ** 2 > (1.0 + LEAST_FALL**2) * self.floor_rad**2

    def enough_beside(self, before: Fit, after: Fit) -> bool:
        """Whether the held-out RMS falls by enough, compared with the noise in the residual of ``after``.

        The error from play and friction depends on the motion before, so without these effects it seems not to repeat.
        """
        fall = self.held_rms(before) ** 2 - self.held_rms(after) ** 2
        if fall < (LEAST_FALL * self.noise.declared_rad) ** 2 or fall <= 0.0:
            return False
        left = noise_left(self.fitter, after).total_rad
        return bool(left < QUIETER * self.floor_rad and fall >= (LEAST_FALL * left) ** 2)

    def acceptable(self, now: Fit, better: Fit) -> bool:
        """Whether the last effect of ``better`` is large enough, within bounds, and supported by all sweeps and
        sectors."""
        if not self.enough(now, better) and not self.enough_beside(now, better):
            return False
        effect = better.effects[-1]
        why = self.impossible(effect, better.values[-1])
        if why:
            self.note(why, effect, now, better)
            return False
        if supported(self.fitter, now, better, len(self.library)):
            return True
        self.note("supported by one sweep or sector only", better.effects[-1], now, better)
        self._leaning.setdefault(now, []).append(better)
        return False

    def impossible(self, effect: Effect, values: Floats) -> str:
        """Why no bench can have an effect of these values; an empty text if it can."""
        words = effect.doubtful(values) if effect.doubtful else ""
        if words:
            self.doubts.setdefault(effect.label, words)
            return "no part can have this value"
        at_bound = [p.name for p, v in zip(effect.parameters, values, strict=True) if v in (p.low, p.high)]
        return f"{at_bound[0]} reaches its bound" if at_bound else ""

    def backward(self, fit: Fit) -> Fit:
        """Remove effects that the others explain as well."""
        for effect in fit.effects[:-1]:
            less = self.without(fit, effect)
            if not self.enough(less, fit):
                self.note("withdrawn: not needed", effect, fit, less)
                return self.backward(less)
        return fit

    def needed(self, fit: Fit) -> Fit:
        """``fit`` without the effects that the others explain as well, also where what they do does not repeat."""
        for effect in fit.effects if len(fit.effects) > 1 else ():
            less = self.without(fit, effect)
            if not self.enough(less, fit) and not self.enough_beside(less, fit):
                self.note("withdrawn: not needed", effect, fit, less)
                return self.needed(less)
        return fit

    def give_back(self, why: str, effect: Effect, fit: Fit) -> Fit:
        """The fit without one of its effects, and record that it is withdrawn."""
        less = self.without(fit, effect)
        self.note(why, effect, fit, less)
        return less

    def note(self, action: str, effect: Effect, before: Fit, after: Fit) -> None:
        self.steps.append(Step(action, effect, self.held_rms(before), self.held_rms(after)))
