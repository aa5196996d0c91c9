"""The loop from measured runs to the finding: residual, search, alternatives, verdict, error before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import bisect
from threadpoolctl import threadpool_limits

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.correction import correction_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import friction, library
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare_all
from mbcdm_cad.loop.result import Helpful, LoopResult, Named, Noise, doubt_of, runs_of, verdict_of
from mbcdm_cad.loop.search import account, few, problem, response, screening
from mbcdm_cad.loop.search.by_evidence import Posterior, Search
from mbcdm_cad.loop.search.evidence import ALIKE_SHARE, ROUNDED
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.moves import MOST_EFFECTS, told
from mbcdm_cad.loop.search.own import begun, differing, in_best_forms, own_effects
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

# If an effect so many times as large changes the prediction by no more than what is alike, the data give only a lower
# bound of its size.
LARGER = 1.5


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
            return response.ResponseLoop(drive, ratio, ready).result()
        if runs[0].kind != MOTION:
            return few.judged_by_hand(d, ratio, ready, known)
        prepared = prepare_all(ready, ratio)
        result = _Loop(d, ratio, prepared, known, differs).result()
        return result if drive is None else friction.beside_design(result, drive)


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
        self.bare = self.fitter.fit(offsets=begun(self.fitter))
        self.search = Search(self.fitter, _shared(offered, own), self.bare)
        self.posterior: Posterior = self.search
        self.bare_whole = self.bare

    def result(self) -> LoopResult:
        """Search, withdraw, describe on all samples of the runs at hand."""
        fit, withdrawn = self.search.withdrawn(self.search.found())
        sets = self.search.sets_of(fit)
        self._on_all()
        whole = self._fitted_on_all(fit)
        self._weigh_about(whole)
        # A quantity that the runs did not measure explains the error as well.
        open_ = [one for one in sets if any(member.unmeasured for member in one.members)]
        withdrawn += [(one.effect, fit) for one in open_]
        unmeasured = [f"{member.name} ({member.form})" for one in open_ for member in one.members]
        certain = [one for one in sets if one not in open_]
        named, one_of = told(certain, lambda effect: self._named(effect, fit, whole), self._other)
        named = self._with_correlations(named, [one.effect for one in certain if not one.alike], whole)
        after = self.posterior.beside_nuisances(whole)
        found = account.errors(self.whole, self.bare_whole, after, self.search.floor_rad)
        unknown = self._largest(after) if self.search.unexplained(fit) or not found.near_floor else None
        blind = all(p.few for p in self.prepared) or unmeasured
        declared = float(np.sqrt(np.mean([p.floor_rad**2 for p in self.prepared])))
        noise = account.stated(self.search.white.noise, declared)
        return LoopResult(
            verdict_of(named or one_of, unknown, not blind),
            tuple(named),
            tuple(one_of),
            unknown,
            found,
            *self.search.candidates(fit),
            account.not_testable(self.d, self.prepared),
            account.next_steps(named, one_of, unknown),
            account.chain_orders(self.d, self.ratio),
            account.traces(self.whole, self.bare_whole, after),
            noise,
            tuple(p.windows for p in self.prepared),
            self._doubts(noise, fit, unmeasured),
            tuple(self._helpful(effect, at) for effect, at in withdrawn),
            within_class=self.search.within_words(fit),
            correction=partial(correction_of, self.whole, whole, self.search.floor_rad),
            own=differing(self.whole, whole, self.posterior.with_offsets(whole), self.differs),
        )

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
            begun = screening.located(self.whole, fit) or fit
        return self.posterior.fitted(self.posterior.white.none, begun.effects, begun.values, begun.offsets)

    def _largest(self, fit: Fit) -> Unknown:
        """The unexplained part of the run in which it is largest."""
        pairs = zip(self.whole.parts, self.whole.runs, strict=True)
        noise = self.search.white.noise
        each = [
            describe_unknown(p, fit.residual[part], replace(noise, step_s=p.step_s, starts=problem.starts_of(p)))
            for part, p in pairs
        ]
        return max(each, key=lambda one: one.rms_rad)

    def _helpful(self, effect: Effect, fit: Fit) -> Helpful:
        """An effect that was withdrawn beside an unknown part, with the odds of its fit."""
        less = self.search.without(fit, effect)
        odds = float(np.exp(np.clip(self.search.score(fit) - self.search.score(less), 0, 50)))
        return Helpful(self.search.named(effect, fit, self.search.fall(fit, effect)), odds)

    def _named(self, effect: Effect, fit: Fit, whole: Fit) -> Named:
        """An effect with its figures from all data, nuisances integrated out, and the fall of the error by it."""
        k, own = whole.effects.index(effect), whole.columns_of(effect)
        block = self.posterior.of(whole).covariance[own, own]
        fall = self.search.fall(fit, effect)
        share = self._least_share(whole, k)
        if share is None:
            named = self._as_named(effect, whole.values_of(effect), block, fall)
            if effect.name == friction.NAME:
                # Parts of a friction that these runs do not tell from it.
                loads = [p.load_Nm for p in self.prepared if p.load_Nm is not None]
                speed = np.concatenate([p.speed_rad_s for p in self.prepared])
                load = np.concatenate(loads) if len(loads) == len(self.prepared) else None
                named = replace(named, equivalent=tuple(friction_alike(speed, load)))
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
        least = float(np.log(ROUNDED))

        def differs(log: float) -> float:
            return float(log == least or self._changes(whole, k, float(np.exp(log)))) - 0.5

        return float(np.exp(bisect(differs, least, 0.0, xtol=0.05)))

    def _changes(self, whole: Fit, k: int, share: float) -> bool:
        """Whether an effect of ``share`` times its fitted size changes the prediction noticeably."""
        values = list(whole.values)
        values[k] = _scaled(whole.effects[k], values[k], share)
        change = self.whole.output - self.whole.predict(whole.effects, values, whole.offsets) - whole.residual
        used = self.whole.used
        return bool(np.std(self.whole.centred_on(used, change)) >= ALIKE_SHARE * self.search.floor_rad)

    def _other(self, fit: Fit) -> Named:
        """An alternative that fits as well, from the training samples."""
        effect = fit.effects[-1]
        named = self.search.named(effect, fit, 0.0)
        return self._before_and_after(named, effect, fit, self.fitter) if effect.base else named

    def _as_named(self, effect: Effect, values: Floats, block: Floats, fall: float) -> Named:
        return account.as_named(effect, values, block, fall, self.fitter.run_name(effect))

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


def _shared(offered: Sequence[Sequence[Effect]], own: Sequence[Sequence[Effect]]) -> list[Effect]:
    """The effects that the search may name, of those ``offered`` in each run, which has ``own`` for itself."""
    labels = [{e.label for e in one} for one in offered]
    found = [e for e in offered[0] if all(e.label in one for one in labels)]
    if len(offered) > 1:
        # What happened once happened in one of the runs; what drifts in one drifts in all.
        events = [replace(e, run=k) for k, one in enumerate(offered) for e in one if e.once]
        # In so many runs what differs from run to run is told by a study.
        if len(offered) > MOST_EFFECTS:
            events = [e for e in events if e.base is None]
        found = [e for e in found if not e.once] + events
    # What every run has for itself is not shared; and a change within a run is not looked for beside it.
    everywhere = set.intersection(*({e.label for e in one} for one in own))
    return [e for e in found if e.label not in everywhere and not (any(own) and e.base)]


def _scaled(effect: Effect, values: Floats, share: float) -> Floats:
    """Values of an effect with its sizes multiplied by ``share``; places and orders stay."""
    sizes = np.array([parameter.role == "size" for parameter in effect.parameters])
    return np.asarray(np.where(sizes, share, 1.0) * values)
