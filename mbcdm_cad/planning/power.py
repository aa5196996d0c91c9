"""The probability that the loop names an effect of a given size: the two rules by which it accepts one, on many draws
of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.signal import lfilter
from scipy.sparse import csr_array
from scipy.stats import f as f_distribution
from scipy.stats import norm

from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.loop.prepare.prepared import SECTORS, Prepared
from mbcdm_cad.loop.search.evidence import ALPHA, jackknifed
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.routes import Floats

# Draws of the noise: the error of a probability of 0.5 is 0.02. Fewer for a long run, which has so many samples in all.
MOST_DRAWS, FEWEST_DRAWS, MOST_SAMPLES = 600, 200, 4_000_000
SEED = 1
# Relative error of the smallest size, and the multiple of the least size beyond which none is looked for.
SIZE_ERROR, FARTHEST = 1e-3, 1e6


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of the noise, (m, n), on the used samples of a run, less their means over the training samples.

    ``offsets`` (n, q): derivatives by the offsets between the input encoders, which the test of support fits too.
    """

    errors: Floats
    offsets: Floats
    noise: Noise
    p: Prepared

    @cached_property
    def test(self) -> NDArray[np.bool_]:
        """Which of the samples are held back."""
        return np.asarray(self.p.test[self.p.used])

    def tested(self, columns: Floats) -> tuple[Floats, Floats]:
        """Sizes that the test of support finds in the noise alone, (m, k), and its covariances of them, (m, k, k)."""
        train, k = ~self.test, columns.shape[1]
        every = np.hstack([columns[train], self.nuisances])
        wide = every.shape[1]
        products = (every[:, :, None] * every[:, None, :]).reshape(-1, wide**2)
        own = np.stack([self._sums(column) for column in columns[train].T], axis=-1)
        value, covariance = jackknifed(
            (self._cells @ products).reshape(-1, wide, wide),
            np.concatenate([own, self._nuisance_sums], axis=-1),
            *self._names,
        )
        return value[:, :k], covariance[:, :k, :k]

    @cached_property
    def nuisances(self) -> Floats:
        """A constant and the offsets on the training samples, each of length 1."""
        rows = np.column_stack([np.ones(self.errors.shape[1]), self.offsets])[~self.test]
        return np.asarray(rows / np.maximum(np.linalg.norm(rows, axis=0), 1e-300))

    @cached_property
    def _names(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Sweep and sector of each cell."""
        names = np.unique(self._cell)
        return names // SECTORS, names % SECTORS

    @cached_property
    def _cell(self) -> NDArray[np.int64]:
        """Number of the cell of each training sample."""
        p = self.p
        return np.asarray((p.sweep * SECTORS + p.sector)[p.train])

    @cached_property
    def _cells(self) -> csr_array:
        """Matrix (cells, training samples) that sums over each cell."""
        number = np.unique(self._cell, return_inverse=True)[1]
        return csr_array((np.ones(number.size), (number, np.arange(number.size))))

    @cached_property
    def trained(self) -> Floats:
        """The noise on the training samples, (n, m)."""
        return np.ascontiguousarray(self.errors[:, ~self.test].T)

    @cached_property
    def held_out(self) -> Floats:
        """The noise on the samples held back, (n, m)."""
        return np.ascontiguousarray(self.errors[:, self.test].T)

    @cached_property
    def _nuisance_sums(self) -> Floats:
        return np.stack([self._sums(column) for column in self.nuisances.T], axis=-1)

    def _sums(self, column: Floats) -> Floats:
        """Sums over each cell of a column (n,) times the noise, (m, cells)."""
        return np.asarray((self._cells.multiply(column[None]).tocsr() @ self.trained).T)


def draws_of(noise: Noise, p: Prepared, offsets: Floats, moved: Floats | None = None) -> Draws:
    """Draws of the noise on the used samples; ``offsets`` as in :class:`Draws`, ``moved`` (k, n): errors of the
    prediction, equally likely, which are added to the draws in turn."""
    n = int(p.used.sum())
    rng = np.random.default_rng(SEED)
    m = int(np.clip(MOST_SAMPLES // n, FEWEST_DRAWS, MOST_DRAWS))
    errors = rng.standard_normal((m, n))
    known = ((noise.coloured_rad / noise.total_rad) ** 2, noise.memory_s)
    colours = noise.likely or (known,)
    for part, (share, memory) in zip(np.array_split(np.arange(m), len(colours)), colours, strict=True):
        errors[part] *= noise.total_rad * np.sqrt(1.0 - share)
        if share > 0.0 and memory > 0.0:
            keep = float(np.exp(-p.step_s / memory))
            kicks = np.sqrt(1.0 - keep**2) * rng.standard_normal((part.size, n))
            kicks[:, 0] /= np.sqrt(1.0 - keep**2)
            errors[part] += noise.total_rad * np.sqrt(share) * lfilter([1.0], [1.0, -keep], kicks, axis=1)
    if moved is not None and len(moved):
        errors += moved[rng.permutation(m) % len(moved)]
    errors -= errors[:, ~p.test[p.used]].mean(axis=1, keepdims=True)
    return Draws(errors, offsets, noise, p)


@dataclass(frozen=True, eq=False)
class Shown:
    """How an effect of k sizes would be fitted beside each of m draws of the noise; its columns ``unit`` (n, k) on the
    used samples have length 1.

    ``fitted`` (m, k): fitted sizes of the noise alone; ``held`` (m, k), ``gram`` (k, k): products of the columns with
    the noise and with each other on the half sweeps held back. ``tested`` (m, k), ``weight`` (m or 1, k, k): sizes of
    the noise alone and inverse covariances in the test of support, ``critical``: its required square. ``one_sign``: a
    size below zero is impossible. ``slopeless``: its size has no slope, and the test of support takes its whole change.
    ``length`` (k,): of the columns by one unit of each size.
    """

    unit: Floats
    draws: Draws
    fitted: Floats
    held: Floats
    gram: Floats
    tested: Floats
    weight: Floats
    critical: float
    one_sign: bool
    slopeless: bool
    length: Floats

    @cached_property
    def noise_fall(self) -> Floats:
        """Fall of the sum of squares held out by fitting the noise alone, (m,); below zero as a rule."""
        return np.asarray(np.sum(self.fitted * (2.0 * self.held - self.fitted @ self.gram), axis=1))

    def itself(self, change: Floats, added: Floats) -> Detection:
        """The effect fitted to its own ``change`` (n,) by one unit of size, which adds ``added`` (k,) to its sizes."""
        there = change[self.draws.test]
        return Detection(self, float(there @ there), 2.0 * there @ self.draws.held_out, added, added)

    def in_place(self, change: Floats) -> Detection:
        """The effect fitted in the place of another that makes this ``change`` (n,) by one unit of its size."""
        test, k = self.draws.test, self.unit.shape[1]
        train = self.unit[~test]
        fitted, tested = (
            (np.linalg.pinv(columns.T @ columns, rcond=1e-12, hermitian=True) @ (columns.T @ change[~test]))[:k]
            for columns in (train, np.hstack([train, self.draws.nuisances]))
        )
        tested = fitted if self.slopeless else tested
        held = self.unit[test].T @ change[test]
        linear = 2.0 * (self.held @ fitted + self.fitted @ (held - self.gram @ fitted))
        return Detection(self, float(fitted @ (2.0 * held - self.gram @ fitted)), linear, fitted, tested)


@dataclass(frozen=True, eq=False)
class Detection:
    """One way to find an effect of any size: what is ``shown`` of the effect that is fitted, the parts of the fall of
    the sum of squares held out that go with the square of the size and, (m,), with the size, and what one unit of it
    adds to the ``fitted`` and ``tested`` sizes, (k,)."""

    shown: Shown
    square: float
    linear: Floats
    fitted: Floats
    tested: Floats

    def accepted(self, size: float) -> NDArray[np.bool_]:
        """With which draws, (m,), the fitted effect is accepted: the held-out mean square falls by ``LEAST_FALL`` of
        the floor's, and sweeps and sectors support it."""
        s = self.shown
        fall = size**2 * self.square + size * self.linear + s.noise_fall
        tested = size * self.tested + s.tested
        square = np.sum((tested[:, None] @ s.weight)[:, 0] * tested, axis=1)
        least = np.count_nonzero(s.draws.test) * (LEAST_FALL * s.draws.noise.total_rad) ** 2
        accepted = (fall >= least) & (square >= s.critical)
        return np.asarray(accepted & (size * self.fitted[0] + s.fitted[:, 0] > 0.0) if s.one_sign else accepted)


def smallest(ways: Sequence[Detection], power: float) -> float:
    """Size with which the first of ``ways``, or one of the others in its place, is accepted with this power; infinite
    if there is none."""

    def beyond(size: float) -> float:
        return float(np.mean(np.any([way.accepted(size) for way in ways], axis=0))) - power

    first = ways[0]
    draws = first.shown.draws
    seen = max(first.square, 1e-300) / np.count_nonzero(draws.test)
    low = high = LEAST_FALL * draws.noise.total_rad / float(np.sqrt(seen))
    while beyond(low) > 0.0:
        low *= 0.5
    while beyond(high) < 0.0:
        high *= 2.0
        if high > FARTHEST * low:
            return np.inf
    return float(np.exp(brentq(lambda x: beyond(float(np.exp(x))), np.log(low), np.log(high), xtol=SIZE_ERROR)))


def shown(
    columns: Floats, draws: Draws, candidates: int, one_sign: bool = False, slopeless: bool = False
) -> Shown | None:
    """From derivatives (n, k) on the used samples, less what offsets explain of them; None if the run shows nothing.

    ``candidates``: effects that are looked at; ``one_sign``, ``slopeless`` as in :class:`Shown`.
    """
    length, test, k = np.linalg.norm(columns, axis=0), draws.test, columns.shape[1]
    if len(columns) < k or not length.all():
        return None
    unit = columns / length
    train, held = unit[~test], unit[test]
    gram = train.T @ train
    if np.linalg.matrix_rank(gram, hermitian=True) < k:
        return None
    fitted = np.linalg.solve(gram, train.T @ draws.trained).T
    if slopeless:
        noise = draws.noise
        lasting = 1.0 + 2.0 * noise.memory_s / draws.p.step_s
        tested, covariance = fitted, np.full((1, 1, 1), noise.white_rad**2 + lasting * noise.coloured_rad**2)
        critical = (2.0 * float(norm.isf(ALPHA / candidates))) ** 2
    else:
        tested, covariance = draws.tested(unit)
        critical = float(f_distribution.isf(ALPHA / candidates, k, SECTORS - k)) * k * (SECTORS - 1) / (SECTORS - k)
    return Shown(
        unit,
        draws,
        fitted,
        (held.T @ draws.held_out).T,
        held.T @ held,
        tested,
        np.asarray(np.linalg.pinv(covariance, rcond=1e-12, hermitian=True), dtype=np.float64),
        critical,
        one_sign,
        slopeless,
        length,
    )


def worst_phase(columns: Floats) -> Floats:
    """Sizes (k,) of length 1 with which an effect with these derivatives (n, k) shows least in the whole run."""
    if columns.shape[1] == 1:
        return np.ones(1)
    return np.asarray(np.linalg.svd(columns, full_matrices=False)[2][-1])
