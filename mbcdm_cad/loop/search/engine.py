"""The loop from measured runs to the finding: residual, search, alternatives, verdict, error before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.correction import correction_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import friction, library
from mbcdm_cad.loop.prepare.noise import doubt_of, runs_of
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare_all
from mbcdm_cad.loop.readable import INTERVAL
from mbcdm_cad.loop.result import Evidence, Helpful, LoopResult, Named
from mbcdm_cad.loop.search.account import (
    as_named,
    chain_orders,
    errors,
    next_steps,
    not_testable,
    time_interval_s,
    traces,
)
from mbcdm_cad.loop.search.exchange import Group
from mbcdm_cad.loop.search.few import judged_by_hand
from mbcdm_cad.loop.search.fit import Fit, Fitter, Rows
from mbcdm_cad.loop.search.own import begun, differing, in_best_forms, own_effects
from mbcdm_cad.loop.search.response import ResponseLoop
from mbcdm_cad.loop.search.screening import located
from mbcdm_cad.loop.search.select import Search
from mbcdm_cad.loop.search.unknown import Scatter, hangs_on
from mbcdm_cad.loop.search.verdict import ZERO_CHANCE, Judge
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.schema import FREQUENCY_RESPONSE, MOTION
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.measurement.vet_signals import friction_alike
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    from mbcdm_cad.design.blocks import AsBuilt
    from mbcdm_cad.design.drive import Drive

# If an effect so many times as large changes the prediction by no more than this share of the floor (RMS), the data
# give only a lower bound of its size.
LARGER, UNCHANGED_SHARE = 1.5, 0.1
# In more runs than these a change is not looked for within each: what differs from run to run is told by a study.
MOST_EVENTFUL = 6
# This bound is searched in steps by the first factor, down to the least share of the fitted size, then to within the
# last factor.
FIRST_STEP, LEAST_SHARE, LEAST_STEP = 16.0, 1e-12, 1.05


def close_loop(drive: Drive | None, runs: Sequence[Run], differs: Sequence[Sequence[str]] = ()) -> LoopResult:
    """Find what the declared model of ``drive`` lacks in ``runs`` (one or more of the same drive, sharing the effects).

    ``drive`` None: only the ratio of the runs is known. Nothing of the drive or the runs is changed. ``differs``: for
    each run the fields of the design, or the effects, of which it has values of its own.
    """
    d = None if drive is None else layout_of(drive).si
    ratio = float(runs[0].ratio or 1.0) if d is None else float(np.mean(d.total_ratio))
    with threadpool_limits(1, "blas"):
        ready = runs if drive is None else [arranged(run, drive) for run in runs]
        known = () if drive is None else drive.as_built
        if runs[0].kind == FREQUENCY_RESPONSE:
            return ResponseLoop(drive, ratio, ready).result()
        if runs[0].kind != MOTION:
            return judged_by_hand(d, ratio, ready, known)
        prepared = prepare_all(ready, ratio)
        result = _Loop(d, ratio, prepared, known, differs).result()
        return result if drive is None else friction.beside_design(result, drive)


# What is too small to be named is in the figures of what is named: so much of it, RMS over the floor, each parameter
# may stand for. Found on runs of the rig.
UNNAMED_SHARE = 0.03
# A size that may be zero or so many times as large is open.
ANY = 3.0


class _Loop:
    """One pass of the loop: it searches on the shortened run that ``prepare`` returns, and judges on the whole run."""

    def __init__(
        self,
        d: DriveSI | None,
        ratio: float,
        prepared: Sequence[tuple[Prepared, Prepared]],
        known: Sequence[AsBuilt],
        differs: Sequence[Sequence[str]] = (),
    ) -> None:
        self.d, self.ratio = d, ratio
        self.prepared = tuple(part for part, _ in prepared)
        self.known, self.differs = tuple(known), tuple(differs)
        offered = [library(d, p) for p in self.prepared]
        forms = [
            own_effects(names, one, p.run.source)
            for names, one, p in zip(self.differs or [()] * len(offered), offered, self.prepared, strict=True)
        ]
        own = in_best_forms(d, ratio, self.prepared, forms)
        self.fitter = Fitter(d, ratio, self.prepared, self.known, own)
        cut = any(part is not whole for part, whole in prepared)
        self.whole = Fitter(d, ratio, [whole for _, whole in prepared], self.known, own) if cut else self.fitter
        labels = [{e.label for e in one} for one in offered]
        self.library = [e for e in offered[0] if all(e.label in one for one in labels)]
        if len(offered) > 1:
            # What happened once happened in one of the runs; what drifts in one drifts in all.
            events = [replace(e, run=k) for k, one in enumerate(offered) for e in one if e.once]
            if len(offered) > MOST_EVENTFUL:
                events = [e for e in events if e.base is None]
            self.library = [e for e in self.library if not e.once] + events
        # What every run has for itself is not shared; and a change within a run is not looked for beside it.
        everywhere = set.intersection(*({e.label for e in one} for one in own))
        self.library = [e for e in self.library if e.label not in everywhere and not (any(own) and e.base)]
        # The same motion as a play that motion takes up: the search has one, the judge puts the other beside it.
        wound = next((e for e in self.library if (e.name, e.form) == (friction.NAME, friction.WOUND)), None)
        self.library = [e for e in self.library if e is not wound]
        self.bare = self.fitter.fit(offsets=begun(self.fitter))
        self.search = Search(self.fitter, self.library, self.bare)
        self.judge = Judge(self.search, wound)

    def result(self) -> LoopResult:
        """Search, try alternatives, judge."""
        fit, groups, unknown = self.judge.judged()
        while True:
            bare, judged = self._on_all(fit)
            if judged is not fit:
                unknown = unknown or self.judge.left(judged, self.whole)
            whole = self.whole.fit(
                judged.effects,
                judged.values,
                judged.offsets,
                rows=Rows(self.whole.used),
                slopes=judged.jacobian,
                fresh=False,
            )
            windows = self._wider(fit, whole) if groups else []
            open_ = next((g for g in groups if self._may_be_zero(g.effect, fit, whole, windows)), None)
            if open_ is None:
                break
            fit, groups, unknown = self.judge.taken_back(open_, fit, groups)
        if unknown is not None and groups:
            windows = self._wider(fit, whole, unknown.rms_rad)
        named, sets = [], []
        for group in groups:
            first = self._named(group.effect, fit, whole, windows)
            first = replace(first, equivalent=(*group.forms, *self._looks_like(first)))
            others = tuple(self._other(one) for one in group.alike)
            if others:
                sets.append((first, *others))
            else:
                named.append(first)
        named = self._with_correlations(named, [g.effect for g in groups if not g.alike], whole, fit, windows)
        found = errors(self.whole, bare, judged, self.search.floor_rad)
        # Neither "explained" nor "none" may stand beside an error that is not near the floor.
        if unknown is None and not found.near_floor:
            unknown = self.judge.largest(judged, self.whole)
        nameless = not groups and not self.judge.unmeasured and not self.judge.within and not self.judge.helpful
        if nameless and judged is not bare:
            judged, found = bare, errors(self.whole, bare, bare, self.search.floor_rad)
            if unknown is None and not found.near_floor:
                unknown = self.judge.largest(bare, self.whole)
        scatter = self._scatter(fit)
        if unknown is not None:
            verdict = "partly_explained" if groups or judged.effects else "unknown"
        else:
            blind = all(p.few for p in self.prepared) or self.judge.unmeasured
            verdict = "explained" if groups else "not_testable" if blind else "none"
        return LoopResult(
            verdict,
            tuple(named),
            tuple(sets),
            unknown,
            found,
            self._evidence(groups, fit),
            self._small(fit),
            not_testable(self.d, self.prepared),
            next_steps(named, sets, unknown),
            chain_orders(self.d, self.ratio),
            traces(self.whole, bare, judged),
            self.search.noise,
            tuple(p.windows for p in self.prepared),
            self._doubts(scatter),
            tuple(
                Helpful(self._as_named(one.effect, one.values, one.covariance, one.fall_rad), one.odds)
                for one in self.judge.helpful
            ),
            within_class=self.judge.within.sentence if self.judge.within else "",
            correction=partial(correction_of, self.whole, judged, self.search.floor_rad),
            own=differing(
                self.whole, whole, self.judge.covariance(whole, self.whole), (self.fitter, fit), self.differs
            ),
        )

    def _on_all(self, fit: Fit) -> tuple[Fit, Fit]:
        """Fits without effects and with those of ``fit``, with all samples of the runs at hand."""
        if self.whole is self.fitter:
            return self.bare, fit
        found = self.whole.fit(fit.effects, fit.values, fit.offsets)
        if any(effect.once for effect in fit.effects):
            # A single event may lie in a part that the search did not use. Of two, one may hide the time of the other.
            found = min(filter(None, (found, located(self.whole, fit))), key=lambda one: one.square)
        return self.whole.fit(offsets=self.bare.offsets), found

    def _may_be_zero(self, effect: Effect, fit: Fit, whole: Fit, windows: Sequence[Floats]) -> bool:
        """Whether the interval of an effect's size, from all data, contains zero."""
        if effect.saturates:
            return False
        shift = windows[fit.effects.index(effect)]
        return self.judge.chance_of_zero(whole, effect, shift, self.whole) > ZERO_CHANCE

    def _looks_like(self, named: Named) -> list[str]:
        """Of a friction the parts that these runs do not tell from it."""
        if named.name != friction.NAME or self.judge.unmeasured:
            return []
        loads = [p.load_Nm for p in self.prepared if p.load_Nm is not None]
        speed = np.concatenate([p.speed_rad_s for p in self.prepared])
        return friction_alike(speed, np.concatenate(loads) if len(loads) == len(self.prepared) else None)

    def _named(self, effect: Effect, fit: Fit, whole: Fit, windows: Sequence[Floats]) -> Named:
        """An effect with its figures from all data and the fall of the held-out error that it causes."""
        k = whole.effects.index(effect)
        block = self.judge.spread(whole, effect, self.whole) + np.diag((windows[k] / INTERVAL) ** 2)
        fall = self.judge.fall_rad(fit, effect)
        share = self._least_share(whole, k)
        if share is None:
            named = self._as_named(effect, whole.values[k], block, fall)
            return self._before_and_after(named, effect, whole, self.whole) if effect.base else named
        named = self._as_named(effect, _scaled(effect, whole.values[k], share), block, fall)
        opened = {name: replace(value, low=value.value, high=np.inf) for name, value in named.parameters.items()}
        return replace(named, parameters=opened)

    def _wider(self, fit: Fit, whole: Fit, unknown_rad: float = 0.0) -> list[Floats]:
        """By how much the interval of each value of the search's fit is wider than its scatter, to either side: other
        smoothing windows, other shapes of laws, what is too small to be named, and an unknown part, rad RMS, of which
        a fit hides as much in the values as it leaves."""
        unnamed = np.diag(self._unnamed(whole)) * (1.0 + (unknown_rad / (UNNAMED_SHARE * self.search.floor_rad)) ** 2)
        parts = (self.judge.shift_by_window(fit), self.judge.shift_by_shape(fit))
        return [
            np.sqrt(one**2 + other**2 + INTERVAL**2 * unnamed[whole.columns_of(effect)])
            for effect, one, other in zip(fit.effects, *parts, strict=True)
        ]

    def _unnamed(self, whole: Fit) -> Floats:
        """Covariance of the values of a fit by effects that are in the run and too small to be named.

        They are slow in angle, load and speed, so that a line does not stand for them.
        """
        lines = [whole.columns_of(effect) for effect in whole.effects if effect.order_index is not None]
        slow = whole.has_slope
        for own in lines:
            slow[own] = False
        kept = np.flatnonzero(slow)
        columns = self.whole.centred_on(self.whole.used, whole.jacobian[:, kept])
        size = np.sqrt(np.mean(columns**2, axis=0))
        size[size == 0.0] = 1.0
        scaled = columns / size
        inverse = np.linalg.pinv(scaled.T @ scaled / scaled.shape[0], rcond=1e-9, hermitian=True)
        found = np.zeros((whole.jacobian.shape[1],) * 2)
        found[np.ix_(kept, kept)] = (UNNAMED_SHARE * self.search.floor_rad) ** 2 * inverse / np.outer(size, size)
        return found

    def _with_correlations(
        self, named: Sequence[Named], effects: Sequence[Effect], whole: Fit, fit: Fit, windows: Sequence[Floats]
    ) -> list[Named]:
        """The named effects, each with the correlations of its values with each other and with those of the others.

        What smoothing windows and shapes add to the variance of each value, as in its interval, is taken as its own.
        """
        unnamed = self._unnamed(whole)
        covariance = self.judge.covariance(whole, self.whole) + unnamed - np.diag(np.diag(unnamed))
        for effect in effects:
            own = np.arange(covariance.shape[0])[whole.columns_of(effect)]
            covariance[own, own] += (windows[fit.effects.index(effect)] / INTERVAL) ** 2
        known = np.isfinite(covariance) & np.isfinite(np.diag(covariance)) & np.isfinite(np.diag(covariance))[:, None]
        covariance = np.where(known, covariance, 0.0)
        size = np.sqrt(np.where(np.diag(covariance) > 0.0, np.diag(covariance), np.inf))
        joint = covariance / np.outer(size, size)
        columns = [whole.columns_of(effect) for effect in effects]
        found = []
        for k, one in enumerate(named):
            found.append(replace(one, correlated={o.words: joint[columns[k], columns[j]] for j, o in enumerate(named)}))
        return found

    def _before_and_after(self, named: Named, effect: Effect, whole: Fit, fitter: Fitter) -> Named:
        """A change with the interval of its time, and its figure before and after; ``whole`` is a fit of ``fitter``."""
        base, values = effect.base, whole.values_of(effect)
        assert base is not None
        parameters = dict(named.parameters)
        if effect.once:
            low, high = time_interval_s(fitter, whole, effect)
            parameters["at_s"] = replace(parameters["at_s"], low=low, high=high)
        there = [whole.values_of(e) for e in whole.effects if (e.key, e.form) == (base.key, base.form)]
        before = there[0] if there else np.array([p.default or 0.0 for p in base.parameters])
        after = before.copy()
        after[0] = (1.0 + before[0]) * (1.0 + values[0]) - 1.0 if named.is_share else before[0] + values[0]
        figure = (base.physical or base.reported())[0]
        physical = {f"before_{figure.name}": figure.of(before), f"after_{figure.name}": figure.of(after)}
        last = self._as_named(base, after, np.zeros((after.size, after.size)), named.fall_rad)
        size = base.parameters[0].name
        half = 0.5 * (named.parameters[size].high - named.parameters[size].low)
        known = {size: replace(last.parameters[size], low=after[0] - half, high=after[0] + half)}
        return replace(named, parameters=parameters, physical=physical, after=replace(last, parameters=known))

    def _least_share(self, whole: Fit, k: int) -> float | None:
        """The least share of a fitted size with which an effect does the same, if a larger size changes nothing: a
        pulley may never reach the other flank of its play. Else None."""
        effect = whole.effects[k]
        if not effect.saturates or self._changes(whole, k, LARGER):
            return None
        low, high = 1.0, 1.0
        while low > LEAST_SHARE and not self._changes(whole, k, low):
            low, high = low / FIRST_STEP, low
        while high > low * LEAST_STEP:
            middle = float(np.sqrt(low * high))
            low, high = (middle, high) if self._changes(whole, k, middle) else (low, middle)
        return high

    def _changes(self, whole: Fit, k: int, share: float) -> bool:
        """Whether an effect of ``share`` times its fitted size changes the prediction noticeably."""
        values = list(whole.values)
        values[k] = _scaled(whole.effects[k], values[k], share)
        change = self.whole.output - self.whole.predict(whole.effects, values, whole.offsets) - whole.residual
        used = self.whole.used
        return bool(np.std(self.whole.centred_on(used, change)) >= UNCHANGED_SHARE * self.search.floor_rad)

    def _other(self, fit: Fit) -> Named:
        """An alternative that fits as well, from the training samples."""
        effect = fit.effects[-1]
        named = self._as_named(effect, fit.values[-1], self.judge.spread(fit, effect, self.fitter), 0.0)
        open_ = {
            p.name: replace(own, low=p.low, high=np.inf)
            for p in effect.parameters
            if p.low == 0.0 and (own := named.parameters.get(p.name)) and own.low < 0.0 and own.high > ANY * own.value
        }
        named = replace(named, parameters={**named.parameters, **open_})
        return self._before_and_after(named, effect, fit, self.fitter) if effect.base else named

    def _as_named(self, effect: Effect, values: Floats, block: Floats, fall: float) -> Named:
        run = "" if effect.run is None else self.prepared[effect.run].run.source or f"run {effect.run + 1}"
        return as_named(effect, values, block, fall, run)

    def _scatter(self, fit: Fit) -> Scatter | None:
        """On what the noise hangs that the encoders are not declared to have."""
        if not self.search.noise.far_above:
            return None
        each = (hangs_on(p, fit.residual[part]) for p, part in zip(self.fitter.runs, self.fitter.parts, strict=True))
        return next((one for one in each if one is not None), None)

    def _doubts(self, scatter: Scatter | None) -> tuple[str, ...]:
        """Doubts that the data raise about the sensors, and about fitted values that no part can have."""
        noise = self.search.noise
        found = []
        if noise.far_above:
            found.append(scatter.words if scatter else doubt_of(noise, runs_of(self.prepared)))
        if self.judge.unmeasured:
            found.append(
                f"no torque was measured: {' or '.join(self.judge.unmeasured)} would explain the error as well as the "
                "load itself; log the load's torque, or run without a load and say load: none"
            )
        return (*found, *self.search.doubts.values())

    def _evidence(self, groups: Sequence[Group], fit: Fit) -> tuple[Evidence, ...]:
        """Candidates that were accepted or withdrawn, and alternatives to the named effects."""
        lines = [
            Evidence(s.effect.label, s.after_rad, float(np.sqrt(abs(s.before_rad**2 - s.after_rad**2))), s.action)
            for s in self.search.steps
        ]
        for group in groups:
            for one in group.alike:
                apart = self.judge.apart(one, fit)
                words = f"as good as {group.effect.label}" + ("" if apart.apart else f": {apart.words}")
                lines.append(Evidence(one.effects[-1].label, self.search.held_rms(one), 0.0, words))
        return tuple(lines)

    def _small(self, fit: Fit, most: int = 5) -> tuple[Evidence, ...]:
        """Candidates that are too small to name, with the fall of the error that each would still cause."""
        rms = self.search.held_rms(fit)
        return tuple(
            Evidence(s.effect.label, rms, float(np.sqrt(max(0.0, s.fall))), "too small to name")
            for s in self.search.screening.screen(fit)[:most]
        )


def _scaled(effect: Effect, values: Floats, share: float) -> Floats:
    """Values of an effect with its sizes multiplied by ``share``; places and orders stay."""
    sizes = np.array([parameter.role == "size" for parameter in effect.parameters])
    return np.asarray(np.where(sizes, share, 1.0) * values)
