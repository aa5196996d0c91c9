"""Evaluation of the paper's three experiments."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.dynamic.rig import input_turns
from mbcdm_cad.rig.dynamic.run import DynamicRun
from mbcdm_cad.routes import Floats

# An input counts as saturated when its torque stays within 0.2 % of the limit, on the average of a fifth of a second.
SATURATED_SHARE = 0.998
AVERAGED_S = 0.2
# An input has left its angle when it is off by five counts of its encoder, on the same average.
LEFT_RAD = 1e-3
# The drum has given way when it is this far off: far more than elasticity accounts for.
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
    """Load at which the first row of ``series`` reaches ``level``, both as running means."""
    window = np.full(max(int(AVERAGED_S / (run.time_s[1] - run.time_s[0])), 1), 1.0)
    load = np.convolve(np.abs(run.torque_Nm), window / window.size, mode="valid")
    reached = [np.flatnonzero(np.convolve(row, window / window.size, mode="valid") >= level) for row in series]
    first = min((int(over[0]) for over in reached if over.size), default=-1)
    return float(load[first]) if first >= 0 else float("nan")


def given_way_index(run: DynamicRun) -> int:
    """First sample at which the drum is off by :data:`GIVEN_WAY_RAD`; the run's length if it never is."""
    over = np.flatnonzero(np.abs(run.reference_rad - run.drum_rad) > GIVEN_WAY_RAD)
    return int(over[0]) if over.size else int(run.time_s.size)


def given_way_Nm(run: DynamicRun) -> float:
    """Load torque at which the drum gave way, N m; NaN if it never did."""
    at = given_way_index(run)
    return float(abs(run.torque_Nm[at])) if at < run.time_s.size else float("nan")


def transmission_error_rad(run: DynamicRun, drive: Drive) -> Floats:
    """Measured output less the mean of the measured inputs over the ratio, Eq. (2)."""
    turns = np.array(input_turns(drive))
    output: Floats = run.measured_drum_rad - (run.measured_input_rad / turns[:, None]).mean(axis=0)
    return output


def reversal_swings_rad(run: DynamicRun, drive: Drive, settle_s: float = 0.05, averaged_s: float = 0.1) -> Floats:
    """How far the transmission error swings while the load turns over: means before and after each change of sign.

    The flank runs from where the torque leaves 95 % of its level to where it reaches 95 % of the other.
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

    Each sweep's middle ``share`` is put on an even grid of angles, freed of its line, and seen through a Hann window.
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
        raise ValueError("no whole sweep in the run: give it more cycles")
    return np.fft.rfftfreq(count, grid[1] - grid[0]), np.sqrt(np.mean(powers, axis=0))


def highest_peak(order: Floats, amplitude: Floats, lowest: float = LOWEST_ORDER) -> tuple[float, float]:
    """Where and how high the highest line above ``lowest`` cycles per rad is: top of a parabola through the logarithms.

    The spectrum's bins are one over the length of a sweep apart, and a Hann window is nearly a parabola there.
    """
    k = int(np.argmax(np.where(order >= lowest, amplitude, 0.0)))
    if not 0 < k < order.size - 1 or not amplitude[k - 1 : k + 2].min() > 0.0:
        return float(order[k]), float(amplitude[k])
    left, top, right = np.log(amplitude[k - 1 : k + 2])
    shift = 0.5 * (left - right) / (left - 2.0 * top + right)
    return float(order[k] + shift * (order[1] - order[0])), float(np.exp(top - 0.25 * (left - right) * shift))
