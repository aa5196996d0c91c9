"""Verify the result of the search: effects that may be zero, names that an unknown error only resembles.

Generic regressors are curves of load or speed without a name, one coefficient each. Several effects of the library
together can imitate such a curve: a compliance that grows with the load looks like a soft shaft with some friction and
a preload error. Where one regressor alone explains as much as the named effects, the names are withdrawn and the
verdict is unknown.

Each effect of the search's fit was compared with others (``exchange``). Names are withdrawn if their size may be zero,
if they may only resemble an unknown error, or if one plain curve of load or speed explains as much.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial, reduce
from math import log

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as t_distribution

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.effects import lash
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.loop.readable import INTERVAL
from mbcdm_cad.loop.result import LEAST_ODDS
from mbcdm_cad.loop.search.class_of_sensor import ClassOfSensor
from mbcdm_cad.loop.search.evidence import chance_without_slope, log_odds
from mbcdm_cad.loop.search.exchange import Group
from mbcdm_cad.loop.search.fit import WINDOWS, Fit, Fitter
from mbcdm_cad.loop.search.select import LEAST_FALL, Search
from mbcdm_cad.loop.search.unknown import Unknown, describe_unknown, hangs_on
from mbcdm_cad.measurement.run import smoothed
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats


def regressors(loaded: bool) -> list[Effect]:
    """Curves without a name, one coefficient each: of load, where it was measured, and of speed."""

    def curve(form: str, unit: str, size: float, shape: Callable[[Setup], Floats]) -> Effect:
        def apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
            return setup.with_added(values[0] * shape(setup))

        return Effect(
            "unknown", form, f"goes with the {form}", "", "", (Parameter(f"coefficient_{unit}", size),), apply
        )

    load, speed = partial(curve, unit="rad_Nm2", size=1e-6), partial(curve, unit="rad_s2", size=1e-4)
    of_load = [
        load("square of the load with its sign", shape=lambda s: s.load * np.abs(s.load)),
        load("square of the load", shape=lambda s: s.load**2),
        load("square of the positive load", shape=lambda s: np.maximum(s.load, 0.0) ** 2),
        load("square of the negative load", shape=lambda s: np.minimum(s.load, 0.0) ** 2),
    ]
    return [
        *(of_load if loaded else ()),
        speed("square of the speed", shape=lambda s: s.p.speed_rad_s**2),
        speed("square of the speed with its sign", shape=lambda s: np.abs(s.p.speed_rad_s) * s.p.speed_rad_s),
    ]


# An effect is not named if the unexplained error is at least this share of the error that the effect explains.
BLAME_SHARE = 0.25
SLOW_S = 0.3
# An effect that is not named is reported as helpful from LEAST_ODDS on. It stays in the fit if it explains this share
# of the error above the floor.
MOST_OF = 0.75
# Two effects cancel each other if one does so many times what all effects together do, and its size, over its standard
# error, is below the second figure: 95 % bands of a third of it. A ratio that undoes a runout may be known far better.
CANCELS, SURE = 3.0, 6.0
# The time of an event is open if another time, this share of the run away or farther, explains the run as well.
AWAY, TIMES = 0.1, 24
# A change ends below its bound if it does by this share of itself.
PAST = 0.25
# A wave that a weight on an arm makes of a compliance.
WAVE, SOFT, SERIES = ("once_per_rev", "drum"), ("stiffness_error", None), "compliance in series"
OTHER_WEIGHT = "a run with another weight on the arm, or none, judged with this one: what is soft goes with the weight"
# A compliance is left open if a fit leaves so much of what it began with.
LEFT_OPEN = 0.5
# A size counts as possibly zero if it is zero with this probability.
ZERO_CHANCE = 0.05


@dataclass(frozen=True, eq=False)
class TakenBack:
    """An effect that is not named but lowers the error: its values in the fit from which it was withdrawn, and its
    odds."""

    effect: Effect
    values: Floats
    covariance: Floats
    fall_rad: float
    odds: float


class Judge(ClassOfSensor):
    """Judges the fits of one search."""

    def __init__(self, search: Search, wound: Effect | None = None) -> None:
        """``wound``: a friction that winds up what is soft, where the runs cannot tell it from a play."""
        super().__init__(search)
        self.wound = wound
        self.helpful: list[TakenBack] = []
        # Names withdrawn because a quantity that the runs did not measure explains the error as well.
        self.unmeasured: list[str] = []

    def judged(self) -> tuple[Fit, tuple[Group, ...], Unknown | None]:
        """The final fit, its effects with their alternatives, and the unexplained part."""
        fit, groups = self.settled()
        fit, groups = self._certain(fit, groups)
        fit, groups = self._bounded(fit, groups)
        groups = tuple(self._or_wound_up(fit, self._beside_a_soft_shaft(fit, group)) for group in groups)
        fit, groups = self.beyond_class(fit, groups)
        unknown = self.left(fit)
        if unknown is not None:
            fit, groups, unknown = self._unblamed(fit, groups, unknown)
        fit, groups, unknown = self._not_generic(fit, groups, unknown)
        fit, groups, unknown = self._not_beside_more(fit, groups, unknown)
        return fit, self._measured(fit, groups), unknown

    def _measured(self, fit: Fit, groups: tuple[Group, ...]) -> tuple[Group, ...]:
        """Withdraw names that an unmeasured quantity explains as well; they stay in the fit, as helpful."""
        kept = []
        for group in groups:
            members = [group.effect, *(one.effects[-1] for one in group.alike)]
            if not any(member.unmeasured for member in members):
                kept.append(group)
                continue
            self._kept_as_helpful(fit, group.effect, self.fall_rad(fit, group.effect))
            self.unmeasured += [f"{member.name} ({member.form})" for member in members]
        return tuple(kept)

    def left(self, fit: Fit, fitter: Fitter | None = None) -> Unknown | None:
        """The unexplained part if it is above the floor, else None; ``fitter`` is the search's by default."""
        fitter = fitter or self.fitter
        worst: Unknown | None = None
        for part, p in zip(fitter.parts, fitter.runs, strict=True):
            r = fit.residual[part]
            at = np.flatnonzero(p.used)
            slow = smoothed(np.interp(np.arange(r.size), at, r[at]), SLOW_S, p.step_s)
            quiet = float(np.mean((r - slow)[p.used] ** 2))
            # White noise leaves this share of its square in the smoothed residual.
            kept = 2.0 / 3.0 * p.step_s / (0.5 * SLOW_S)
            excess = float(np.mean(slow[p.used] ** 2)) - kept * quiet
            fast = quiet - 1.5 * self.search.floor_rad**2
            if max(excess, fast) > (LEAST_FALL * self.search.floor_rad) ** 2:
                found = describe_unknown(p, r, self.search.floor_rad)
                # An error that does not repeat is noise, white or coloured, and a pattern in time cannot repeat. With
                # too few half sweeps repetition cannot be tested, and the error cannot be called noise.
                repeats = p.few or any(pattern.variable != "time" for pattern in found.patterns)
                if repeats and (worst is None or found.rms_rad > worst.rms_rad):
                    worst = found
        return worst

    def largest(self, fit: Fit, fitter: Fitter) -> Unknown:
        """The unexplained part of the run in which it is largest, whether or not it repeats."""
        each = [
            describe_unknown(p, fit.residual[part], self.search.floor_rad)
            for part, p in zip(fitter.parts, fitter.runs, strict=True)
        ]
        return max(each, key=lambda one: one.rms_rad)

    def _unexplained(self, fit: Fit, unknown: Unknown) -> float:
        """Size of what is unexplained, rad RMS: held-out error above the floor, or the part that certainly repeats."""
        beyond = float(np.sqrt(max(0.0, self.search.held_rms(fit) ** 2 - self.search.floor_rad**2)))
        return max([beyond, *(pattern.rms_rad for pattern in unknown.patterns if pattern.variable != "time")])

    def _unblamed(
        self, fit: Fit, groups: tuple[Group, ...], unknown: Unknown
    ) -> tuple[Fit, tuple[Group, ...], Unknown]:
        """Withdraw names that may only resemble an unknown cause, the one that explains least first.

        An effect that certainly lowers the error is recorded as helpful; if it explains most of the error above the
        floor, it stays in the fit.
        """
        full = fit
        while groups:
            rms = self.search.held_rms(fit)
            # Of two that cancel each other, neither explains more than both do together.
            most = self._without_all(fit, groups) ** 2 - rms**2
            falls = [min(most, self.search.held_rms(self.search.without(fit, g.effect)) ** 2 - rms**2) for g in groups]
            least = int(np.argmin(falls))
            if self._unexplained(fit, unknown) < BLAME_SHARE * np.sqrt(max(0.0, falls[least])):
                break
            less = self.search.without(fit, groups[least].effect)
            if self._odds(less, fit) >= LEAST_ODDS:
                self._kept_as_helpful(fit, groups[least].effect, float(np.sqrt(max(0.0, falls[least]))))
            fit, groups = self._in_best_form(less, (*groups[:least], *groups[least + 1 :]))
            left = self.left(fit)
            if left is None:
                return fit, groups, unknown
            unknown = left
        above = self.search.held_rms(fit) ** 2 - self.search.floor_rad**2
        explained = self.search.held_rms(fit) ** 2 - self.search.held_rms(full) ** 2
        # A form chosen without the others has its size without them too.
        same = all(group.effect in full.effects for group in groups)
        together = self.helpful and same and len(self.helpful) + len(groups) == len(full.effects)
        if together and explained > MOST_OF * above:
            return full, groups, self.left(full) or unknown
        return fit, groups, unknown

    def _without_all(self, fit: Fit, groups: tuple[Group, ...]) -> float:
        """Held-out RMS without any of the named effects, rad."""
        return self.search.held_rms(reduce(self.search.without, (g.effect for g in groups), fit))

    def _in_best_form(self, fit: Fit, groups: tuple[Group, ...]) -> tuple[Fit, tuple[Group, ...]]:
        """The last effect that is left, in the form that fits best without those that were withdrawn.

        Of forms that fit alike, that with the lowest held-out error.
        """
        if len(groups) != 1:
            return fit, groups
        effect = groups[0].effect
        others = [o for o in self.search.alternatives(fit, effect) if o.effects[-1].key == effect.key]
        forms = [o for o in others if self._in_better_form(o, fit, effect) or self.alike(o, fit)]
        best = min((fit, *forms), key=self.search.held_rms)
        # An exchanged effect is the last of its fit; in the fit as it was, errors of the sensors may stand there.
        return best, groups if best is fit else (replace(groups[0], effect=best.effects[-1]),)

    def _kept_as_helpful(self, fit: Fit, effect: Effect, fall_rad: float) -> None:
        """Record an effect of a fit that is not named and lowers the error."""
        block, odds = self.spread(fit, effect, self.fitter), self._odds(self.search.without(fit, effect), fit)
        self.helpful.append(TakenBack(effect, fit.values_of(effect), block, fall_rad, odds))

    def _odds(self, less: Fit, fit: Fit) -> float:
        """Odds that ``fit`` has a lower error than ``less`` on half sweeps that neither was fitted to."""
        test = self.fitter.test
        sweep = np.unique(self.fitter.sweep[test], return_inverse=True)[1]
        falls = np.bincount(sweep, (less.residual**2 - fit.residual**2)[test]) / np.bincount(sweep)
        if falls.size < 3:
            return 1.0
        error = float(np.std(falls, ddof=1)) / np.sqrt(falls.size)
        wrong = float(t_distribution.sf(float(np.mean(falls)) / error, falls.size - 1)) if error > 0.0 else 0.5
        return (1.0 - wrong) / max(wrong, 1e-12)

    def taken_back(
        self, group: Group, fit: Fit, groups: tuple[Group, ...]
    ) -> tuple[Fit, tuple[Group, ...], Unknown | None]:
        """Fit, effects and unexplained part without an effect whose size all data together do not tell from zero."""
        fit = self.search.give_back("may be zero", group.effect, fit)
        groups = tuple(one for one in groups if one is not group)
        unknown = self.left(fit)
        return (fit, groups, None) if unknown is None else self._unblamed(fit, groups, unknown)

    def _certain(self, fit: Fit, groups: tuple[Group, ...]) -> tuple[Fit, tuple[Group, ...]]:
        """Withdraw names whose sizes may be zero: by their scatter over sweeps and sectors, and with other windows."""
        while groups:
            windows = self.shift_by_window(fit)
            chances = []
            for group in groups:
                shift = windows[fit.effects.index(group.effect)]
                chance = self.chance_of_zero(fit, group.effect, shift, self.fitter)
                # Scatter says nothing of a size without a slope, or beside an uncertain time of an event.
                if group.effect.saturates or group.effect.once:
                    without = self.search.without(fit, group.effect)
                    chance = min(chance, chance_without_slope(self.fitter, without, fit))
                chances.append(chance)
            worst = int(np.argmax(chances))
            if chances[worst] <= ZERO_CHANCE:
                break
            fit = self.search.give_back("may be zero", groups[worst].effect, fit)
            groups = (*groups[:worst], *groups[worst + 1 :])
        return fit, groups

    def _bounded(self, fit: Fit, groups: tuple[Group, ...]) -> tuple[Fit, tuple[Group, ...]]:
        """Withdraw names that another of the effects cancels, and events whose time the data do not tell."""
        while groups:
            unsure = [self._size_over_error(fit, g.effect) < SURE for g in groups]
            cancelled = [self._cancelled(fit, g.effect) if u else 0.0 for g, u in zip(groups, unsure, strict=True)]
            worst = groups[int(np.argmax(cancelled))]
            why = "cancelled by another effect"
            if max(cancelled) <= CANCELS:
                below = [g for g in groups if self._no_part_can(fit, g.effect)]
                open_times = below or [g for g in groups if g.effect.once and self._time_is_open(fit, g.effect)]
                if not open_times:
                    break
                worst, why = open_times[0], "no part can have this value" if below else "its time is open"
            fit = self.search.give_back(why, worst.effect, fit)
            groups = tuple(group for group in groups if group is not worst)
        return fit, groups

    def _no_part_can(self, fit: Fit, effect: Effect) -> bool:
        """Whether an effect ends at a value that no part can have; a change of a part's figure by more than noise."""
        base, change = effect.base, float(fit.values_of(effect)[0])
        if base is None or base.parameters[0].name.endswith("share"):
            return bool(effect.doubtful and effect.doubtful(fit.values_of(effect)))
        before = [fit.values_of(e)[0] for e in fit.effects if (e.key, e.form) == (base.key, base.form)]
        after = float(before[0] if before else base.parameters[0].default or 0.0) + change
        return after < base.parameters[0].low - PAST * abs(change)

    def _beside_a_soft_shaft(self, fit: Fit, group: Group) -> Group:
        """A wave of the drum as a set with a compliance where any share of it may be the load's.

        Where all loads are one wave of the drum's angle, as of one weight on an arm, a compliance beside a smaller or a
        larger wave is as good, whatever its size; no exchange of one effect for another shows that.
        """
        effect = group.effect
        soft = next((e for e in self.search.library if e.key[:2] == SOFT and e.form == SERIES), None)
        taken = [e.key[:2] for e in fit.effects] + [one.effects[-1].key[:2] for one in group.alike]
        if effect.key[:2] != WAVE or soft is None or SOFT in taken:
            return group
        soft = replace(soft, separate_by=OTHER_WEIGHT)
        f, own = self.fitter, fit.columns_of(effect)
        load = np.concatenate([p.load_Nm[p.used] for p in f.runs if p.load_Nm is not None])
        if not np.ptp(load) > 0.0:
            return group
        size = float(np.hypot(*fit.values_of(effect)[:2])) / (0.5 * float(np.ptp(load)))
        # Begun where the wave makes up for the compliance: a fit does not move along what the runs do not tell.
        before = f.output - fit.residual
        bent = f.centred_on(
            f.used, f.predict((*fit.effects, soft), (*fit.values, np.array([size])), fit.offsets) - before
        )
        back = np.linalg.lstsq(f.centred_on(f.used, fit.jacobian[:, own]), -bent, rcond=1e-9)[0]
        values = [v + back if e is effect else v for e, v in zip(fit.effects, fit.values, strict=True)] + [[size]]
        other = self.fitter.tried((*fit.effects, soft), values, fit.offsets)
        # Where the runs tell the compliance, the fit brings it back.
        if other is None or float(other.values[-1][0]) < LEFT_OPEN * size or not self.alike(other, fit):
            return group
        return replace(group, alike=(*group.alike, other))

    def _or_wound_up(self, fit: Fit, group: Group) -> Group:
        """A play that motion takes up as a set with a friction behind what is soft: both are the same motion."""
        members = [(fit, group.effect), *((one, one.effects[-1]) for one in group.alike)]
        if self.wound is None or any(effect.name == self.wound.name for _, effect in members):
            return group
        for one, effect in members:
            if (effect.name, effect.form) == (lash.NAME, lash.BY_MOTION):
                others = [(e, v) for e, v in zip(one.effects, one.values, strict=True) if e is not effect]
                effects, values = [e for e, _ in others], [v for _, v in others]
                found = self.fitter.tried([*effects, self.wound], [*values, 0.5 * one.values_of(effect)], fit.offsets)
                if found is not None and self.alike(found, fit):
                    return replace(group, alike=(*group.alike, found))
        return group

    def chance_of_zero(self, fit: Fit, effect: Effect, shift: Floats | float, fitter: Fitter) -> float:
        """Probability of such sizes of an effect if they are zero; ``fit`` is one of ``fitter``."""
        sizes = sum(p.role == "size" for p in effect.parameters)
        return float(chi2.sf(self._strength(fit, effect, shift, fitter), sizes))

    def _strength(self, fit: Fit, effect: Effect, shift: Floats | float, fitter: Fitter) -> float:
        """Square of an effect's sizes over their standard errors, which ``shift`` (other windows) makes wider."""
        sizes = [k for k, p in enumerate(effect.parameters) if p.role == "size"]
        values = fit.values_of(effect)
        wider = np.diag(np.broadcast_to((shift / INTERVAL) ** 2, values.shape))
        block = self.spread(fit, effect, fitter) + wider
        inverse = np.linalg.pinv(block[np.ix_(sizes, sizes)], hermitian=True)
        return float(values[sizes] @ inverse @ values[sizes])

    def _size_over_error(self, fit: Fit, effect: Effect) -> float:
        """An effect's size over its standard error: of a wave the amplitude, whose phase may be known far better."""
        unit = np.array([p.size for p in effect.parameters])
        own = fit.values_of(effect) / unit * np.array([p.role == "size" for p in effect.parameters])
        block = self.spread(fit, effect, self.fitter) / np.outer(unit, unit)
        return float(own @ own / np.sqrt(max(own @ block @ own, 1e-300)))

    def _cancelled(self, fit: Fit, effect: Effect) -> float:
        """What one effect changes, over what all effects together change."""
        if len(fit.effects) == 1:
            return 1.0
        f = self.fitter
        rest = [(e, v) for e, v in zip(fit.effects, fit.values, strict=True) if e is not effect]
        without = f.predict([e for e, _ in rest], [v for _, v in rest], fit.offsets)
        own = (f.output - fit.residual) - without
        whole = self.search.bare.residual - fit.residual
        return float(np.std(f.centred_on(f.used, own))) / max(float(np.std(f.centred_on(f.used, whole))), 1e-30)

    def _time_is_open(self, fit: Fit, effect: Effect) -> bool:
        """Whether the event explains the run as well at a time far from the fitted one."""
        f, k = self.fitter, fit.effects.index(effect)
        at = next(i for i, p in enumerate(effect.parameters) if p.role == "place")
        low, high = effect.parameters[at].low, effect.parameters[at].high
        for time in np.linspace(low, high, TIMES):
            if abs(time - fit.values[k][at]) < AWAY * (high - low):
                continue
            values = [v.copy() for v in fit.values]
            values[k][at] = time
            residual = f.centred(f.output - f.predict(fit.effects, values, fit.offsets), f.train)
            moved = replace(fit, values=tuple(values), residual=residual, square=float(np.mean(residual[f.train] ** 2)))
            if self.alike(moved, fit):
                return True
        return False

    def _not_generic(
        self, fit: Fit, groups: tuple[Group, ...], unknown: Unknown | None
    ) -> tuple[Fit, tuple[Group, ...], Unknown | None]:
        """Withdraw names of load and speed if one generic regressor explains more than one, or as much as several; and
        waves and bows that have by chance the phase at which they look like one."""
        fit, groups, unknown = self._not_by_chance(fit, groups, unknown)
        mistaken = [group for group in groups if group.effect.generic]
        if not mistaken:
            return fit, groups, unknown
        kept = tuple(group for group in groups if group not in mistaken)
        effects = [group.effect for group in kept]
        values = [fit.values_of(effect) for effect in effects]
        for regressor in regressors(all(p.load_Nm is not None for p in self.fitter.runs)):
            trial = self.fitter.tried((*effects, regressor), (*values, [0.0]), fit.offsets)
            if trial is None:
                continue
            better = trial.square < fit.square and not self.alike(fit, trial)
            if better or (len(mistaken) > 1 and self.alike(trial, fit)):
                less = self.fitter.fit(effects, values, fit.offsets)
                return less, kept, self.left(less) or unknown
        return fit, groups, unknown

    def _not_beside_more(
        self, fit: Fit, groups: tuple[Group, ...], unknown: Unknown | None
    ) -> tuple[Fit, tuple[Group, ...], Unknown | None]:
        """Withdraw names beside a larger error that does not repeat and is no sensor's noise, since it hangs on load,
        time, place or speed: they may resemble a part of its cause.
        """
        noise, f = self.search.noise, self.fitter
        if unknown is not None or not groups or not noise.far_above:
            return fit, groups, unknown
        explained = self._without_all(fit, groups) ** 2 - self.search.held_rms(fit) ** 2
        if noise.coloured_rad**2 < explained or not any(
            hangs_on(p, fit.residual[part]) for p, part in zip(f.runs, f.parts, strict=True)
        ):
            return fit, groups, unknown
        for group in groups:
            self.search.give_back("beside a larger error that hangs on more", group.effect, fit)
        less = reduce(self.search.without, (g.effect for g in groups), fit)
        return less, (), self.largest(less, f)

    def _not_by_chance(
        self, fit: Fit, groups: tuple[Group, ...], unknown: Unknown | None
    ) -> tuple[Fit, tuple[Group, ...], Unknown | None]:
        """Withdraw names of two sizes where a plain curve of one explains the run as well: on a sine the square of the
        speed is a parabola of the angle. All directions of the two sizes are equally likely before.
        """
        for group in groups:
            members = [group.effect, *(one.effects[-1] for one in group.alike)]
            if any([p.role for p in member.parameters] != ["size", "size"] for member in members):
                continue
            rest = [e for e in fit.effects if e is not group.effect]
            values = [fit.values_of(e) for e in rest]
            likely = log(self._phase_likelihood(fit, group.effect))
            for regressor in regressors(all(p.load_Nm is not None for p in self.fitter.runs)) if likely < 0.0 else ():
                trial = self.fitter.tried((*rest, regressor), (*values, [0.0]), fit.offsets)
                if trial is None or self._failed(trial, fit) or log_odds(self.fitter, trial, fit) + likely >= 0.0:
                    continue
                less = self.search.give_back(f"by chance like the {regressor.form}", group.effect, fit)
                return less, tuple(one for one in groups if one is not group), self.left(less) or unknown
        return fit, groups, unknown

    def shift_by_window(self, fit: Fit) -> list[Floats]:
        """Change of every parameter of the search's fit with the smoothing windows; as many arrays as effects."""
        most = [np.zeros_like(v) for v in fit.values]
        for factor in WINDOWS:
            other = self.fitter.rewindowed(factor)
            try:
                again = other.fit(fit.effects, fit.values, fit.offsets, iterations=2, slopes=fit.jacobian, fresh=False)
            except ModelError:  # with less smoothing noise may slacken a cable that is nearly slack
                continue
            most = [np.maximum(m, np.abs(a - b)) for m, a, b in zip(most, again.values, fit.values, strict=True)]
        return most

    def shift_by_shape(self, fit: Fit) -> list[Floats]:
        """The same with other shapes of laws that these runs do not tell from those of the fit."""
        most = [np.zeros_like(v) for v in fit.values]
        for effect, shape in [(e, shape) for e in fit.effects if e.shapes for shape in e.shapes()]:
            effects = [shape if one is effect else one for one in fit.effects]
            again = self.fitter.tried(effects, fit.values, fit.offsets)
            if again is not None and (again.square <= fit.square or self.alike(again, fit)):
                most = [np.maximum(m, np.abs(a - b)) for m, a, b in zip(most, again.values, fit.values, strict=True)]
        return most
