"""The duty: a cycle of loads and movements that repeats, and what it asks of each motor: torque, temperature, time.

A cycle is pieces of constant load and speed. A load above zero opposes positive rotation of the drum.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil, inf, sqrt

import numpy as np

from mbcdm_cad.design.blocks import DutyRow
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.duty_record import RecordedDuty
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.heat import RATED_AT_C, STANDSTILL_SHARE, MotorHeat, Temperatures
from mbcdm_cad.model.losses import Train
from mbcdm_cad.routes import Floats

# What a design file that states no duty is taken to do: over the whole travel and back in so many seconds, under a
# share of the peak torque that is the usual test torque, and for a share of the time still under the peak torque.
DEFAULT_PERIOD_S, DEFAULT_PEAK_SHARE, DEFAULT_TORQUE_SHARE = 10.0, 0.1, 0.3
# Times there and back in one row that are told apart; more of them are as even for the winding as their mean.
_MOST_STROKES = 50
# Classes of range and load, from zero to the largest, into which more strokes of a record are sorted.
_CLASSES = 6
# Turns back by less than this share of the whole range are noise of a recorded angle.
_NOISE_SHARE = 0.01
_HOUR_S = 3600.0


@dataclass(frozen=True)
class Stroke:
    """Movement of the drum over ``range_deg`` and back, the load of the largest amount on it, and how often an hour."""

    range_deg: float
    torque_Nm: float
    per_h: float


@dataclass(frozen=True, eq=False)
class Duty:
    """One cycle by its pieces: duration, load on the drum, speed of the drum (zero: it holds), all of shape (n,).

    ``strokes``: the movements there and back of one cycle. ``stated``: whether the design file states it.
    ``assumed``: what the file leaves out, as words for a report.
    """

    time_s: Floats
    torque_Nm: Floats
    speed_deg_s: Floats
    strokes: tuple[Stroke, ...]
    ambient_C: float
    stated: bool
    assumed: tuple[str, ...] = ()

    @property
    def period_s(self) -> float:
        """Duration of a cycle."""
        return float(self.time_s.sum())

    @property
    def peak_torque_Nm(self) -> float:
        """Largest load, either way."""
        return float(np.abs(self.torque_Nm).max())

    @property
    def rms_torque_Nm(self) -> float:
        """Root mean square of the load over the cycle."""
        return float(np.sqrt((self.time_s * self.torque_Nm**2).sum() / self.period_s))

    @property
    def lasting_torque_Nm(self) -> float:
        """Cubic mean of the load over the cycle, what a gearhead's continuous rating is compared with.

        The rule of gearhead makers for loads that change; at rest they count nothing, here a held load counts whole.
        """
        return float(np.cbrt((self.time_s * np.abs(self.torque_Nm) ** 3).sum() / self.period_s))

    @property
    def moving_share(self) -> float:
        """Share of the time in which the drum moves."""
        return float(self.time_s[self.speed_deg_s != 0.0].sum() / self.period_s)

    @property
    def largest_speed_deg_s(self) -> float:
        """Largest speed of the drum."""
        return float(np.abs(self.speed_deg_s).max())

    @property
    def cycles_per_h(self) -> float:
        """Movements of the drum there and back, an hour."""
        return sum(stroke.per_h for stroke in self.strokes)


def of_rows(
    rows: Sequence[DutyRow], period_s: float, travel_deg: float, ambient_C: float, assumed: Sequence[str] = ()
) -> Duty:
    """The duty that a file states by rows, one after the other; ``travel_deg``: from end to end.

    Shares count relative to their sum. A row at a speed of zero, or with neither speed nor range, holds. Without a
    range it moves over the whole travel; without a speed it moves once there and back in its time.
    """
    pieces: list[tuple[float, float, float]] = []
    strokes = []
    whole = sum(row.share for row in rows)
    for row in rows:
        time = period_s * row.share / whole
        if row.speed_deg_s == 0.0 or (row.speed_deg_s is None and row.range_deg is None):
            pieces.append((time, row.torque_Nm, 0.0))
            continue
        span = travel_deg if row.range_deg is None else row.range_deg
        speed = 2.0 * span / time if row.speed_deg_s is None else abs(row.speed_deg_s)
        many = speed * time / (2.0 * span)
        pairs = min(ceil(many - 1e-9), _MOST_STROKES)
        pieces += [(time / (2 * pairs), row.torque_Nm, way * speed) for way in (1.0, -1.0)] * pairs
        strokes.append(Stroke(span, row.torque_Nm, many * _HOUR_S / period_s))
    times, torques, speeds = np.array(pieces).T
    return Duty(times, torques, speeds, tuple(strokes), ambient_C, True, tuple(assumed))


def default_duty(peak_torque_Nm: float, travel_deg: float, ambient_C: float, weight_Nm: float = 0.0) -> Duty:
    """The duty of a design file that states none.

    ``weight_Nm``: torque of the payload's weight with its centre beside the axis, which the motors carry all the time:
    where it is larger than the usual share of the peak torque, it stands in its place.
    """
    usual = DEFAULT_TORQUE_SHARE * peak_torque_Nm
    moved = max(usual, weight_Nm)
    rows = (
        DutyRow(torque_Nm=peak_torque_Nm, share=DEFAULT_PEAK_SHARE),
        DutyRow(torque_Nm=moved, share=1.0 - DEFAULT_PEAK_SHARE, range_deg=travel_deg),
    )
    found = of_rows(rows, DEFAULT_PERIOD_S, travel_deg, ambient_C)
    share = f"{DEFAULT_TORQUE_SHARE:g} of the peak torque"
    words = [
        f"the whole travel and back every {DEFAULT_PERIOD_S:g} s under {share}, "
        f"which is held for {DEFAULT_PEAK_SHARE:.0%} of the time",
        f"ambient {ambient_C:g} C",
    ]
    if weight_Nm > usual:
        words[0] = (
            f"the whole travel and back every {DEFAULT_PERIOD_S:g} s under the payload's weight, {weight_Nm:.4g} N m "
            f"beside the axis (more than {share}); the peak torque is held for {DEFAULT_PEAK_SHARE:.0%} of the time"
        )
    elif weight_Nm > 0.0:
        words.append(f"the payload's weight, {weight_Nm:.4g} N m beside the axis, is within these loads")
    return Duty(found.time_s, found.torque_Nm, found.speed_deg_s, found.strokes, ambient_C, False, tuple(words))


def of_record(
    time_s: Floats, angle_deg: Floats, torque_Nm: Floats, ambient_C: float, assumed: Sequence[str] = ()
) -> Duty:
    """The duty of a recorded cycle: angle and load over a time that grows; the last sample ends it.

    Between two samples speed and load are constant, the load their root mean square, with the sign of their mean.
    """
    steps = np.diff(time_s)
    a, b = torque_Nm[1:], torque_Nm[:-1]
    # Of a straight line between the samples.
    load = np.sqrt((a * a + a * b + b * b) / 3.0) * np.where(a + b < 0.0, -1.0, 1.0)
    strokes = _strokes(angle_deg, torque_Nm, float(steps.sum()))
    return Duty(steps, load, np.diff(angle_deg) / steps, strokes, ambient_C, True, tuple(assumed))


def duty_of(drive: Drive) -> Duty:
    """The duty that the design file states, or the assumed one."""
    stated, travel = drive.loads.duty, 2.0 * drive.half_travel_deg
    if stated is None:
        return default_duty(drive.loads.peak_torque_Nm, travel, RATED_AT_C, drive.loads.carried.weight_torque_Nm)
    assumed = []
    period, ambient = stated.period_s, stated.ambient_C
    recorded = isinstance(stated, RecordedDuty)
    if period is None and not recorded:
        period = DEFAULT_PERIOD_S
        assumed.append(f"a cycle takes {period:g} s")
    if ambient is None:
        ambient = RATED_AT_C
        assumed.append(f"ambient {ambient:g} C")
    if isinstance(stated, RecordedDuty):
        found = stated.samples
        time, angle, torque = (np.array(values) for values in (found.time_s, found.angle_deg, found.torque_Nm))
        return of_record(time, angle, torque, ambient, assumed)
    return of_rows(stated.rows, period or DEFAULT_PERIOD_S, travel, ambient, assumed)


def _strokes(angle_deg: Floats, torque_Nm: Floats, period_s: float) -> tuple[Stroke, ...]:
    """Half movements from reversal to reversal; each counts half. The last one ends where the cycle begins anew."""
    angle = np.append(angle_deg, angle_deg[0])
    torque = np.append(torque_Nm, torque_Nm[0])
    least = _NOISE_SHARE * float(np.ptp(angle))
    turns, way = [0], 0.0
    for k in range(1, len(angle)):
        moved = float(angle[k] - angle[turns[-1]])
        if way * moved > 0.0:
            turns[-1] = k  # further the same way
        elif abs(moved) > least:
            way = float(np.sign(moved))
            turns.append(k)
    once = 0.5 * _HOUR_S / period_s
    parts = ((float(abs(angle[b] - angle[a])), torque[a : b + 1]) for a, b in pairwise(turns))
    return _classed([Stroke(span, float(load[np.abs(load).argmax()]), once) for span, load in parts])


def _classed(strokes: Sequence[Stroke]) -> tuple[Stroke, ...]:
    """Many strokes by classes of range and load; each class counts as the largest of both in it."""
    if len(strokes) <= _MOST_STROKES:
        return tuple(strokes)
    span, load = max(s.range_deg for s in strokes), max(abs(s.torque_Nm) for s in strokes) or 1.0
    classes: dict[tuple[int, int], list[Stroke]] = {}
    for s in strokes:
        key = ceil(s.range_deg / span * _CLASSES), ceil(s.torque_Nm / load * _CLASSES)
        classes.setdefault(key, []).append(s)
    return tuple(
        Stroke(max(s.range_deg for s in each), max((s.torque_Nm for s in each), key=abs), sum(s.per_h for s in each))
        for each in classes.values()
    )


# Temperature of a seat beside the housing's, a standard deviation of the estimate, K.
SEAT_SIGMA_K = 5.0
# More than so many times the torques of a duty are not looked for.
MOST_SHARE = 10.0


def motor_torques_Nm(train: Train, load_Nm: Floats, speed: Floats) -> Floats:
    """Torque at each motor's shaft, (n_inputs, n), under loads while the drum moves with ``speed``, or holds at zero.

    Moving counts all losses but the motor's own friction, which the catalogue's torques do not contain either. While
    the drum holds, friction may help or hinder, and is left out; the torque that the preload puts on an input is in it.
    """
    load, speed = np.asarray(load_Nm, float), np.asarray(speed, float)
    # Against the load is the way of the motion where load and speed have one sign; see Train.moving without a load.
    way = np.where(speed * np.where(load < 0.0, -1.0, 1.0) >= 0.0, 1, -1)
    kinds, of = np.unique(np.stack([load, np.where(speed == 0.0, 0, way)]), axis=1, return_inverse=True)
    of = np.asarray(of).reshape(-1)
    found = np.zeros((train.d.n_inputs, kinds.shape[1]))
    for sign in (0, 1, -1):
        at = kinds[1] == sign
        if not at.any():
            continue
        if sign == 0:
            held = solve_equilibrium(train.d, kinds[0, at])
            found[:, at] = np.abs(held.input_torque_Nm(train.d)) / train.gear_ratio
        else:
            found[:, at] = np.abs(train.moving(kinds[0, at], sign).motor_Nm - train.motor_idle_Nm)
    return np.asarray(found[:, of])


@dataclass(frozen=True, eq=False)
class MotorDay:
    """One motor over the duty. ``heat_torque_Nm``: in each piece, the torque that heats it as much.

    It is larger than the torque where a brushless motor holds at standstill. ``peak_Nm``: the torque that the drive's
    peak load asks of it, held.
    """

    name: str
    heat: MotorHeat
    duty: Duty
    torque_Nm: Floats
    heat_torque_Nm: Floats
    peak_Nm: float

    @property
    def rms_Nm(self) -> float:
        """Root mean square of the torque that heats it."""
        return sqrt(float((self.duty.time_s * self.heat_torque_Nm**2).sum()) / self.duty.period_s)

    @cached_property
    def repeated(self) -> Temperatures | None:
        """Temperatures of the cycle that repeats; None where the winding would get hotter without end."""
        return self.heat.repeated(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C)

    @property
    def winding_C(self) -> float:
        """Hottest temperature of the winding in the cycle that repeats."""
        return inf if self.repeated is None else self.repeated.hottest_winding_C

    @property
    def housing_C(self) -> float:
        """Hottest temperature of the housing in the cycle that repeats."""
        return inf if self.repeated is None else self.repeated.hottest_housing_C

    @cached_property
    def sigma_K(self) -> tuple[float, float]:
        """Standard deviations of both temperatures, from mounting and from figures that are estimates."""
        found = np.zeros(2)
        for pair in self.heat.sigmas():
            at = [m.repeated(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C) for m in pair]
            if any(t is None for t in at):
                return inf, inf
            high, low = (np.array([t.hottest_winding_C, t.hottest_housing_C]) for t in at if t is not None)
            found += (0.5 * (high - low)) ** 2
        winding, housing = np.sqrt(found)
        return float(winding), float(housing)

    @property
    def peak_from_cold_s(self) -> float:
        """How long it holds the peak load, winding and housing as cold as the air at the start."""
        return self.heat.time_to_limit_s(self.peak_Nm, self.duty.ambient_C)

    @property
    def peak_from_warm_s(self) -> float:
        """How long it holds the peak load from the hottest moment of the duty."""
        if self.repeated is None:
            return 0.0
        k = int(self.repeated.winding_C.argmax())
        start = float(self.repeated.winding_C[k]), float(self.repeated.housing_C[k])
        return self.heat.time_to_limit_s(self.peak_Nm, self.duty.ambient_C, start)

    @cached_property
    def stands_share(self) -> float:
        """Torques of the duty that its winding stands, over those it has; at most :data:`MOST_SHARE`."""
        low, high = 0.0, MOST_SHARE
        for _ in range(24):
            middle = 0.5 * (low + high)
            found = self.heat.repeated(self.duty.time_s, middle * self.heat_torque_Nm, self.duty.ambient_C)
            fits = found is not None and found.hottest_winding_C <= self.heat.limit_C
            low, high = (middle, high) if fits else (low, middle)
        return low

    @property
    def duty_from_cold_s(self) -> float:
        """How long the duty may go on from cold; infinite where it may without end."""
        if self.winding_C <= self.heat.limit_C:
            return inf
        return self.heat.cycles_to_limit_s(self.duty.time_s, self.heat_torque_Nm, self.duty.ambient_C)


def motor_days(
    train: Train, heat: MotorHeat, duty: Duty, peak_torque_Nm: float, names: Sequence[str]
) -> tuple[MotorDay, ...]:
    """Every motor of a drive over its duty."""
    torque = motor_torques_Nm(train, duty.torque_Nm, duty.speed_deg_s)
    peaks = motor_torques_Nm(train, np.array([peak_torque_Nm, -peak_torque_Nm]), np.zeros(2)).max(axis=1)
    still = 1.0 / STANDSTILL_SHARE if heat.brushless else 1.0
    warms = torque * np.where(duty.speed_deg_s == 0.0, still, 1.0)
    return tuple(
        MotorDay(name, heat, duty, torque[i], warms[i], still * float(peaks[i])) for i, name in enumerate(names)
    )
