"""The noise of few readings: what those that repeat each other scatter by, or what a line or a curve leaves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.by_hand import loadings
from mbcdm_cad.routes import Floats

# Readings repeat each other if inputs and load differ by less than this share of their range. So many degrees of
# freedom tell their scatter; with fewer it is taken from what lines over load and angle leave.
REPEATS_SHARE, FEWEST_REPEATS = 0.05, 4
# Degree of the curve over the logarithm of time beside which readings at rest scatter.
CURVE = 3
# Degrees of freedom of a noise that is known from the steps of the figures alone.
KNOWN = 30


def noise_of(fitter: Fitter, residual_rad: Floats, at_rest: bool) -> tuple[Noise, int]:
    """Scatter of readings that repeat each other, and its degrees of freedom; never below the figures' steps.

    ``residual_rad``: what the declared model leaves of all readings.
    """
    f, declared = fitter, max(p.floor_rad for p in fitter.runs)
    squares, freedom = 0.0, 0
    for part, p in [] if at_rest else zip(f.parts, f.runs, strict=True):
        at = np.flatnonzero(p.used)
        residual, alike = residual_rad[part][at], _groups(p, at)
        for group in np.unique(alike):
            mine = residual[alike == group]
            squares, freedom = squares + float(np.sum((mine - mine.mean()) ** 2)), freedom + mine.size - 1
    source = f"{freedom} repeated readings"
    if freedom < FEWEST_REPEATS:
        left = _curve if at_rest else _lines
        rows = [left(residual_rad[part], p) for part, p in zip(f.parts, f.runs, strict=True)]
        squares, freedom = sum(one[0] for one in rows), sum(one[1] for one in rows)
        source = (
            "what a smooth curve over the logarithm of time leaves"
            if at_rest
            else "what lines over load, angle and direction leave, as too few readings repeat"
        )
    scatter = float(np.sqrt(squares / freedom)) if freedom > 0 else 0.0
    if scatter < declared:
        return Noise(declared, declared, 0.0, 0.0, declared, "the steps of the figures"), KNOWN
    return Noise(scatter, scatter, 0.0, 0.0, declared, source), max(freedom, 1)


def _lines(residual_rad: Floats, p: Prepared) -> tuple[float, int]:
    """Sum of squares that lines over load, angle and direction leave, and its degrees of freedom."""
    at = np.flatnonzero(p.used)
    columns = [np.ones(at.size), p.mean_rad[at], p.sense[at], *([] if p.load_Nm is None else [p.load_Nm[at]])]
    x, y = np.stack(columns, axis=1), residual_rad[at]
    solved, _, rank, _ = np.linalg.lstsq(x, y, rcond=1e-9)
    return float(np.sum((y - x @ solved) ** 2)), max(0, at.size - int(rank))


def _curve(residual_rad: Floats, p: Prepared) -> tuple[float, int]:
    """The same for a cubic over the logarithm of the time since each step of the load."""
    squares, freedom, x, course = 0.0, 0, since(p), _course(p)
    for one in np.unique(course[p.used]):
        at = p.used & (course == one)
        degree = min(CURVE, int(at.sum()) - 3)
        if degree > 0:
            y = residual_rad[at]
            curve = np.polynomial.Polynomial.fit(x[at], y, degree)
            squares, freedom = squares + float(np.sum((y - curve(x[at])) ** 2)), freedom + y.size - degree - 1
    return squares, freedom


def since(p: Prepared) -> Floats:
    """Logarithm of the time since the last step of the load, (n,)."""
    times = np.array([at for at, _ in loadings(p.run)])
    since = p.time_s - times[np.maximum(_course(p) - 1, 0)]
    return np.asarray(np.log10(np.maximum(since, 1e-9)))


def _course(p: Prepared) -> NDArray[np.int64]:
    """Number of steps of the load before each sample, (n,)."""
    return np.searchsorted([at for at, _ in loadings(p.run)], p.time_s, side="left")


def _groups(p: Prepared, at: NDArray[np.int64]) -> NDArray[np.int64]:
    """A number for each of the samples ``at``, the same for readings that repeat each other."""
    columns = [p.mean_rad[at], p.sense[at], *([] if p.load_Nm is None else [p.load_Nm[at]])]
    groups = np.zeros(at.size, dtype=np.int64)
    for values in columns:
        order = np.argsort(values)
        apart = np.diff(values[order], prepend=values[order][0]) > REPEATS_SHARE * max(float(np.ptp(values)), 1e-30)
        level = np.empty(at.size, dtype=np.int64)
        level[order] = np.cumsum(apart)
        groups = groups * (at.size + 1) + level
    return groups
