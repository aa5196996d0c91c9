"""Frequency responses: estimated from a log of a chirp, a multisine or noise, or read from an analyser's table.

Spectra of the whole log are averaged over ``AVERAGED`` neighbouring lines, so that a single chirp has as many averages
as repeated ones, and no window hides how many there are. With a column of the excitation the response is the ratio of
the cross-spectra with it (instrumental variable), to which noise of the input does not matter; without one it is H1.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.signal import detrend, stft
from scipy.signal.windows import tukey

from mbcdm_cad.measurement.run import ResponseTable, Run, VettingNote, doubt, fact, refused
from mbcdm_cad.routes import Complex, Floats

# Lines of the spectrum in each average, and averages over which the scatter of the response is smoothed.
AVERAGED, SMOOTHED = 8, 5
# Rows of a table around each over which its scatter is taken.
AROUND = 15
# Coherence below which an average says nothing, and from which a response is good.
LEAST_COHERENCE, GOOD_COHERENCE = 0.5, 0.9
# Deviation of what says nothing.
NO_WEIGHT = 1e9
# Averages that a mode needs, and share of the log that is faded in and out.
FEWEST_AVERAGES, FADED = 24, 0.02
# Time steps that differ by this share of their median are uneven; share of the sample rate up to which is looked.
UNEVEN, HIGHEST = 0.01, 0.45
# Periods of the middle of the band in each part of the log whose amplitude is taken.
PERIODS = 16
# Error of the first harmonic of a sine that is counted, as a share: times (step / amplitude)^1.5. RMS over amplitudes A
# of the first term of the sawtooth's series, 2 q / (pi A) J1(2 pi A / q), of a sine about the middle of a count.
COUNTED = np.sqrt(2.0) / np.pi**2
# Bias of H1 by the counts of the input from which it is doubtful.
DOUBTFUL_BIAS = 0.02


@dataclass(frozen=True, eq=False)
class Quotient:
    """One response (n,): ``value`` with ``sigma``, the standard deviation of each of its two parts, and coherence."""

    value: Complex
    sigma: Floats
    coherence: Floats


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """What a log shows, at ``frequency_Hz`` (n,), rising.

    ``output``: output over inputs, both as angles of the output. ``twist``: turn of the output behind the inputs over
    the torque that it carries, rad/(N m), None where no torque was measured. ``acceleration_rad_s2``: amplitude of the
    output's acceleration while it is excited at each frequency, ``input_rad`` that of inputs; ``input_power_rad2``:
    mean square of the inputs' spectrum over the number of samples, which for white noise is its mean square.

    Of an analyser's table ``output`` may be over a torque on the output, in rad/(N m), and ``input_rad`` is then the
    amplitude of that, N m. Where none is stated (not ``levelled``) it is 1 mrad or 1 N m, and the acceleration 1.
    """

    frequency_Hz: Floats
    output: Quotient
    twist: Quotient | None
    acceleration_rad_s2: Floats
    input_rad: Floats
    input_power_rad2: Floats
    over_torque: bool = False
    levelled: bool = True

    @property
    def quotients(self) -> tuple[Quotient, ...]:
        """Output over inputs, and the twist over the torque where there is one."""
        return (self.output,) if self.twist is None else (self.output, self.twist)


def response_of(run: Run, ratio: float) -> FrequencyResponse:
    """The response of a run of kind frequency_response; ``ratio`` of inputs to output."""
    if run.table is not None:
        return _of_table(run.table, ratio)
    step, n = run.step_s, run.time_s.size
    if _uneven(run):
        n = int(np.floor((run.time_s[-1] - run.time_s[0]) / step)) + 1
    even = run.time_s[0] + step * np.arange(n)
    fade = tukey(n - 1, 2.0 * FADED)

    def spectrum(values: Floats) -> Complex:
        at = np.interp(even, run.time_s, values) if _uneven(run) else values
        # Differences whiten drifts, whose jump from end to beginning would leak into all lines; quotients stay.
        return np.asarray(np.fft.rfft(detrend(np.diff(at)) * fade))

    u, y = spectrum(run.input_rad.mean(axis=0) / ratio), spectrum(run.output_rad)
    drive = u if run.excitation is None else spectrum(run.excitation)
    lines: Floats = np.asarray(np.fft.rfftfreq(n - 1, step), dtype=float)
    differences = 2.0 * np.sin(np.pi * lines * step)
    differences[0] = np.inf
    count = int(np.searchsorted(lines, HIGHEST / step)) // AVERAGED * AVERAGED

    def averaged(values: Any) -> Any:
        return np.asarray(values[:count].reshape(-1, AVERAGED).mean(axis=1))

    frequency = np.asarray(averaged(lines).real)
    output, twist = _quotient(averaged, drive, u, y), None
    counts = run.sensors.input_resolution_rad or 0.0
    if run.load_Nm is not None and np.ptp(run.load_Nm) > 0.0:
        twist = _quotient(averaged, drive, spectrum(run.load_Nm), u - y)
    kept = output.coherence > LEAST_COHERENCE
    kept[0] = False  # offsets and drifts
    if not kept.any():
        none = np.zeros(0)
        return FrequencyResponse(none, Quotient(none.astype(complex), none, none), None, none, none, none)
    near = np.pad(np.repeat(kept, AVERAGED), (0, lines.size - count))
    acceleration = _acceleration(frequency, kept, near * y / differences * lines**2, n - 1, step)
    twist = None if twist is None else _only(twist, kept)
    if twist is not None:
        blind = twist.coherence < LEAST_COHERENCE
        twist = None if blind.mean() > 0.5 else replace(twist, sigma=np.where(blind, NO_WEIGHT, twist.sigma))
    output, acceleration = _only(output, kept), acceleration[kept]
    amplitude = acceleration / (np.abs(output.value) * (2.0 * np.pi * frequency[kept]) ** 2)
    counted = COUNTED * (counts / ratio / amplitude) ** 1.5 / np.sqrt(run.input_rad.shape[0])
    output = replace(output, sigma=np.hypot(output.sigma, counted * np.abs(output.value)))
    if twist is not None:
        # What the inputs are wrong by is a twist.
        counted *= np.abs(twist.value / (1.0 - output.value))
        twist = replace(twist, sigma=np.hypot(twist.sigma, counted))
    power = averaged(np.abs(u / differences) ** 2)[kept].real / n
    return FrequencyResponse(frequency[kept], output, twist, acceleration, amplitude, power)


def _of_table(table: ResponseTable, ratio: float) -> FrequencyResponse:
    """The response of an analyser's table. Its noise is the scatter of each row about its neighbours."""
    f, turns = table.frequency_Hz, ratio if table.turns is None else table.turns
    over_torque = table.over == "torque"
    value = table.value if over_torque else table.value * turns
    coherence = np.full(f.size, np.nan) if table.coherence is None else table.coherence
    if table.amplitude is None:
        amplitude, acceleration = np.full(f.size, 1.0 if over_torque else 1e-3), np.ones(f.size)
    else:
        amplitude = table.amplitude if over_torque else table.amplitude / turns
        acceleration = amplitude * np.abs(value) * (2.0 * np.pi * f) ** 2
    kept = np.asarray(~(coherence <= LEAST_COHERENCE))
    # What the rows scatter by, or what the coherence says of as many averages: neighbours may share a window.
    gamma = np.clip(np.nan_to_num(coherence, nan=1.0), LEAST_COHERENCE, 1.0)
    share = np.maximum(_scatter(f, value), np.sqrt((1.0 - gamma) / (2.0 * gamma * AVERAGED)))
    output = _only(Quotient(value, np.abs(value) * share, coherence), kept)
    power = np.zeros(int(kept.sum()))
    levelled = table.amplitude is not None
    return FrequencyResponse(f[kept], output, None, acceleration[kept], amplitude[kept], power, over_torque, levelled)


def _scatter(frequency_Hz: Floats, value: Complex) -> Floats:
    """Standard deviation of each part of a response, (n,), as a share of it: what a cubic through the two neighbours on
    each side leaves of its logarithm, the median of those around, so that a peak of few rows does not count."""
    x, z = np.log(frequency_Hz), np.log(np.abs(value)) + 1j * np.unwrap(np.angle(value))
    at = np.arange(2, x.size - 2)
    nodes = at + np.array([-2, -1, 1, 2])[:, None]
    weights = np.ones(nodes.shape)
    for j, m in permutations(range(4), 2):
        weights[j] *= (x[at] - x[nodes[m]]) / (x[nodes[j]] - x[nodes[m]])
    left = np.abs(z[at] - (weights * z[nodes]).sum(axis=0)) ** 2 / (1.0 + (weights**2).sum(axis=0))
    # The median of a sum of two squares is 2 ln 2 of the square of each.
    around = median_filter(np.pad(left, 2, mode="edge"), AROUND, mode="reflect")
    return np.asarray(np.sqrt(around / (2.0 * np.log(2.0))))


def _uneven(run: Run) -> bool:
    return bool(np.ptp(np.diff(run.time_s)) > UNEVEN * run.step_s)


def _quotient(averaged: Callable[[Any], Any], drive: Complex, below: Complex, above: Complex) -> Quotient:
    """``above`` over ``below`` by their cross-spectra with ``drive``."""

    def power(values: Complex) -> Floats:
        return np.asarray(averaged(np.abs(values) ** 2).real) + 1e-300

    cross, square = averaged(drive.conj() * below), power(drive)
    value = averaged(drive.conj() * above) / (cross + 1e-300)
    both = averaged(below.conj() * above)
    left = power(above) - 2.0 * (value.conj() * both).real + np.abs(value) ** 2 * power(below)
    left, total = (uniform_filter1d(np.maximum(row, 0.0), SMOOTHED) for row in (left, power(above)))
    sigma = np.sqrt(0.5 * left * square / (AVERAGED - 1)) / (np.abs(cross) + 1e-300)
    return Quotient(np.asarray(value), sigma, np.clip(1.0 - left / total, 0.0, 1.0))


def _only(one: Quotient, kept: NDArray[np.bool_]) -> Quotient:
    return Quotient(one.value[kept], one.sigma[kept], one.coherence[kept])


def _acceleration(frequency: Floats, kept: NDArray[np.bool_], spectrum: Complex, n: int, step: float) -> Floats:
    """Amplitude of a sine with the mean square that the acceleration has while it is excited at each frequency, (m,),
    from its ``spectrum`` over (2 pi)^2: of a chirp that of the moment, of a steady noise that of the whole."""
    values = (2.0 * np.pi) ** 2 * np.fft.irfft(spectrum, n)
    middle = float(np.average(frequency[kept]))
    length = int(np.clip(PERIODS / middle / step, 16, n))
    at, _, parts = stft(values, 1.0 / step, nperseg=length)
    square = np.abs(parts) ** 2
    of_time = square.sum(axis=0)
    of_time *= float(np.mean(values**2)) / float(np.mean(of_time))
    mean = (square * of_time).sum(axis=1) / (square.sum(axis=1) + 1e-300)
    return np.asarray(np.sqrt(2.0 * np.interp(frequency, at, mean)))


# Rows of a table at its lowest frequencies that say what its gain is over, and how near a factor must be.
LOWEST, NEAR = 5, 1.25
NO_TORQUE = "no torque: an inertia and a stiffness that are wrong look alike"


def table_findings(table: ResponseTable, ratio: float, gearhead: float | None) -> Iterator[VettingNote]:
    """What an analyser's table can show, and whether its gain and phase begin as they must."""
    seen = _of_table(table, ratio)
    f, n = seen.frequency_Hz, seen.frequency_Hz.size
    if n < FEWEST_AVERAGES:
        text = f"coherence above {LEAST_COHERENCE:g} in {n} rows, {FEWEST_AVERAGES} are needed"
        remedy = "excite the drive harder, or let the analyser average longer"
        yield refused("coherence", text, remedy, "columns", "coherence")
        return
    what = "a torque on it, inputs held" if seen.over_torque else "the inputs"
    scatter = float(np.median(seen.output.sigma / np.abs(seen.output.value)))
    text = (
        f"frequency response of a table, output over {what}, {f[0]:.3g} to {f[-1]:.4g} Hz in {n} rows, which scatter "
        f"by {100.0 * scatter:.2g} % about their neighbours"
    )
    yield fact("frequency_response", text)
    begin = complex(np.mean(seen.output.value[:LOWEST]))
    gain, turns = abs(begin), ratio if table.turns is None else table.turns
    if begin.real < 0.0:
        text = (
            f"phase of {np.degrees(np.angle(begin)):.3g} deg at the lowest frequencies: output and {what} are opposed"
        )
        yield refused("reversed_gain", text, "set zero: 180 on phase", "columns", "phase")
    if not seen.over_torque and not 1.0 / NEAR < gain < NEAR:
        likely = {"angles of the output": 1.0, "the inputs' encoders": ratio}
        likely |= {} if gearhead is None else {"encoders on the motors": ratio * gearhead}
        text = f"gain of {gain / turns:.4g} at the lowest frequencies, {1.0 / turns:.4g} is that of a rigid drive"
        near = {word: one for word, one in likely.items() if 1.0 / NEAR < gain * one / turns < NEAR}
        remedy = "measure from well below the first mode; check the unit of gain, and response.over and turns"
        for word, one in near.items():
            text, remedy = f"{text}: it is over {word}", f"set response.turns: {one:.6g}"
        yield (refused if near else doubt)("gain", text, remedy, "response", "turns")
    if table.coherence is None:
        yield fact("no_coherence", "no coherence: its noise is the scatter of the rows alone")
    if not seen.levelled:
        text = "no amplitude: that the wraps slip the more the larger it is may look like a soft rope"
        amplitude = "amplitude_Nm" if seen.over_torque else "amplitude_rad"
        yield doubt("no_amplitude", text, f"give response.{amplitude}", "response")
    if not seen.over_torque:
        yield fact("no_torque", NO_TORQUE, "give a table over a torque on the output with the inputs held beside it")


def response_findings(run: Run, ratio: float) -> Iterator[VettingNote]:
    """What a log of a frequency response can show, and what makes it doubtful."""
    seen = response_of(run, ratio)
    f, n = seen.frequency_Hz, seen.frequency_Hz.size
    if n < FEWEST_AVERAGES:
        text = f"coherence of inputs and output above {LEAST_COHERENCE:g} in {n} averages of {AVERAGED} lines"
        remedy = "excite the drive longer or harder, log faster, and check that the columns belong together"
        yield refused("coherence", f"{text}, {FEWEST_AVERAGES} are needed", remedy, "columns")
        return
    width = AVERAGED / (run.step_s * run.time_s.size)
    by = "of the inputs (H1)" if run.excitation is None else "of the cross-spectra with the excitation"
    good = float(np.mean(seen.output.coherence > GOOD_COHERENCE))
    text = (
        f"frequency response {by}, {f[0]:.3g} to {f[-1]:.4g} Hz in {n} averages of {width:.2g} Hz, coherence above "
        f"{GOOD_COHERENCE:g} in {good:.0%} of them"
    )
    yield fact("frequency_response", text)
    if _uneven(run):
        steps = np.diff(run.time_s)
        text = f"time steps of {1e3 * steps.min():.3g} to {1e3 * steps.max():.3g} ms, interpolated"
        yield doubt("uneven_steps", f"{text}: high frequencies suffer", "log at an even rate")
    step = run.sensors.input_resolution_rad
    if run.excitation is None and step:
        counts = (step / ratio) ** 2 / 12.0 / run.input_rad.shape[0]
        bias = float(np.quantile(counts / seen.input_power_rad2, 0.9))
        if bias > DOUBTFUL_BIAS:
            text = f"counts of the inputs may lower the gain by {min(bias, 1.0):.0%}, as no excitation was logged"
            yield doubt("input_counts", text, "log the command as excitation, or excite harder")
    if run.load_Nm is not None and seen.twist is None:
        text = f"coherence of the torque below {LEAST_COHERENCE:g} in most averages: it is not used"
        yield doubt("torque_coherence", text, "check its column, filter it less, or excite harder")
    if run.load_Nm is None:
        yield fact("no_torque", NO_TORQUE, "log the torque between drum and what it turns")
