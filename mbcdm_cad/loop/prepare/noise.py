"""The noise floor: the part of the residual that does not repeat in the data.

An error of the drive repeats at the same angle, direction, load and speed. The residual is regressed on flexible curves
of these quantities, on the strongest lines of its spectrum, and on what happens once or slowly (a step, warming,
settling). The part of a half sweep that the curves fitted on all other half sweeps do not predict is noise, white or
coloured. The declared steps of the sensors are its lower bound; a data sheet seldom states more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.lines import strongest_orders
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.quiet import SignalNoise
from mbcdm_cad.loop.prepare.setup import Setup
from mbcdm_cad.measurement.run import smoothed
from mbcdm_cad.routes import Floats

# Knots of the curves over angle, load and speed.
ANGLE_KNOTS, LOAD_KNOTS, SPEED_KNOTS = 24, 9, 6
# A knot with less than this much time near it is drawn to zero.
PRIOR_S = 0.2
# Half sweeps that are needed to fit and to judge; with fewer, repetition cannot be tested.
FEWEST_SWEEPS = 4
# Samples that the regression works on.
MOST_SAMPLES = 20_000
# Lines of the spectrum that are fitted first.
MOST_LINES = 3
# Where repetition cannot be tested, everything faster than this counts as noise, s.
FAST_S = 0.1
# If the floor is so many times the declared one, the sensor or its data sheet is doubtful.
FAR_ABOVE = 1.5


@dataclass(frozen=True)
class Noise:
    """The part of the residual that does not repeat, rad RMS.

    ``total_rad`` is the floor in use; ``white_rad`` and ``coloured_rad`` its parts (quadratic sum), ``memory_s`` the
    correlation time of the coloured part, ``declared_rad`` the noise from the sensors' declared steps alone, 0 where
    they are not given. ``source`` says how it was found. For planning runs: ``likely``, equally likely shares of the
    mean square that last, with their correlation times, and ``signals``, the noise of the signals that drive the
    friction, None where the planned run shall have its own.
    """

    total_rad: float
    white_rad: float
    coloured_rad: float
    memory_s: float
    declared_rad: float
    source: str
    likely: tuple[tuple[float, float], ...] = ()
    signals: SignalNoise | None = None

    @property
    def far_above(self) -> bool:
        """Whether it is far above the noise that the sensors are declared to have."""
        return 0.0 < self.declared_rad * FAR_ABOVE < self.total_rad

    def to_json(self) -> dict[str, float | str]:
        """For the result file."""
        return {
            "floor_rad": self.total_rad,
            "white_rad": self.white_rad,
            "coloured_rad": self.coloured_rad,
            "memory_s": self.memory_s,
            "declared_rad": self.declared_rad,
            "source": self.source,
        }


def noise_of(setups: Sequence[Setup], residuals: Sequence[Floats]) -> Noise:
    """The noise of several runs together; each residual (n,) covers all samples of its run."""
    each = [_of_run(setup, residual) for setup, residual in zip(setups, residuals, strict=True)]

    def together(values: Sequence[float]) -> float:
        return float(np.sqrt(np.mean(np.square(values))))

    coloured = [one.coloured_rad for one in each]
    return Noise(
        together([one.total_rad for one in each]),
        together([one.white_rad for one in each]),
        together(coloured),
        each[int(np.argmax(coloured))].memory_s,
        together([one.declared_rad for one in each]) if all(one.declared_rad > 0.0 for one in each) else 0.0,
        "; ".join(dict.fromkeys(one.source for one in each)),
    )


def _of_run(setup: Setup, residual: Floats) -> Noise:
    p = setup.p
    at = np.flatnonzero(p.train)
    at = at[:: max(1, at.size // MOST_SAMPLES)]
    sweep = p.sweep[at]
    if p.few or np.unique(sweep).size < FEWEST_SWEEPS:
        slow = smoothed(residual, FAST_S, p.step_s)
        fast = float(np.std((residual - slow)[p.train])) * _rest_of_white(FAST_S, p.step_s)
        total = max(fast, p.floor_rad) or 1e-12
        return Noise(total, total, 0.0, 0.0, p.floor_rad, f"what is faster than {FAST_S:g} s, since nothing repeats")
    columns, prior = curves(setup, residual, at)
    y = residual[at] - residual[at].mean()
    left, square = _left_out(columns, prior, y, sweep)
    total = max(float(np.sqrt(square)), p.floor_rad, 1e-12)
    white, memory = _colour(left, sweep, np.diff(p.time_s[at], prepend=p.time_s[at[0]]))
    white = min(white, total)
    source = "scatter between half sweeps at the same angle, direction, load and speed"
    if total == p.floor_rad:
        source, white = "steps of the encoders as declared; the scatter between half sweeps is not above them", total
    return Noise(total, white, float(np.sqrt(total**2 - white**2)), memory, p.floor_rad, source)


def _rest_of_white(window_s: float, step_s: float) -> float:
    """Factor from the RMS of white noise minus its moving mean to the RMS of the noise."""
    width = 2 * round(window_s / (4.0 * step_s)) + 1
    return float(1.0 / np.sqrt(max(1.0 - 2.0 / width + 2.0 / (3.0 * width), 0.2))) if width > 1 else 1.0


def curves(setup: Setup, residual: Floats, at: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Columns (n, k) on which a residual is regressed, and the weight that draws each to zero, in samples (k,)."""
    p = setup.p
    angle, speed, t = p.output_rad[at], p.speed_rad_s[at], p.time_s[at] - p.time_s[0]
    forward = speed >= 0.0
    senses = [forward, ~forward] if 0.02 < float(forward.mean()) < 0.98 else [np.ones_like(forward)]
    free: list[Floats] = [np.ones_like(angle), _unit(angle)]
    drawn: list[Floats] = []
    for sense in senses:
        drawn += [hat * sense for hat in _hats(angle, ANGLE_KNOTS)]
    drawn += _hats(speed, SPEED_KNOTS)
    if p.load_Nm is not None and np.ptp(p.load_Nm[at]) > 0.0:
        load = p.load_Nm[at]
        free += [_unit(load), _unit(load) * _unit(angle)]
        for sense in senses:
            drawn += [hat * sense for hat in _hats(load, LOAD_KNOTS)]
            drawn += [_unit(load) * _unit(angle) * sense]
    duration = float(p.time_s[-1] - p.time_s[0])
    drawn += [1.0 - np.exp(-t / (share * duration)) for share in (0.02, 0.1, 0.4)]
    drawn += [np.log1p(t / (share * duration)) for share in (0.005, 0.05)]
    if p.temperature_C is not None and np.ptp(p.temperature_C[at]) > 0.0:
        drawn.append(_unit(p.temperature_C[at]))
    drawn.append(_step(residual[at]))
    for order in strongest_orders(setup, residual, MOST_LINES):
        drawn += [np.cos(order * angle), np.sin(order * angle)]
    prior = np.concatenate([np.full(len(free), 1e-6), np.full(len(drawn), max(1.0, PRIOR_S / p.step_s))])
    return np.stack([*free, *drawn], axis=1), prior


def _unit(values: Floats) -> Floats:
    """Values about their middle, from -1 to 1."""
    low, high = float(values.min()), float(values.max())
    return np.asarray((2.0 * values - low - high) / ((high - low) or 1.0))


def _hats(values: Floats, knots: int) -> list[Floats]:
    """Linear B-splines over the range of ``values``: any curve that is straight between the knots is a sum of them."""
    low, span = float(values.min()), float(np.ptp(values))
    if span == 0.0:
        return []
    place = (values - low) / span * (knots - 1)
    return [np.asarray(np.maximum(0.0, 1.0 - np.abs(place - k))) for k in range(knots)]


def _step(residual: Floats) -> Floats:
    """A step at the time at which it explains most of the residual."""
    r = residual - residual.mean()
    n = r.size
    k = np.arange(1, n)
    gain = np.cumsum(r)[:-1] ** 2 * n / (k * (n - k))
    return np.asarray(np.arange(n) > int(np.argmax(gain)), dtype=float)


def _left_out(columns: Floats, prior: Floats, y: Floats, sweep: NDArray[np.int64]) -> tuple[Floats, float]:
    """The residual of the curves (n,), and its mean square on sweeps that were not fitted, corrected for bias.

    On fitted sweeps it is too small and on others too large, by about the same factor: the geometric mean of the two is
    the noise. The sums of each sweep are computed once; leaving a sweep out subtracts its sums.
    """
    scale = np.sqrt(np.mean(columns**2, axis=0)) + 1e-30
    columns = columns / scale
    groups, number = np.unique(sweep, return_inverse=True)
    wide = columns.shape[1]
    grams, sides = np.zeros((groups.size, wide, wide)), np.zeros((groups.size, wide))
    squares = np.zeros(groups.size)
    for k in range(groups.size):
        mine = number == k
        grams[k], sides[k] = columns[mine].T @ columns[mine], columns[mine].T @ y[mine]
        squares[k] = float(y[mine] @ y[mine])
    ridge = np.diag(prior / scale**2)
    gram, side = grams.sum(axis=0), sides.sum(axis=0)
    solved = np.linalg.solve(gram + ridge, side)
    left = y - columns @ solved
    others = np.linalg.solve(gram[None] - grams + ridge, (side - sides)[..., None])[..., 0]
    unseen = squares - 2.0 * np.einsum("gi,gi->g", others, sides) + np.einsum("gi,gij,gj->g", others, grams, others)
    seen = float(np.mean(left**2))
    return left, float(np.sqrt(seen * max(float(unseen.sum()) / y.size, seen)))


def _colour(left: Floats, sweep: NDArray[np.int64], steps_s: Floats) -> tuple[float, float]:
    """RMS of the white part, and the correlation time of the rest in s, from the autocovariance within half sweeps."""
    step = float(np.median(steps_s[1:]))
    lags = np.unique(np.geomspace(1, max(3, left.size // 8), 40).astype(int))

    def covariance(lag: int) -> float:
        same = sweep[lag:] == sweep[:-lag]
        return float(np.mean((left[lag:] * left[:-lag])[same])) if same.any() else 0.0

    found = np.array([covariance(int(lag)) for lag in lags])
    square = float(np.mean(left**2))
    coloured = float(np.clip(2.0 * found[0] - found[1], 0.0, square)) if found[0] > 0.0 else 0.0
    below = np.flatnonzero(found < coloured / np.e)
    memory = float(lags[below[0] if below.size else -1]) * step if coloured > 0.05 * square else 0.0
    return float(np.sqrt(square - coloured)), memory


def doubt_of(noise: Noise, names: str) -> str:
    """A sentence where the noise is far above what the file declares; ``names`` are the runs."""
    return (
        f"{names}: the sensors are noisier than declared: {1e6 * noise.total_rad:.3g} urad RMS do not repeat, where "
        f"the declared steps make {1e6 * noise.declared_rad:.3g} urad (white {1e6 * noise.white_rad:.3g}, coloured "
        f"{1e6 * noise.coloured_rad:.3g} urad"
        + (f" with a memory of {noise.memory_s:.2g} s" if noise.memory_s else "")
        + "); check mounts, cables and supply of the encoders, or declare their angle noise"
    )


def runs_of(prepared: Sequence[Prepared]) -> str:
    """Names of the runs, for a message."""
    return ", ".join(dict.fromkeys(p.run.source or "run" for p in prepared))
