"""What of a run is used: half sweeps that are held back, samples where it is too long, signals without their noise.

The half sweeps that are held back are chosen by load, direction and time alone, before any residual is computed. Taking
every fourth by number is not enough: where loads are stepped periodically, all half sweeps held back could have the
same load, and an effect of the load could not be judged on them.

A part of the samples of a half sweep is enough, but the turning points of motion and load must be among them. This
limits the thinning; beyond it whole stretches are left out. The friction depends on extremes from long before a
stretch, so the turning points of the part that is left out are simulated before the next stretch.

The noise of the sensors is removed from the signals that drive the friction of the model; every window follows from the
data.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.measurement.run import SPEED_WINDOW_S, Run, smoothed, smoothed_at
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# One half sweep of so many is held back.
ONE_OF = 4
# Loads closer than this share of their range count as one level.
LEVEL_SHARE = 0.1
# Bins of the load in which held half sweeps are compared with all. They are exchanged while this share of their samples
# is in bins in which it should not be, and if an exchange lowers the share by so much at least.
LOAD_BINS = 8
# Parts of a run of which the first and the last have a half sweep that is held back; a difference beyond any of levels.
THIRDS, FAR = 3, 1e3
UNLIKE, LEAST_GAIN = 0.2, 0.02


def held_sweeps(sweep: NDArray[np.int64], output_rad: Floats, load_Nm: Floats | None) -> NDArray[np.int64]:
    """Numbers of the half sweeps to hold back; ``sweep`` (n,) numbers them, ascending, below 0 those that are not used.

    The half sweeps are put in order of direction, then of load level (up and down in turn, so that neighbours are
    alike), then of time; every fourth along that order is taken, so that each direction and, with enough of them, each
    level has its share. Half sweeps are then exchanged as long as their loads differ much from those of the run. At
    least one, never all.
    """
    numbers = np.unique(sweep[sweep >= 0])
    if numbers.size < 2:
        return numbers[:0]
    first, last = np.searchsorted(sweep, numbers), np.searchsorted(sweep, numbers, side="right") - 1
    direction = np.sign(output_rad[last] - output_rad[first])
    level = np.zeros(numbers.size)
    if load_Nm is not None:
        mean = _means(numbers, sweep, load_Nm)
        level = np.round(mean / (LEVEL_SHARE * np.ptp(load_Nm))) if np.ptp(load_Nm) > 0.0 else level
    level = np.where(direction > 0.0, level, -level)
    order = np.lexsort((numbers, level, direction))
    held = np.zeros(numbers.size, dtype=np.bool_)
    held[order[min(ONE_OF // 2, numbers.size - 1) :: ONE_OF]] = True
    if load_Nm is not None and np.ptp(load_Nm) > 0.0:
        held = _representative(held, _counts(numbers, sweep, load_Nm, direction > 0.0))
    return numbers[_throughout(held, direction, level)]


def _throughout(held: NDArray[np.bool_], direction: Floats, level: Floats) -> NDArray[np.bool_]:
    """``held`` with one half sweep in the first and in the last third of the run, if there are two: a drive may change.

    The one that is given up is of the same direction, and of the nearest level of the load.
    """
    third = held.size // THIRDS
    held = held.copy()
    for part in (slice(0, third), slice(held.size - third, held.size)):
        if held[part].any() or held.sum() < 2 or third < 2:
            continue
        inside = np.flatnonzero(held)
        others = np.arange(held.size)[part]
        apart = np.abs(level[inside, None] - level[others]) + FAR * (direction[inside, None] != direction[others])
        # Of equal ones, the held half sweep nearest in time gives way, so that the other end keeps its own.
        apart = apart + np.abs(inside[:, None] - others) / held.size**2
        i, j = np.unravel_index(int(np.argmin(apart)), apart.shape)
        held[inside[i]], held[others[j]] = False, True
    return held


def _counts(numbers: NDArray[np.int64], sweep: NDArray[np.int64], load_Nm: Floats, up: NDArray[np.bool_]) -> Floats:
    """Samples of each half sweep in each bin of the load; the two directions have bins of their own; (m, 2 bins)."""
    used = np.isin(sweep, numbers)
    k = np.searchsorted(numbers, sweep[used])
    load = load_Nm[used]
    span = float(np.ptp(load)) or 1.0
    place = np.minimum((load - load.min()) / span * LOAD_BINS, LOAD_BINS - 1).astype(np.int64) + LOAD_BINS * up[k]
    table = np.bincount(k * 2 * LOAD_BINS + place, minlength=numbers.size * 2 * LOAD_BINS)
    return table.reshape(numbers.size, 2 * LOAD_BINS).astype(float)


def _representative(held: NDArray[np.bool_], counts: Floats) -> NDArray[np.bool_]:
    """``held`` after the exchanges that bring the loads of the held half sweeps near to those of all, one at a time.

    Where the load changes within a half sweep, its mean does not tell which loads it has.
    """
    whole = counts.sum(axis=0) / counts.sum()

    def distance(sums: Floats) -> Floats:
        """Share of the samples that would have to change their bin, for sums (..., bins)."""
        return np.asarray(0.5 * np.abs(sums / sums.sum(axis=-1, keepdims=True) - whole).sum(axis=-1))

    held = held.copy()
    now = counts[held].sum(axis=0)
    while distance(now) > UNLIKE:
        inside, outside = np.flatnonzero(held), np.flatnonzero(~held)
        after = distance(now - counts[inside, None] + counts[None, outside])
        i, j = np.unravel_index(int(np.argmin(after)), after.shape)
        if after[i, j] > distance(now) - LEAST_GAIN:
            break
        held[inside[i]], held[outside[j]] = False, True
        now = counts[held].sum(axis=0)
    return held


def _means(numbers: NDArray[np.int64], sweep: NDArray[np.int64], values: Floats) -> Floats:
    """Mean of ``values`` over each of the half sweeps; ``sweep`` ascends."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first, last = np.searchsorted(sweep, numbers), np.searchsorted(sweep, numbers, side="right")
    return np.asarray((sums[last] - sums[first]) / (last - first))


def held_words(held: NDArray[np.int64], sweep: NDArray[np.int64], load_Nm: Floats | None, few: bool) -> str:
    """Text for results: numbers of the half sweeps in the run, from 1, and their mean loads.

    ``sweep`` counts from the second half sweep of the run; with too ``few`` it counts eighths of the time.
    """
    if not held.size:
        return "none"
    numbers = ", ".join(str(one + (1 if few else 2)) for one in held[:8]) + (", ..." if held.size > 8 else "")
    words = f"eighths {numbers} of the time" if few else f"half sweep{'s' * (held.size > 1)} {numbers}"
    if load_Nm is not None and load_Nm.any():
        means = _means(held, sweep, load_Nm)
        words += f" (mean loads {min(means):.2g} to {max(means):.2g} N m)"
    return words


# Samples that the search uses, and the most of a half sweep that it keeps. Half as many are enough for fast lines;
# more half sweeps say more than more samples of each.
SEARCH_SAMPLES = 20_000
SEARCH_IN_SWEEP = 1250
SEARCH_STRETCHES = 4
# Runs up to which each has all these samples.
FULL_RUNS = 3
# The same for the figures and the errors; the friction must not change noticeably within this time.
WHOLE_SAMPLES = 250_000
WHOLE_IN_SWEEP = 200
WHOLE_STEP_S = 0.04
WHOLE_STRETCHES = 16
# A stretch has at least so many half sweeps, of which the first is discarded.
LEAST_SWEEPS = 5
# Half sweeps before a stretch whose turning points are simulated.
LEAD_SWEEPS = 200
# The last of these half sweeps are simulated in steps, since effects of the angle have extremes between the ends.
STEPPED_SWEEPS = 12
LEAD_STEPS = 32
# Number of last samples of a stretch, which smoothing would mix with the samples after it.
TAIL = 32


@dataclass(frozen=True, eq=False)
class Cut:
    """Samples of a run: ``index`` (n,), every ``stride``-th within stretches that begin at positions ``starts``.

    ``lead`` (n,) marks the few samples that are simulated before a stretch begins, ``unknown`` (n,) these and all
    others that are simulated but not judged: the first half sweep of each stretch, whose friction history is only
    roughly known.
    """

    index: NDArray[np.int64]
    stride: int
    starts: NDArray[np.int64]
    lead: NDArray[np.bool_]
    unknown: NDArray[np.bool_]


def search_cut(sweep: NDArray[np.int64], load_Nm: Floats | None, runs: int = 1) -> Cut | None:
    """The samples that the search uses; None if that is the whole run. ``sweep`` (n,): half sweeps, ascending.

    Of many ``runs``, each has its share of the samples of a few.
    """
    share = min(1.0, FULL_RUNS / runs)
    most, in_sweep = int(share * SEARCH_SAMPLES), share * SEARCH_IN_SWEEP
    if sweep.size <= most * 1.25:
        return None
    return _cut(sweep, load_Nm, math.ceil(_in_sweep(sweep) / in_sweep), most, SEARCH_STRETCHES)


def whole_cut(sweep: NDArray[np.int64], load_Nm: Floats | None, step_s: float) -> Cut:
    """The samples for the figures: the whole run, thinned, or stretches of a very long run."""
    most = max(1, int(WHOLE_STEP_S / step_s), _in_sweep(sweep) // WHOLE_IN_SWEEP)
    return _cut(sweep, load_Nm, min(-(-sweep.size // WHOLE_SAMPLES), most), WHOLE_SAMPLES, WHOLE_STRETCHES)


def _in_sweep(sweep: NDArray[np.int64]) -> int:
    return int(np.median(np.bincount(sweep - sweep[0])))


def _cut(sweep: NDArray[np.int64], load_Nm: Floats | None, stride: int, most: int, stretches: int) -> Cut:
    n = sweep.size
    if n <= 1.25 * most * stride:
        index = np.arange(0, n, stride)
        none = np.zeros(index.size, dtype=np.bool_)
        return Cut(index, stride, np.zeros(1, dtype=np.int64), none, none)
    turns = np.flatnonzero(np.diff(sweep)) + 1
    count = int(np.clip(most * stride / (LEAST_SWEEPS * n / (turns.size + 1)), 1, stretches))
    length = most * stride // count
    # The first stretch begins with the run, the last ends with it; all others begin at a reversal of the drive.
    begins = _with_extremes(np.linspace(0, n - length, count).astype(np.int64), length, turns, load_Nm)
    if turns.size:
        begins[1:] = turns[np.minimum(np.searchsorted(turns, begins[1:]), turns.size - 1)]
    pieces, leads, unknown, end = [], [], [], 0
    for begin, following in pairwise([*begins.tolist(), n]):
        before = _turning_points(sweep, load_Nm, end, begin)
        end = min(begin + length, following)
        piece = np.arange(begin, end, stride)
        first = np.zeros(piece.size, dtype=np.bool_) if begin == 0 else sweep[piece] == sweep[begin]
        first[-TAIL:] = True
        pieces += [before, piece]
        leads += [np.ones(before.size, dtype=np.bool_), np.zeros(piece.size, dtype=np.bool_)]
        unknown += [np.ones(before.size, dtype=np.bool_), first]
    starts = np.cumsum([0, *(piece.size for piece in pieces[:-1])])[1::2]
    return Cut(np.concatenate(pieces), stride, starts, np.concatenate(leads), np.concatenate(unknown))


def _with_extremes(
    begins: NDArray[np.int64], length: int, turns: NDArray[np.int64], load_Nm: Floats | None
) -> NDArray[np.int64]:
    """``begins`` after a stretch was moved to each extreme of the load that no stretch has: play may be crossed only
    there.

    The first and the last stretch stay. The half sweep of the extreme is the second of its stretch, because the first
    is discarded.
    """
    if load_Nm is None:
        return begins
    found, free = begins.copy(), list(range(1, begins.size - 1))
    for extreme in (int(load_Nm.argmin()), int(load_Nm.argmax())):
        if not free or np.any((found <= extreme) & (extreme < found + length)):
            continue
        nearest = min(free, key=lambda k: abs(int(found[k]) - extreme))
        free.remove(nearest)
        before = turns[turns <= extreme]
        found[nearest] = before[-2] if before.size > 1 else max(0, extreme - length // 2)
    return np.sort(found)


def _turning_points(sweep: NDArray[np.int64], load_Nm: Floats | None, begin: int, end: int) -> NDArray[np.int64]:
    """Samples between two stretches: reversals, extremes of the load in each half sweep, and a few more."""
    if load_Nm is None or end <= begin:
        return np.empty(0, dtype=np.int64)
    turns = begin + 1 + np.flatnonzero(np.diff(sweep[begin:end]))
    found: list[NDArray[np.int64]] = []
    for first, last in pairwise([*turns[-LEAD_SWEEPS:].tolist(), end]):
        part = load_Nm[first:last]
        found.append(np.array([first, first + int(part.argmin()), first + int(part.argmax())]))
    near = int(turns[-STEPPED_SWEEPS:].min(initial=end))
    found.append(np.arange(near, end, max(1, (end - near) // (STEPPED_SWEEPS * LEAD_STEPS))))
    return np.unique(np.concatenate(found))


# Longest window of the load's smoothing, s; the window in use follows from the data.
LONGEST_LOAD_S = 2.6
# The difference of the inputs is separated from noise by its spectrum: power, over that of the noise, that is kept;
# share of a frequency over which the spectrum is averaged, and least number of its lines; time added before and after.
LEAST_POWER = 1.6
SPECTRUM_SHARE, SPECTRUM_LEAST = 0.1, 6
PAD_S = 5.0
# Servos seldom differ faster than this, Hz. A faster difference of the inputs is an error of their encoders, unless its
# power is so many times that of their noise: the cogging of a motor moves the cables to and fro and eases their
# friction.
FASTEST_HZ = 4.0
FAST_POWER = 20.0
# Window over which an angle is smoothed before it is rounded to its steps again, s.
COUNTING_WINDOW_S = 0.2
# The speed is computed over the shortest window that leaves noise of this share of its RMS, between these limits in s.
SPEED_NOISE_SHARE = 0.01
LONGEST_SPEED_S = 1.0
# The narrowest mean is over so many samples; half the width of a confidence interval, standard errors.
NARROWEST = 5
APART_ERRORS = 1.5
# Where smoothed and measured load differ by so many standard errors of one sample, the load is on a flank, and the
# sample is used.
FLANK_ERRORS = 5.0


def noise_of_signal(values: Floats) -> float:
    """Standard deviation of a signal's white noise, from second differences, which contain hardly any of the signal."""
    # 1.4826: from the median deviation to the standard deviation of a normal distribution.
    return 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / math.sqrt(6.0)


def locally_fitted(values: Floats, noise: float, longest: int) -> tuple[Floats, NDArray[np.int64]]:
    """A signal (n,) without white noise of that standard deviation, and the width of the window used at each sample.

    At each sample the mean over a window before, after or around it is taken, or a line (before, after) or parabola
    (around) that is made of the means over two windows. Of each kind the window is widened while its confidence
    interval intersects those of all narrower ones (intersection of confidence intervals: O. V. Lepski; windows to one
    side, which keep a step: V. Katkovnik, IEEE Trans. Signal Process. 47 (1999)), up to ``longest`` samples. The value
    of least variance is used.
    """
    # At each sample the value taken, the width of its window, and its variance.
    taken = np.stack([values, np.zeros(values.size), np.full(values.size, np.inf)])
    for side in (0, -1, 1):
        # The least and the greatest value that agrees with all intervals so far, of means and of lines or parabolas.
        straight, bent = np.full((2, 2, values.size), [[[-np.inf], [np.inf]]])
        width, mean, moment = NARROWEST, np.empty(0), 0.0
        while width <= max(longest, NARROWEST):
            few, narrow, before = (width + 1) // 2, mean, moment
            mean = uniform_filter1d(values, width, mode="reflect", origin=-side * (width // 2))
            # The moment by which the mean of a bent or, to one side, a sloping signal is wrong.
            moment = (width**2 - 1.0) / 12.0 if side == 0 else (width - 1.0) / 2.0
            found = [(straight, mean, 0.0, 1.0 / width)]
            if narrow.size:
                share = moment / (moment - before)
                found.append((bent, narrow, share, share**2 / few + (1.0 - share**2) / width))
            for agreed, other, share, variance in found:
                _narrow(agreed, mean, other, share, APART_ERRORS * noise * math.sqrt(variance), width, variance, taken)
            width = 2 * width - 1
    return taken[0], taken[1].astype(np.int64)


@compiled
def _narrow(
    agreed: Floats, wide: Floats, narrow: Floats, share: float, reach: float, width: int, variance: float, taken: Floats
) -> None:
    """Narrow ``agreed`` (2, n) by one more interval; take its middle where a value is left and its variance is less."""
    for k in range(wide.size):
        value = share * narrow[k] + (1.0 - share) * wide[k] if share else wide[k]
        agreed[0, k] = max(agreed[0, k], value - reach)
        agreed[1, k] = min(agreed[1, k], value + reach)
        if agreed[0, k] <= agreed[1, k] and variance < taken[2, k]:
            taken[0, k], taken[1, k], taken[2, k] = value, width, variance


def told_from_noise(
    values: Floats, noise: float, step_s: float, counting: Floats | None = None
) -> tuple[Floats, float]:
    """A signal (n,) with only the frequencies at which it exceeds its noise, and the shortest period kept, s.

    ``noise`` is the least standard deviation of the white noise; the actual one is taken from the upper half of the
    spectrum. ``counting`` (n,) is the error that the steps of the encoder cause in such a motion: also noise, but not
    white. Each frequency keeps the power that is not noise, since the friction of the cables is eased by the power of
    the motion: a Wiener filter, which keeps the least square error, keeps too little power, and the drive looks too
    soft. A frequency is removed if its power is below ``LEAST_POWER`` times that of the noise, above ``FASTEST_HZ``
    below ``FAST_POWER`` times.
    """
    n = values.size
    spectrum, power, inside = _spectrum(values, step_s)
    upper = power[power.size // 2 :]
    white = max(noise**2, float(np.median([part.mean() for part in np.array_split(upper, 8)])))
    floor = np.full(power.size, white)
    if counting is not None:
        floor = np.maximum(floor, _near_mean(_spectrum(counting, step_s)[1]))
    mean = _near_mean(power)
    size = 2 * (power.size - 1)
    least = np.where(np.arange(power.size) > FASTEST_HZ * size * step_s, FAST_POWER, LEAST_POWER)
    signal = np.maximum(1.0 - floor / np.maximum(mean, floor.max() * 1e-9 or 1.0), 0.0)
    weight = np.where(mean > least * floor, np.sqrt(signal), 0.0)
    kept = irfft(spectrum * weight, size)[inside : inside + n] + float(values.mean())
    highest = np.flatnonzero(weight > 0.0)
    period = size * step_s / max(int(highest[-1]) if highest.size else 1, 1)
    return np.asarray(kept), float(min(0.5 * period, n * step_s))


def _spectrum(values: Floats, step_s: float) -> tuple[NDArray[np.complex128], Floats, int]:
    """Spectrum of a signal without its mean, its power per sample, and the sample at which the signal begins in it.

    The signal is extended by reflection at its ends, so that a filter meets no jump from the last sample to the first.
    """
    pad = min(values.size - 1, int(PAD_S / step_s))
    before, after = 2.0 * values[0] - values[pad:0:-1], 2.0 * values[-1] - values[-2 : -pad - 2 : -1]
    long = np.concatenate([before, values, after]) - values.mean()
    size = next_fast_len(long.size + long.size % 2, real=True)
    spectrum = rfft(long, size + size % 2)
    return spectrum, np.abs(spectrum) ** 2 / long.size, pad


def _near_mean(power: Floats) -> Floats:
    """Mean of a spectrum over the lines near each."""
    near = np.maximum(SPECTRUM_LEAST, (SPECTRUM_SHARE * np.arange(power.size)).astype(np.int64))
    sums = np.concatenate([[0.0], np.cumsum(power)])
    high, low = np.minimum(np.arange(power.size) + near + 1, power.size), np.maximum(np.arange(power.size) - near, 0)
    return np.asarray((sums[high] - sums[low]) / (high - low))


def counting_errors(run: Run) -> Floats:
    """An estimate of the error of each input encoder from its finite steps, (n_inputs, n), rad.

    At a steady speed this error repeats with every step. It is a few strong lines of the spectrum, at the frequencies
    to which sampling aliases them, and no motion of the servos. A smoothed angle that is rounded to the steps again has
    the same lines.
    """
    step = input_step_rad(run)
    if step == 0.0:
        return np.zeros_like(run.input_rad)
    angle = smoothed_at(run.input_rad, run.time_s, COUNTING_WINDOW_S, run.step_s)
    zero = run.input_rad[:, :1]
    return np.asarray(zero + step * np.round((angle - zero) / step) - angle)


def slow_difference(run: Run, factor: float = 1.0) -> tuple[Floats, float]:
    """Difference of each input from their mean without the encoders' noise, (n_inputs, n), and the window used, s.

    Servos do not track alike. Their true difference drives the friction and is kept; the errors of the encoders are
    removed. ``factor`` scales the noise that is assumed.
    """
    apart = run.input_rad - run.input_rad.mean(axis=0)
    count = apart.shape[0]
    if count == 1:
        return np.zeros_like(apart), 0.0
    least = input_step_rad(run) / math.sqrt(12.0) * math.sqrt((count - 1) / count)
    counted = counting_errors(run)
    counted = max(factor, 1.0) * (counted - counted.mean(axis=0))
    found = [
        told_from_noise(row, factor * max(noise_of_signal(row), least), run.step_s, errors)
        for row, errors in zip(apart, counted, strict=True)
    ]
    rows = np.stack([row for row, _ in found])
    return rows - rows.mean(axis=0), min(window for _, window in found)


def quiet_load(run: Run, factor: float = 1.0) -> tuple[Floats, float]:
    """Load without the sensor's noise, (n,), and the window used, s.

    Noise in the load drives the friction of the model and makes the drive look too soft. A flank of a few samples is
    left as it was measured. ``factor`` scales the noise that is assumed.
    """
    load_Nm = run.load_Nm
    assert load_Nm is not None, "a run without a torque column has no load to smooth"
    noise = factor * noise_of_signal(load_Nm)
    quiet, widths = locally_fitted(load_Nm, noise, int(LONGEST_LOAD_S / run.step_s))
    # Neighbouring values may come from windows of other kinds: their mean is taken, but not across a step.
    kept = load_Nm
    for smoother in (quiet, uniform_filter1d(quiet, NARROWEST, mode="reflect")):
        kept = np.where(np.abs(load_Nm - smoother) > FLANK_ERRORS * noise, kept, smoother)
    return kept, float(np.median(widths)) * run.step_s


def speed_window(run: Run, ratio: float) -> tuple[float, float]:
    """The shortest window that gives the drum's speed accurately enough from the inputs, s, and what noise it leaves,
    rad/s."""
    mean = run.input_rad.mean(axis=0) / ratio
    noise = max(noise_of_signal(mean), input_step_rad(run) / ratio / math.sqrt(12.0 * run.input_rad.shape[0]))
    swept = np.diff(smoothed(mean, LONGEST_SPEED_S, run.step_s)) / np.diff(run.time_s)
    speed = float(np.sqrt(np.mean(swept**2))) or 1e-12
    # A slope over a window of w seconds at n samples a second has the deviation noise sqrt(12 / (w^3 n)).
    wanted = (12.0 * run.step_s * (noise / (SPEED_NOISE_SHARE * speed)) ** 2) ** (1.0 / 3.0)
    window = float(np.clip(wanted, SPEED_WINDOW_S, LONGEST_SPEED_S))
    return window, noise * math.sqrt(12.0 * run.step_s / window**3)


def input_step_rad(run: Run) -> float:
    """Step of the input encoders: as declared, else the smallest change in the record."""
    if run.sensors.input_resolution_rad:
        return run.sensors.input_resolution_rad
    changes = np.abs(np.diff(run.input_rad[0]))
    return float(changes[changes > 0.0].min(initial=np.inf)) if np.any(changes > 0.0) else 0.0
