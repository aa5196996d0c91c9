"""Joint nonlinear least squares: effects, each run's own offsets, on the samples that are not held back.

Several runs share the effects' parameters. Each has two offsets of its own: where its output encoder counts from, and
where its input encoders count from against each other (at most a step or two).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import AsBuilt
from mbcdm_cad.loop.as_built import known_effects
from mbcdm_cad.loop.effects.base import Effect
from mbcdm_cad.loop.prepared import Prepared
from mbcdm_cad.loop.run import Floats
from mbcdm_cad.loop.setup import Setup, Simulator, declared
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI

# Counts by which the input encoders may start apart (each anywhere within one).
APART_COUNTS = 1.5
# Relative fall of the sum of squares below which a fit has settled.
SETTLED = 1e-6
# Share of a parameter's size that a finite difference steps.
DIFFERENCE = 0.1


@dataclass(frozen=True, eq=False)
class Fit:
    """A fit's outcome.

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

    def values_of(self, effect: Effect) -> Floats:
        """Fitted values of one of its effects."""
        return self.values[self.effects.index(effect)]


class Fitter:
    """Fits sets of effects to one or more runs of one drive, ``known`` effects besides (``Drive.as_built``)."""

    def __init__(
        self, d: DriveSI | None, ratio: float, runs: Sequence[Prepared], known: Sequence[AsBuilt] = ()
    ) -> None:
        self.d, self.runs = d, tuple(runs)
        self.simulate = [Simulator() for _ in self.runs]
        self.base = [declared(d, ratio, p) for p in self.runs]
        # What the built drive is known to have is part of what is declared.
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
        # Sweeps are numbered on through the runs; sectors are of one drum.
        first = np.cumsum([0, *(int(p.sweep.max()) + 2 for p in self.runs)])
        self.sweep = np.concatenate([p.sweep + start for p, start in zip(self.runs, first, strict=False)])
        self.sector = np.concatenate([p.sector for p in self.runs])
        # The offset between two inputs matters only where it strains the cables.
        strained = d is not None and d.n_inputs == 2
        self.free = np.array([strained and p.load_Nm is not None for p in self.runs])
        self.limit = np.array([APART_COUNTS * p.input_step_rad for p in self.runs])
        self._shifted: dict[tuple[int, float], Setup] = {}

    def twin(self) -> Fitter:
        """The same fitter with memories of its own, for another thread."""
        other = copy(self)
        other.simulate = [Simulator() for _ in self.runs]
        other._shifted = {}
        return other

    def setup(self, run: int, offset_rad: float) -> Setup:
        """The declared model of a run with its input encoders put apart; the same object for the same offset."""
        if offset_rad == 0.0:
            return self.base[run]
        key = (run, offset_rad)
        if key not in self._shifted:
            if len(self._shifted) > 64:
                self._shifted.clear()
            base = self.base[run]
            apart = 0.5 * offset_rad * np.array([[1.0], [-1.0]])
            self._shifted[key] = replace(base, angle_rad=base.angle_rad + apart)
        return self._shifted[key]

    def predict(self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats) -> Floats:
        """Reading of the output encoder, all runs one behind the other, up to each run's own zero."""
        out = []
        for k, simulate in enumerate(self.simulate):
            s = self.setup(k, float(offsets[k]))
            for effect, value in zip(effects, values, strict=True):
                s = effect.apply(s, value, simulate)
            out.append(simulate(s))
        return np.concatenate(out)

    def centred(self, values: Floats, mask: NDArray[np.bool_]) -> Floats:
        """Each run's mean over its masked samples taken off; ``values`` (n,) or (n, k)."""
        out = np.array(values, dtype=float)
        for part in self.parts:
            chosen = mask[part]
            out[part] -= values[part][chosen].mean(axis=0)
        return out

    def residual(
        self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats, mask: NDArray[np.bool_]
    ) -> Floats:
        """Measured less predicted, rad."""
        return self.centred(self.output - self.predict(effects, values, offsets), mask)

    def fit(
        self,
        effects: Sequence[Effect] = (),
        values: Sequence[Floats | list[float]] = (),
        offsets: Floats | None = None,
        mask: NDArray[np.bool_] | None = None,
        iterations: int = 8,
        settled: float = SETTLED,
    ) -> Fit:
        """Levenberg-Marquardt from ``values`` and ``offsets``; ``mask`` defaults to the training samples.

        A fit has settled when the sum of squares falls by less than ``settled``, relative; its Jacobian is then that of
        the step before.
        """
        mask = self.train if mask is None else mask
        now = [np.array(v, dtype=float) for v in values]
        apart = np.zeros(len(self.runs)) if offsets is None else np.array(offsets, dtype=float)
        r = self.residual(effects, now, apart, mask)
        square = float(np.mean(r[mask] ** 2))
        damping = 1e-7
        jacobian = self.jacobian(effects, now, apart)
        for _ in range(iterations):
            columns = self.centred(jacobian, mask)[mask]
            size = np.linalg.norm(columns, axis=0)
            size[size == 0.0] = 1.0
            columns /= size
            normal, slope = columns.T @ columns, columns.T @ r[mask]
            better = None
            for _ in range(6):
                step = np.linalg.solve(normal + damping * np.eye(slope.size), slope) / size
                better = self._tried(effects, now, apart, step, mask, square)
                if better is None and self.free.any() and effects:
                    # An offset that runs into its bound spoils the step of the rest: leave the offsets alone.
                    kept = slope.size - int(self.free.sum())
                    short = np.linalg.solve(normal[:kept, :kept] + damping * np.eye(kept), slope[:kept]) / size[:kept]
                    step = np.concatenate([short, np.zeros(slope.size - kept)])
                    better = self._tried(effects, now, apart, step, mask, square)
                if better is not None:
                    break
                damping = max(30.0 * damping, 1e-6)
            if better is None:
                break
            fall = (square - better[3]) / square
            now, apart, r, square = better
            damping = max(damping / 30.0, 1e-9)
            if fall < settled:
                break
            jacobian = self.jacobian(effects, now, apart)
        return Fit(tuple(effects), tuple(now), apart, r, jacobian, square)

    def _tried(
        self,
        effects: Sequence[Effect],
        values: Sequence[Floats],
        offsets: Floats,
        step: Floats,
        mask: NDArray[np.bool_],
        square: float,
    ) -> tuple[list[Floats], Floats, Floats, float] | None:
        """Values, offsets, residual and mean square after a step; None if that is no better, or cannot be simulated."""
        trial, apart = self.moved(effects, values, offsets, step)
        try:
            r = self.residual(effects, trial, apart, mask)
        except ModelError:  # a step too far: slack, or a radius gone
            return None
        found = float(np.mean(r[mask] ** 2))
        return (trial, apart, r, found) if found < square else None

    def moved(
        self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats, step: Floats
    ) -> tuple[list[Floats], Floats]:
        """Values and offsets after a step, within their bounds."""
        out, at = [], 0
        for effect, value in zip(effects, values, strict=True):
            low = [p.low for p in effect.parameters]
            high = [p.high for p in effect.parameters]
            out.append(np.clip(value + step[at : at + value.size], low, high))
            at += value.size
        apart = offsets.copy()
        apart[self.free] += step[at:]
        return out, np.clip(apart, -self.limit, self.limit)

    def jacobian(self, effects: Sequence[Effect], values: Sequence[Floats], offsets: Floats) -> Floats:
        """Derivatives of the prediction, one-sided differences; shape (n, parameters + free offsets)."""
        base = self.predict(effects, values, offsets)
        columns = []
        for k, effect in enumerate(effects):
            for i, parameter in enumerate(effect.parameters):
                changed = values[k].copy()
                step = DIFFERENCE * parameter.size
                changed[i] += step if changed[i] + step <= parameter.high else -step
                trial = [*values[:k], changed, *values[k + 1 :]]
                columns.append((self.predict(effects, trial, offsets) - base) / (changed[i] - values[k][i]))
        for run in np.flatnonzero(self.free):
            changed = offsets.copy()
            changed[run] += DIFFERENCE * self.limit[run]
            columns.append((self.predict(effects, values, changed) - base) / (changed[run] - offsets[run]))
        return np.stack(columns, axis=1) if columns else np.zeros((base.size, 0))
