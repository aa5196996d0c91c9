"""Evaluation of the paper's three experiments."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.dynamic.rig import input_turns
from mbcdm_cad.rig.dynamic.run import DynamicRun
from mbcdm_cad.routes import Floats

# An input is saturated if its torque, averaged over a fifth of a second, is within 0.2 % of the limit.
SATURATED_SHARE = 0.998
AVERAGED_S = 0.2
# An input has left its angle if it is off by this much (five counts of its encoder), on the same average.
LEFT_RAD = 1e-3
# The drum has given way if it is off by this much, which is far more than its elastic deflection.
GIVEN_WAY_RAD = 0.02
LOWEST_ORDER = 20.0


def first_saturated_Nm(run: DynamicRun, limits_Nm: Sequence[float]) -> float:
    """Load torque at which the first input reaches its limit, N m; NaN if none does."""
    return _load_where(run, np.abs(run.motor_Nm) / np.asarray(limits_Nm)[:, None], SATURATED_SHARE)


def left_angle_Nm(run: DynamicRun, drive: Drive) -> float:
    """Load torque at which the first input has left its angle by :data:`LEFT_RAD`, N m; NaN if none does."""
    turns = np.array(input_turns(drive))
    return _load_where(run, np.abs(run.input_rad - turns[:, None] * run.reference_rad), LEFT_RAD)


def _load_where(run: DynamicRun, series: Floats, level: float) -> float:
    """Load at which the first row of ``series`` reaches ``level``, for running means of both."""
    window = np.full(max(int(AVERAGED_S / (run.time_s[1] - run.time_s[0])), 1), 1.0)
    load = np.convolve(np.abs(run.torque_Nm), window / window.size, mode="valid")
    reached = [np.flatnonzero(np.convolve(row, window / window.size, mode="valid") >= level) for row in series]
    first = min((int(over[0]) for over in reached if over.size), default=-1)
    return float(load[first]) if first >= 0 else float("nan")


def given_way_index(run: DynamicRun) -> int:
    """First sample at which the drum is off by :data:`GIVEN_WAY_RAD`; the length of the run if there is none."""
    over = np.flatnonzero(np.abs(run.reference_rad - run.drum_rad) > GIVEN_WAY_RAD)
    return int(over[0]) if over.size else int(run.time_s.size)


def given_way_Nm(run: DynamicRun) -> float:
    """Load torque at which the drum is off by :data:`GIVEN_WAY_RAD`, N m; NaN if it never is."""
    at = given_way_index(run)
    return float(abs(run.torque_Nm[at])) if at < run.time_s.size else float("nan")


def transmission_error_rad(run: DynamicRun, drive: Drive) -> Floats:
    """Measured output minus the mean of the measured inputs over the ratio, Eq. (2)."""
    turns = np.array(input_turns(drive))
    output: Floats = run.measured_drum_rad - (run.measured_input_rad / turns[:, None]).mean(axis=0)
    return output


def reversal_swings_rad(run: DynamicRun, drive: Drive, settle_s: float = 0.05, averaged_s: float = 0.1) -> Floats:
    """Change of the transmission error at each reversal of the load: difference of the means after and before it.

    A reversal lasts from the last sample above 95 % of the torque level to the first one above 95 % of the opposite
    level; ``settle_s`` before and after it is left out.
    """
    error, torque = transmission_error_rad(run, drive), run.torque_Nm
    level = np.abs(torque).max()
    side = np.where(torque > 0.95 * level, 1, np.where(torque < -0.95 * level, -1, 0))
    dt = run.time_s[1] - run.time_s[0]
    gap, mean = max(round(settle_s / dt), 1), max(round(averaged_s / dt), 1)
    swings, last = [], -1
    for k in np.flatnonzero(side).tolist():
        if last >= 0 and side[k] != side[last]:
            before, after = error[max(last - gap - mean, 0) : last - gap + 1], error[k + gap : k + gap + mean]
            if before.size and after.size:
                swings.append(abs(after.mean() - before.mean()))
        last = k
    return np.array(swings)


def angle_spectrum(angle_rad: Floats, error_rad: Floats, share: float = 0.8) -> tuple[Floats, Floats]:
    """Orders (cycles per rad) and amplitudes (rad) of the error over the angle, root mean square over the sweeps.

    The middle ``share`` of each sweep is interpolated on an even grid of angles, its linear trend is removed, and a
    Hann window is applied.
    """
    half = share * np.abs(angle_rad).max()
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle_rad))) != 0) + 1
    edges = [0, *turns.tolist(), angle_rad.size]
    count = 4096
    grid = np.linspace(-half, half, count)
    window = np.hanning(count)
    powers = []
    for start, end in pairwise(edges):
        angle, error = angle_rad[start:end], error_rad[start:end]
        if not half > 0.0 or angle.min() > -half or angle.max() < half:
            continue
        order = np.argsort(angle, kind="stable")
        even = np.interp(grid, angle[order], error[order])
        even -= np.polyval(np.polyfit(grid, even, 1), grid)
        powers.append((2.0 / window.sum() * np.abs(np.fft.rfft(even * window))) ** 2)
    if not powers:
        raise ValueError("the run contains no whole sweep; run more cycles")
    return np.fft.rfftfreq(count, grid[1] - grid[0]), np.sqrt(np.mean(powers, axis=0))


def highest_peak(order: Floats, amplitude: Floats, lowest: float = LOWEST_ORDER) -> tuple[float, float]:
    """(order, amplitude) of the highest line above ``lowest`` cycles per rad: vertex of a parabola through logarithms.

    The distance of two bins of the spectrum is one over the length of a sweep; near its maximum the logarithm of a Hann
    window's spectrum is nearly a parabola.
    """
    k = int(np.argmax(np.where(order >= lowest, amplitude, 0.0)))
    if not 0 < k < order.size - 1 or not amplitude[k - 1 : k + 2].min() > 0.0:
        return float(order[k]), float(amplitude[k])
    left, top, right = np.log(amplitude[k - 1 : k + 2])
    shift = 0.5 * (left - right) / (left - 2.0 * top + right)
    return float(order[k] + shift * (order[1] - order[0])), float(np.exp(top - 0.25 * (left - right) * shift))
