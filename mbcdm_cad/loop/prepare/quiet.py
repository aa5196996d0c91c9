"""Remove the noise of the sensors from the signals that drive the friction of the model, and choose the windows for it.

Every window follows from the data.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.measurement.run import SPEED_WINDOW_S, Run, smoothed, smoothed_at
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

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
