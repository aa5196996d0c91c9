"""From measured runs to what the model lacks: residual, search, who else would do, verdict, error before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t as t_distribution
from threadpoolctl import threadpool_limits

from mbcdm_cad.identification.account import INTERVAL, chain_orders, errors, interval, next_steps, not_testable, traces
from mbcdm_cad.identification.clusters import TOLD_APART, Estimate, Separation, cluster_estimate, separation
from mbcdm_cad.identification.effect import Effect
from mbcdm_cad.identification.effects import library
from mbcdm_cad.identification.fit import Fit, Fitter
from mbcdm_cad.identification.generic import regressors
from mbcdm_cad.identification.prepared import Prepared, prepare
from mbcdm_cad.identification.result import Evidence, LoopResult, Named
from mbcdm_cad.identification.select import LEAST_FALL, Search
from mbcdm_cad.identification.unknown import Unknown, describe_unknown
from mbcdm_cad.measurement.run import Floats, Run
from mbcdm_cad.measurement.sweeps import smoothed
from mbcdm_cad.model.si import DriveSI, to_si

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import AsBuilt, Drive

# Two candidates are alike where the one that does better could be the wrong one (see ``separable``), where their errors
# differ by less than this many standard errors over the cells of sweep and sector, or by less than this share of the
# floor in quadrature: so small a difference may be the model's own.
ALIKE_ERRORS = 2.0
ALIKE_SHARE = 0.12
# A name is not given where what stays unexplained is as large as this share of what the name explains.
BLAME_SHARE = 0.35
# Windows that the intervals are told over: the difference's smoothing, halved and doubled.
WINDOWS = (0.5, 2.0)
SLOW_S = 0.3


def close_loop(drive: Drive | None, runs: Sequence[Run]) -> LoopResult:
    """Find what the declared model of ``drive`` lacks in ``runs`` (one or more of the same drive, sharing the effects).

    ``drive`` None: only the ratio of the runs is known. Nothing of the drive or the runs is changed.
    """
    d = None if drive is None else to_si(drive)
    ratio = float(runs[0].ratio or 1.0) if d is None else float(np.mean(d.total_ratio))
    with threadpool_limits(1, "blas"):
        prepared = [prepare(run, ratio) for run in runs]
        return _Loop(d, ratio, prepared, () if drive is None else drive.as_built).result()


@dataclass(frozen=True, eq=False)
class _Group:
    """One effect of the final fit and those that would do as well."""

    effect: Effect
    alike: tuple[Fit, ...]


class _Loop:
    """One pass of the loop: searched on the part of each run that ``prepare`` gives first, judged on the whole."""

    def __init__(
        self, d: DriveSI | None, ratio: float, prepared: Sequence[tuple[Prepared, Prepared]], known: Sequence[AsBuilt]
    ) -> None:
        self.d, self.ratio = d, ratio
        self.prepared = tuple(part for part, _ in prepared)
        self.known = tuple(known)
        self.fitter = Fitter(d, ratio, self.prepared, self.known)
        cut = any(part is not whole for part, whole in prepared)
        self.whole = Fitter(d, ratio, [whole for _, whole in prepared], self.known) if cut else self.fitter
        offered = [library(d, p) for p in self.prepared]
        labels = [{e.label for e in one} for one in offered]
        self.library = [e for e in offered[0] if all(e.label in one for one in labels)]
        self.bare = self.fitter.fit()
        self._estimates: dict[Fit, Estimate] = {}
        self.floor_rad = self._floor()
        self.search = Search(self.fitter, self.library, self.floor_rad, self.bare)

    def _floor(self) -> float:
        """Noise floor: what the sensors are declared to do, else what the residual has beyond slow change."""
        declared = [p.floor_rad for p in self.prepared]
        if all(f > 0.0 for f in declared):
            return float(np.sqrt(np.mean(np.square(declared))))
        fast = np.concatenate(
            [
                self.bare.residual[part] - smoothed(self.bare.residual[part], 0.1, p.step_s)
                for part, p in zip(self.fitter.parts, self.prepared, strict=True)
            ]
        )
        return float(np.sqrt(np.mean(fast[self.fitter.used] ** 2))) or 1e-12

    def result(self) -> LoopResult:
        """Search, swap, judge."""
        fit, groups = self._settled()
        unknown = self._left(fit)
        if unknown is not None:
            fit, groups, unknown = self._unblamed(fit, groups, unknown)
        fit, groups, unknown = self._not_generic(fit, groups, unknown)
        judged, bare = fit, self.bare
        if self.whole is not self.fitter:
            bare = self.whole.fit(offsets=self.bare.offsets)
            judged = self._located(fit)
            unknown = unknown or self._left(judged, self.whole)
        whole = self.whole.fit(
            judged.effects, judged.values, judged.offsets, mask=self.whole.used, slopes=judged.jacobian, fresh=False
        )
        named, sets = [], []
        windows = self._shift_by_window(fit) if groups else []
        for group in groups:
            first = self._named(group.effect, fit, whole, windows)
            others = tuple(self._other(one) for one in group.alike)
            if others:
                sets.append((first, *others))
            else:
                named.append(first)
        if unknown is not None:
            verdict = "partly_explained" if groups else "unknown"
        else:
            verdict = "explained" if groups else "not_testable" if all(p.few for p in self.prepared) else "none"
        return LoopResult(
            verdict,
            tuple(named),
            tuple(sets),
            unknown,
            errors(self.whole, bare, judged, self.floor_rad),
            self._evidence(groups, fit),
            self._small(fit),
            not_testable(self.d, self.prepared),
            next_steps(named, sets, unknown),
            chain_orders(self.d, self.ratio),
            traces(self.whole, bare, judged),
        )

    def _located(self, fit: Fit) -> Fit:
        """The search's fit on the whole of the runs; what happened once may lie where the search saw nothing."""
        values = list(fit.values)
        for k, effect in enumerate(fit.effects):
            if not effect.once:
                continue
            rest = [j for j in range(len(values)) if j != k]
            less = self.whole.fit([fit.effects[j] for j in rest], [values[j] for j in rest], fit.offsets, fresh=False)
            guess = np.array(effect.first_guesses(self.whole.base[0], less.residual[self.whole.parts[0]])[0])
            values[k] = np.where(guess != 0.0, guess, values[k])
        return self.whole.fit(fit.effects, values, fit.offsets)

    # --- selection -------------------------------------------------------------------------------------------------
    def _settled(self) -> tuple[Fit, tuple[_Group, ...]]:
        """The search's fit, after every effect was tried against the others of its looks."""
        fit = self.search.forward()
        for _ in range(4):
            groups, better = [], None
            for effect in fit.effects:
                others = self.search.alternatives(fit, effect)
                if others and others[0].square < fit.square and not self._alike(fit, others[0]):
                    better = others[0]
                    break
                alike = [o for o in others if self._alike(o, fit)]
                better = next((o for o in alike if self._coincidence(o, o.effects[-1], fit, effect)), None)
                if better is not None:
                    break
                alike = [o for o in alike if not self._coincidence(fit, effect, o, o.effects[-1])]
                groups.append(_Group(effect, self._by_name(alike, effect)))
            if better is None:
                return fit, tuple(groups)
            fit = better
        return fit, tuple(groups)

    @staticmethod
    def _by_name(fits: Sequence[Fit], effect: Effect) -> tuple[Fit, ...]:
        """The best fit of each name other than the effect's own."""
        best: dict[object, Fit] = {}
        for one in fits:
            key = one.effects[-1].key
            if key != effect.key and (key not in best or one.square < best[key].square):
                best[key] = one
        return tuple(best.values())

    def _coincidence(self, simpler: Fit, simple: Effect, fit: Fit, two: Effect) -> bool:
        """Would ``two`` of ``fit`` need its phase to fall by chance where it looks like ``simple`` of ``simpler``?

        A wave could have had any phase, alike likely. That it has that of the simpler effect to within its deviation s
        is s / sqrt(2 pi) as likely as the simpler effect itself, times the odds of the two fits (Bayes' factor).
        """
        if len(two.parameters) <= len(simple.parameters):
            return False
        values = fit.values_of(two)
        deviation = float(np.sqrt(np.diag(self._spread(fit, two, self.fitter))[:2].max()) / np.hypot(*values[:2]))
        worse, better = (simpler, fit) if fit.square < simpler.square else (fit, simpler)
        wrong = self._apart(worse, better).probability
        odds = (1.0 - wrong) / max(wrong, 1e-300) if better is fit else wrong / (1.0 - wrong)
        return bool(deviation / np.sqrt(2.0 * np.pi) * odds < TOLD_APART)

    def _apart(self, worse: Fit, better: Fit) -> Separation:
        """How well two fits are told apart."""
        used, f = self.fitter.used, self.fitter
        here = better.residual[used]
        return separation(-here, -worse.residual[used], here, f.sweep[used], f.sector[used])

    def _alike(self, worse: Fit, better: Fit) -> bool:
        """Is the first no worse than the second, as far as sweeps and sectors can tell?"""
        used = self.fitter.used
        excess = (worse.residual**2 - better.residual**2)[used]
        # A fit that went astray is wrong in a few cells beyond all measure, which a test by their scatter would excuse.
        if float(np.mean(excess)) > max(self.floor_rad**2, float(np.mean(better.residual[used] ** 2))):
            return False
        if float(np.mean(excess)) < (ALIKE_SHARE * self.floor_rad) ** 2:
            return True
        if not self._apart(worse, better).apart:
            return True
        sweep, sector = self.fitter.sweep[used], self.fitter.sector[used]
        cell = np.unique(sweep * (int(sector.max()) + 1) + sector, return_inverse=True)[1]
        sums = np.bincount(cell, excess)
        return bool(sums.sum() < ALIKE_ERRORS * np.sqrt(np.sum(sums**2)))

    # --- what is left ----------------------------------------------------------------------------------------------
    def _left(self, fit: Fit, fitter: Fitter | None = None) -> Unknown | None:
        """What stays unexplained, where it is more than the floor allows; ``fitter`` is the search's by default."""
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
            fast = quiet - 1.5 * self.floor_rad**2
            if max(excess, fast) > (LEAST_FALL * self.floor_rad) ** 2:
                found = describe_unknown(p, r, self.floor_rad)
                # What neither repeats nor stands out of the floor is the floor.
                too_much = found.rms_rad**2 > (1.0 + LEAST_FALL**2) * self.floor_rad**2
                if (found.repeatable or too_much) and (worst is None or found.rms_rad > worst.rms_rad):
                    worst = found
        return worst

    def _excess(self, fit: Fit) -> float:
        """RMS on held-out data beyond the floor, rad."""
        return float(np.sqrt(max(0.0, self.search.held_rms(fit) ** 2 - self.floor_rad**2)))

    def _unblamed(
        self, fit: Fit, groups: tuple[_Group, ...], unknown: Unknown
    ) -> tuple[Fit, tuple[_Group, ...], Unknown]:
        """Take back names that something unknown may only resemble, the one that explains least first."""
        while groups:
            rms = self.search.held_rms(fit)
            falls = [self.search.held_rms(self.search.without(fit, g.effect)) ** 2 - rms**2 for g in groups]
            least = int(np.argmin(falls))
            if self._excess(fit) < BLAME_SHARE * np.sqrt(max(0.0, falls[least])):
                break
            fit = self.search.without(fit, groups[least].effect)
            groups = (*groups[:least], *groups[least + 1 :])
            left = self._left(fit)
            if left is None:
                return fit, groups, unknown
            unknown = left
        return fit, groups, unknown

    def _not_generic(
        self, fit: Fit, groups: tuple[_Group, ...], unknown: Unknown | None
    ) -> tuple[Fit, tuple[_Group, ...], Unknown | None]:
        """Take back names of load and speed that one generic regressor does better, or several that it equals."""
        mistaken = [group for group in groups if group.effect.generic]
        if not mistaken:
            return fit, groups, unknown
        kept = tuple(group for group in groups if group not in mistaken)
        effects = [group.effect for group in kept]
        values = [fit.values_of(effect) for effect in effects]
        for regressor in regressors(all(p.load_Nm is not None for p in self.prepared)):
            trial = self.fitter.fit((*effects, regressor), (*values, [0.0]), fit.offsets)
            better = trial.square < fit.square and not self._alike(fit, trial)
            if better or (len(mistaken) > 1 and self._alike(trial, fit)):
                less = self.fitter.fit(effects, values, fit.offsets)
                return less, kept, self._left(less) or unknown
        return fit, groups, unknown

    # --- figures ---------------------------------------------------------------------------------------------------
    def _spread(self, fit: Fit, effect: Effect, fitter: Fitter) -> Floats:
        """Covariance of one effect's parameters, scaled so that 1.96 standard deviations make a 95 % interval.

        Clustered by sweep and sector, on all samples in use.
        """
        if fit not in self._estimates:
            used = fitter.used
            columns = fitter.centred(fit.jacobian, used)[used]
            found = cluster_estimate(columns, fit.residual[used], fitter.sweep[used], fitter.sector[used])
            self._estimates[fit] = found
        estimate = self._estimates[fit]
        wider = (float(t_distribution.ppf(0.975, estimate.freedom)) / INTERVAL) ** 2
        block = estimate.covariance[fit.columns_of(effect), fit.columns_of(effect)]
        # What the data do not move at all has no interval by linear theory; it is as unknown as it is large.
        return np.asarray(wider * np.where(np.isfinite(block), block, np.max(np.abs(fit.values_of(effect))) ** 2))

    def _shift_by_window(self, fit: Fit) -> list[Floats]:
        """Change of every parameter of the search's fit with the smoothing windows; as many arrays as effects."""
        most = [np.zeros_like(v) for v in fit.values]
        for factor in WINDOWS:
            other = Fitter(self.d, self.ratio, [p.rewindowed(factor) for p in self.prepared], self.known)
            again = other.fit(fit.effects, fit.values, fit.offsets, iterations=2, slopes=fit.jacobian, fresh=False)
            most = [np.maximum(m, np.abs(a - b)) for m, a, b in zip(most, again.values, fit.values, strict=True)]
        return most

    def _named(self, effect: Effect, fit: Fit, whole: Fit, windows: Sequence[Floats]) -> Named:
        """An effect with its figures from all data and the held-out fall that it is worth."""
        k = whole.effects.index(effect)
        block = self._spread(whole, effect, self.whole) + np.diag((windows[k] / INTERVAL) ** 2)
        less = self.search.without(fit, effect)
        fall = np.sqrt(max(0.0, self.search.held_rms(less) ** 2 - self.search.held_rms(fit) ** 2))
        return self._as_named(effect, whole.values[k], block, float(fall))

    def _other(self, fit: Fit) -> Named:
        """Another that would do as well, from the training samples."""
        return self._as_named(fit.effects[-1], fit.values[-1], self._spread(fit, fit.effects[-1], self.fitter), 0.0)

    def _as_named(self, effect: Effect, values: Floats, block: Floats, fall: float) -> Named:
        figures = {figure.name: interval(figure, values, block, effect) for figure in effect.reported()}
        others = [e.form for e in self.library if e.key == effect.key and e is not effect]
        return Named(
            effect.name,
            effect.form,
            effect.stage,
            effect.cables,
            figures,
            {figure.name: figure.of(values) for figure in effect.physical},
            tuple(others),
            effect.where_to_look,
            effect.separate_by,
            effect.physics,
            fall,
            {p.name: float(v) for p, v in zip(effect.parameters, values, strict=True)},
            {figure.name: figure.meaning for figure in effect.reported() if figure.meaning},
        )

    # --- words -----------------------------------------------------------------------------------------------------
    def _evidence(self, groups: Sequence[_Group], fit: Fit) -> tuple[Evidence, ...]:
        """What was taken, given back, and stands beside the named."""
        lines = [
            Evidence(s.effect.label, s.after_rad, float(np.sqrt(abs(s.before_rad**2 - s.after_rad**2))), s.action)
            for s in self.search.steps
        ]
        for group in groups:
            for one in group.alike:
                apart = self._apart(one, fit)
                words = f"as good as {group.effect.label}" + ("" if apart.apart else f": {apart.words}")
                lines.append(Evidence(one.effects[-1].label, self.search.held_rms(one), 0.0, words))
        return tuple(lines)

    def _small(self, fit: Fit, most: int = 5) -> tuple[Evidence, ...]:
        """Candidates that were left out: what they would still take off, below the size that is named."""
        rms = self.search.held_rms(fit)
        return tuple(
            Evidence(s.effect.label, rms, float(np.sqrt(max(0.0, s.fall))), "too small to name")
            for s in self.search.screen(fit)[:most]
        )
