"""A run made ready for the model: smoothed signals, sweeps and sectors, what is held back, the noise floor.

The friction of the model has memory, so noise in its inputs would move the slip fronts and fake a residual. What works
the friction is the difference between the inputs, and the load; both are smoothed, and the input noise taken out so is
added back linearly (see :mod:`mbcdm_cad.loop.setup`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.loop.holdout import held_sweeps, held_words
from mbcdm_cad.loop.run import Floats, Run

# Windows of the smoothing in s: left minus right, and the inputs' mean (estimates, varied for the intervals).
DIFFERENCE_WINDOW_S = 2.0
SPEED_WINDOW_S = 0.1
COMMON_WINDOW_S = 0.05
TEMPERATURE_WINDOW_S = 5.0
# The elastic part of the prediction is simulated at steps of this length at most, and interpolated.
COARSE_STEP_S = 0.04
# Means over so many samples of the load are tried, and how many standard errors count as apart.
LOAD_WIDTHS = (5, 9, 17, 33, 65, 129)
LOAD_ERRORS = 2.5
# A reversal counts where the output has come back by this share of its travel.
REVERSAL_SHARE = 0.1
SECTORS = 8
# Of longer runs every so many samples are kept, down to this number, before anything is fitted.
MOST_SAMPLES = 20_000


@dataclass(frozen=True, eq=False)
class Prepared:
    """Signals of one run on the samples that the fits use; shapes (n,) or (n_inputs, n).

    ``sweep`` numbers the half sweeps, -1 for the first, whose friction history nobody knows; ``sector`` is the angle
    sector; ``used`` marks samples of known history, ``held`` those held back. ``floor_rad`` is the RMS that the sensors
    alone put into the residual, 0 where the measurement file does not say; ``input_step_rad`` one step of the inputs.
    """

    time_s: Floats
    angle_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None
    raw_load_Nm: Floats | None
    speed_rad_s: Floats
    temperature_C: Floats | None
    sweep: NDArray[np.int64]
    sector: NDArray[np.int64]
    used: NDArray[np.bool_]
    held: NDArray[np.bool_]
    step_s: float
    floor_rad: float
    input_step_rad: float
    held_words: str
    difference_window_s: float = DIFFERENCE_WINDOW_S

    @property
    def train(self) -> NDArray[np.bool_]:
        """Samples that the fits may see."""
        return self.used & ~self.held

    @property
    def test(self) -> NDArray[np.bool_]:
        """Samples held back."""
        return self.used & self.held

    @cached_property
    def coarse(self) -> NDArray[np.int64]:
        """Samples on which the cables are simulated, the first and the last among them."""
        every = max(1, int(COARSE_STEP_S / self.step_s))
        return np.union1d(np.arange(0, self.time_s.size, every), [self.time_s.size - 1])

    def rewindowed(self, factor: float) -> Prepared:
        """The same run with other windows on the difference of the inputs and on the load."""
        load = self.load_Nm if self.raw_load_Nm is None else quiet_load(self.raw_load_Nm, factor)
        return replace(self, difference_window_s=factor * self.difference_window_s, load_Nm=load)


def smoothed(values: Floats, window_s: float, step_s: float) -> Floats:
    """Two passes of a centred moving mean: a triangle ``window_s`` wide; the ends are held."""
    width = 2 * round(window_s / (4.0 * step_s)) + 1
    if width == 1:
        return values
    once = uniform_filter1d(values, width, axis=-1, mode="nearest")
    return np.asarray(uniform_filter1d(once, width, axis=-1, mode="nearest"))


def quiet_load(load_Nm: Floats, factor: float = 1.0) -> Floats:
    """Load freed of the sensor's noise: a long mean where it is steady, a short one on its flanks.

    Noise left in the load works the friction of the model and reads as too soft a drive; a mean longer than a flank
    misses the loads that were reached. At each sample the mean is widened as long as its interval still meets those of
    all narrower ones (intersection of confidence intervals, after Lepski). ``factor`` scales the noise that is assumed.
    """
    # Second differences see the noise and not the load; 1.4826 makes a median deviation a standard deviation.
    bend = np.diff(load_Nm, 2)
    noise = factor * 1.4826 * float(np.median(np.abs(bend))) / np.sqrt(6.0)
    chosen = low = high = np.empty(0)
    alive = np.ones(load_Nm.size, dtype=np.bool_)
    for width in LOAD_WIDTHS:
        mean = uniform_filter1d(load_Nm, width, mode="nearest")
        reach = LOAD_ERRORS * noise / np.sqrt(width)
        if width == LOAD_WIDTHS[0]:
            chosen, low, high = mean, mean - reach, mean + reach
            continue
        low, high = np.maximum(low, mean - reach), np.minimum(high, mean + reach)
        alive &= low <= high
        chosen = np.where(alive, mean, chosen)
    return np.asarray(uniform_filter1d(chosen, LOAD_WIDTHS[0], mode="nearest"))


def half_sweeps(output_rad: Floats) -> NDArray[np.int64]:
    """Number of the half sweep at each sample, from 0; shape (n,). A turn counts after a tenth of the travel."""
    reach = REVERSAL_SHARE * float(np.ptp(output_rad))
    turns: list[int] = []
    rising = 0
    low = high = float(output_rad[0])
    low_at = high_at = 0
    for k, value in enumerate(output_rad.tolist()):
        if rising >= 0 and value > high:
            high, high_at = value, k
        if rising <= 0 and value < low:
            low, low_at = value, k
        if rising >= 0 and high - value > reach:
            turns.append(high_at)
            rising, low, low_at = -1, value, k
        elif rising <= 0 and value - low > reach:
            turns.append(low_at)
            rising, high, high_at = 1, value, k
    sweep = np.zeros(output_rad.size, dtype=np.int64)
    for turn in turns:
        # A start at rest is no sweep of its own.
        if turn > 0.01 * output_rad.size:
            sweep[turn:] += 1
    return sweep


def prepare(run: Run, ratio: float, most: int = MOST_SAMPLES) -> Prepared:
    """Make a run ready for a drive of total ratio ``ratio``.

    Of runs of more than ``most`` samples every so many are kept, after the smoothing: the model needs the turning
    points of load and motion, not each sample between them, and a mean over a block would blunt them.

    The first half sweep is discarded, and some are held back before any residual is looked at (see ``holdout``).
    """
    stride = max(1, run.time_s.size // most)
    full_step = float(np.median(np.diff(run.time_s)))
    quiet = smoothed(run.input_rad.mean(axis=0) / ratio, SPEED_WINDOW_S, full_step)
    speed = smoothed(np.gradient(quiet, run.time_s), SPEED_WINDOW_S, full_step)[::stride]
    angle, raw_load = run.input_rad, run.load_Nm
    load = None if raw_load is None else quiet_load(raw_load)[::stride]
    if stride > 1:
        mean = angle.mean(axis=0)
        # Too few samples are left to smooth the difference afterwards.
        angle = mean + smoothed(angle - mean, DIFFERENCE_WINDOW_S, full_step)
        raw_load = None
    time, angle, output = run.time_s[::stride], angle[:, ::stride], run.output_rad[::stride]
    step = stride * full_step
    temperature = None
    if run.temperature_C is not None:
        temperature = smoothed(run.temperature_C, TEMPERATURE_WINDOW_S, full_step)[::stride]
    sweep = half_sweeps(smoothed(output, SPEED_WINDOW_S, step)) - 1
    if sweep.max() < 3:
        # Too few reversals to spare one: a quarter of the time is a sweep.
        sweep = np.minimum((time - time[0]) / (time[-1] - time[0]) * 8.0, 7.0).astype(np.int64)
    low, span = float(output.min()), float(np.ptp(output))
    sector = np.minimum((output - low) / span * SECTORS, SECTORS - 1).astype(np.int64)
    used = sweep >= 0
    numbers = held_sweeps(sweep, output, load)
    held = np.isin(sweep, numbers)
    return Prepared(
        time, angle, output, load, raw_load, speed, temperature, sweep, sector, used, held, step,
        sensor_floor_rad(run, ratio), input_step_rad(run), held_words(numbers, sweep, load),
    )  # fmt: skip


def sensor_floor_rad(run: Run, ratio: float) -> float:
    """RMS that the encoders' steps put into the residual, rad: uniform errors, the inputs' mean through the ratio."""
    s = run.sensors
    inputs = (s.input_resolution_rad or 0.0) / ratio / np.sqrt(12.0 * run.input_rad.shape[0])
    output = (s.output_resolution_rad or 0.0) / np.sqrt(12.0)
    return float(np.hypot(inputs, output))


def input_step_rad(run: Run) -> float:
    """Step of the input encoders: as declared, else the smallest change in the record."""
    if run.sensors.input_resolution_rad:
        return run.sensors.input_resolution_rad
    changes = np.abs(np.diff(run.input_rad[0]))
    return float(changes[changes > 0.0].min(initial=np.inf)) if np.any(changes > 0.0) else 0.0
