"""A run made ready for the model: smoothed signals, sweeps and sectors, what is held back, the noise floor.

The friction of the model depends on earlier loads, so noise in its inputs would move the slip fronts and cause a false
residual. The friction is driven by the load and by the difference between the inputs. Both are smoothed, and the noise
removed from the inputs is added back linearly (see :mod:`mbcdm_cad.loop.prepare.setup`).

A long run is prepared twice: the search works on stretches of it; the figures and errors are those of the whole.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare import samples
from mbcdm_cad.measurement.run import Run, smoothed, smoothed_at
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

COMMON_WINDOW_S = 0.05
TEMPERATURE_WINDOW_S = 5.0
# The elastic part of the prediction is simulated at steps of this time, or this turn of the inputs, at most, and
# interpolated.
COARSEST_S = 0.15
COARSE_TURN_RAD = 0.1
# Simulated samples in one cycle of a ripple that moves the cables.
IN_A_CYCLE = 10.0
SECTORS = 8
# The sense of motion changes where the speed is below this share of its RMS, or below so many times its noise.
STANDSTILL_SHARE, STANDSTILL_NOISE = 0.005, 2.0
# Without a measured torque, samples so near a reversal are not used, s: a brake changes sign there at an unknown time.
FLIP_S = 0.25
# Where the load comes from the motors' currents, samples slower than this share of the RMS speed are not used: the
# friction of motor and gearhead hides the load there, and the smoothed load rounds the jump beside it.
HIDDEN_SHARE = 0.3
# If these are more than this share of a run, too few others remain, and all samples are used.
MOST_BLIND = 0.5
# The first half sweep is left out if at least so many follow.
FEWEST_SWEEPS = 3
# Between simulated samples, load and difference of the inputs may deviate from a straight line by this share of their
# range, the load by this share of its sensor's noise; of a run too long to use every sample, the difference by that of
# what a step of the encoders makes.
BENT_SHARE = 0.001
BENT_NOISE = 0.05
BENT_STEP = 0.01
# A play or a friction changes sides within a jump of the load or a reversal: the load and the sense of motion change by
# at most this share of their range between simulated samples.
JUMP_SHARE = 0.1
# A motion of the inputs within this share of their travel is no path: it may be noise.
PATH_SHARE = 1e-3


@compiled
def _play(drive: Floats, half: float, out: Floats) -> None:
    at = drive[0]
    for k in range(drive.size):
        at = min(max(at, drive[k] - half), drive[k] + half)
        out[k] = at


@compiled
def _slid(drive: Floats, path: float, out: Floats) -> None:
    at = 0.0
    for k in range(1, drive.size):
        step = drive[k] - drive[k - 1]
        sense = 1.0 if step > 0.0 else -1.0
        at = sense + (at - sense) * math.exp(-abs(step) / path)
        out[k] = at


def slid(drive: Floats, path: float) -> Floats:
    """Share, -1 to 1, of a friction that builds up along ``drive`` (n,): 63 % of it over ``path`` (P. R. Dahl)."""
    out = np.zeros_like(drive)
    _slid(np.ascontiguousarray(drive), path, out)
    return out


def played(drive: Floats, half: float) -> Floats:
    """What follows ``drive`` (n,) with a play of ``half`` to either side: the play operator."""
    out = np.empty_like(drive)
    _play(np.ascontiguousarray(drive), half, out)
    return out


@dataclass(frozen=True)
class Windows:
    """Widths of the smoothing that were used, s: medians over the samples. ``load_s`` is 0 without a torque column."""

    difference_s: float
    load_s: float
    speed_s: float


@dataclass(frozen=True, eq=False)
class Prepared:
    """Signals of one run on the samples that the fits use; shapes (n,) or (n_inputs, n).

    ``angle_rad`` is as measured, ``shaft_rad`` without the encoders' steps, ``apart_rad`` how far each input slowly
    stands from their mean. ``sweep`` numbers the half sweeps, -1 for the first, whose friction history is unknown;
    ``sector`` is the angle sector; ``used`` marks samples of known history, ``held`` those held back. ``floor_rad`` is
    the RMS that the sensors alone put into the residual, 0 where the measurement file does not say; ``input_step_rad``
    one step of the inputs; ``few``: too few half sweeps to leave the first one out. ``cut``: which samples of the run
    these are. ``standstill_rad_s``: speed below which the sense of motion is not sharp. ``cycles_a_turn``: order of the
    fastest ripple of the inputs that the simulated samples must follow; ``built_up_rad``: path of the inputs' mean over
    which a friction builds up that they must follow, 0 for none.
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
    standstill_rad_s: float
    held_words: str
    few: bool
    run: Run
    cut: samples.Cut
    windows: Windows
    cycles_a_turn: float = 0.0
    built_up_rad: float = 0.0

    @property
    def train(self) -> NDArray[np.bool_]:
        """Samples that the fits may use."""
        return self.used & ~self.held

    @property
    def test(self) -> NDArray[np.bool_]:
        """Samples held back."""
        return self.used & self.held

    @cached_property
    def sense(self) -> Floats:
        """Sense of motion, -1 to 1, with a smooth transition near standstill, (n,)."""
        return np.asarray(np.tanh(self.speed_rad_s / self.standstill_rad_s))

    @cached_property
    def mean_rad(self) -> Floats:
        """Mean of the inputs as measured, (n,)."""
        return np.asarray(self.angle_rad.mean(axis=0))

    @cached_property
    def common_rad(self) -> Floats:
        """Mean of the inputs without the encoders' steps, (n,)."""
        return np.asarray(self.shaft_rad.mean(axis=0))

    @cached_property
    def path_rad(self) -> Floats:
        """Path that the mean of the inputs has travelled since the run began, rad (n,).

        From the whole run, with what lies between stretches. Noise travels too, so the angle must leave a band first.
        """
        run = self.run
        mean = smoothed_at(run.input_rad, run.time_s, COMMON_WINDOW_S, run.step_s).mean(axis=0)
        followed = played(mean, PATH_SHARE * float(np.ptp(mean)))
        return np.asarray(np.cumsum(np.abs(np.diff(followed, prepend=followed[0])))[self.cut.index])

    @cached_property
    def coarse(self) -> NDArray[np.int64]:
        """Samples on which the cables are simulated: between them all signals that move the cables are nearly straight.

        The ends of each stretch and the few samples that lead in to it are among them.
        """
        n = self.time_s.size
        turned = np.abs(np.diff(self.common_rad)) / COARSE_TURN_RAD
        if self.cycles_a_turn:
            cycles = np.abs(np.diff(self.common_rad)) * self.cycles_a_turn / (2.0 * np.pi)
            turned = np.maximum(turned, IN_A_CYCLE * cycles)
        passed = np.maximum(turned, np.diff(self.time_s) / COARSEST_S)
        built_up = slid(self.common_rad, self.built_up_rad) if self.built_up_rad else None
        for values in (self.sense, self.load_Nm, built_up):
            if values is not None and np.ptp(values) > 0.0:
                passed = np.maximum(passed, np.abs(np.diff(values)) / (JUMP_SHARE * float(np.ptp(values))))
        grid = np.flatnonzero(np.diff(np.floor(np.cumsum(passed)), prepend=-1.0))
        few = np.flatnonzero(self.cut.lead)
        ends = np.append(self.cut.starts[1:], n) - 1
        at = np.unique(np.concatenate([[0], grid, few, few[few > 0] - 1, self.cut.starts, ends]))
        for values, most in self._works_the_cables:
            at = _until_straight(at, values, most)
        return at

    @cached_property
    def coarse_common_rad(self) -> Floats:
        """``common_rad`` on the samples ``coarse``."""
        return np.asarray(self.common_rad[self.coarse])

    @cached_property
    def coarse_rad(self) -> Floats:
        """The inputs that work the cables, on the samples ``coarse``, (n_inputs, m)."""
        return np.asarray(self.coarse_common_rad + self.apart_rad[:, self.coarse])

    @cached_property
    def removed_rad(self) -> Floats:
        """What the smoothing removed from each input beside its mean, (n_inputs, n)."""
        return np.asarray(self.angle_rad - self.mean_rad - self.apart_rad)

    @property
    def _works_the_cables(self) -> list[tuple[Floats, float]]:
        """Signals that drive the friction, and the deviation from a straight line that each may have between
        samples."""
        long = self.time_s.size < self.run.time_s.size
        least = BENT_STEP * self.input_step_rad / math.sqrt(12.0) if long else 0.0
        found = [(row, max(BENT_SHARE * float(np.ptp(row)), least)) for row in self.apart_rad]
        if self.load_Nm is not None:
            noise = 0.0 if self.run.load_Nm is None else samples.noise_of_signal(self.run.load_Nm)
            found.append((self.load_Nm, max(BENT_SHARE * float(np.ptp(self.load_Nm)), BENT_NOISE * noise)))
        return found

    def following(self, cycles_a_turn: float) -> "Prepared":
        """The run with simulated samples close enough for a ripple of that order of the inputs.

        Similar orders share one object, so that a fit may change the order and still use the cached simulations.
        """
        if cycles_a_turn <= self.cycles_a_turn:
            return self
        order = 2.0 ** math.ceil(math.log2(cycles_a_turn))
        return self._followed.setdefault(order, replace(self, cycles_a_turn=order))

    def building_up(self, path_rad: float) -> "Prepared":
        """The run with simulated samples close enough for a friction that builds up over such a path of the inputs."""
        path = 2.0 ** math.floor(math.log2(path_rad))
        if path == self.built_up_rad:
            return self
        return self._followed.setdefault(-path, replace(self, built_up_rad=path))

    @cached_property
    def _followed(self) -> "dict[float, Prepared]":
        return {}

    def rewindowed(self, factor: float) -> "Prepared":
        """The same samples with other windows on the difference of the inputs and on the load."""
        return self.driven_by(self.run, factor)

    def driven_by(self, run: Run, factor: float = 1.0) -> "Prepared":
        """The same samples with the smoothed difference of the inputs and load of ``run``, logged at the same times;
        ``factor`` scales the noise that the smoothing assumes."""
        at = self.cut.index
        load = None if run.load_Nm is None else samples.quiet_load(run, factor)[0][at]
        return replace(self, apart_rad=samples.slow_difference(run, factor)[0][:, at], load_Nm=load)


def _until_straight(at: NDArray[np.int64], values: Floats, most: float) -> NDArray[np.int64]:
    """Samples ``at``, intervals halved until ``values`` (n,) deviate from straight lines by at most ``most``."""
    every = np.arange(values.size)
    while True:
        bent = np.abs(values - np.interp(every, at, values[at])) > most
        first = np.unique(np.searchsorted(at, np.flatnonzero(bent), side="right")) - 1
        if not first.size:
            return at
        at = np.union1d(at, (at[first] + at[first + 1]) // 2)


def prepare_all(runs: Sequence[Run], ratio: float) -> list[tuple[Prepared, Prepared]]:
    """Every run, as :func:`prepare` makes it. Short runs repeat each other: together they may have enough half
    sweeps."""
    counts = [int(run.half_sweep.max()) for run in runs]
    together = sum(counts) > FEWEST_SWEEPS and min(counts) > 1
    return [prepare(run, ratio, number if together else None, len(runs)) for number, run in enumerate(runs)]


def prepare(run: Run, ratio: float, one_of_several: int | None = None, runs: int = 1) -> tuple[Prepared, Prepared]:
    """The part of a run that the search uses, and the whole run; the same object for a short run.

    The first half sweep of the run and of every stretch is discarded. Some half sweeps are held back before any
    residual is computed (see ``samples``): the same ones in both. ``one_of_several`` is the number of a run that others
    repeat: of such runs, where one alone has too few half sweeps, every other holds one back. ``runs``: how many there
    are; of many runs fewer samples of each are enough.
    """
    step, time, output = run.step_s, run.time_s, run.output_rad
    shaft = smoothed_at(run.input_rad, time, COMMON_WINDOW_S, step)
    speed_s, speed_noise = samples.speed_window(run, ratio)
    quiet = smoothed(run.input_rad.mean(axis=0) / ratio, speed_s, step)
    speed = smoothed(np.gradient(quiet, smoothed(time, speed_s, step)), speed_s, step)
    apart, apart_s = samples.slow_difference(run)
    load, load_s = (None, 0.0) if run.load_Nm is None else samples.quiet_load(run)
    windows = Windows(apart_s, load_s, speed_s)
    temperature = None if run.temperature_C is None else smoothed(run.temperature_C, TEMPERATURE_WINDOW_S, step)
    sweep = run.half_sweep - 1
    short = bool(sweep.max() < FEWEST_SWEEPS)
    few = short and one_of_several is None
    if few:
        # Too few reversals to leave one half sweep out: each quarter of the time counts as a sweep.
        sweep = np.minimum((time - time[0]) / (time[-1] - time[0]) * 8.0, 7.0).astype(np.int64)
    low, span = float(output.min()), float(np.ptp(output))
    sector = np.minimum((output - low) / span * SECTORS, SECTORS - 1).astype(np.int64)
    searched = samples.search_cut(sweep, load, runs)
    held = _held(sweep, output, load, searched)
    if short and one_of_several is not None:
        held = np.array([one_of_several // 2 % (int(sweep.max()) + 1)] if one_of_several % 2 == 0 else [], dtype=int)
    words = samples.held_words(held, sweep, load, few)
    floor, input_step = sensor_floor_rad(run, ratio), samples.input_step_rad(run)
    blind = np.zeros(time.size, dtype=np.bool_)
    if load is None and run.ratio is None:
        flips = time[1:][np.diff(sweep) != 0]
        blind = np.searchsorted(flips, time + FLIP_S) > np.searchsorted(flips, time - FLIP_S)
        if blind.mean() > MOST_BLIND:
            blind[:] = False
    elif run.sensors.torque_class.of_currents:
        blind = np.abs(speed) < HIDDEN_SHARE * float(np.sqrt(np.mean(speed**2)))

    def taken(cut: samples.Cut) -> Prepared:
        at = cut.index
        here = sweep[at]
        used = (here >= 0) & ~cut.unknown & ~blind[at]
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
            max(STANDSTILL_SHARE * float(np.sqrt(np.mean(speed[at] ** 2))), STANDSTILL_NOISE * speed_noise, 1e-30),
            words,
            few,
            run,
            cut,
            windows,
        )

    whole = taken(samples.whole_cut(sweep, load, step))
    return (whole if searched is None else taken(searched)), whole


def held_out(runs: Sequence[Prepared]) -> str:
    """Which half sweeps were held back, of each run by its name where there are several."""
    if len(runs) == 1:
        return runs[0].held_words
    return "; ".join(f"{p.run.source or f'run {k}'}: {p.held_words}" for k, p in enumerate(runs, 1) if p.held.any())


def _held(
    sweep: NDArray[np.int64], output_rad: Floats, load_Nm: Floats | None, searched: samples.Cut | None
) -> NDArray[np.int64]:
    """Numbers of the half sweeps held back. The search judges an effect on its own half sweeps alone, so these and the
    others each have their share."""
    if searched is None:
        return samples.held_sweeps(sweep, output_rad, load_Nm)
    inside = searched.index[~searched.unknown]
    outside = np.flatnonzero(~np.isin(sweep, sweep[inside]))
    found = [
        samples.held_sweeps(sweep[at], output_rad[at], None if load_Nm is None else load_Nm[at])
        for at in (inside, outside)
    ]
    return np.union1d(*found)


def sensor_floor_rad(run: Run, ratio: float) -> float:
    """RMS of the residual from the declared errors of the encoders, rad: steps (uniform errors) and noise."""
    s = run.sensors
    step, noise = s.input_resolution_rad or 0.0, s.input_noise_rad or 0.0
    inputs = math.hypot(step / math.sqrt(12.0), noise) / ratio / math.sqrt(run.input_rad.shape[0])
    output = math.hypot((s.output_resolution_rad or 0.0) / math.sqrt(12.0), s.output_noise_rad or 0.0)
    return math.hypot(inputs, output)
