"""The noise floor: the part of the residual that does not repeat in the data.

An error of the drive repeats at the same angle, direction, load and speed. The residual is regressed on flexible curves
of these quantities, on the strongest lines of its spectrum, and on what happens once or slowly (a step, warming,
settling, a drive that changes). The part of a half sweep that the curves fitted on all other half sweeps do not predict
is noise, white or coloured. The declared steps of the sensors are its lower bound; a data sheet seldom states more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.events import time_of_change
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
# The same for what changes during the run, which lasts: it is drawn to zero more, so that it leaves all else alone.
CHANGE_PRIOR_S = 4.0
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
    pairs = list(zip(setups, residuals, strict=True))
    if len(pairs) > 1 and any(not s.p.few and np.unique(s.p.sweep[s.p.train]).size < FEWEST_SWEEPS for s in setups):
        return _of_runs(pairs)
    each = [_of_runs([pair]) for pair in pairs]

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


def _of_runs(pairs: Sequence[tuple[Setup, Floats]]) -> Noise:
    """The noise of one run, or of several that repeat each other and have too few half sweeps each."""
    sweeps, each, last = [], [], -1
    for setup, residual in pairs:
        p = setup.p
        at = np.flatnonzero(p.train)
        at = at[:: max(1, at.size * len(pairs) // MOST_SAMPLES)]
        each.append(_Samples.of(setup, residual, at))
        sweeps.append(p.sweep[at] + last + 1)
        last = int(sweeps[-1].max(initial=last))
    sweep = np.concatenate(sweeps)
    p, residual = pairs[0][0].p, pairs[0][1]
    if p.few or np.unique(sweep).size < FEWEST_SWEEPS:
        slow = smoothed(residual, FAST_S, p.step_s)
        fast = float(np.std((residual - slow)[p.train])) * _rest_of_white(FAST_S, p.step_s)
        total = max(fast, p.floor_rad) or 1e-12
        return Noise(total, total, 0.0, 0.0, p.floor_rad, f"what is faster than {FAST_S:g} s, since nothing repeats")
    samples = _Samples.together(each)
    columns, prior = _curves(samples)
    declared = max(setup.p.floor_rad for setup, _ in pairs)
    left, square = _left_out(columns, prior, samples.residual - samples.residual.mean(), sweep)
    total = max(float(np.sqrt(square)), declared, 1e-12)
    white, memory = _colour(left, sweep, np.diff(samples.elapsed_s, prepend=samples.elapsed_s[0]))
    white = min(white, total)
    source = "scatter between half sweeps at the same angle, direction, load and speed"
    if total == declared:
        source, white = "steps of the encoders as declared; the scatter between half sweeps is not above them", total
    return Noise(total, white, float(np.sqrt(total**2 - white**2)), memory, declared, source)


def _rest_of_white(window_s: float, step_s: float) -> float:
    """Factor from the RMS of white noise minus its moving mean to the RMS of the noise."""
    width = 2 * round(window_s / (4.0 * step_s)) + 1
    return float(1.0 / np.sqrt(max(1.0 - 2.0 / width + 2.0 / (3.0 * width), 0.2))) if width > 1 else 1.0


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples of one run or of several, (n,) each: what an error may repeat with; ``orders`` of its strongest lines."""

    angle_rad: Floats
    speed_rad_s: Floats
    elapsed_s: Floats
    path_rad: Floats
    load_Nm: Floats | None
    temperature_C: Floats | None
    residual: Floats
    run: NDArray[np.int64]
    orders: tuple[float, ...]
    duration_s: float
    step_s: float

    @classmethod
    def of(cls, setup: Setup, residual: Floats, at: NDArray[np.int64]) -> _Samples:
        """The samples ``at`` of a run."""
        p = setup.p
        return cls(
            p.output_rad[at],
            p.speed_rad_s[at],
            p.time_s[at] - p.time_s[0],
            p.path_rad[at],
            None if p.load_Nm is None else p.load_Nm[at],
            None if p.temperature_C is None else p.temperature_C[at],
            residual[at],
            np.zeros(at.size, dtype=np.int64),
            tuple(strongest_orders(setup, residual, MOST_LINES)),
            float(p.time_s[-1] - p.time_s[0]),
            p.step_s,
        )

    @classmethod
    def together(cls, each: Sequence[_Samples]) -> _Samples:
        """The samples of all runs, with the lines of the first."""

        def joined(name: str) -> Any:
            rows = [getattr(one, name) for one in each]
            return None if any(row is None for row in rows) else np.concatenate(rows)

        names = ("angle_rad", "speed_rad_s", "elapsed_s", "path_rad", "load_Nm", "temperature_C", "residual")
        run = np.concatenate([np.full(one.residual.size, k) for k, one in enumerate(each)])
        rows = {name: joined(name) for name in names}
        return replace(each[0], **rows, run=run, duration_s=max(one.duration_s for one in each))


def curves(setup: Setup, residual: Floats, at: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Columns (n, k) on which a residual is regressed, and the weight that draws each to zero, in samples (k,)."""
    return _curves(_Samples.of(setup, residual, at))


def _curves(s: _Samples) -> tuple[Floats, Floats]:
    angle, speed, t = s.angle_rad, s.speed_rad_s, s.elapsed_s
    forward = speed >= 0.0
    senses = [forward, ~forward] if 0.02 < float(forward.mean()) < 0.98 else [np.ones_like(forward)]
    free: list[Floats] = [np.asarray(s.run == k, dtype=float) for k in np.unique(s.run)]
    free.append(_unit(angle))
    drawn: list[Floats] = []
    for sense in senses:
        drawn += [hat * sense for hat in _hats(angle, ANGLE_KNOTS)]
    drawn += _hats(speed, SPEED_KNOTS)
    if s.load_Nm is not None and np.ptp(s.load_Nm) > 0.0:
        load = s.load_Nm
        free += [_unit(load), _unit(load) * _unit(angle)]
        for sense in senses:
            drawn += [hat * sense for hat in _hats(load, LOAD_KNOTS)]
            drawn += [_unit(load) * _unit(angle) * sense]
    drawn += [1.0 - np.exp(-t / (share * s.duration_s)) for share in (0.02, 0.1, 0.4)]
    drawn += [np.log1p(t / (share * s.duration_s)) for share in (0.005, 0.05)]
    drawn += [_unit(t), _unit(s.path_rad)]
    if s.temperature_C is not None and np.ptp(s.temperature_C) > 0.0:
        drawn.append(_unit(s.temperature_C))
    drawn.append(_step(s.residual))
    for order in s.orders:
        drawn += [np.cos(order * angle), np.sin(order * angle)]
    changed = _changed(s)
    weights = (1e-6, max(1.0, PRIOR_S / s.step_s), max(1.0, CHANGE_PRIOR_S / s.step_s))
    prior = np.repeat(weights, [len(free), len(drawn), len(changed)])
    return np.stack([*free, *drawn, *changed], axis=1), prior


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


def _changed(s: _Samples) -> list[Floats]:
    """What a drive that changes during the run adds: load, sense of motion and angle, from a time on and more and more.

    The angle counts about the middle of its range, the place of the drum at rest.
    """
    shapes = [np.sign(s.speed_rad_s), _unit(s.angle_rad)]
    if s.load_Nm is not None and np.ptp(s.load_Nm) > 0.0:
        shapes.append(_unit(s.load_Nm))
    found = []
    for shape in shapes:
        for run in np.unique(s.run):
            mine = s.run == run
            after = mine & (s.elapsed_s > time_of_change(s.elapsed_s[mine], shape[mine], s.residual[mine]))
            found.append(shape * after)
        found.append(shape * s.elapsed_s / s.duration_s)
    return found


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
