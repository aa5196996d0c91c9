"""The loop from measured runs to the finding: residual, search, alternatives, verdict, error before and after."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.correction import correction_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import friction, library
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare_all
from mbcdm_cad.loop.result import Evidence, Helpful, LoopResult, Named, Noise, doubt_of, runs_of
from mbcdm_cad.loop.search import account
from mbcdm_cad.loop.search.by_evidence import CredibleSet, Posterior, Search
from mbcdm_cad.loop.search.evidence import LEAST_FALL, LOG_ODDS
from mbcdm_cad.loop.search.few import judged_by_hand
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.own import begun, differing, in_best_forms, own_effects
from mbcdm_cad.loop.search.response import ResponseLoop
from mbcdm_cad.loop.search.screening import located
from mbcdm_cad.loop.search.selection import LISTED
from mbcdm_cad.loop.search.unknown import Unknown, describe_unknown, hangs_on
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


# A name is withdrawn beside a certain unknown part of this share of what it explains, which may contain it.
BLAME_SHARE = 0.25
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
        self.bare = self.fitter.fit(offsets=begun(self.fitter))
        self.search = Search(self.fitter, self.library, self.bare)
        self.posterior: Posterior = self.search
        self.bare_whole = self.bare

    def result(self) -> LoopResult:
        """Search, withdraw, describe on all samples of the runs at hand."""
        fit, sets = self.search.found()
        kept, withdrawn = self._withdrawn(fit)
        self._on_all()
        whole = self._fitted_on_all(fit)
        judged = whole if kept is fit else self._fitted_on_all(kept)
        self._weigh_about(whole)
        named: list[Named] = []
        one_of: list[tuple[Named, ...]] = []
        outright: list[Effect] = []
        unmeasured: list[str] = []
        for one in sets:
            members = [one.effect, *(other.effects[-1] for other, _ in one.alike)]
            if one.effect not in kept.effects:
                continue
            if any(member.unmeasured for member in members):
                # A quantity that the runs did not measure explains the error as well.
                withdrawn.append((one.effect, fit))
                unmeasured += [f"{member.name} ({member.form})" for member in members]
                continue
            first = self._named(one.effect, fit, whole)
            alike = (*one.forms, *self._looks_like(first))
            first = replace(first, equivalent=alike, probability=one.probability)
            others = tuple(replace(self._other(other), probability=share) for other, share in one.alike)
            if others:
                one_of.append((first, *others))
            else:
                named.append(first)
                outright.append(one.effect)
        named = self._with_correlations(named, outright, whole)
        floor_rad = self.search.floor_rad
        after = self.posterior.beside_nuisances(judged)
        found = account.errors(self.whole, self.bare_whole, after, floor_rad)
        certain = self.search.of(kept).unknown_odds > LOG_ODDS
        left = certain and self.search.unknown_rad(kept) > LEAST_FALL * floor_rad
        groups = named or one_of
        # An error above the floor that certainly does not repeat is none beside what was found.
        rest = not found.near_floor and not (groups and self.search.of(kept).unknown_odds < -LOG_ODDS)
        unknown = self._largest(after) if left or rest else None
        if unknown is not None:
            verdict = "partly_explained" if groups else "unknown"
        else:
            blind = all(p.few for p in self.prepared) or unmeasured
            verdict = "explained" if groups else "not_testable" if blind else "none"
        rms, screened = self.search.held_rms(kept), self.search.screening.screen(kept)
        declared = float(np.sqrt(np.mean([p.floor_rad**2 for p in self.prepared])))
        noise = account.stated(self.search.white.noise, declared)
        return LoopResult(
            verdict,
            tuple(named),
            tuple(one_of),
            unknown,
            found,
            tuple(self._alternatives(sets)),
            tuple(account.left_out(s.effect.label, rms, s.fall, floor_rad) for s in screened[:LISTED]),
            account.not_testable(self.d, self.prepared),
            account.next_steps(named, one_of, unknown),
            account.chain_orders(self.d, self.ratio),
            account.traces(self.whole, self.bare_whole, after),
            noise,
            tuple(p.windows for p in self.prepared),
            self._doubts(noise, kept, unmeasured),
            tuple(self._helpful(effect, at) for effect, at in withdrawn),
            within_class=self.search.within_words(kept),
            correction=partial(correction_of, self.whole, judged, floor_rad),
            own=differing(self.whole, judged, self.posterior.with_offsets(judged), self.differs),
        )

    def _withdrawn(self, fit: Fit) -> tuple[Fit, list[tuple[Effect, Fit]]]:
        """The fit without effects that are too small to name, or that a certain unknown part may contain; and those of
        them that are not too small, each with the fit that had it."""
        search, taken = self.search, list[tuple[Effect, Fit]]()
        least_rad = LEAST_FALL * search.floor_rad
        while fit.effects:
            certain = search.of(fit).unknown_odds > LOG_ODDS
            needed = max(least_rad, search.unknown_rad(fit) / BLAME_SHARE if certain else 0.0)
            falls = {effect: search.fall_rad(search.without(fit, effect), fit) for effect in fit.effects}
            # Of those that do too little that goes without which the rest is likeliest.
            less = {effect: search.without(fit, effect) for effect in fit.effects if falls[effect] < needed}
            if not less:
                break
            out, rest = max(less.items(), key=lambda pair: search.score(pair[1]))
            if falls[out] >= least_rad:
                taken.append((out, fit))
            fit = rest
        return fit, taken

    def _on_all(self) -> None:
        """Weigh all samples of the runs at hand under the noise of the search."""
        if self.whole is not self.fitter:
            self.bare_whole = self.whole.fit(offsets=self.bare.offsets)
        self.posterior = Posterior(self.whole, self.bare_whole, self.search.names)
        self._weigh_about(self.bare_whole)

    def _weigh_about(self, fit: Fit) -> None:
        """Take nuisances that are linear about a fit: intervals have what windows and sensors do to what was found."""
        problem = self.posterior.problem
        noise = replace(self.search.white.noise, step_s=problem.step_s, starts=problem.starts)
        self.posterior.weigh(noise, problem.nuisances_of(fit))

    def _fitted_on_all(self, fit: Fit) -> Fit:
        """A fit of the search, with all samples of the runs at hand."""
        if self.whole is self.fitter:
            return fit
        if not fit.effects:
            return self.bare_whole
        begun = fit
        if any(effect.once for effect in fit.effects):
            # A single event may lie in a part that the search did not use. Of two, one may hide the time of the other.
            begun = located(self.whole, fit) or fit
        unknown = self.search.of(fit).unknown
        return self.posterior.fitted(unknown, begun.effects, begun.values, begun.offsets)

    def _largest(self, fit: Fit) -> Unknown:
        """The unexplained part of the run in which it is largest."""
        pairs = zip(self.whole.parts, self.whole.runs, strict=True)
        each = (describe_unknown(p, fit.residual[part], self.search.floor_rad) for part, p in pairs)
        return max(each, key=lambda one: one.rms_rad)

    def _helpful(self, effect: Effect, fit: Fit) -> Helpful:
        """An effect that was withdrawn beside an unknown part, with the odds of its fit."""
        less, own = self.search.without(fit, effect), fit.columns_of(effect)
        fall, block = self.search.fall_rad(less, fit), self.search.of(fit).covariance
        odds = float(np.exp(np.clip(self.search.score(fit) - self.search.score(less), 0, 50)))
        return Helpful(self._as_named(effect, fit.values_of(effect), block[own, own], fall), odds)

    def _looks_like(self, named: Named) -> list[str]:
        """Of a friction the parts that these runs do not tell from it."""
        if named.name != friction.NAME:
            return []
        loads = [p.load_Nm for p in self.prepared if p.load_Nm is not None]
        speed = np.concatenate([p.speed_rad_s for p in self.prepared])
        return friction_alike(speed, np.concatenate(loads) if len(loads) == len(self.prepared) else None)

    def _named(self, effect: Effect, fit: Fit, whole: Fit) -> Named:
        """An effect with its figures from all data, nuisances integrated out, and the fall of the error that it
        causes."""
        k, own = whole.effects.index(effect), whole.columns_of(effect)
        block = self.posterior.of(whole).covariance[own, own]
        fall = self.search.fall_rad(self.search.without(fit, effect), fit)
        share = self._least_share(whole, k)
        if share is None:
            named = self._as_named(effect, whole.values_of(effect), block, fall)
            return self._before_and_after(named, effect, whole, self.whole) if effect.base else named
        named = self._as_named(effect, _scaled(effect, whole.values[k], share), block, fall)
        opened = {name: replace(value, low=value.value, high=np.inf) for name, value in named.parameters.items()}
        return replace(named, parameters=opened)

    def _with_correlations(self, named: Sequence[Named], effects: Sequence[Effect], whole: Fit) -> list[Named]:
        """The named effects, each with the correlations of its values with each other and with those of the others."""
        covariance = self.posterior.of(whole).covariance
        size = np.sqrt(np.where(np.diag(covariance) > 0.0, np.diag(covariance), np.inf))
        joint = covariance / np.outer(size, size)
        columns = [whole.columns_of(effect) for effect in effects]
        return [
            replace(one, correlated={o.words: joint[columns[k], columns[j]] for j, o in enumerate(named)})
            for k, one in enumerate(named)
        ]

    def _before_and_after(self, named: Named, effect: Effect, whole: Fit, fitter: Fitter) -> Named:
        """A change with the interval of its time, and its figure before and after; ``whole`` is a fit of ``fitter``."""
        base = effect.base
        values = whole.values_of(effect)
        assert base is not None
        parameters = dict(named.parameters)
        if effect.once:
            low, high = account.time_interval_s(fitter, whole, effect, self.search.white.noise)
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
        columns = fit.columns_of(effect)
        block = self.search.of(fit).covariance[columns, columns]
        named = self._as_named(effect, fit.values_of(effect), block, 0.0)
        open_ = {
            p.name: replace(own, low=p.low, high=np.inf)
            for p in effect.parameters
            if p.low == 0.0 and (own := named.parameters.get(p.name)) and own.low < 0.0 and own.high > ANY * own.value
        }
        named = replace(named, parameters={**named.parameters, **open_})
        return self._before_and_after(named, effect, fit, self.fitter) if effect.base else named

    def _as_named(self, effect: Effect, values: Floats, block: Floats, fall: float) -> Named:
        run = "" if effect.run is None else self.prepared[effect.run].run.source or f"run {effect.run + 1}"
        return account.as_named(effect, values, block, fall, run)

    def _doubts(self, noise: Noise, fit: Fit, unmeasured: Sequence[str]) -> tuple[str, ...]:
        """Doubts that the data raise about the sensors, and about fitted values that no part can have."""
        found = []
        if noise.far_above:
            pairs = zip(self.fitter.runs, self.fitter.parts, strict=True)
            each = (hangs_on(p, fit.residual[part]) for p, part in pairs)
            scatter = next((one for one in each if one is not None), None)
            found.append(scatter.words if scatter else doubt_of(noise, runs_of(self.prepared)))
        if unmeasured:
            found.append(
                f"no torque was measured: {' or '.join(unmeasured)} would explain the error as well as the "
                "load itself; log the load's torque, or run without a load and say load: none"
            )
        return (*found, *self.search.doubts.values())

    def _alternatives(self, sets: Sequence[CredibleSet[Fit]]) -> Iterator[Evidence]:
        """Named effects and what may stand in their place, each with its share of the posterior."""
        for one in sets:
            for fit, share in one.alike:
                words = f"in place of {one.effect.label}: probability {share:.2g}, of that {one.probability:.2g}"
                yield Evidence(fit.effects[-1].label, self.search.held_rms(fit), 0.0, words)


def _scaled(effect: Effect, values: Floats, share: float) -> Floats:
    """Values of an effect with its sizes multiplied by ``share``; places and orders stay."""
    sizes = np.array([parameter.role == "size" for parameter in effect.parameters])
    return np.asarray(np.where(sizes, share, 1.0) * values)
