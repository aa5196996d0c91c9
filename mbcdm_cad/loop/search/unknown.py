"""Describe the error that no effect explains: with what it repeats, how large it is, and its shape as a formula.

A residual repeats in angle (or load, or speed) if its means over bins of that variable agree from sweep to sweep. The
common part is measured by products of different sweeps only, so that noise within a sweep, also coloured noise, does
not count. A time does not occur twice: for a drift in time, sectors of angle are compared instead of sweeps. What does
not repeat is noise; it is none of a sensor where its size hangs on load, speed or time.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.lines import order_spectrum
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.readable import INTERVAL, Value, readable
from mbcdm_cad.loop.search.evidence import LEAST_FALL
from mbcdm_cad.routes import Floats

# Shapes within this of the best one's share are listed too.
CLOSE = 0.03
MOST = 3
# A shape is listed only if it explains at least this share of the curve's variance.
LEAST = 0.6


@dataclass(frozen=True)
class Shape:
    """One shape: its formula in the variable, the share of the curve's variance it explains, and words with sizes."""

    form: str
    explains: float
    words: str


Basis = Callable[[Floats], Floats]
# Formula, words, power of the unit that the coefficient is divided by, basis. A constant is always fitted besides.
FIXED: tuple[tuple[str, str, int, Basis], ...] = (
    ("x", "proportional to {name}", 1, lambda x: x),
    ("x^2", "goes with the square of {name}", 2, np.square),
    ("x |x|", "goes with the square of {name} and its sign", 2, lambda x: x * np.abs(x)),
    ("x^3", "goes with the cube of {name}", 3, lambda x: x**3),
    ("max(x, 0)", "one-sided, proportional to positive {name}", 1, lambda x: np.maximum(x, 0.0)),
    ("max(-x, 0)", "one-sided, proportional to negative {name}", 1, lambda x: np.maximum(-x, 0.0)),
    ("max(x, 0)^2", "one-sided, with the square of positive {name}", 2, lambda x: np.maximum(x, 0.0) ** 2),
    ("max(-x, 0)^2", "one-sided, with the square of negative {name}", 2, lambda x: np.maximum(-x, 0.0) ** 2),
    ("|x|", "goes with the size of {name}", 1, np.abs),
    ("sign(x)", "goes with the sign of {name}", 0, np.sign),
)


def best_shapes(name: str, unit: str, at: Floats, mean: Floats, count: NDArray[np.int64]) -> tuple[Shape, ...]:
    """Shapes that fit a curve ``mean`` (rad) over ``at`` (``unit``), weighted by ``count``, best first."""
    if at.size < 6:
        return ()
    weight = np.sqrt(count / count.sum())
    found = []
    for form, words, power, basis in FIXED:
        explains, size = _explained(basis(at)[:, None], mean, weight)
        per = f" rad/({unit})" + (f"^{power}" if power > 1 else "") if power else " rad"
        found.append(Shape(form, explains, f"{words.format(name=name)}: {size[0]:.3g}{per}"))
    found += [_bump(name, unit, at, mean, weight), _step(name, unit, at, mean, weight)]
    found.sort(key=lambda shape: -shape.explains)
    best = found[0].explains
    return tuple(shape for shape in found[:MOST] if shape.explains >= max(LEAST, best - CLOSE))


def _explained(columns: Floats, mean: Floats, weight: Floats) -> tuple[float, Floats]:
    """Share of the weighted variance that the columns and a constant explain, and the coefficients."""
    x = np.column_stack([np.ones(mean.size), columns]) * weight[:, None]
    y = mean * weight
    solved = np.linalg.lstsq(x, y, rcond=1e-10)[0]
    left = float(np.sum((y - x @ solved) ** 2))
    level = float(np.sum(weight * y) / np.sum(weight**2))
    whole = float(np.sum((y - weight * level) ** 2))
    return (1.0 - left / whole if whole > 0.0 else 0.0), np.asarray(solved[1:], dtype=float)


def _bump(name: str, unit: str, at: Floats, mean: Floats, weight: Floats) -> Shape:
    """A bump at one place, Gaussian."""
    span = float(np.ptp(at))
    best = (-np.inf, 0.0, 0.0, 0.0)
    for width in span * np.geomspace(0.01, 0.15, 8):
        for centre in at:
            explains, size = _explained(np.exp(-0.5 * ((at - centre) / width) ** 2)[:, None], mean, weight)
            if explains > best[0]:
                best = explains, float(centre), float(width), float(size[0])
    explains, centre, width, height = best
    tall = readable("_rad", [height])[1][0]
    words = f"a bump of {tall} at {name} {centre:.4g} {unit}, {2.355 * width:.3g} {unit} wide at half height"
    return Shape("exp(-((x - x0)/w)^2 / 2)", explains, words)


def _step(name: str, unit: str, at: Floats, mean: Floats, weight: Floats) -> Shape:
    """A step at one place."""
    best = (-np.inf, 0.0, 0.0)
    for k in range(2, at.size - 2):
        explains, size = _explained((np.arange(at.size) >= k).astype(float)[:, None], mean, weight)
        if explains > best[0]:
            best = explains, float(0.5 * (at[k - 1] + at[k])), float(size[0])
    explains, place, height = best
    tall = readable("_rad", [height])[1][0]
    return Shape("x > x0", explains, f"a step of {tall} at {name} {place:.4g} {unit}")


# A pattern counts if its RMS over the noise floor is what a named effect has at least, and if its mean product stands
# this many standard errors off zero.
LEAST_ERRORS = 3.0
# A pattern must explain at least this share of the residual's mean square to describe it.
LEAST_SHARE = 0.15
# A second variable within this factor of the best one counts as equally good.
ALIKE = 0.85
ANGLE_BINS = 48
OTHER_BINS = 16
# Samples that a bin needs in one sweep and in all sweeps together: with fewer samples the bins are wider.
LEAST_IN_BIN = 2
MEAN_IN_BIN = 8
LEAST_BINS = 8


@dataclass(frozen=True, eq=False)
class Pattern:
    """How a residual repeats in one variable.

    ``variable``: angle, load, speed, time; with "by direction" where the two senses of motion have their own curve.
    ``at`` and ``mean_rad``: the curve over the bins, shape (m,), ``at`` in ``unit``. ``rms_rad`` of what repeats, its
    ``share`` of the residual's mean square, ``errors``: how many standard errors it stands off zero.
    """

    variable: str
    unit: str
    at: Floats
    mean_rad: Floats
    rms_rad: float
    share: float
    errors: float
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, eq=False)
class Unknown:
    """A residual that no effect of the library explains.

    ``rms_rad`` is what stands above the noise floor, ``ci95_rad`` its interval; ``patterns`` that repeat, largest
    first; none if it does not repeat. ``alike``: further variables that describe it about as well. ``memory_s``:
    correlation time of the residual. ``lines``: (cycles a turn of the drum, amplitude) of the highest peaks of the
    order spectrum, which show errors too fast for the bins. All sizes in rad.
    """

    rms_rad: float
    peak_rad: float
    floor_rad: float
    patterns: tuple[Pattern, ...]
    alike: tuple[str, ...]
    memory_s: float
    lines: tuple[tuple[float, float], ...]
    ci95_rad: tuple[float, float] = (0.0, np.inf)

    @property
    def repeatable(self) -> bool:
        """Whether any part of it repeats."""
        return bool(self.patterns)

    def sentence(self) -> str:
        """For people."""
        repeats_rad = self.patterns[0].rms_rad if self.patterns else 0.0
        figures = [self.rms_rad, *self.ci95_rad, self.peak_rad, repeats_rad]
        _, (rms, low, high, peak, repeats) = readable("_rad", figures)
        size = f"{rms} RMS above the noise ({low.split(' ')[0]} to {high}), {peak} at most"
        if not self.patterns:
            return f"{size}; does not repeat in angle, load, speed or time; correlation time {self.memory_s:.2g} s"
        best = self.patterns[0]
        words = f"{size}; repeats in {best.variable}: {repeats} RMS, {best.share:.0%} of what is left"
        if best.shapes:
            words += f"; {best.shapes[0].words}"
        if self.alike:
            words += f"; this run cannot tell it from {', '.join(self.alike)}"
        return words

    def to_json(self) -> dict[str, Any]:
        """For the result file."""
        return {
            "description": self.sentence(),
            "repeatable": self.repeatable,
            "rms_rad": self.rms_rad,
            "rms_ci95_rad": list(self.ci95_rad),
            "peak_rad": self.peak_rad,
            "memory_s": self.memory_s,
            "order_spectrum_peaks": [{"cycles_per_output_rev": n, "amplitude_rad": a} for n, a in self.lines],
            "not_told_from": list(self.alike),
            "patterns": [
                {
                    "variable": p.variable,
                    "unit": p.unit,
                    "rms_rad": p.rms_rad,
                    "share": p.share,
                    "standard_errors": p.errors,
                    "at": [round(float(x), 9) for x in p.at],
                    "mean_rad": [float(y) for y in p.mean_rad],
                    "shapes": [{"form": s.form, "explains": s.explains, "words": s.words} for s in p.shapes],
                }
                for p in self.patterns
            ],
        }


def describe_unknown(p: Prepared, residual_rad: Floats, floor_rad: float) -> Unknown:
    """Describe a residual (rad, shape (n,), all samples of the run); ``floor_rad`` says how small a pattern counts.

    Whether the residual is too large at all is for the caller to test.
    """
    use = p.used
    r = residual_rad[use] - residual_rad[use].mean()
    square = float(np.mean(r**2))
    sweep, sector = p.sweep[use], p.sector[use]
    sense = np.where(np.sign(p.speed_rad_s[use]) >= 0.0, 1, 0)
    variables: list[tuple[str, str, Floats, int]] = [("angle", "rad", p.output_rad[use], ANGLE_BINS)]
    if p.load_Nm is not None:
        variables.append(("load", "N*m", p.load_Nm[use], OTHER_BINS))
    variables.append(("speed", "rad/s", p.speed_rad_s[use], OTHER_BINS))
    plain, split = [], []
    enough = max(LEAST_BINS, r.size // (MEAN_IN_BIN * np.unique(sweep).size))
    for name, unit, x, bins in variables:
        index = _binned(x, min(bins, enough))
        plain.append(_pattern(name, unit, x, index, r, sweep, square, floor_rad))
        if name != "speed":
            by_sense = _pattern(f"{name} by direction", unit, x, index * 2 + sense, r, sweep, square, floor_rad)
            split.append(by_sense)
    # Two curves, one for each direction, are reported only if they explain clearly more than one.
    most = max((one.share for one in plain if one), default=0.0)
    found = [*plain, *(one for one in split if one and one.share > most + LEAST_SHARE)]
    t = p.time_s[use]
    found.append(_pattern("time", "s", t, sweep // 2, r, sector, square, floor_rad))
    patterns = sorted((one for one in found if one is not None), key=lambda one: -one.share)
    alike = tuple(one.variable for one in patterns[1:] if one.share >= ALIKE * patterns[0].share)
    peak = float(np.quantile(np.abs(r), 0.999))
    lines = _lines(p.output_rad[use], r)
    memory, size = memory_s(r, sweep, p.step_s), rms_value(r, sweep, floor_rad)
    return Unknown(size.value, peak, floor_rad, tuple(patterns), alike, memory, lines, (size.low, size.high))


def rms_value(r: Floats, sweep: NDArray[np.int64], floor_rad: float = 0.0) -> Value:
    """RMS of ``r`` (rad, (n,)) above a floor in quadrature, with the interval of its scatter between half sweeps."""
    number = np.unique(sweep, return_inverse=True)[1]
    squares = np.bincount(number, r**2) / np.bincount(number)
    square = float(np.mean(r**2))
    half = INTERVAL * float(np.std(squares, ddof=1)) / np.sqrt(squares.size) if squares.size > 1 else square
    ends = (square + way * half - floor_rad**2 for way in (0.0, -1.0, 1.0))
    return Value(*(float(np.sqrt(max(0.0, end))) for end in ends))


def _lines(angle_rad: Floats, r: Floats, most: int = 3) -> tuple[tuple[float, float], ...]:
    """The highest peaks of the order spectrum, two cycles a travel apart or more."""
    orders, amplitude = order_spectrum(angle_rad, r)
    apart = 4.0 * np.pi / float(np.ptp(angle_rad))
    found: list[tuple[float, float]] = []
    for k in np.argsort(amplitude)[::-1]:
        if all(abs(orders[k] - order) > apart for order, _ in found):
            found.append((float(orders[k]), float(amplitude[k])))
        if len(found) == most:
            break
    return tuple(found)


def _binned(x: Floats, bins: int) -> NDArray[np.int64]:
    """Bins of equal width over the range of ``x``."""
    low, span = float(x.min()), float(np.ptp(x)) or 1.0
    return np.minimum(((x - low) / span * bins).astype(np.int64), bins - 1)


def _pattern(
    name: str,
    unit: str,
    x: Floats,
    index: NDArray[np.int64],
    r: Floats,
    group: NDArray[np.int64],
    square: float,
    floor_rad: float,
) -> Pattern | None:
    """The pattern that the bin means of all groups of samples (sweeps or sectors) share; None if it is too small."""
    shared, errors, count = shared_square(index, r, group)
    if shared <= 0.0 or errors < LEAST_ERRORS:
        return None
    rms, share = float(np.sqrt(shared)), shared / square
    if rms < LEAST_FALL * floor_rad or share < LEAST_SHARE:
        return None
    kept = np.flatnonzero(count >= LEAST_IN_BIN)
    at = np.bincount(index, x)[kept] / count[kept]
    mean = np.bincount(index, r)[kept] / count[kept]
    order = np.argsort(at)
    at, mean = at[order], mean[order]
    shapes = () if "direction" in name else best_shapes(name, unit, at, mean, count[kept][order])
    return Pattern(name, unit, at, mean, rms, min(share, 1.0), errors, shapes)


def shared_square(
    index: NDArray[np.int64], values: Floats, group: NDArray[np.int64]
) -> tuple[float, float, NDArray[np.int64]]:
    """Mean product of bin means of different groups, how many standard errors it is off zero, samples in each bin.

    The standard error is that of a jackknife over groups, so that no single sweep decides.
    """
    groups, number = np.unique(group, return_inverse=True)
    bins = int(index.max()) + 1
    cell = number * bins + index
    count = np.bincount(cell, minlength=groups.size * bins).reshape(groups.size, bins)
    total = np.bincount(cell, values, groups.size * bins).reshape(groups.size, bins)
    full = count >= LEAST_IN_BIN
    mean = np.where(full, total / np.maximum(count, 1), 0.0)
    weight = count.sum(axis=0).astype(float)

    def product(chosen: NDArray[np.bool_]) -> float:
        m, f = mean[chosen], full[chosen]
        n = f.sum(axis=0)
        pairs = n * (n - 1)
        good = pairs > 0
        if not good.any():
            return 0.0
        cross = m.sum(axis=0) ** 2 - (m**2).sum(axis=0)
        return float(np.sum(weight[good] * cross[good] / pairs[good]) / np.sum(weight[good]))

    everything = np.ones(groups.size, dtype=np.bool_)
    shared = product(everything)
    if groups.size < 3:
        return 0.0, 0.0, count.sum(axis=0)
    less = np.array([product(np.arange(groups.size) != k) for k in range(groups.size)])
    error = float(np.sqrt((groups.size - 1) / groups.size * np.sum((less - less.mean()) ** 2)))
    return shared, shared / error if error > 0.0 else np.inf, count.sum(axis=0)


def memory_s(values: Floats, sweep: NDArray[np.int64], step_s: float) -> float:
    """Time after which the autocorrelation within sweeps has fallen below 1/e."""
    lags = np.unique(np.geomspace(1, max(2, values.size // 4), 60).astype(int))
    square = float(np.mean(values**2)) or 1.0
    for lag in lags:
        same = sweep[lag:] == sweep[:-lag]
        if not same.any():
            break
        if float(np.mean((values[lag:] * values[:-lag])[same])) < square / np.e:
            return float(lag * step_s)
    return float(lags[-1] * step_s)


# Least ratio of the noise between the two ends, and least slope over its error.
LEAST_RATIO, SURE_ERRORS = 2.0, 5.0
# Sweeps and samples of a cell that are needed to say anything.
FEWEST_SWEEPS, FEWEST_SAMPLES = 6, 8
# Ends of a quantity, as shares of the cells.
ENDS = (0.1, 0.9)
CAUSES = {
    "load": "the stiffness or the tension of the drive changes during the run, or the torque sensor lags",
    "speed": "time stamps that jitter, or a delay that changes",
    "time": "something of the drive or the bench changes during the run",
}


@dataclass(frozen=True)
class Scatter:
    """Noise that hangs on a quantity: its RMS where that is small and where it is large, rad."""

    quantity: str
    low_rad: float
    high_rad: float

    @property
    def words(self) -> str:
        """For people."""
        _, (low, high) = readable("_rad", [self.low_rad, self.high_rad])
        ends = {"time": ("at first", "in the end")}.get(self.quantity, (f"at small {self.quantity}", "at large"))
        return (
            f"what does not repeat hangs on the {self.quantity}: {low} RMS {ends[0]}, {high} {ends[1]}; no noise of an "
            f"encoder does: {CAUSES[self.quantity]}"
        )


def hangs_on(p: Prepared, residual: Floats) -> Scatter | None:
    """The quantity on which the noise of a run hangs most surely; None if it is the same everywhere, as a sensor's is.

    ``residual`` (rad, (n,)) is what all effects leave. Its mean square over cells of sweep and sector is compared, as
    its logarithm, with the mean of each quantity there. A quantity counts if the noise is twice as large at one end as
    at the other, and if whole sweeps agree on it (slope over its error, clustered by sweep). A drive that changes in
    mid-run has noise that hangs on load and time; time stamps that jitter have noise that hangs on the speed.
    """
    use = p.used
    sweeps, sweep = np.unique(p.sweep[use], return_inverse=True)
    if sweeps.size < FEWEST_SWEEPS:
        return None
    cell = sweep * (int(p.sector.max()) + 1) + p.sector[use]
    _, cell = np.unique(cell, return_inverse=True)
    count = np.bincount(cell)
    full = count >= FEWEST_SAMPLES
    if full.sum() < FEWEST_SWEEPS:
        return None
    square = np.bincount(cell, (residual[use] - residual[use].mean()) ** 2) / count
    of_sweep = np.zeros(count.size, dtype=np.int64)
    of_sweep[cell] = sweep
    quantities: dict[str, Floats] = {"speed": np.abs(p.speed_rad_s), "time": p.time_s}
    if p.load_Nm is not None and p.load_Nm.any():
        quantities["load"] = np.abs(p.load_Nm)
    found: list[tuple[float, Scatter]] = []
    for name, values in quantities.items():
        at = (np.bincount(cell, values[use]) / count)[full]
        low, high = np.quantile(at, ENDS)
        log_square, groups = np.log(square[full] + 1e-300), of_sweep[full]
        x = at - at.mean()
        if not x.any() or high <= low:
            continue
        slope = float(x @ log_square / (x @ x))
        rest = x * (log_square - log_square.mean() - slope * x)
        error = float(np.sqrt(np.sum(np.bincount(groups, rest) ** 2))) / float(x @ x)
        ratio = float(np.exp(0.5 * slope * (high - low)))
        if error > 0.0 and abs(slope) / error >= SURE_ERRORS and max(ratio, 1.0 / ratio) >= LEAST_RATIO:
            middle = float(log_square.mean())
            ends = (np.exp(0.5 * (middle + slope * (end - at.mean()))) for end in (low, high))
            found.append((abs(slope) / error, Scatter(name, *(float(end) for end in ends))))
    return max(found, key=lambda one: one[0])[1] if found else None
