"""What a run of one kind gives the search: data, prediction and Jacobian, nuisances, curves of an unknown cause, noise.

The search and its evidence know nothing else of a run. :class:`LogProblem` is that of a log of a motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from mbcdm_cad.loop.effects.load_sensor import within_class, within_prior
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.marginal import NoiseModel, Whitened, noise_model
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

# Knots of the unknown curves over angle, load and speed; coarse and fine, so that a smooth curve is the likelier one.
ANGLE_KNOTS, LOAD_KNOTS, SPEED_KNOTS = (4, 8, 16, 32), (5, 9), (6,)
# How far an unknown law of the load that is nearly proportional to it is from that, as a share.
PROPORTIONAL = 0.2
# Candidates without which the noise is found, of which the largest are tried; odds from which one is taken out.
MOST_TRIED, LOG_CERTAIN = 4, float(np.log(99.0))
# Windows of the smoothing as if the noise were so many times as large: two standard deviations apart.
OTHER_WINDOWS = (0.5, 2.0)


@dataclass(frozen=True, eq=False)
class Nuisance:
    """What a bench may be wrong by: the change of the prediction (n,), rad, for one standard deviation, of which it is
    ``most`` at most. ``of_class``: a sensor within its class, or a figure of the design within its own."""

    name: str
    column: Floats
    most: float = 2.0
    of_class: bool = False


class LogProblem:
    """Logs of one or more runs of one drive; rows are the samples in use."""

    def __init__(self, fitter: Fitter, bare: Fit) -> None:
        self.fitter, self.bare = fitter, bare
        self.used = fitter.used
        # Width of the prior of every size: what it does may be as large as the whole error.
        self.prior_rad = max(float(np.std(bare.residual[self.used])), 1e-9)
        self.step_s = min(p.step_s for p in fitter.runs)
        self.least_rad = max(p.floor_rad for p in fitter.runs)

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """First rows of stretches of samples that follow each other."""
        each = zip(self.fitter.parts, self.fitter.runs, strict=True)
        number = [np.arange(part.start, part.stop) + 1e9 * k + 1e6 * _stretch(p) for k, (part, p) in enumerate(each)]
        return (0, *(np.flatnonzero(np.diff(np.concatenate(number)[self.used]) != 1.0) + 1).tolist())

    @cached_property
    def nuisances(self) -> tuple[Nuisance, ...]:
        """Sensors within their class, the design's figures within theirs, offsets of the inputs, windows of the
        smoothing, and each run's zero."""
        f, bare = self.fitter, self.bare
        base = f.output - bare.residual
        found = []
        for effect in (*within_class(f.runs), *within_prior(f.runs)):
            # Two standard deviations are the bound of a class.
            try:
                moved = f.predict([effect], [np.array([0.5 * effect.parameters[0].high])], bare.offsets)
            except ModelError:
                continue
            found.append(Nuisance(effect.name, f.centred(moved - base, f.used), of_class=True))
        for factor in OTHER_WINDOWS:
            try:
                moved = f.rewindowed(factor).predict([], [], bare.offsets)
            except ModelError:  # with less smoothing noise may slacken a cable that is nearly slack
                continue
            found.append(Nuisance(f"smoothing, noise times {factor:g}", 0.5 * f.centred(moved - base, f.used)))
        for column, limit in zip(bare.jacobian.T, f.limit[f.free], strict=True):
            size = float(np.std(column[self.used]))
            sigma = min(limit / np.sqrt(3.0), 10.0 * self.prior_rad / max(size, 1e-30))
            found.append(Nuisance("offset of the inputs, or an own value", sigma * column, limit / sigma))
        for part in f.parts:
            ones = np.zeros(f.output.size)
            ones[part] = 1e3 * self.prior_rad
            found.append(Nuisance("zero of the output", ones, np.inf))
        return tuple(found)

    @cached_property
    def nuisance_columns(self) -> Floats:
        """Columns of the nuisances on the rows."""
        return np.stack([one.column[self.used] for one in self.nuisances], axis=1)

    @cached_property
    def curves(self) -> tuple[Floats, ...]:
        """What an unknown cause may do, by families: (n, k) each, RMS 1 together.

        Curves of angle, of load and of speed, all at once and by sense of motion; smooth ones of angle alone, fine ones,
        smooth ones by sense; those of load alone, also nearly proportional to it. A simple unknown cause is as likely as a name only if it does not
        pay for what it does not do.
        """
        smooth, fine = ANGLE_KNOTS[:2], ANGLE_KNOTS
        families = [
            [
                *self._hats("angle", fine, True),
                *self._hats("load", LOAD_KNOTS, True),
                *self._hats("speed", SPEED_KNOTS),
            ],
            self._hats("angle", smooth),
            self._hats("angle", fine),
            self._hats("angle", smooth, True),
            self._hats("load", LOAD_KNOTS, True),
        ]
        found = [unit for family in families if (unit := self._unit(family)).size]
        torque = self._of("load")
        if families[-1] and torque is not None:
            load = self._unit([torque])
            found.append(np.column_stack([load, PROPORTIONAL * self._unit(families[-1])]))
        return tuple(found)

    def _unit(self, family: Sequence[Floats]) -> Floats:
        """Columns (n, k) of RMS 1 together, those that vary."""
        columns = np.stack(family, axis=1) if family else np.zeros((int(self.used.sum()), 0))
        columns = columns - columns.mean(axis=0)
        size = np.sqrt(np.mean(columns**2, axis=0))
        kept = size > 1e-6
        return np.asarray(columns[:, kept] / size[kept] / np.sqrt(kept.sum())) if kept.any() else np.zeros((0, 0))

    def _of(self, name: str) -> Floats | None:
        """Angle, load or speed of all runs, None if it was not measured."""
        name = {"angle": "output_rad", "load": "load_Nm", "speed": "speed_rad_s"}[name]
        values = [getattr(p, name) for p in self.fitter.runs]
        if any(v is None for v in values):
            return None
        return np.concatenate([v[p.used] for v, p in zip(values, self.fitter.runs, strict=True)])

    def _hats(self, of: str, numbers: Sequence[int], by_sense: bool = False) -> list[Floats]:
        """Hats (n,) over angle, load or speed of all runs, of each number of knots."""
        at = self._of(of)
        if at is None:
            return []
        hats = [hat for knots in numbers for hat in _hats(at, knots)]
        if not by_sense:
            return hats
        onward = np.concatenate([p.speed_rad_s[p.used] for p in self.fitter.runs]) >= 0.0
        return [hat * sense for hat in hats for sense in (onward, ~onward)]

    @cached_property
    def _flexible(self) -> Floats:
        """Orthonormal basis of nuisances and curves, which no noise is taken from."""
        return _orthonormal(np.column_stack([self.nuisance_columns, self.curves[0]]))

    def noise_of(self, fit: Fit, candidates: Sequence[tuple[Floats, Floats]]) -> NoiseModel:
        """The noise of most likelihood in what curves and nuisances leave of a fit, and those candidates without which
        it is certainly less likely: a drift is no wander.

        ``candidates``: columns (n, k) of each, and the prior standard deviations (k,) of their coefficients.
        """
        rest = fit.residual[self.used]
        rest = rest - self._flexible @ (self._flexible.T @ rest)
        # Each column that is taken out takes a sample's share of the noise with it.
        rest *= np.sqrt(rest.size / max(rest.size - self._flexible.shape[1], 1))
        score, noise = self._likeliest(rest)
        columns = np.hstack([columns * sd for columns, sd in candidates])
        columns -= self._flexible @ (self._flexible.T @ columns)
        ends = np.cumsum([0, *(sd.size for _, sd in candidates)])
        each = [columns[:, a:b] for a, b in pairwise(ends)]
        while each:
            left = []
            for own in each:
                inner = own.T @ own + np.mean(rest**2) * np.eye(own.shape[1])
                left.append(rest - own @ np.linalg.solve(inner, own.T @ rest))
            tried = []
            for k in np.argsort([float(one @ one) for one in left])[:MOST_TRIED]:
                paid = 0.5 * each[k].shape[1] * np.log(rest.size) + np.log(len(each)) + LOG_CERTAIN
                tried.append((*self._likeliest(left[k]), paid, k))
            better, found, paid, k = max(tried, key=lambda one: one[0] - one[2])
            if better - paid <= score:
                break
            score, noise, rest = better, found, left[k]
            del each[k]
        return noise

    def _likeliest(self, rest: Floats) -> tuple[float, NoiseModel]:
        return noise_model(rest, self.step_s, self.starts, self.least_rad)

    def whitened(self, noise: NoiseModel, names: int) -> Whitened:
        """Nuisances and curves under a noise; an unknown cause is as likely as one of so many names."""
        most = np.array([one.most for one in self.nuisances])
        return Whitened(noise, self.nuisance_columns, np.stack([-most, most]), self.curves, names)


def _orthonormal(columns: Floats) -> Floats:
    """Orthonormal basis (n, r) of columns (n, k)."""
    size = np.linalg.norm(columns, axis=0)
    least = 1e-9 * size.max(initial=0.0)
    columns = columns[:, size > least] / size[size > least]
    if not columns.shape[1]:
        return columns
    values, axes = np.linalg.eigh(columns.T @ columns)
    kept = values > 1e-9 * values[-1]
    return np.asarray(columns @ (axes[:, kept] / np.sqrt(values[kept])))


def _hats(values: Floats, knots: int) -> list[Floats]:
    """Linear B-splines over the range of ``values``: any curve that is straight between the knots is a sum of them."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return []
    return list(BSpline.design_matrix(values, np.r_[low, np.linspace(low, high, knots), high], 1).toarray().T)


def _stretch(p: Prepared) -> Floats:
    """Number of the stretch of each sample."""
    return np.asarray(np.searchsorted(p.cut.starts, np.arange(p.time_s.size), side="right"), dtype=float)
