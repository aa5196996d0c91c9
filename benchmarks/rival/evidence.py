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

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.signal import lfilter

from mbcdm_cad.routes import Floats

# Candidates of the noise: shares of the mean square with a memory, and memories from steps of the run to its duration.
SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 0.99)
MEMORIES = 9
# Scales of the unknown curves, over the floor: from what is in every run, to far beyond.
SCALES = np.geomspace(0.06, 60.0, 16)


@dataclass(frozen=True)
class NoiseModel:
    """White noise and AR(1), rad RMS, ``memory_s`` of the second; ``starts``: first rows of stretches without gaps.

    ``rest_rad``: RMS in the run. Of a memory as long as the run only the square over the memory is known.
    """

    white_rad: float
    coloured_rad: float
    memory_s: float
    step_s: float
    starts: tuple[int, ...]
    rest_rad: float = np.inf

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


def noise_model(rest: Floats, step_s: float, starts: tuple[int, ...], least_rad: float) -> NoiseModel:
    """The noise of most likelihood of what curves and nuisances leave of a residual, rad (n,); ``least_rad``: the white
    noise of the sensors' declared steps."""
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
    return best[1]


@dataclass(frozen=True, eq=False)
class Evidence:
    """``log``: marginal likelihood; ``mean`` and ``covariance`` of the effects' values (k,), (k, k), all else
    integrated out; ``scale_rad`` of the unknown curves, and their log Bayes factor against the least scale;
    ``curves``: posterior mean of their coefficients."""

    log: float
    mean: Floats
    covariance: Floats
    scale_rad: float
    unknown_odds: float
    curves: Floats


class Whitened:
    """Nuisances and curves, whitened by one noise model and projected out of all that follows."""

    def __init__(self, noise: NoiseModel, nuisances: Floats, curves: Floats) -> None:
        self.noise, self.flat = noise, curves
        n = self.nuisances = noise.whitened(nuisances)
        z = self.curves = noise.whitened(curves)
        self.root = np.linalg.cholesky(np.eye(n.shape[1]) + n.T @ n)
        self.log_nuisances = float(np.log(np.diag(self.root)).sum())
        nz = np.linalg.solve(self.root, n.T @ z)
        values, self.axes = np.linalg.eigh(z.T @ z - nz.T @ nz)
        self.sizes = np.maximum(values, 0.0)
        self._nz = nz
        scales = (SCALES * noise.floor_rad)[:, None]
        # Of each scale the weights of the axes, and half the logarithm of the determinant.
        self.scales, self.weights = scales[:, 0], scales**2 / (1.0 + scales**2 * self.sizes)
        self.log_curves = 0.5 * np.log1p(scales**2 * self.sizes).sum(axis=1)

    def parts(self, columns: Floats) -> tuple[Floats, Floats]:
        """Products (k, k) of whitened columns beyond the nuisances, and their projections on the axes of the curves."""
        w = self.noise.whitened(columns)
        on_n = np.linalg.solve(self.root, self.nuisances.T @ w)
        return w.T @ w - on_n.T @ on_n, self.axes.T @ (self.curves.T @ w - self._nz.T @ on_n)

    def evidence(self, parts: tuple[Floats, Floats], prior_sd: Floats, rows: int) -> Evidence:
        """Evidence of effects with prior standard deviations (k,); ``parts``: those of their Jacobian and the data."""
        k = prior_sd.size
        scaled = np.append(prior_sd, 1.0)
        gram, on_z = parts[0] * np.outer(scaled, scaled), parts[1] * scaled
        inner = gram - np.einsum("zi,sz,zj->sij", on_z, self.weights, on_z, optimize=True)
        root = np.linalg.cholesky(np.eye(k) + inner[:, :k, :k])
        h = np.linalg.solve(root, inner[:, :k, k:])[..., 0]
        log = (
            -0.5 * (inner[:, k, k] - np.sum(h**2, axis=1))
            - np.log(np.einsum("sii->si", root)).sum(axis=1)
            - self.log_curves
        )
        best = int(np.argmax(log))
        inverse = np.linalg.inv(root[best])
        mean = inverse.T @ h[best]
        curves = self.axes @ (self.weights[best] * (on_z[:, k] - on_z[:, :k] @ mean))
        covariance = (inverse.T @ inverse) * np.outer(prior_sd, prior_sd)
        total = float(log[best]) - self.log_nuisances - rows * self.noise.log_scale
        return Evidence(total, mean * prior_sd, covariance, float(self.scales[best]), float(log[best] - log[0]), curves)
