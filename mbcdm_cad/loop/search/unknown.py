"""Describe the error that no effect explains: with what it repeats, how large it is, and its shape as a formula.

A residual repeats in angle (or load, or speed) if a curve of that variable is certain beside the noise of the run,
white and coloured, by the evidence with which causes are named. What does not repeat is noise; it is none of a sensor
where its size hangs on load, speed or time.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import order_spectrum
from mbcdm_cad.loop.readable import INTERVAL, Value, readable
from mbcdm_cad.loop.search.evidence import LOG_ODDS, NoiseModel, Whitened
from mbcdm_cad.loop.search.problem import hats_over, unit_columns
from mbcdm_cad.routes import Floats

# Knots of a curve over each variable.
KNOTS = 48


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


def best_shape(name: str, unit: str, at: Floats, mean: Floats, count: Floats) -> Shape:
    """The shape that explains most of a curve ``mean`` (rad) over ``at`` (``unit``), weighted by ``count``."""
    weight = np.sqrt(count / count.sum())
    found = []
    for form, words, power, basis in FIXED:
        explains, size = _explained(basis(at)[:, None], mean, weight)
        per = f" rad/({unit})" + (f"^{power}" if power > 1 else "") if power else " rad"
        found.append(Shape(form, explains, f"{words.format(name=name)}: {size[0]:.3g}{per}"))
    found += [_bump(name, unit, at, mean, weight), _step(name, unit, at, mean, weight)]
    return max(found, key=lambda shape: shape.explains)


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


@dataclass(frozen=True, eq=False)
class Pattern:
    """How a residual repeats in one variable.

    ``variable``: angle, load, speed, time; with "by direction" where the two senses of motion have their own curve.
    ``at`` and ``mean_rad``: the curve at its knots, shape (m,), ``at`` in ``unit``. ``rms_rad`` of what repeats, its
    ``share`` of the residual's mean square, ``log``: logarithm of its evidence; ``shape``, None of two curves.
    """

    variable: str
    unit: str
    at: Floats
    mean_rad: Floats
    rms_rad: float
    share: float
    log: float
    shape: Shape | None


@dataclass(frozen=True, eq=False)
class Unknown:
    """A residual that no effect of the library explains.

    ``rms_rad`` is what stands above the noise floor, ``ci95_rad`` its interval; ``patterns`` that repeat, likeliest
    first; none if it does not repeat. ``alike``: further variables that the data do not tell from the first.
    ``memory_s``: correlation time of the noise. ``lines``: (cycles a turn of the drum, amplitude) of the highest peaks
    of the order spectrum, which show errors too fast for the knots. All sizes in rad.
    """

    rms_rad: float
    peak_rad: float
    floor_rad: float
    patterns: tuple[Pattern, ...]
    alike: tuple[str, ...]
    memory_s: float
    lines: tuple[tuple[float, float], ...]
    ci95_rad: tuple[float, float] = (0.0, np.inf)
    repeat: ClassVar[str] = "repeat the run at another load and speed, and see whether it repeats"

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
        words += f"; {best.shape.words}" if best.shape else ""
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
                    "log_evidence": p.log,
                    "at": [round(float(x), 9) for x in p.at],
                    "mean_rad": [float(y) for y in p.mean_rad],
                    "shapes": [] if p.shape is None else [asdict(p.shape)],
                }
                for p in self.patterns
            ],
        }


def describe_unknown(p: Prepared, residual_rad: Floats, noise: NoiseModel) -> Unknown:
    """Describe a residual (rad, shape (n,), all samples of the run) beside the noise of the run.

    Whether the residual is too large at all is for the caller to test.
    """
    use = p.used
    r = residual_rad[use] - residual_rad[use].mean()
    onward = p.speed_rad_s[use] >= 0.0
    variables = {
        "angle": ("rad", p.output_rad),
        "load": ("N*m", p.load_Nm),
        "speed": ("rad/s", p.speed_rad_s),
        "time": ("s", p.time_s),
    }
    found = []
    for name, (unit, values) in variables.items():
        hats = [] if values is None else hats_over(values[use], KNOTS)
        by_sense = [hat * way for way in (onward, ~onward) for hat in hats]
        if not hats:
            continue
        assert values is not None
        knots = np.linspace(values[use].min(), values[use].max(), KNOTS)
        # A curve over the speed may jump where the sense changes, and a time has one sense.
        found.append(_pattern(name, unit, knots, by_sense if name == "speed" else hats, r, noise))
        if name in ("angle", "load"):
            found.append(_pattern(f"{name} by direction", unit, knots, by_sense, r, noise))
    patterns = sorted((one for one in found if one is not None), key=lambda one: -one.log)
    alike = tuple(one.variable for one in patterns[1:] if one.log > patterns[0].log - LOG_ODDS)
    peak = float(np.quantile(np.abs(r), 0.999))
    size = rms_value(r, p.sweep[use], noise.floor_rad)
    lines = _lines(p.output_rad[use], r)
    return Unknown(
        size.value, peak, noise.floor_rad, tuple(patterns), alike, noise.memory_s, lines, (size.low, size.high)
    )


def _pattern(name: str, unit: str, knots: Floats, hats: list[Floats], r: Floats, noise: NoiseModel) -> Pattern | None:
    """The curve of a residual over one variable; None if it is not certain."""
    columns, size = unit_columns(hats)
    zero = np.full((r.size, 1), np.std(r)), np.array([[-np.inf], [np.inf]])
    white = Whitened(noise, *zero, [columns], 1)
    found = white.evidence_of(r[:, None], np.zeros(0), np.zeros((2, 0)))
    if found.unknown_odds < LOG_ODDS:
        return None
    rms = float(np.std(white.unknown(found, [columns])))
    kept = size > 0.0
    at, count = np.tile(knots, len(hats) // knots.size)[kept], np.sum(hats, axis=1)[kept]
    order = np.argsort(at)
    at, count, mean = at[order], count[order], (white.axes[0] @ found.curves / size[kept])[order]
    mean -= np.average(mean, weights=count)
    shape = None if "direction" in name else best_shape(name, unit, at, mean, count)
    return Pattern(name, unit, at, mean, rms, min(1.0, float(rms**2 / np.mean(r**2))), found.log, shape)


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


# Least ratio of the noise between the two ends.
LEAST_RATIO = 2.0
# Sweeps that are needed to say anything.
FEWEST_SWEEPS = 6
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
    at the other, and if whole sweeps agree on it (likelihood of the slope, its error clustered by sweep). A drive that
    changes in mid-run has noise that hangs on load and time; time stamps that jitter have noise that hangs on the
    speed.
    """
    use = p.used
    sweeps, sweep = np.unique(p.sweep[use], return_inverse=True)
    if sweeps.size < FEWEST_SWEEPS:
        return None
    cell = np.unique(sweep * (int(p.sector.max()) + 1) + p.sector[use], return_inverse=True)[1]
    count = np.bincount(cell).astype(float)
    log_square = np.log(np.bincount(cell, (residual[use] - residual[use].mean()) ** 2) / count + 1e-300)
    middle = float(np.average(log_square, weights=count))
    of_sweep = np.zeros(count.size, dtype=np.int64)
    of_sweep[cell] = sweep
    quantities: dict[str, Floats] = {"speed": np.abs(p.speed_rad_s), "time": p.time_s}
    if p.load_Nm is not None and p.load_Nm.any():
        quantities["load"] = np.abs(p.load_Nm)
    found: list[tuple[float, Scatter]] = []
    for name, values in quantities.items():
        at = np.bincount(cell, values[use]) / count
        x = at - np.average(at, weights=count)
        if not x.any():
            continue
        square = float(count @ x**2)
        slope = float((count * x) @ log_square) / square
        rest = count * x * (log_square - middle - slope * x)
        sure = slope * square / max(float(np.sqrt(np.sum(np.bincount(of_sweep, rest) ** 2))), 1e-300)
        ratio = float(np.exp(0.5 * slope * np.ptp(x)))
        if 0.5 * sure**2 > LOG_ODDS and max(ratio, 1.0 / ratio) >= LEAST_RATIO:
            ends = (np.exp(0.5 * (middle + slope * end)) for end in (x.min(), x.max()))
            found.append((abs(sure), Scatter(name, *(float(end) for end in ends))))
    return max(found, key=lambda one: one[0])[1] if found else None
