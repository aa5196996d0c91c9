"""The effects that a planned run may show: how each changes the prediction, and from which size it is named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.effects.load_sensor import UNPLANNED, within_class
from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.prepare.quiet import signal_noise
from mbcdm_cad.loop.search.exchange import ALIKE_SHARE
from mbcdm_cad.loop.search.fit import DIFFERENCE, Fit, Fitter
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.measurement.run import MOTORS_CURRENT, Run
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.power import Draws, Shown, draws_of, shown, smallest, worst_phase
from mbcdm_cad.planning.prediction_noise import along, friction_errors
from mbcdm_cad.routes import Floats

# t^2 (1 - rho) from which a wrong choice between two effects is less likely than 1 %.
TOLD_STRENGTH = 10.9
# Orders of ripple that are planned, cycles a turn of the output.
ORDERS = (20.0, 200.0)
# What an offset may explain, and how an effect that strains the cables shows, hang on the size, and the size on both.
# The size is searched in such steps of its logarithm, and found to within this share: in a few rounds where the effect
# shows much the same at any size, else by bisection. A size that shows nothing, or with which a cable is slack, counts
# as so far off.
STEP, SETTLED, FEW, FAR = 0.5, 0.01, 3, 20.0
# An effect that would have to be so many times its typical size, or beyond its bound, is never seen in the run.
NEVER = 1e4


@dataclass(frozen=True, eq=False)
class Tried:
    """One effect at the place ``at``.

    ``plain`` (n, k): derivatives by its sizes on all samples; ``columns``: on the used samples without what offsets
    explain; ``basis``: orthonormal, of these. ``counted``: number of independent samples that the noise leaves along
    them, ``unit``: the RMS that one unit of the size causes at the phase that shows least. ``shown``: None if the run
    shows nothing of it.
    """

    effect: Effect
    label: str
    at: Floats
    plain: Floats
    columns: Floats
    basis: Floats
    counted: float
    unit: float
    shown: Shown | None

    @property
    def size_index(self) -> int:
        """Index of its first size among the parameters."""
        return _sizes(self.effect)[0]

    def likeness(self, other: Tried) -> float:
        """Cosine of this effect and another, at the phases at which they are most alike."""
        return min(1.0, float(np.linalg.svd(self.basis.T @ other.basis, compute_uv=False)[0]))

    def apart_within(self, other: Tried, reach: float) -> float:
        """RMS over the floor from which this effect is separated from another that can do no more than ``reach``.

        What the other cannot imitate is the part that is unlike it, and what is beyond its reach of the part that is
        like it.
        """
        alike, most = self.likeness(other), self.apart(other)
        needed = np.sqrt(TOLD_STRENGTH / self.counted)

        def left(strength: float) -> float:
            beyond = max(0.0, strength * alike - reach)
            return float(np.hypot(strength * np.sqrt(max(1.0 - alike, 0.0)), beyond) - needed)

        return most if left(most) <= 0.0 else float(brentq(left, 0.0, most))

    def apart(self, other: Tried) -> float:
        """RMS over the floor from which this effect is separated from another."""
        alike = self.likeness(other)
        left = max(1.0 - alike, 1e-12)
        least = ALIKE_SHARE / np.sqrt(max(1.0 - alike**2, 1e-12))
        return float(max(np.sqrt(TOLD_STRENGTH / left / self.counted), least))


class PlannedEffects:
    """The effects of the library on one planned run with such a noise."""

    def __init__(self, fitter: Fitter, bare: Fit, noise: Noise) -> None:
        self.fitter, self.bare, self.noise = fitter, bare, noise
        p = fitter.runs[0]
        signals = noise.signals or signal_noise(p.run)
        if not signals.load_Nm:  # a pilot run without a torque sensor says nothing of the noise of one
            signals = replace(signals, load_Nm=signal_noise(p.run).load_Nm)
        self.draws: Draws = draws_of(noise, p, bare.jacobian[fitter.used], friction_errors(fitter, bare, signals))
        offered = [effect for effect in library(fitter.d, p) if not effect.inside and effect.base is None]
        self.offered = [effect for effect in offered if effect.name not in UNPLANNED]
        self.tried = [found for effect in self.offered for found in self._tried(effect)]
        # What a load from motors' currents may be wrong by is as good an explanation as an effect, within its bound.
        allowed = p.run.sensors.torque_class
        within = within_class((p,)) if allowed.what == MOTORS_CURRENT else []
        self.within = [(found, effect.parameters[0].high) for effect in within for found in self._tried(effect)]

    def sizes(self, one: Tried, power: float) -> tuple[float, float]:
        """The positive and the negative size from which an effect is named with this power, by its name or in a set;
        infinite where the run cannot show it, equal where the sign makes no difference.

        Another effect that differs from it by less than the loop tells apart, at the least size, may be accepted in its
        place: then it is exchanged for the better of the two, or both are in a set.
        """
        if one.shown is None:
            return np.inf, np.inf
        phase = worst_phase(one.columns)
        start = smallest([one.shown.itself(one.columns @ phase, one.shown.length * phase)], power)
        if not np.isfinite(start):
            return np.inf, np.inf
        rivals = [
            other.shown
            for other in self.tried
            if other is not one and other.shown and np.sqrt(1.0 - one.likeness(other) ** 2) < ALIKE_SHARE / LEAST_FALL
        ]
        positive = self._size(one, rivals, power, 1.0, start)
        both = self._bent(one) and one.effect.parameters[one.size_index].low < 0.0
        return positive, self._size(one, rivals, power, -1.0, start) if both else positive

    def _size(self, one: Tried, rivals: Sequence[Shown], power: float, sign: float, start: float) -> float:
        """Size of one sign, searched from ``start`` on; infinite if no part can have it.

        An effect of one size that strains the cables is taken at that size and not by its derivative: a low preload
        shows more than a high one.
        """
        parameter = one.effect.parameters[one.size_index]
        limit = min(parameter.high if sign > 0.0 else -parameter.low, NEVER * parameter.size)

        @cache
        def beyond(logarithm: float) -> float:
            """Logarithm of the size that is named if the effect shows as at this size, over this size."""
            at, plain, slopes = float(np.exp(logarithm)), one.plain, one.plain
            if self._bent(one):
                try:
                    plain, slopes = self._at(one, sign * at)
                except ModelError:  # a cable is slack: far more than has to be shown
                    return -FAR
            columns, local = np.split(
                without_offsets(self.fitter, self.bare, np.hstack([plain, slopes]), self.noise, at), 2, axis=1
            )
            own = self._shown(one.effect, local)
            if own is None:
                return FAR
            phase = sign * worst_phase(columns)
            change = columns @ phase
            ways = [own.itself(change, own.length * phase), *(rival.in_place(change) for rival in rivals)]
            return min(float(np.log(smallest(ways, power))) - logarithm, FAR)

        most = float(np.log(limit))
        at = min(float(np.log(start)), most)
        for _ in range(FEW):
            off = beyond(at)
            if abs(off) < SETTLED:
                return float(np.exp(at + off))
            if off > 0.0 and at == most:
                return np.inf
            at = min(at + float(np.clip(off, -STEP, STEP)), most)
        low = high = at
        while beyond(high) > 0.0:
            if high == most:
                return np.inf
            high = min(high + STEP, most)
        while beyond(low) <= 0.0:
            if low < np.log(start) - FAR:  # a cable is slack however small the effect is
                return np.inf
            low -= STEP
        found = float(brentq(beyond, low, high, xtol=SETTLED))
        # Between a size that shows too little and one with which a cable is slack there need not be one that is enough.
        return float(np.exp(found)) if abs(beyond(found)) < STEP else np.inf

    def _bent(self, one: Tried) -> bool:
        """Whether an effect has one size and strains the cables. A play at an input has no slope: it is taken as it
        shows at its usual size."""
        return len(_sizes(one.effect)) == 1 and self.fitter.kind(one.effect) == 0 and not one.effect.saturates

    def _shown(self, effect: Effect, columns: Floats) -> Shown | None:
        sizes = _sizes(effect)
        one_sign = len(sizes) == 1 and effect.parameters[sizes[0]].low >= 0.0
        return shown(columns, self.draws, len(self.offered), one_sign, effect.saturates)

    def _change(self, effect: Effect, at: Floats) -> Floats:
        """Change of the prediction by the effect, but for a constant."""
        bare = self.bare
        return np.asarray(self.fitter.predict([effect], [at], bare.offsets) - (self.fitter.output - bare.residual))

    def _tried(self, effect: Effect) -> list[Tried]:
        """The effect at each place that is planned."""
        places: Sequence[Sequence[float]] = [[0.0] * len(effect.parameters)]
        labels = [effect.label]
        if effect.order_index is not None:
            places = [[0.0] * effect.order_index + [order] for order in ORDERS]
            labels = [f"{effect.name} of order {order:g}" for order in ORDERS]
        elif any(p.role == "place" for p in effect.parameters):
            guesses = effect.first_guesses(self.fitter.base[0], self.bare.residual)
            places = [guesses[len(guesses) // 2]]
        found = []
        for place, label in zip(places, labels, strict=True):
            at = np.array(place, dtype=float)
            try:
                plain = self._derivatives(effect, at)
            except ModelError:
                continue
            columns = without_offsets(self.fitter, self.bare, plain, self.noise)
            spread = max(along(column, self.noise, self.fitter.runs[0].step_s) for column in columns.T)
            unit = float(np.linalg.svd(columns, compute_uv=False)[-1]) / np.sqrt(columns.shape[0])
            counted, basis = columns.shape[0] / spread, np.linalg.qr(columns)[0]
            way = self._shown(effect, columns)
            found.append(Tried(effect, label, at, plain, columns, basis, counted, unit, way))
        return found

    def _at(self, one: Tried, size: float) -> tuple[Floats, Floats]:
        """Change over its size, and derivative by the size, of an effect of this one size, (n, 1) each."""
        changes = []
        for share in (1.0, 1.0 + DIFFERENCE):
            moved = one.at.copy()
            moved[one.size_index] += share * size
            changes.append(self._change(one.effect, moved))
        return (changes[0] / size)[:, None], ((changes[1] - changes[0]) / (DIFFERENCE * size))[:, None]

    def _derivatives(self, effect: Effect, at: Floats) -> Floats:
        """Changes by one unit of each size, (n, k)."""
        sizes, rows = _sizes(effect), []
        before = self._change(effect, at) if at[sizes].any() else 0.0
        for k in sizes:
            moved = at.copy()
            moved[k] += effect.parameters[k].size
            rows.append((self._change(effect, moved) - before) / effect.parameters[k].size)
        return np.stack(rows, axis=1)


def planned_fitter(drive: Drive, run: Run) -> Fitter:
    """The fitter of one run, measured or planned."""
    d = layout_of(drive).si
    ratio = float(np.mean(d.total_ratio))
    return Fitter(d, ratio, [prepare(arranged(run, drive), ratio)[0]], drive.as_built)


def _sizes(effect: Effect) -> list[int]:
    """Indices of the parameters that are sizes."""
    return [k for k, parameter in enumerate(effect.parameters) if parameter.role == "size"]


def without_offsets(fitter: Fitter, bare: Fit, columns: Floats, noise: Noise, size: float = 0.0) -> Floats:
    """Changes of the prediction (n, k) on all used samples, as the loop sees them: less their mean over the training
    samples, and less what the offsets between the input encoders explain there of so many times the columns.

    An offset is known before the run: it is within its limit, as likely here as there, of a variance of a third of the
    limit squared. Where that moves the prediction by less than the noise, it explains nothing; and never more than its
    limit does.
    """
    train, used, p = fitter.train, fitter.used, fitter.runs[0]
    columns = fitter.centred(columns, train)
    known = fitter.centred(bare.jacobian, train)
    if known.shape[1]:
        own, limit = known[train], fitter.limit[fitter.free]
        noises = [along(row, noise, p.step_s) * noise.total_rad**2 for row in own.T]
        drawn = np.diag(3.0 * np.array(noises) / limit**2)
        offsets = np.linalg.solve(own.T @ own + drawn, own.T @ columns[train])
        wanted = np.maximum(size * np.linalg.norm(offsets, axis=1), 1e-30 * limit)
        columns = columns - known @ (offsets * np.minimum(1.0, limit / wanted)[:, None])
    return np.asarray(columns[used])
