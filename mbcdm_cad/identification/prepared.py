"""A run made ready for the model: smoothed signals, sweeps and sectors, what is held back, the noise floor.

The friction of the model has memory, so noise in its inputs would move the slip fronts and fake a residual. What works
the friction is the difference between the inputs, and the load; both are smoothed, and the input noise taken out so is
added back linearly (see :mod:`mbcdm_cad.identification.setup`).

A long run is looked at twice: the search works on stretches of it, the figures and errors are those of the whole.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.identification.holdout import held_sweeps, held_words
from mbcdm_cad.identification.stretches import Cut, search_cut, whole_cut
from mbcdm_cad.measurement.run import Floats, Run
from mbcdm_cad.measurement.sweeps import SPEED_WINDOW_S, half_sweeps, smoothed

# Windows of the smoothing in s: left minus right, and the inputs' mean (estimates, varied for the intervals).
DIFFERENCE_WINDOW_S = 2.0
COMMON_WINDOW_S = 0.05
TEMPERATURE_WINDOW_S = 5.0
# The elastic part of the prediction is simulated at steps of this length at most, and interpolated.
COARSE_STEP_S = 0.04
# Means over so many samples of the load are tried, and how many standard errors count as apart.
LOAD_WIDTHS = (5, 9, 17, 33, 65, 129)
LOAD_ERRORS = 2.5
SECTORS = 8
# Half sweeps that must follow the first for it to be left out.
FEWEST_SWEEPS = 3
# Where the mean misses the load by so many standard errors of one sample, it is on a flank and the sample is taken.
FLANK_ERRORS = 5.0
# Between samples on which the cables are simulated the load may leave a straight line by this share of its range.
BENT_SHARE = 0.005


@dataclass(frozen=True, eq=False)
class Prepared:
    """Signals of one run on the samples that the fits use; shapes (n,) or (n_inputs, n).

    ``angle_rad`` is as measured, ``shaft_rad`` freed of the encoders' steps, ``apart_rad`` how far each input slowly
    stands from their mean. ``sweep`` numbers the half sweeps, -1 for the first, whose friction history nobody knows;
    ``sector`` is the angle sector; ``used`` marks samples of known history, ``held`` those held back. ``floor_rad`` is
    the RMS that the sensors alone put into the residual, 0 where the measurement file does not say; ``input_step_rad``
    one step of the inputs; ``few``: too few half sweeps to leave the first one out. ``cut`` says which samples of the
    run these are.
    """

    time_s: Floats
    angle_rad: Floats
    shaft_rad: Floats
    apart_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None
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
    few: bool
    run: Run
    cut: Cut

    @property
    def train(self) -> NDArray[np.bool_]:
        """Samples that the fits may see."""
        return self.used & ~self.held

    @property
    def test(self) -> NDArray[np.bool_]:
        """Samples held back."""
        return self.used & self.held

    @cached_property
    def mean_rad(self) -> Floats:
        """Mean of the inputs as measured, (n,)."""
        return np.asarray(self.angle_rad.mean(axis=0))

    @cached_property
    def common_rad(self) -> Floats:
        """The same freed of the encoders' steps."""
        return np.asarray(self.shaft_rad.mean(axis=0))

    @cached_property
    def coarse(self) -> NDArray[np.int64]:
        """Samples on which the cables are simulated: the ends of each stretch and the load's flanks among them."""
        every = max(1, int(COARSE_STEP_S / self.step_s))
        starts = self.cut.starts
        ends = np.append(starts[1:], self.time_s.size) - 1
        few = np.flatnonzero(self.cut.lead)
        at = np.unique(np.concatenate([np.arange(0, self.time_s.size, every), few, few[few > 0] - 1, starts, ends]))
        if self.load_Nm is None:
            return at
        straight = np.interp(np.arange(self.time_s.size), at, self.load_Nm[at])
        bent = np.flatnonzero(np.abs(self.load_Nm - straight) > BENT_SHARE * np.ptp(self.load_Nm))
        return np.union1d(at, bent)

    def rewindowed(self, factor: float) -> Prepared:
        """The same samples with other windows on the difference of the inputs and on the load."""
        at = self.cut.index
        load = None if self.run.load_Nm is None else quiet_load(self.run.load_Nm, factor)[at]
        return replace(self, apart_rad=slow_difference(self.run, factor)[:, at], load_Nm=load)


def slow_difference(run: Run, factor: float = 1.0) -> Floats:
    """How far each input slowly stands from their mean, (n_inputs, n); ``factor`` scales the window."""
    apart = run.input_rad - run.input_rad.mean(axis=0)
    return smoothed(apart, factor * DIFFERENCE_WINDOW_S, run.step_s)


def quiet_load(load_Nm: Floats, factor: float = 1.0) -> Floats:
    """Load freed of the sensor's noise: a long mean where it is steady, a short one on its flanks.

    Noise left in the load works the friction of the model and reads as too soft a drive; a mean longer than a flank
    misses the loads that were reached. At each sample the mean is widened as long as its interval still meets those of
    all narrower ones (intersection of confidence intervals, after Lepski); a flank of a few samples is left as it was
    measured. ``factor`` scales the noise that is assumed.
    """
    # Second differences see the noise and not the load; 1.4826 makes a median deviation a standard deviation.
    noise = factor * 1.4826 * float(np.median(np.abs(np.diff(load_Nm, 2)))) / math.sqrt(6.0)
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
    quiet = uniform_filter1d(chosen, LOAD_WIDTHS[0], mode="nearest")
    return np.where(np.abs(load_Nm - quiet) > FLANK_ERRORS * noise, load_Nm, quiet)


def prepare(run: Run, ratio: float) -> tuple[Prepared, Prepared]:
    """The part of a run that the search works on, and the whole of it; the same object for a short run.

    The first half sweep, of the run and of every stretch, is discarded, and some half sweeps are held back before any
    residual is looked at (see ``holdout``): the same ones in both.
    """
    step, time, output = run.step_s, run.time_s, run.output_rad
    shaft = smoothed(run.input_rad, COMMON_WINDOW_S, step)
    quiet = smoothed(run.input_rad.mean(axis=0) / ratio, SPEED_WINDOW_S, step)
    speed = smoothed(np.gradient(quiet, time), SPEED_WINDOW_S, step)
    apart = slow_difference(run)
    load = None if run.load_Nm is None else quiet_load(run.load_Nm)
    temperature = None if run.temperature_C is None else smoothed(run.temperature_C, TEMPERATURE_WINDOW_S, step)
    sweep = half_sweeps(smoothed(output, SPEED_WINDOW_S, step)) - 1
    few = bool(sweep.max() < FEWEST_SWEEPS)
    if few:
        # Too few reversals to spare one: a quarter of the time is a sweep.
        sweep = np.minimum((time - time[0]) / (time[-1] - time[0]) * 8.0, 7.0).astype(np.int64)
    low, span = float(output.min()), float(np.ptp(output))
    sector = np.minimum((output - low) / span * SECTORS, SECTORS - 1).astype(np.int64)
    held = held_sweeps(sweep, output, load)
    words = held_words(held, sweep, load)
    floor, input_step = sensor_floor_rad(run, ratio), input_step_rad(run)

    def taken(cut: Cut) -> Prepared:
        at = cut.index
        here = sweep[at]
        used = (here >= 0) & ~cut.unknown
        return Prepared(
            time[at],
            run.input_rad[:, at],
            shaft[:, at],
            apart[:, at],
            output[at],
            None if load is None else load[at],
            speed[at],
            None if temperature is None else temperature[at],
            here,
            sector[at],
            used,
            np.isin(here, held),
            cut.stride * step,
            floor,
            input_step,
            words,
            few,
            run,
            cut,
        )

    whole = taken(whole_cut(sweep, load, step))
    part = search_cut(sweep, load)
    return (whole if part is None else taken(part)), whole


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
