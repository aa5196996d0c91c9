"""What the evidence of a planned run will say: the size from which an effect is named, or told from another.

The data of an effect of size s are s times a column, beside the noise, so that the logarithm of the evidence of every
model is quadratic in s, and follows from one Gram matrix of all whitened columns with nuisances and each hypothesis of
an unknown cause integrated out. The noise makes the odds a noncentral chi-square.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq
from scipy.special import chndtrix, logsumexp
from scipy.stats import norm

from mbcdm_cad.loop.search.by_evidence import CREDIBLE
from mbcdm_cad.loop.search.evidence import LEAST_FALL, LOG_ODDS, Whitened
from mbcdm_cad.routes import Floats

# Effects that may stand for one, the likeliest where it does as much as the noise.
NEAR = 3
# The least size that is looked for, over that which does as much as the noise; the greatest over the least, and over
# that which is named; the factor between two that are tried.
LEAST, MOST, ANY_SIZE, FACTOR = 1e-2, 1e8, 1e3, 3.0


@dataclass(frozen=True, eq=False)
class Shown:
    """How an effect shows: derivatives of the prediction by its sizes (n, k), and by its places over its size (n, p),
    of which ``place_sd`` are the priors; ``log_prior``: logarithm of the odds against an effect of its kind; ``data``
    (n,): what it does at size 1, None: at the phase that shows least."""

    columns: Floats
    places: Floats
    place_sd: Floats
    log_prior: float = 0.0
    data: Floats | None = None

    @property
    def width(self) -> int:
        """Number of its columns."""
        return int(self.columns.shape[1] + self.places.shape[1])


class Foresight:
    """Effects on the rows of one run; ``freedom``: degrees of freedom with which the size of the noise is known;
    ``floor``: of the error, if it is another than that of the whitened noise."""

    def __init__(
        self, white: Whitened, shown: Sequence[Shown], names: int, freedom: float = np.inf, floor: float | None = None
    ) -> None:
        self.white, self.shown, self.names, self.freedom = white, tuple(shown), names, freedom
        self.floor = white.noise.floor_rad if floor is None else floor
        each = [np.hstack([one.columns, one.places]) for one in self.shown]
        ends = np.cumsum([0, *(one.shape[1] for one in each)])
        self.own = [slice(int(a), int(b)) for a, b in pairwise(ends)]
        given = [one.data for one in self.shown if one.data is not None]
        columns = np.column_stack([*each, *given])
        gram, self.logs = self._beyond(columns)
        # Least at every phase, in the likeliest case that nothing else is there.
        data = np.zeros((columns.shape[1], len(self.shown)))
        extra = iter(range(int(ends[-1]), columns.shape[1]))
        for i, (one, own) in enumerate(zip(self.shown, self.own, strict=True)):
            if one.data is not None:
                data[next(extra), i] = 1.0
                continue
            k = one.columns.shape[1]
            data[own.start : own.start + k, i] = np.linalg.eigh(gram[0][own, own][:k, :k])[1][:, 0]
        # Of the data with each other's columns and with themselves, under each hypothesis of the unknown (h, ...).
        self.gram, self.on_data = gram, gram @ data
        self.square = np.einsum("mi,hmi->hi", data, self.on_data)
        self.rms = np.sqrt(np.mean((columns - columns.mean(axis=0)) ** 2, axis=0))
        made = columns @ data
        self.does = np.sqrt(np.mean((made - made.mean(axis=0)) ** 2, axis=0))

    def _beyond(self, columns: Floats) -> tuple[Floats, Floats]:
        """Products of whitened columns with nuisances and an unknown cause integrated out, for each hypothesis of it
        (h, m, m), and the logarithm of its prior over its Occam factor (h,), with what the noise alone gives it."""
        white = self.white
        gram, on_z = white.parts(columns)
        q = white.bounds.shape[1]
        found, logs = [], -np.array(white.log_curves)
        for h in range(logs.size):
            axes, weights = white.hypothesis(h)
            inner = gram - on_z[axes].T @ (weights[:, None] * on_z[axes])
            root = np.linalg.cholesky(np.eye(q) + inner[:q, :q])
            across = np.linalg.solve(root, inner[:q, q:])
            found.append(inner[q:, q:] - across.T @ across)
            freedom = float(weights @ np.sum(white.curves[:, axes] ** 2, axis=0))
            logs[h] += 0.5 * freedom - float(np.log(np.diag(root)).sum())
        return np.array(found), logs

    def _evidence(self, i: int, j: int | None, size: float) -> tuple[Floats, Floats]:
        """Logarithm of the evidence of data of effect ``i`` of a size without noise, under each hypothesis of the
        unknown, with effect ``j`` or none fitted; and what that leaves of half the square of the data."""
        left = 0.5 * size**2 * self.square[:, i]
        if j is None:
            return self.logs - left, left
        one, own = self.shown[j], self.own[j]
        k = one.columns.shape[1]
        scale = np.ones(one.width)
        scale[k:] = size  # a place moves more data, the larger the effect is
        whole = float(np.hypot(self.white.noise.floor_rad, size * self.does[i]))
        sd = np.append(whole / np.maximum(self.rms[own][:k], 1e-300), one.place_sd) * scale
        inner = np.eye(one.width) + self.gram[:, own, own] * np.outer(sd, sd)
        root = np.linalg.cholesky(inner)
        across = np.linalg.solve(root, (sd * size * self.on_data[:, own, i])[..., None])[..., 0]
        left = np.maximum(left - 0.5 * np.sum(across**2, axis=1), 0.0)
        occam = np.log(np.einsum("hii->hi", root)).sum(axis=1)
        return self.logs - left - occam - one.log_prior, left

    def log_odds(self, i: int, mine: Sequence[int], its: int | None, size: float, power: float) -> float:
        """Logarithm of the odds of effects, each as likely beforehand, against another one or none, that data of effect
        ``i`` of a size give with this probability."""
        each, other = [self._evidence(i, j, size) for j in mine], self._evidence(i, its, size)
        plain = float(logsumexp([logs for logs, _ in each]) - logsumexp(other[0]))
        least = min(float(left[np.argmax(logs)]) for logs, left in each)
        strength = max(float(other[1][np.argmax(other[0])]) - least, 1e-12)
        width = self.shown[i].width if its is None else 1
        drawn = 0.5 * float(chndtrix(1.0 - power, width, 2.0 * strength))
        if np.isfinite(self.freedom):  # of a noise of unknown size
            drawn = 0.5 * self.freedom * float(np.log1p(2.0 * drawn / self.freedom))
        return plain - strength + drawn

    def smallest(self, i: int, power: float) -> float:
        """Size from which an effect is named, by its name or in a set: by its odds, and by the fall of the error;
        infinite if there is none."""
        if not self.does[i] > 0.0:
            return np.inf
        sure = float(norm.isf(1.0 - power)) / np.sqrt(max(float(self.square[0, i]), 1e-300))
        return max(self.likely(i, power), LEAST_FALL * self.floor / float(self.does[i]) + float(sure))

    def likely(self, i: int, power: float) -> float:
        """Size from which an effect, or one of those that stand for it, is likely enough, counted over all names, and
        it is itself in the set of these."""
        needed = LOG_ODDS + float(np.log(self.names))
        least = self.floor / float(self.does[i])
        logs = {j: float(logsumexp(self._evidence(i, j, least)[0])) for j in range(len(self.shown))}
        near = sorted(logs, key=lambda j: -logs[j])[:NEAR]
        own = sorted({i, *near})

        def beyond(size: float) -> float:
            mine = float(logsumexp(self._evidence(i, i, size)[0]))
            best = max(float(logsumexp(self._evidence(i, j, size)[0])) for j in own)
            return min(self.log_odds(i, own, None, size, power) - needed, mine - best - float(np.log(1.0 - CREDIBLE)))

        return _least(beyond, LEAST * least, MOST)

    def apart(self, i: int, j: int, power: float, named: float) -> float:
        """Size, from that with which it is named, from which an effect is told from another; infinite if there is
        none."""
        return _least(lambda s: self.log_odds(i, [i], j, s, power) - LOG_ODDS, named, ANY_SIZE)

    def wrong(self, i: int, j: int) -> float:
        """Probability to take effect ``j`` for effect ``i`` of size 1."""
        left = self._evidence(i, j, 1.0)[1][0] - self._evidence(i, i, 1.0)[1][0]
        return float(norm.sf(0.5 * np.sqrt(2.0 * max(left, 0.0))))


def _least(beyond: Callable[[float], float], first: float, most: float) -> float:
    """The least size, from ``first`` up to so many times it, with which a function is above zero."""
    low = high = first
    while beyond(high) <= 0.0:
        low, high = high, FACTOR * high
        if high > most * first:
            return np.inf
    if high == first:
        return first
    return float(np.exp(brentq(lambda x: beyond(float(np.exp(x))), np.log(low), np.log(high), xtol=1e-2)))
