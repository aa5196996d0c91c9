"""The simulated run: drive, inputs, load, cable paths and additions to the reading; and the simulation itself.

Orders in angle stand below: the part of a residual that repeats N times for a turn of the drum.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

# What a file of effects takes from here.
from mbcdm_cad.loop.prepare.prepared import Prepared as Prepared
from mbcdm_cad.loop.prepare.readings import under_load
from mbcdm_cad.model.creep import START_S
from mbcdm_cad.model.hysteresis import faces, lags, lags_and_drum_rad, simulate
from mbcdm_cad.model.profiles import Response, simulate_profiles
from mbcdm_cad.model.si import DriveSI as DriveSI
from mbcdm_cad.routes import Floats as Floats
from mbcdm_cad.storage.compiled import compiled

# Simulations in the cache: as many as one Jacobian needs, so that effects on the reading alone need no simulation.
REMEMBERED = 24


@dataclass(frozen=True, eq=False)
class Setup:
    """One run as it is to be predicted: everything that an effect may change.

    ``d`` is None for a drive of which only the ratio is known; ``load_Nm`` None without a torque column.
    ``path_m`` (n_cables, n) lengthens the cables' paths; ``shift_rad`` (n_inputs, n) is how far each input pulley
    stands from where its encoder says; ``added_rad`` (n,) adds to the reading; ``winding`` is how much of the winding
    history is applied, 0 to 1; ``play_rad`` is the play between encoder and pulley of each input, empty for none;
    ``creep`` is the share, 0 to 1, of the creep over the inputs that a wrap of ``through_rad`` allows; ``lines`` are
    lines in angle on the reading: cosine and sine in rad, cycles a turn of the output. ``rubbed_Nm`` (n,) is the part
    of the load that is friction and drag at the drum: the cables bear it, the output shaft does not.
    """

    d: DriveSI | None
    ratio: float
    p: Prepared
    load_Nm: Floats | None
    path_m: Floats | None
    shift_rad: Floats | None
    added_rad: Floats
    winding: float = 0.0
    play_rad: tuple[float, ...] = ()
    creep: float = 0.0
    through_rad: float = 0.0
    lines: tuple[tuple[float, float, float], ...] = ()
    rubbed_Nm: Floats | float = 0.0

    @property
    def drive(self) -> DriveSI:
        """The drive. AssertionError where only the ratio is known."""
        assert self.d is not None, "an effect of the cables was offered where only the ratio is known"
        return self.d

    @property
    def load(self) -> Floats:
        """The measured load, N m (n,). AssertionError for a run without torque."""
        assert self.load_Nm is not None, "an effect of the load was offered for a run without torque"
        return self.load_Nm

    @property
    def borne(self) -> Floats:
        """The load that structure and output shaft carry: that of the cables without the friction that loads them."""
        return np.asarray(self.load - self.rubbed_Nm)

    def with_rubbed(self, torque_Nm: Floats) -> "Setup":
        """Load the cables by a friction or a drag at the drum, (n,), beyond the output shaft."""
        return replace(self, load_Nm=self.load + torque_Nm, rubbed_Nm=self.rubbed_Nm + torque_Nm)

    def with_path(self, path_m: Floats) -> "Setup":
        """Lengthen the paths of the cables."""
        return replace(self, path_m=path_m if self.path_m is None else self.path_m + path_m)

    def with_shift(self, index: int, shift_rad: Floats) -> "Setup":
        """Move one input pulley away from the angle of its encoder."""
        shift = np.zeros_like(self.p.angle_rad)
        shift[index] += shift_rad
        return self.with_shifts(shift)

    def with_shifts(self, shift_rad: Floats) -> "Setup":
        """Move all input pulleys, (n_inputs, n)."""
        return replace(self, shift_rad=shift_rad if self.shift_rad is None else self.shift_rad + shift_rad)

    def with_play(self, index: int, play_rad: float) -> "Setup":
        """Add play between encoder and pulley of one input."""
        play = list(self.play_rad or [0.0] * self.drive.n_inputs)
        play[index] += play_rad
        return replace(self, play_rad=tuple(play))

    def following(self, cycles_a_turn: float) -> "Setup":
        """Simulate the cables on samples close enough for a ripple of that order of the inputs."""
        return replace(self, p=self.p.following(cycles_a_turn))

    def with_added(self, added_rad: Floats) -> "Setup":
        """Add to the reading."""
        return replace(self, added_rad=self.added_rad + added_rad)

    def with_line(self, line: tuple[float, float, float]) -> "Setup":
        """Add a line in angle to the reading."""
        return replace(self, lines=(*self.lines, line))

    def input_shaft_rad(self, index: int) -> Floats:
        """Angle of one input pulley without the encoder's steps, rad (n,)."""
        return np.asarray(self.p.shaft_rad[index])

    @property
    def drum_rad(self) -> Floats:
        """Drum angle from the inputs and the ratio alone, rad (n,)."""
        return np.asarray(self.p.common_rad / self.ratio)


def declared(d: DriveSI | None, ratio: float, p: Prepared) -> Setup:
    """The declared model of a run: cables, and of the other parts what its file counts.

    Friction of cables and bearings loads the cables; the parts give with the load of the output alone. The play of a
    belt or gears is known where its inputs are measured at the motors. At rest the rope creeps as its catalogue says.
    """
    parts, load, added = p.run.parts, p.load_Nm, np.zeros_like(p.time_s)
    if p.run.expected_creep and d is not None and load is not None:
        give = give_rad_Nm(d) * p.run.expected_creep
        added = under_load(p, lambda since: give * np.log10(1.0 + since / START_S))
    if parts is None or load is None or d is None:
        return Setup(d, ratio, p, load, None, None, added)
    play = (parts.play_rad,) * d.n_inputs if parts.play_rad else ()
    bare = Setup(d, ratio, p, load, None, None, added - parts.give_rad_Nm * load, play_rad=play)
    return bare.with_rubbed(parts.friction_Nm * p.sense)


def give_rad_Nm(d: DriveSI | None) -> float:
    """Elastic turn of the drum for 1 N m with nothing slipping, rad/(N m); 1 where no drive is known."""
    return 1.0 if d is None else 1.0 / float(np.sum(d.axial_stiffness_N * d.drum_radius_m**2 / d.free_span_m))


def input_shares(d: DriveSI) -> Floats:
    """Share of each input in the stiffness at the drum, cables sticking; shape (n_inputs,)."""
    stiffness = d.drum_radius_m**2 / d.free_span_m
    return np.asarray([(stiffness * d.of_input(i)).sum() for i in range(d.n_inputs)] / stiffness.sum())


def rigid_drum_rad(s: Setup) -> Floats:
    """Drum angle with the elastic part off: the cables as springs that balance no load."""
    angle = s.p.angle_rad if s.shift_rad is None else s.p.angle_rad + s.shift_rad
    if s.d is None:
        return np.asarray(angle.mean(axis=0) / s.ratio)
    d = s.d
    wound = (d.sigma * d.input_radius_m)[:, None] * angle[list(d.input_of)]
    if s.path_m is not None:
        wound = wound + s.path_m
    weight = d.drum_radius_m / d.free_span_m
    return np.asarray(((weight * d.sigma)[:, None] * wound).sum(axis=0) / (weight * d.drum_radius_m).sum())


def _worked(s: Setup) -> tuple[Floats, Floats, Floats | None]:
    """The signals that move the cables, on the samples ``Prepared.coarse``: smoothed inputs, load, paths."""
    at = s.p.coarse
    angle = s.p.coarse_rad
    if s.shift_rad is not None:
        angle = angle + s.shift_rad[:, at]
    return angle, s.load[at], None if s.path_m is None else s.path_m[:, at]


def _simulated(s: Setup, winding: bool, through: bool = False) -> Response:
    """Drum angle with the cables simulated on those samples, rad.

    Winding history has no slip on passed bodies: where the design counts it, what it adds without winding is added.
    """
    worked, d = _worked(s), s.drive
    if winding and d.slips_on_passed:
        slipped, bare = simulate(d, *worked), simulate(d.without_passed_slip, *worked)
        wound = _simulated(replace(s, d=d.without_passed_slip), winding, through)
        return Response(
            wound.drum_angle_rad + slipped.drum_angle_rad - bare.drum_angle_rad,
            wound.tension_N + slipped.tension_N - bare.tension_N,
        )
    if through:
        return simulate_profiles(d, *worked, winding, s.through_rad)
    return simulate(d, *worked, winding)


def _between(p: Prepared, values: Floats) -> Floats:
    """Values on ``Prepared.coarse`` interpolated to all samples."""
    return straight_between(p.coarse, np.ascontiguousarray(values))


@compiled
def straight_between(at: NDArray[np.int64], values: Floats) -> Floats:
    """What numpy.interp gives at 0, 1, 2 ... for values at ``at``, which rises from 0, without a search at each."""
    found = np.empty(at[-1] + 1)
    for i in range(at.size - 1):
        slope = (values[i + 1] - values[i]) / (at[i + 1] - at[i])
        for k in range(at[i], at[i + 1]):
            found[k] = slope * (k - at[i]) + values[i]
    found[-1] = values[-1]
    return found


def respond(s: Setup, winding: bool = False, through: bool = False) -> Floats:
    """Drum angle on all samples, rad, (n,).

    The elastic part changes slowly and is interpolated. The common motion of the inputs is added on every sample, and
    the noise that was removed from the inputs is added back linearly.
    """
    p, d = s.p, s.drive
    if any(s.play_rad) and d.n_inputs > 1 and d.endless_wraps and not (winding or through or d.slips_on_passed):
        drum = lags_and_drum_rad(d, *_worked(s), s.play_rad)[1]
    else:
        s = taken_up(s)
        drum = _simulated(s, winding, through).drum_angle_rad
    elastic = drum - p.coarse_common_rad / s.ratio
    noise = input_shares(s.drive) @ p.removed_rad
    return np.asarray((p.mean_rad + noise) / s.ratio + _between(p, elastic))


def taken_up(s: Setup) -> Setup:
    """The setup with each pulley that has play at its position within it (:mod:`mbcdm_cad.model.hysteresis`).

    The position is computed with the declared wraps and without winding history: both change the torque on a pulley,
    and so its position, only a little.
    """
    if not any(s.play_rad):
        return s if s.play_rad == () else replace(s, play_rad=())
    d, bare = s.drive, replace(s, play_rad=())
    angle, load, path = _worked(bare)
    lag = lags(d, angle, load, path, s.play_rad)
    rest = faces(d)[:, None] * 0.5 * np.array(s.play_rad)[:, None]
    return bare.with_shifts(rest - np.stack([_between(s.p, row) for row in lag]))


def input_torque_Nm(s: Setup, index: int) -> Floats:
    """Torque on one input, on all samples, N m (n,); ``s`` comes from :func:`taken_up`."""
    return _between(s.p, _simulated(taken_up(s), False).input_torque_Nm(s.drive)[index])


# Steps of Newton's method after which the error of all lines is known to this, rad.
LINE_STEPS, LINE_RAD = 12, 1e-9
# The method stays within this slope of the error over the angle; beyond 1 the reading would turn back.
STEEPEST = 0.9


def lines_rad(s: Setup) -> Floats:
    """Error of the reading by all lines together, rad (n,).

    A line is a function of the shaft's true angle e = f(reading - e): with the wrong reading in its place a line would
    have overtones of amplitude times order. The reading, and not a smoothed angle, gives the phase of a fast order.
    """
    reading = s.p.output_rad
    at = reading - np.mean(reading - s.drum_rad)
    error = np.zeros_like(at)
    for _ in range(LINE_STEPS):
        true = at - (error - error.mean())
        value, slope = np.zeros_like(at), np.zeros_like(at)
        for cosine, sine, order in s.lines:
            c, w = np.cos(order * true), np.sin(order * true)
            value += cosine * c - sine * w
            slope += order * (-cosine * w - sine * c)
        step = (value - error) / (1.0 + np.clip(slope, -STEEPEST, STEEPEST))
        error = error + step
        if np.abs(step).max() < LINE_RAD:
            break
    return error


class Simulator:
    """Predicts the reading for setups and caches the last simulations."""

    def __init__(self) -> None:
        self._known: list[tuple[Setup, tuple[bool, float], Floats]] = []
        self._turned: list[tuple[Setup, object, Floats]] = []

    def __call__(self, s: Setup) -> Floats:
        """Reading of the output encoder, rad, shape (n,)."""
        drum = self._drum(s, False)
        if s.winding != 0.0:
            drum = drum + s.winding * (self._drum(s, True) - drum)
        if s.creep != 0.0:
            drum = drum + s.creep * (self._drum(s, True, through=True) - self._drum(s, True))
        drum = drum + s.added_rad
        return drum + lines_rad(s) if s.lines else drum

    def turned_by(self, key: object, s: Setup, change: Callable[[], Setup]) -> Floats:
        """How far the reading turns when ``change`` is made to ``s``, rad (n,); ``key`` is its name in the cache."""
        for known, name, turned in self._turned:
            history = (known.winding, known.creep, known.through_rad) == (s.winding, s.creep, s.through_rad)
            if name == key and history and _strained_alike(known, s):
                return turned
        # What only adds to the reading is the same before and after.
        turned = self(change()) - self(s)
        self._turned.append((s, key, turned))
        del self._turned[:-REMEMBERED]
        return turned

    def _drum(self, s: Setup, winding: bool, through: bool = False) -> Floats:
        asked = (winding, s.through_rad if through else 0.0)
        for known, flag, drum in self._known:
            if flag == asked and _strained_alike(known, s):
                return drum
        rigid = s.d is None or s.load_Nm is None
        drum = rigid_drum_rad(s) if rigid else respond(s, winding, through)
        self._known.append((s, asked, drum))
        del self._known[:-REMEMBERED]
        return drum


def _strained_alike(one: Setup, other: Setup) -> bool:
    """Whether the same objects strain the cables of both."""
    same = one.d is other.d and one.p is other.p and one.load_Nm is other.load_Nm and one.path_m is other.path_m
    return same and one.shift_rad is other.shift_rad and one.play_rad == other.play_rad


# The lowest order in the search makes this many cycles over the travel; a lower one is a trend.
LEAST_CYCLES = 2.5
MOST_ORDER = 4000.0
# A line must exceed by this factor the amplitude that the encoders' own steps can cause at its order.
STEP_LINE_MARGIN = 1.5


def order_spectrum(angle_rad: Floats, residual: Any) -> tuple[Floats, Floats]:
    """(cycles a turn, amplitude in the residual's unit) over the travel covered; binned in angle, then an FFT.

    Shapes (m,). The bins are a quarter of the shortest wave in the search, or wider where the samples are too few. Bins
    hold means, since samples are spaced unevenly (sweeps dwell at some angles, and pass the same ones again), and a
    Hann window keeps a slow trend from leaking into every order. Empty if the angle does not change.
    """
    low, span = float(angle_rad.min()), float(np.ptp(angle_rad))
    if span == 0.0:
        return np.empty(0), np.empty(0)
    bins = int(min(4.0 * MOST_ORDER * span / (2.0 * np.pi), angle_rad.size / 4.0)) + 8
    index = np.minimum(((angle_rad - low) / span * bins).astype(np.int64), bins - 1)
    count = np.bincount(index, minlength=bins)
    full = np.flatnonzero(count)
    window = np.hanning(bins)
    # Zero padding makes the grid of orders four times finer than one cycle a travel.
    length = 4 * bins
    half = length // 2 + 1

    def lines(values: Floats) -> Any:
        mean = np.interp(np.arange(bins), full, np.bincount(index, values, bins)[full] / count[full])
        mean = (mean - float((window * mean).sum() / window.sum())) * window
        return np.fft.fft(mean, length) / window.sum()

    if np.iscomplexobj(residual):
        both = np.abs(lines(residual.real) + 1j * lines(residual.imag))
        amplitude = np.maximum(both[:half], both[-np.arange(half)])
    else:
        amplitude = 2.0 * np.abs(lines(residual)[:half])
    orders = np.arange(amplitude.size) * bins / length * 2.0 * np.pi / span
    keep = (orders * span / (2.0 * np.pi) >= LEAST_CYCLES) & (orders <= min(MOST_ORDER, bins * np.pi / span))
    return orders[keep], amplitude[keep]


@lru_cache(maxsize=4)
def step_lines(setup: Setup) -> Floats:
    """Amplitude (rad) that the inputs' encoder steps can cause at each order of the spectrum; shape of its orders.

    The sawtooth of the steps has far more cycles a turn than any order in the search, but at steady speed the sampling
    aliases it to a lower order, where it is as steady as a true line.
    """
    p, used = setup.p, setup.p.used
    total: Floats | float = 0.0
    for index in range(setup.p.angle_rad.shape[0]):
        turns = 2.0 * np.pi * setup.input_shaft_rad(index)[used] / p.input_step_rad
        for harmonic in (1, 2, 3):
            height = p.input_step_rad / (np.pi * harmonic) / setup.ratio / setup.p.angle_rad.shape[0]
            total = total + height * order_spectrum(setup.drum_rad[used], np.exp(1j * harmonic * turns))[1]
    return np.asarray(total)


def strongest_orders(setup: Setup, residual: Floats) -> list[float]:
    """The two orders with the highest peaks, more than two cycles a travel apart; steps of encoders do not count."""
    used = setup.p.used
    angle, values = setup.drum_rad[used], residual[used]
    orders, amplitude = order_spectrum(angle, values - values.mean())
    if orders.size == 0:
        return []
    if setup.p.input_step_rad > 0.0:
        amplitude = np.where(amplitude > STEP_LINE_MARGIN * step_lines(setup), amplitude, 0.0)
    found: list[float] = []
    near = 2.0 * 2.0 * np.pi / float(np.ptp(angle))
    for k in np.argsort(amplitude)[::-1][:200]:
        if amplitude[k] > 0.0 and all(abs(orders[k] - other) > near for other in found):
            found.append(float(orders[k]))
        if len(found) == 2:
            break
    return found
