"""Joint nonlinear least squares: effects, each run's own offsets, on the samples that are not held back.

Several runs share the effects' parameters. Each run has its own zero of the output encoder and its own offsets between
the input encoders (at most a step or two; one offset less than there are inputs). Where a run is declared to differ, it
has own values of some effects too: they are fitted in every fit, as the offsets are, and follow them in the same row.
"""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import known_effects
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator, declared
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

# Largest offset between two input encoders, in counts (each starts anywhere within one).
APART_COUNTS = 1.5
# Relative fall of the sum of squares below which a fit has converged.
SETTLED = 1e-6
# A step that is no better is tried again with this damping at least, over the square of a column, so many times in all.
LEAST_DAMPED, MOST_DAMPED = 0.1, 3
# Step of a finite difference, as a share of a parameter's typical size.
DIFFERENCE = 0.1
# Fields of a setup that strain the cables.
_STRAINS = ("d", "load_Nm", "path_m", "shift_rad", "play_rad")
# Bytes of changed runs that are kept in memory.
REMEMBERED_BYTES = 2**27


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a fit.

    ``residual`` (rad) and ``jacobian`` (columns: effects' parameters, then offsets) cover all samples. ``values`` holds
    one array an effect, ``offsets`` the runs' input offsets (rad), ``square`` the mean square of the residual on the
    training samples.
    """

    effects: tuple[Effect, ...]
    values: tuple[Floats, ...]
    offsets: Floats
    residual: Floats
    jacobian: Floats
    square: float

    @property
    def width(self) -> int:
        """Number of its effects' parameters: so many columns of the Jacobian come before those of the offsets."""
        return sum(v.size for v in self.values)

    def values_of(self, effect: Effect) -> Floats:
        """Fitted values of one of its effects."""
        return self.values[self.effects.index(effect)]

    def columns_of(self, effect: Effect) -> slice:
        """Columns of the Jacobian that are an effect's own."""
        k = self.effects.index(effect)
        start = sum(v.size for v in self.values[:k])
        return slice(start, start + self.values[k].size)


@dataclass(frozen=True, eq=False)
class FitRows:
    """The samples of a fit, ``mask`` of all; ``independent`` whitens errors (n, ...) of these, white without it."""

    mask: NDArray[np.bool_]
    independent: Callable[[Floats], Floats] | None = None

    def errors(self, chosen: Floats) -> Floats:
        """Independent errors of the rows."""
        return chosen if self.independent is None else self.independent(chosen)


@dataclass(frozen=True, eq=False)
class _Point:
    """The state of a fit: values, offsets, prediction and residual (rad, all samples), the independent errors of its
    rows, their mean square."""

    values: list[Floats]
    offsets: Floats
    predicted: Floats
    residual: Floats
    errors: Floats
    square: float

    @property
    def theta(self) -> Floats:
        """All values and offsets in one row."""
        return np.concatenate([*self.values, self.offsets])


def _bounded_step(normal: Floats, slope: Floats, damping: float, bounds: Floats) -> Floats:
    """The damped step of least squares, (k,), within ``bounds`` (2, k): parameters that would pass a bound stop there,
    and the others make the best of it.

    To clip the step of all would spoil it: the zero of two input encoders is bounded and resembles many effects.
    """
    step, free = np.zeros(slope.size), np.ones(slope.size, dtype=np.bool_)
    while free.any():
        inner = normal[np.ix_(free, free)] + damping * np.eye(int(free.sum()))
        step[free] = np.linalg.solve(inner, (slope - normal @ np.where(free, 0.0, step))[free])
        beyond = free & ((step < bounds[0]) | (step > bounds[1]))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, *bounds)[beyond]
        free &= ~beyond
    return step


class Fitter:
    """Fits sets of effects to runs of one drive; ``known`` effects (``Drive.as_built``) are always applied."""

    def __init__(
        self,
        d: DriveSI | None,
        ratio: float,
        runs: Sequence[Prepared],
        known: Sequence[AsBuilt] = (),
        own: Sequence[Sequence[Effect]] = (),
    ) -> None:
        """``own``: for each run the effects of which it has values for itself; empty if no run differs."""
        self.d, self.ratio, self.runs, self.known = d, ratio, tuple(runs), tuple(known)
        self.own = tuple(map(tuple, own)) or ((),) * len(self.runs)
        self.simulate = [Simulator() for _ in self.runs]
        self.base = [declared(d, ratio, p) for p in self.runs]
        # Known effects of the built drive (as_built) are part of the declared model.
        if d is not None:
            for k, p in enumerate(self.runs):
                for effect, values in known_effects(d, p, known):
                    self.base[k] = effect.apply(self.base[k], values, self.simulate[k])
        ends = np.cumsum([0, *(p.time_s.size for p in self.runs)])
        self.parts = [slice(a, b) for a, b in pairwise(ends)]
        self.output = np.concatenate([p.output_rad for p in self.runs])
        self.train = np.concatenate([p.train for p in self.runs])
        self.test = np.concatenate([p.test for p in self.runs])
        self.used = np.concatenate([p.used for p in self.runs])
        # Sweeps are numbered through all runs; sectors are shared, since the runs are of one drum.
        first = np.cumsum([0, *(int(p.sweep.max()) + 2 for p in self.runs)])
        self.sweep = np.concatenate([p.sweep + start for p, start in zip(self.runs, first, strict=False)])
        self.sector = np.concatenate([p.sector for p in self.runs])
        # The offset between two inputs matters only where it strains the cables.
        self.apart = max(1, self.runs[0].angle_rad.shape[0] - 1)
        strained = d is not None and d.n_inputs > 1
        blocks = [[p for effect in one for p in effect.parameters] for one in self.own]
        ends = np.cumsum([0, *(self.apart + len(block) for block in blocks)])
        # Offsets and own values of each run, and their bounds and typical sizes.
        self.rows = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        self.free = np.ones(int(ends[-1]), dtype=np.bool_)
        self.limit, self.size = np.full(self.free.size, np.inf), np.ones(self.free.size)
        self.least = np.full(self.free.size, -np.inf)
        for row, block, p in zip(self.rows, blocks, self.runs, strict=True):
            apart, rest = slice(row.start, row.start + self.apart), slice(row.start + self.apart, row.stop)
            self.free[apart] = strained and p.load_Nm is not None
            self.limit[apart] = self.size[apart] = self._offset_limit_rad(p)
            self.least[apart] = -self.limit[apart]
            self.least[rest], self.limit[rest] = [q.low for q in block], [q.high for q in block]
            self.size[rest] = [q.size for q in block]
        self._most = max(8, REMEMBERED_BYTES // (64 * self.output.size))
        self._changed: dict[tuple[Any, ...], Setup] = {}
        self._kinds: dict[Effect, int] = {}
        self._rewindowed: dict[float, Fitter] = {}

    @staticmethod
    def _offset_limit_rad(p: Prepared) -> float:
        """Largest offset between two input encoders: some counts, or what zeros taken from the data may be wrong by."""
        return max(APART_COUNTS * p.input_step_rad, p.run.zeros.apart_unsure_rad if p.run.zeros else 0.0)

    def run_name(self, effect: Effect) -> str:
        """Name of the only run that has an effect; empty if all have it."""
        return "" if effect.run is None else self.runs[effect.run].run.source or f"run {effect.run + 1}"

    def twin(self) -> "Fitter":
        """The same fitter with its own cache, for another thread."""
        other = copy(self)
        other.simulate = [Simulator() for _ in self.runs]
        other._changed = {}
        return other

    def rewindowed(self, factor: float) -> "Fitter":
        """The same runs, smoothed as if their noise were ``factor`` times as large; computed once."""
        if factor not in self._rewindowed:
            runs = [p.rewindowed(factor) for p in self.runs]
            self._rewindowed[factor] = Fitter(self.d, self.ratio, runs, self.known, self.own)
        return self._rewindowed[factor]

    def kind(self, effect: Effect) -> int:
        """What an effect changes in a run: 0 the strain of the cables, 1 their winding, 2 only the reading."""
        if effect not in self._kinds:
            run = 0 if effect.run is None else effect.run
            before = self.base[run]
            after = effect.apply(before, np.array([p.size for p in effect.parameters]), self.simulate[run])
            strain = any(getattr(before, n) is not getattr(after, n) for n in _STRAINS)
            history = after.winding != before.winding or after.creep != before.creep
            self._kinds[effect] = 0 if strain else 1 if history else 2
        return self._kinds[effect]

    def setup(self, run: int, row: Floats) -> Setup:
        """The declared model of a run with offsets between neighbouring input encoders, rad, and its own values."""
        setup = self.base[run]
        for index in np.flatnonzero(row[: self.apart]):
            half = np.full(setup.p.time_s.size, 0.5 * row[index])
            setup = setup.with_shift(int(index), half).with_shift(int(index) + 1, -half)
        at = self.apart
        for effect in self.own[run]:
            values, at = row[at : at + len(effect.parameters)], at + len(effect.parameters)
            setup = effect.apply(setup, values, self.simulate[run])
        return setup

    def guesses(self, effect: Effect, residual: Floats) -> list[list[float]]:
        """Values from which the fit of an effect starts; ``residual`` (rad) covers all samples of all runs."""
        run = 0 if effect.run is None else effect.run
        return effect.first_guesses(self.base[run], residual[self.parts[run]])

    def predict(self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats) -> Floats:
        """Reading of the output encoder, all runs one after the other, without each run's zero.

        Effects that strain the cables are applied first and cached, so that those that only change the reading need no
        simulation.
        """
        order = sorted(zip(effects, values, strict=True), key=lambda pair: self.kind(pair[0]))
        return np.concatenate([self._of_run(k, order, offsets) for k in range(len(self.runs))])

    def _of_run(self, k: int, order: Sequence[tuple[Effect, Floats]], offsets: Floats) -> Floats:
        """The reading of one run; ``order``: effects and values, those that strain the cables first."""
        simulate, own = self.simulate[k], offsets[self.rows[k]]
        key: tuple[Any, ...] = (k, own.tobytes())
        s = self._remembered(key, lambda: self.setup(k, own))
        for effect, value in order:
            if any((one.key, one.form) == (effect.key, effect.form) for one in self.own[k]):
                continue
            if effect.run is not None and effect.run != k:
                # What changed stays so in the runs that follow, which are given in the order of time.
                if effect.later is not None and k > effect.run:
                    s = effect.later(s, value, simulate)
                continue
            if self.kind(effect) == 2:
                s = effect.apply(s, value, simulate)
                continue
            key = (*key, effect, value.tobytes())
            s = self._remembered(key, lambda s=s, e=effect, v=value: e.apply(s, v, simulate))  # type: ignore[misc]
        return simulate(s)

    def _remembered(self, key: tuple[Any, ...], make: Callable[[], Setup]) -> Setup:
        if key not in self._changed:
            while len(self._changed) >= self._most:
                del self._changed[next(iter(self._changed))]
            self._changed[key] = make()
        return self._changed[key]

    def centred(self, values: Floats, mask: NDArray[np.bool_]) -> Floats:
        """``values`` (n,) or (n, k) with each run's mean over its masked samples subtracted."""
        out = np.array(values, dtype=float)
        for part in self.parts:
            chosen = mask[part]
            out[part] -= values[part][chosen].mean(axis=0)
        return out

    def centred_on(self, mask: NDArray[np.bool_], values: Floats) -> Floats:
        """``values`` (n,) or (n, k) on the masked samples, each run's mean over them subtracted."""
        chosen = [values[part][mask[part]] for part in self.parts]
        return np.concatenate([one - one.mean(axis=0) for one in chosen])

    def fit(
        self,
        effects: Sequence[Effect] = (),
        values: Sequence[Floats | list[float]] = (),
        offsets: Floats | None = None,
        rows: FitRows | None = None,
        iterations: int = 8,
        settled: float = SETTLED,
        slopes: Floats | None = None,
        fresh: bool = True,
    ) -> Fit:
        """Levenberg-Marquardt from ``values`` and ``offsets``; ``rows`` default to the training samples.

        The Jacobian is taken by differences once, or given as ``slopes`` from a fit near by, and is then updated by the
        changes that each step made (Broyden's update). A fit has converged when the relative fall of the sum of squares
        is below ``settled``; with ``fresh`` this must hold with a Jacobian computed at that point. Without it a fit is
        good enough to rank candidates, but not to judge them.
        """
        rows = rows or FitRows(self.train)
        apart = np.zeros(self.free.size) if offsets is None else np.array(offsets, dtype=float)
        now = self._at(effects, [np.array(v, dtype=float) for v in values], apart, rows)
        taken = slopes is None
        jacobian = self.jacobian(effects, now) if slopes is None else slopes
        damping = 1e-7
        for _ in range(iterations):
            following, damping = self._stepped(effects, now, jacobian, damping, rows, settled)
            fall = 0.0 if following is None else (now.square - following.square) / now.square
            if following is not None:
                jacobian = self._updated(jacobian, now, following)
                now = following
            if fall < settled:
                if taken or not fresh:
                    break
                jacobian, damping, taken = self.jacobian(effects, now), 1e-7, True
        if fresh and not taken:
            jacobian = self.jacobian(effects, now)
        return Fit(tuple(effects), tuple(now.values), now.offsets, now.residual, jacobian, now.square)

    def tried(self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats) -> Fit | None:
        """A fit of a candidate that may make the drive impossible; None if it cannot be simulated at its start."""
        try:
            return self.fit(effects, values, offsets)
        except ModelError:
            return None

    def _at(self, effects: Sequence[Effect], values: list[Floats], offsets: Floats, rows: FitRows) -> _Point:
        predicted = self.predict(effects, values, offsets)
        residual = self.centred(self.output - predicted, rows.mask)
        errors = rows.errors(residual[rows.mask])
        return _Point(values, offsets, predicted, residual, errors, float(np.mean(errors**2)))

    def _stepped(
        self, effects: Sequence[Effect], now: _Point, jacobian: Floats, damping: float, rows: FitRows, settled: float
    ) -> tuple[_Point | None, float]:
        """A better point, or None, and the damping for the next step.

        None also where the step promises less than the fall at which a fit has ``settled``: a simulation is not worth
        its time.
        """
        if now.square == 0.0:  # the prediction is already exact, as for a drum that stands still
            return None, damping
        columns = rows.errors(self.centred_on(rows.mask, jacobian))
        size = np.linalg.norm(columns, axis=0)
        size[size == 0.0] = 1.0
        columns /= size
        normal, slope = columns.T @ columns, columns.T @ now.errors
        bounds = self._bounds(effects, now) * size
        for _ in range(MOST_DAMPED):
            step = np.linalg.solve(normal + damping * np.eye(slope.size), slope)
            promised = float(2.0 * slope @ step - step @ normal @ step) / (now.square * now.errors.size)
            if promised < settled:
                return None, damping
            if ((step < bounds[0]) | (step > bounds[1])).any():
                step = _bounded_step(normal, slope, damping, bounds)
            better = self._tried(effects, now, step / size, rows)
            if better is not None:
                return better, max(damping / 30.0, 1e-9)
            damping = max(30.0 * damping, LEAST_DAMPED)
        return None, damping

    def _bounds(self, effects: Sequence[Effect], at: _Point) -> Floats:
        """The least and the greatest step of each value and free offset that stays within its bounds, (2, k)."""
        own = [p for effect in effects for p in effect.parameters]
        low = np.concatenate([[p.low for p in own], self.least[self.free]])
        high = np.concatenate([[p.high for p in own], self.limit[self.free]])
        theta = np.concatenate([*at.values, at.offsets[self.free]])
        return np.stack([low - theta, high - theta])

    def _tried(self, effects: Sequence[Effect], now: _Point, step: Floats, rows: FitRows) -> _Point | None:
        """The point after a step; None if that is no better, or cannot be simulated."""
        try:
            found = self._at(effects, *self.moved(effects, now.values, now.offsets, step), rows)
        except ModelError:  # the step is too large: a cable is slack or a radius negative
            return None
        return found if found.square < now.square else None

    def _updated(self, jacobian: Floats, before: _Point, after: _Point) -> Floats:
        """The Jacobian updated by the change that a step made, in units in which all columns have similar size."""
        kept = np.concatenate([np.ones(sum(v.size for v in before.values), dtype=np.bool_), self.free])
        size = np.linalg.norm(jacobian, axis=0)
        size[size == 0.0] = 1.0
        step = (after.theta - before.theta)[kept] * size
        length = float(step @ step)
        if length == 0.0:
            return jacobian
        miss = after.predicted - before.predicted - (jacobian / size) @ step
        return jacobian + np.outer(miss / length, step * size)

    def moved(
        self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats, step: Floats
    ) -> tuple[list[Floats], Floats]:
        """Values and offsets after a step, within their bounds."""
        out, at = [], 0
        for effect, value in zip(effects, values, strict=True):
            low, high = np.array([(p.low, p.high) for p in effect.parameters]).T
            out.append(np.clip(value + step[at : at + value.size], low, high))
            at += value.size
        apart = offsets.copy()
        apart[self.free] += step[at:]
        return out, np.clip(apart, self.least, self.limit)

    def jacobian(self, effects: Sequence[Effect], at: _Point) -> Floats:
        """Derivatives of the prediction by one-sided differences, (n, parameters + free offsets); rounding is none."""
        values, offsets, base = at.values, at.offsets, at.predicted
        columns = []
        for k, effect in enumerate(effects):
            for i, parameter in enumerate(effect.parameters):
                changed = values[k].copy()
                step = DIFFERENCE * parameter.size
                changed[i] += step if changed[i] + step <= parameter.high else -step
                change = self.predict(effects, [*values[:k], changed, *values[k + 1 :]], offsets) - base
                shown = np.abs(change).max() > change.size * np.finfo(float).eps * np.abs(base).max()
                columns.append(change / (changed[i] - values[k][i]) * shown)
        order = sorted(zip(effects, values, strict=True), key=lambda pair: self.kind(pair[0]))
        for k in np.flatnonzero(self.free).tolist():
            run = next(n for n, row in enumerate(self.rows) if k < row.stop)
            changed, part = offsets.copy(), self.parts[run]
            changed[k] += DIFFERENCE * self.size[k]
            columns.append(np.zeros(base.size))
            columns[-1][part] = (self._of_run(run, order, changed) - base[part]) / (changed[k] - offsets[k])
        return np.stack(columns, axis=1) if columns else np.zeros((base.size, 0))
