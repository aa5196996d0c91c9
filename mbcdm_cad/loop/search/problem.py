"""What a run of one kind gives the search: data, prediction and Jacobian, nuisances, curves of an unknown cause, noise.

The search and its evidence know nothing else of a run. :class:`LogProblem` is that of a log of a motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects.load_sensor import within_class, within_prior
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.search.evidence import LOG_ODDS, ROUNDED, TRIED, NoiseModel, Whitened, noise_model
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

# Knots of the unknown curves over angle, load and speed; coarse and fine, so that a smooth curve is the likelier one.
ANGLE_KNOTS, LOAD_KNOTS, SPEED_KNOTS = (4, 8, 16, 32), (5, 9), (6,)
# How far an unknown law of the load that is nearly proportional to it is from that, as a share.
PROPORTIONAL = 0.2
# Windows of the smoothing as if the noise were so many times as large: two standard deviations apart.
OTHER_WINDOWS = (0.5, 2.0)


@dataclass(frozen=True, eq=False)
class Nuisance:
    """What a bench may be wrong by: the change of the prediction (n,), rad, for one standard deviation, of which it is
    ``most`` at most. ``offset``: that of an offset of the inputs, which a fit may have already. ``effect``: of a sensor
    within its class, or a figure of the design within its own, with its ``size`` of one standard deviation."""

    name: str
    column: Floats
    most: float = 2.0
    offset: float = np.inf
    effect: Effect | None = None
    size: float = 0.0


class LogProblem:
    """Logs of one or more runs of one drive; rows are the samples in use."""

    # Of the smoothing, as if the noise were so many times as large.
    windows: Sequence[float] = OTHER_WINDOWS

    def __init__(self, fitter: Fitter, bare: Fit) -> None:
        self.fitter, self.bare = fitter, bare
        self.used = fitter.used
        # Width of the prior of every size: what it does may be as large as the whole error.
        self.prior_rad = max(float(np.std(bare.residual[self.used])), 1e-9)
        self.step_s = min(p.step_s for p in fitter.runs)
        # Where no steps are declared, less than a bit of any encoder.
        least = float(np.sqrt(np.finfo(float).eps) * np.ptp(fitter.output))
        self.least_rad = max(p.floor_rad for p in fitter.runs) or least

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """First rows of stretches of samples that follow each other."""
        sizes = [int(p.used.sum()) for p in self.fitter.runs]
        before = np.cumsum([0, *sizes[:-1]]).tolist()
        pairs = zip(before, self.fitter.runs, strict=True)
        return tuple(first + start for first, p in pairs for start in starts_of(p))

    def nuisances_of(self, fit: Fit) -> tuple[Nuisance, ...]:
        """Sensors within their class, the design's figures within theirs, shapes of laws, offsets of the
        inputs, windows of the smoothing, and each run's zero, linear about a fit."""
        f = self.fitter
        base = f.output - fit.residual

        def moved(fitter: Fitter, effects: Sequence[Effect], *values: Floats) -> Floats | None:
            try:
                at = fitter.predict(effects, (*fit.values, *values), fit.offsets)
            except ModelError:  # with less smoothing noise may slacken a cable that is nearly slack
                return None
            return f.centred(at - base, f.used)

        found = []
        for effect in (*within_class(f.runs), *within_prior(f.runs)):
            # Two standard deviations are the bound of a class.
            size = 0.5 * effect.parameters[0].high
            change = moved(f, (*fit.effects, effect), np.array([size]))
            if change is not None:
                found.append(Nuisance(effect.name, change, effect=effect, size=size))
        for factor in self.windows:
            change = moved(f.rewindowed(factor), fit.effects)
            if change is not None:
                found.append(Nuisance(f"smoothing, noise times {factor:g}", 0.5 * change))
        for effect, shape in [(e, shape) for e in fit.effects if e.shapes for shape in e.shapes()]:
            change = moved(f, [shape if e is effect else e for e in fit.effects])
            if change is not None:
                found.append(Nuisance("another shape of its law", change))
        offsets = fit.jacobian[:, fit.width :]
        for column, limit in zip(offsets.T, f.limit[f.free], strict=True):
            rms = float(np.std(column[self.used]))
            sigma = min(limit / np.sqrt(3.0), 10.0 * self.prior_rad / max(rms, 1e-30))
            found.append(Nuisance("offset of the inputs, or an own value", sigma * column, limit / sigma, sigma))
        for part in f.parts:
            ones = np.zeros(f.output.size)
            ones[part] = 1e3 * self.prior_rad
            found.append(Nuisance("zero of the output", ones, np.inf))
        return tuple(found)

    @property
    def curves(self) -> tuple[Floats, ...]:
        """What an unknown cause may do, by families: (n, k) each, RMS 1 together."""
        return tuple(columns for columns, _ in self._families)

    @cached_property
    def _families(self) -> tuple[tuple[Floats, float], ...]:
        """Families of curves, and the logarithm of the odds against each.

        Curves of angle, of load and of speed, all at once and by sense of motion; smooth ones of angle alone, fine
        ones, smooth ones by sense; those of load alone, as much as the angle says, or nearly proportional to it.
        A simple unknown cause is as likely as a name only if it does not pay for what it does not do.
        """
        smooth, fine = ANGLE_KNOTS[:2], ANGLE_KNOTS
        by_load, by_speed = self._hats("load", LOAD_KNOTS, True), self._hats("speed", SPEED_KNOTS)
        load = self._of("load")
        by_place = [] if load is None else [load * hat for hat in self._hats("angle", smooth)]
        families: list[list[Floats]] = [
            [*self._hats("angle", fine, True), *by_load, *by_speed, *by_place],
            self._hats("angle", smooth),
            self._hats("angle", fine),
            self._hats("angle", smooth, True),
            by_place,
            by_load,
        ]
        # Squares of load and speed look like a wave or a parabola of the angle, and what is nearly proportional to the
        # load is nearly a stiffness: they are to be certain beside those.
        speed = self._of("speed")
        assert speed is not None
        squares = [one for of in (speed, load) if of is not None for one in (of**2, np.abs(of) * of)]
        found = [(unit_columns(family)[0], 0.0) for family in families if family]
        found += [(unit_columns([square])[0], LOG_ODDS) for square in squares]
        if load is not None and by_load:
            near = [unit_columns([load])[0], PROPORTIONAL * unit_columns(by_load)[0]]
            found.append((np.column_stack(near), LOG_ODDS))
        return tuple(pair for pair in found if pair[0].size)

    def _of(self, name: str) -> Floats | None:
        """Angle, load or speed of all runs, None if it was not measured.

        The angle is the predicted one: beside a curve of the measured one any ratio would explain the whole error.
        """
        if name == "angle":
            return np.asarray((self.fitter.output - self.bare.residual)[self.used])
        name = {"load": "load_Nm", "speed": "speed_rad_s"}[name]
        values = [getattr(p, name) for p in self.fitter.runs]
        if any(v is None for v in values):
            return None
        return np.concatenate([v[p.used] for v, p in zip(values, self.fitter.runs, strict=True)])

    def _hats(self, of: str, numbers: Sequence[int], by_sense: bool = False) -> list[Floats]:
        """Hats (n,) over angle, load or speed of all runs, of each number of knots."""
        at = self._of(of)
        if at is None:
            return []
        hats = [hat for knots in numbers for hat in hats_over(at, knots)]
        if not by_sense:
            return hats
        onward = np.concatenate([p.speed_rad_s[p.used] for p in self.fitter.runs]) >= 0.0
        return [hat * sense for hat in hats for sense in (onward, ~onward)]

    def columns_of(self, nuisances: Sequence[Nuisance]) -> Floats:
        """Columns of nuisances on the rows."""
        return np.stack([one.column[self.used] for one in nuisances], axis=1)

    def noise_of(
        self, fit: Fit, nuisances: Sequence[Nuisance], candidates: Sequence[tuple[Floats, Floats]]
    ) -> NoiseModel:
        """The noise of most likelihood in what curves and nuisances leave of a fit, and those candidates without which
        it is certainly less likely: a drift is no wander.

        ``candidates``: columns (n, k) of each, and the prior standard deviations (k,) of their coefficients.
        """
        rest = fit.residual[self.used]
        flexible = _orthonormal(np.column_stack([self.columns_of(nuisances), self.curves[0]]))
        rest = rest - flexible @ (flexible.T @ rest)
        # Each column that is taken out takes a sample's share of the noise with it.
        rest *= np.sqrt(rest.size / max(rest.size - flexible.shape[1], 1))
        score, noise = self._likeliest(rest)
        columns = np.hstack([columns * sd for columns, sd in candidates])
        columns -= flexible @ (flexible.T @ columns)
        ends = np.cumsum([0, *(sd.size for _, sd in candidates)])
        each = [columns[:, a:b] for a, b in pairwise(ends)]
        while each:
            left = []
            for own in each:
                inner = own.T @ own + np.mean(rest**2) * np.eye(own.shape[1])
                left.append(rest - own @ np.linalg.lstsq(inner, own.T @ rest, rcond=None)[0])
            tried = []
            for k in np.argsort([float(one @ one) for one in left])[:TRIED]:
                paid = 0.5 * each[k].shape[1] * np.log(rest.size) + np.log(len(each)) + LOG_ODDS
                tried.append((*self._likeliest(left[k]), paid, k))
            better, found, paid, k = max(tried, key=lambda one: one[0] - one[2])
            if better - paid <= score:
                break
            score, noise, rest = better, found, left[k]
            del each[k]
        return noise

    def _likeliest(self, rest: Floats) -> tuple[float, NoiseModel]:
        return noise_model(rest, self.step_s, self.starts, self.least_rad)

    def whitened(self, noise: NoiseModel, nuisances: Sequence[Nuisance], names: int, scales: Floats) -> Whitened:
        """Nuisances and curves of these scales under a noise; an unknown cause is as likely as one of so many names."""
        most = np.array([one.most for one in nuisances])
        against = [odds for _, odds in self._families]
        bounds = np.stack([-most, most])
        return Whitened(noise, self.columns_of(nuisances), bounds, self.curves, names, self.prior_rad, against, scales)


def _orthonormal(columns: Floats) -> Floats:
    """Orthonormal basis (n, r) of columns (n, k)."""
    size = np.linalg.norm(columns, axis=0)
    least = ROUNDED * size.max(initial=0.0)
    columns = columns[:, size > least] / size[size > least]
    if not columns.shape[1]:
        return columns
    values, axes = np.linalg.eigh(columns.T @ columns)
    kept = values > ROUNDED * values[-1]
    return np.asarray(columns @ (axes[:, kept] / np.sqrt(values[kept])))


def unit_columns(family: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Columns (n, k) without mean, of RMS 1 together, and what each was divided by; 0 of those that do not vary."""
    columns = np.stack(family, axis=1)
    columns = columns - columns.mean(axis=0)
    size = np.sqrt(np.mean(columns**2, axis=0))
    size = np.where(size > ROUNDED * size.max(), size, 0.0)
    kept = size > 0.0
    size *= np.sqrt(max(kept.sum(), 1))
    return np.asarray(columns[:, kept] / size[kept]), np.asarray(size)


def hats_over(values: Floats, knots: int) -> list[Floats]:
    """Linear B-splines over the range of ``values``: any curve that is straight between the knots is a sum of them."""
    low, high = float(values.min()), float(values.max())
    if low == high:
        return []
    return list(BSpline.design_matrix(values, np.r_[low, np.linspace(low, high, knots), high], 1).toarray().T)


def starts_of(p: Prepared) -> tuple[int, ...]:
    """First of the samples in use, by number, of each stretch without gaps."""
    stretch = np.searchsorted(p.cut.starts, np.arange(p.time_s.size), side="right")
    gaps = (np.diff(np.flatnonzero(p.used)) != 1) | (np.diff(stretch[p.used]) != 0)
    return (0, *(np.flatnonzero(gaps) + 1).tolist())
