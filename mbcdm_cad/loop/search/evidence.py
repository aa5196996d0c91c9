"""Marginal likelihood of a linear-Gaussian model at a nonlinear fit: the one number by which this search decides.

    y = J b + N s + Z z + noise

The marginal likelihood, or evidence, is the probability density of the data ``y`` with all coefficients integrated out
over their priors. It falls with each coefficient that the data did not need (Occam factor), so that models of different
size are compared by it alone; the ratio of two is the odds between them (Bayes factor).

``J``: Jacobian of the effects at their fit, ``b`` with a prior as wide as the whole error, for sizes, phases and times.
``N``: nuisances, what the bench may be wrong by and nobody asks for, one standard deviation a column. ``Z``: curves of
an unknown cause that repeats, the rival of every name; their scale is found by likelihood, never below what a model of
a real drive leaves. The noise is white and AR(1), together an ARMA(1,1) process whose memory and shares are found by
likelihood; the innovations of its steady Kalman filter are white, and the same filter is applied to all columns
(whitening). D. J. C. MacKay, Neural Computation 4 (1992) 415-447.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.signal import lfilter
from scipy.special import logsumexp

from mbcdm_cad.routes import Floats

# Logarithm of the odds from which something counts as certain.
LOG_ODDS = float(np.log(99.0))
# The posterior that a set of names holds.
CREDIBLE = 0.95
# Least fall of the error by a named effect, RMS over the floor: smaller ones are listed.
LEAST_FALL = 0.45
# Two predictions that differ by this share of the noise, RMS, are alike: so much may be an error of the model.
ALIKE_SHARE = 0.12
# Of a ranking so many are looked at: what may be first after more work.
TRIED = 4
# Candidates of the noise: shares of the mean square with a memory, and memories from steps of the run to its duration.
SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 0.99)
MEMORIES = 9
# A model of a real drive is never right: two predictions that differ by ALIKE_SHARE of the floor, or by this share of
# the whole error that is to be explained, are told apart at LOG_ODDS at most, however many samples there are. Beyond
# that the error of the model is white noise beside that of the run, so that the posterior is coarsened (J. W. Miller
# and D. B. Dunson, J. Am. Stat. Assoc. 114 (2019) 1113), and what a slow noise leaves untold already is not taken off
# twice.
ALIKE_OF_WHOLE = 0.004
# Directions of columns, and pushes beyond a bound, that are zero but for rounding.
ROUNDED = 1e-9
# Samples for which the sums are made.
MOST_ROWS = 4000
# Scales of the unknown curves, over the floor: from what is in every run, to far beyond.
SCALES = np.geomspace(0.06, 60.0, 11)
# Sizes of the noise of few readings over that at hand, and the degrees of freedom with which that is known.
FACTORS, FREEDOM = np.geomspace(0.5, 4.0, 9), 3.0


@dataclass(frozen=True)
class NoiseModel:
    """White noise and AR(1), rad RMS, ``memory_s`` of the second; ``starts``: first rows of stretches without gaps.

    ``rest_rad``: RMS in the run. Of a memory as long as the run only the square over the memory is known.
    """

    white_rad: float
    coloured_rad: float = 0.0
    memory_s: float = 0.0
    step_s: float = 1.0
    starts: tuple[int, ...] = (0,)
    rest_rad: float = np.inf

    def coarsened(self, samples: int, whole_rad: float) -> "NoiseModel":
        """With the error of the model beside it, which grows with the whole error."""
        untold = np.hypot(ALIKE_SHARE * self.floor_rad, ALIKE_OF_WHOLE * whole_rad)
        beyond = max(samples * untold**2 / (2.0 * LOG_ODDS) - self.floor_rad**2, 0.0)
        return replace(self, white_rad=float(np.sqrt(self.white_rad**2 + beyond)))

    @property
    def floor_rad(self) -> float:
        """Its RMS, as far as the run is long."""
        return min(float(np.hypot(self.white_rad, self.coloured_rad)), max(self.rest_rad, self.white_rad))

    @cached_property
    def _steady(self) -> tuple[float, float, float]:
        """Correlation of a step, gain and innovation variance of the steady Kalman filter."""
        w, c = self.white_rad**2, self.coloured_rad**2
        phi = float(np.exp(-self.step_s / self.memory_s)) if self.memory_s > 0.0 else 0.0
        q = c * (1.0 - phi**2)
        half = 0.5 * (q + w * (phi**2 - 1.0))
        p = half + float(np.sqrt(half**2 + q * w))
        return phi, p / (p + w), p + w

    @property
    def log_scale(self) -> float:
        """Logarithm of the standard deviation of an innovation."""
        return 0.5 * float(np.log(self._steady[2]))

    def whitened(self, columns: Floats) -> Floats:
        """Innovations (n,) or (n, k) over their standard deviation."""
        phi, gain, variance = self._steady
        out = np.empty_like(columns)
        for first, last in pairwise((*self.starts, columns.shape[0])):
            out[first:last] = lfilter([1.0, -phi], [1.0, -phi * (1.0 - gain)], columns[first:last], axis=0)
            # The first sample of a stretch has the variance of the noise, not of an innovation.
            out[first] *= np.sqrt(variance) / np.hypot(self.white_rad, self.coloured_rad)
        return np.asarray(out / np.sqrt(variance))


def noise_model(rest: Floats, step_s: float, starts: tuple[int, ...], least_rad: float) -> tuple[float, NoiseModel]:
    """The noise of most likelihood of what curves and nuisances leave of a residual, rad (n,); ``least_rad``: the white
    noise of the sensors' declared steps. With the logarithm of its likelihood."""
    n, rest_rad = rest.size, float(np.sqrt(np.mean(rest**2)))
    best: tuple[float, NoiseModel] | None = None
    memories = np.geomspace(2.0 * step_s, 0.25 * n * step_s, MEMORIES)
    for memory in memories:
        for share in (0.0, *SHARES) if memory == memories[0] else SHARES:
            unit = NoiseModel(float(np.sqrt(1.0 - share)), float(np.sqrt(share)), float(memory), step_s, starts)
            square = float(np.mean(unit.whitened(rest) ** 2))
            score = -0.5 * n * float(np.log(square)) - n * unit.log_scale
            if best is None or score > best[0]:
                size = float(np.sqrt(square))
                white = max(size * unit.white_rad, least_rad, 1e-12)
                best = score, NoiseModel(white, size * unit.coloured_rad, float(memory), step_s, starts, rest_rad)
    assert best is not None
    return best


@dataclass(frozen=True, eq=False)
class Weighed:
    """The evidence of a model. ``log``: marginal likelihood; ``mean`` of the effects' values (k,), all else integrated
    out; ``joint``: nuisances and values, their covariance (q + k, q + k); ``nuisances``: posterior means (q,), in
    standard deviations; ``unknown``: number of the likeliest hypothesis of the unknown cause, and the log odds of any
    against the least scale; ``curves``: posterior mean of its coefficients; ``alone``: ``log`` beside no unknown cause.
    """

    log: float
    mean: Floats
    joint: Floats
    nuisances: Floats
    unknown: int
    unknown_odds: float
    curves: Floats
    alone: float

    @property
    def covariance(self) -> Floats:
        """Covariance of the effects' values (k, k)."""
        own = self.nuisances.size
        return self.joint[own:, own:]


class Whitened:
    """Nuisances and curves, whitened by one noise model; the curves of each family in their principal axes.

    Each family at each scale is one hypothesis of what an unknown cause does, by number; ``none``: the least.
    """

    none = 0

    def __init__(
        self,
        noise: NoiseModel,
        nuisances: Floats,
        bounds: Floats,
        curves: Sequence[Floats],
        names: int,
        whole_rad: float = 0.0,
        against: Sequence[float] = (),
        scales: Floats = SCALES,
    ) -> None:
        """``bounds`` (2, q) of the nuisances, in standard deviations. An unknown cause is as likely beforehand as one
        of so many ``names``, whatever its family and scale; the least scale is what is in every run. ``whole_rad``: RMS
        of the whole error. ``against``: logarithms of the odds beforehand against each of the ``curves``; ``scales``
        over the floor."""
        self.noise, self.bounds = noise, bounds
        self.coarse = noise.coarsened(nuisances.shape[0], whole_rad)
        self.every = max(1, nuisances.shape[0] // MOST_ROWS)
        self.nuisances = self.whitened(nuisances)
        self.scales = scales * noise.floor_rad
        squares = self.scales[:, None] ** 2
        self.axes, kept, self.weights, logs = [], [], [], []
        for family, less in zip(curves, against or [0.0] * len(curves), strict=True):
            z = self.whitened(family)
            values, axes = np.linalg.eigh(z.T @ z)
            some = values > ROUNDED * values[-1]
            self.axes.append(axes[:, some])
            kept.append(z @ axes[:, some])
            # Of each scale the weights of the axes, and half the logarithm of the determinant.
            self.weights.append(squares / (1.0 + squares * values[some]))
            logs.append(0.5 * np.log1p(squares * values[some]).sum(axis=1))
            # The least scale is certain, the others share the prior of one name.
            prior = np.full(scales.size, -np.log(names * len(curves) * max(scales.size - 1, 1)) - less)
            prior[0] = -np.log(len(curves))
            logs[-1] -= prior
        self.curves, self.log_curves = np.hstack(kept), np.concatenate(logs)
        ends = np.cumsum([0, *(one.shape[1] for one in kept)])
        self.slices = [slice(a, b) for a, b in pairwise(ends)]
        self._gram, self._on_z = self.nuisances.T @ self.nuisances, self.curves.T @ self.nuisances

    def family(self, unknown: int) -> int:
        """Number of the family of a hypothesis."""
        return unknown // self.scales.size

    def hypothesis(self, unknown: int) -> tuple[slice, Floats]:
        """The axes of a hypothesis of the unknown, and their weights."""
        family, scale = divmod(unknown, self.scales.size)
        return self.slices[family], self.weights[family][scale]

    def whitened(self, columns: Floats) -> Floats:
        """Some of the innovations, which are independent, for all of them."""
        return np.asarray(np.sqrt(self.every) * self.coarse.whitened(columns)[:: self.every])

    def parts(self, columns: Floats) -> tuple[Floats, Floats]:
        """Products of the nuisances (first) and ``columns`` (n, k), whitened, and their projections on the curves."""
        w = self.whitened(columns)
        across = self.nuisances.T @ w
        return np.block([[self._gram, across], [across.T, w.T @ w]]), np.hstack([self._on_z, self.curves.T @ w])

    def metric(self, unknown: int) -> Callable[[Floats], Floats]:
        """What makes errors beyond nuisances and unknown curves independent: the root of the inverse covariance."""
        family, scale = divmod(unknown, self.scales.size)
        both = np.column_stack([self.nuisances, self.scales[scale] * self.curves[:, self.slices[family]]])
        values, axes = np.linalg.eigh(both.T @ both)
        kept = values > ROUNDED * values[-1]
        basis = both @ (axes[:, kept] / np.sqrt(values[kept]))
        taken = basis * (1.0 - 1.0 / np.sqrt(1.0 + values[kept]))

        def independent(rows: Floats) -> Floats:
            white = self.whitened(rows)
            return np.asarray(white - taken @ (basis.T @ white))

        return independent

    def evidence_of(self, columns: Floats, prior_sd: Floats, bounds: Floats) -> Weighed:
        """The evidence of effects whose Jacobian, and after it the data, are ``columns`` (n, k + 1)."""
        return self.evidence(self.parts(columns), prior_sd, bounds, columns.shape[0])

    def evidence(self, parts: tuple[Floats, Floats], prior_sd: Floats, bounds: Floats, rows: int) -> Weighed:
        """The evidence of effects with prior standard deviations (k,); ``parts``: those of their Jacobian and the data.

        Every value and nuisance whose posterior mean lies beyond its bounds (2, k) is held there: it has no column,
        since the data cannot move it.
        """
        own = self.bounds.shape[1]
        sd, limits = np.append(np.ones(own), prior_sd), np.hstack([self.bounds, bounds])
        held = np.where(sd > 0.0, np.nan, 0.0)
        for _ in range(4 * sd.size):
            free = np.flatnonzero(np.isnan(held))
            # The data less what held values do, in terms of all columns.
            take = np.zeros((sd.size + 1, free.size + 1))
            take[free, np.arange(free.size)] = sd[free]
            take[:, -1] = np.append(-np.nan_to_num(held), 1.0)
            on_z = parts[1] @ take
            best, logs, mean, spread = self._solved(take.T @ parts[0] @ take, on_z)
            value = mean * sd[free]
            past = np.maximum(limits[0, free] - value, value - limits[1, free]) / sd[free]
            if past.max(initial=0.0) > 0.0:
                worst = int(np.argmax(past))
                held[free[worst]] = np.clip(value[worst], *limits[:, free[worst]])
                continue
            # One that was held too early goes back: the data push it inwards.
            left = take @ np.append(-mean, 1.0)
            axes, weights = self.hypothesis(best)
            push = parts[0][:-1] @ left - parts[1][axes, :-1].T @ (weights * (parts[1][axes] @ left))
            inwards = np.where(held == limits[0], sd, -sd) * (sd > 0.0)
            push = np.where(np.isnan(held), 0.0, (push - held / np.where(sd > 0.0, sd, 1.0) ** 2) * inwards)
            if push.max(initial=0.0) <= ROUNDED:
                break
            held[int(np.argmax(push))] = np.nan
        whole, covariance = np.nan_to_num(held), np.zeros((sd.size, sd.size))
        whole[free] = value
        covariance[np.ix_(free, free)] = spread * np.outer(sd[free], sd[free])
        fixed = np.flatnonzero(~np.isnan(held[:own]))
        beyond = 0.5 * float(held[fixed] @ held[fixed]) + rows * self.coarse.log_scale
        axes, weights = self.hypothesis(best)
        curves = weights * (on_z[axes, -1] - on_z[axes, :-1] @ mean)
        least = np.arange(logs.size) % self.scales.size == 0
        odds = float(logsumexp(logs[~least]) - logsumexp(logs[least])) if not least.all() else -np.inf
        log, alone = float(logsumexp(logs)) - beyond, float(logs[self.none]) - beyond
        return Weighed(log, whole[own:], covariance, whole[:own], best, odds, curves, alone)

    def unknown(self, evidence: Weighed, curves: Sequence[Floats]) -> Floats:
        """What the unknown cause does, rad (n,); ``curves`` as given at first."""
        family = self.family(evidence.unknown)
        return np.asarray(curves[family] @ (self.axes[family] @ evidence.curves))

    def _solved(self, gram: Floats, on_z: Floats) -> tuple[int, Floats, Floats, Floats]:
        """The likeliest hypothesis of the unknown, the logarithm of the posterior of each, mean of the columns there,
        and their mean square about it over all of them, all columns with a prior of one standard deviation."""
        k = gram.shape[0] - 1
        inner = gram - np.concatenate(
            [
                np.matmul(on_z[axes].T[None] * weights[:, None, :], on_z[axes])
                for axes, weights in zip(self.slices, self.weights, strict=True)
            ]
        )
        # Columns far larger than the noise: what rounding leaves of their squares may be below zero.
        root = np.linalg.cholesky(np.diag(1.0 + 1e-12 * np.diagonal(gram)[:k]) + inner[:, :k, :k])
        h = np.linalg.solve(root, inner[:, :k, k:])[..., 0]
        logs = -0.5 * (inner[:, k, k] - np.sum(h**2, axis=1)) - self.log_curves
        logs -= np.log(np.einsum("sii->si", root)).sum(axis=1)
        best = int(np.argmax(logs))
        share = np.exp(logs - logsumexp(logs))
        some = np.flatnonzero(share > ROUNDED)
        inverse = np.linalg.inv(root[some])
        means = np.einsum("sij,si->sj", inverse, h[some])
        mean = means[np.searchsorted(some, best)]
        roots = np.concatenate([inverse, (means - mean)[:, None]], axis=1) * np.sqrt(share[some])[:, None, None]
        return best, logs, mean, np.einsum("sij,sik->jk", roots, roots)


class NoiseOfUnknownSize(Whitened):
    """White noise of few readings, whose size is known to a factor: the evidence is summed over it.

    Its variance is inverse chi-square about that of ``noise``, and never below ``least_rad``, what the steps of the
    sensors leave.
    """

    def __init__(
        self,
        noise: NoiseModel,
        nuisances: Floats,
        bounds: Floats,
        curves: Sequence[Floats],
        names: int,
        least_rad: float,
        scales: Floats = SCALES,
    ) -> None:
        super().__init__(noise, nuisances, bounds, curves, names, scales=scales)
        factors = FACTORS[noise.white_rad * FACTORS >= least_rad * (1.0 - ROUNDED)]
        sizes = [replace(noise, white_rad=noise.white_rad * float(factor)) for factor in factors]
        self.each = [Whitened(one, nuisances, bounds, curves, names, scales=scales) for one in sizes]
        prior = -FREEDOM * (np.log(factors) + 0.5 / factors**2)
        self.prior = prior - logsumexp(prior)

    def evidence_of(self, columns: Floats, prior_sd: Floats, bounds: Floats) -> Weighed:
        """That of all sizes of the noise, with mean and covariance of their mixture."""
        found = [one.evidence_of(columns, prior_sd, bounds) for one in self.each]
        logs = np.array([one.log for one in found]) + self.prior
        share = np.exp(logs - logsumexp(logs))
        means = np.array([np.append(one.nuisances, one.mean) for one in found])
        mean = share @ means
        joint = np.einsum("s,sij->ij", share, np.array([one.joint for one in found]))
        joint += (means - mean).T @ (share[:, None] * (means - mean))
        odds = np.array([one.unknown_odds for one in found])
        unknown = logsumexp(logs - np.logaddexp(0.0, -odds)) - logsumexp(logs - np.logaddexp(0.0, odds))
        best = int(np.argmax(logs))
        number = best * self.log_curves.size + found[best].unknown
        own, log, curves = self.bounds.shape[1], float(logsumexp(logs)), found[best].curves
        return Weighed(log, mean[own:], joint, mean[:own], number, float(unknown), curves, found[best].alone)

    def family(self, unknown: int) -> int:
        """Number of the family of a hypothesis."""
        return super().family(unknown % self.log_curves.size)

    def metric(self, unknown: int) -> Callable[[Floats], Floats]:
        """Beside the likeliest noise."""
        noise, number = divmod(unknown, self.log_curves.size)
        return Whitened.metric(self.each[noise], number)
