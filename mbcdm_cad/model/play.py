"""Inputs with play: the position of each pulley within its play at each sample.

A pulley with play rests on the flank that transmits its torque. Without torque it floats between the flanks, at the
angle at which the torques of its cables cancel. The friction of the cables depends on the path, so this position is
found at each sample before the cables are moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbcdm_cad.model.hysteresis import DRUM, FREE, PRELOAD, SIGMA, at_preload, balance, constants, settle, simulate
from mbcdm_cad.model.series import checked_series, path_offset_m
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# Largest numbers of steps to find the position of a floating pulley in one sample, and of rounds over the inputs.
STEPS = 40
ROUNDS = 8
# A torque below this share of that from the preload of one cable counts as zero.
NO_TORQUE = 1e-6


def lags(
    d: DriveSI, input_angle_rad: Floats, load_Nm: Floats, path_m: Floats | None, play_rad: Sequence[float]
) -> Floats:
    """How far each pulley lags behind the middle of its play, rad (n_inputs, n), between -play/2 and +play/2.

    ``play_rad`` has one value for each input; other arguments and errors as in
    :func:`mbcdm_cad.model.hysteresis.simulate`. Wraps are taken as longer than any slip zone, and without slip on
    passed bodies. Before the first sample each pulley rests on the flank to which the preload presses it.
    """
    d = d.without_passed_slip if d.slips_on_passed else d
    half = 0.5 * np.asarray(play_rad, dtype=float)
    if d.n_inputs == 1:
        # It turns with the drum and never floats: the sign of its torque gives the flank.
        carried = simulate(d, input_angle_rad, load_Nm, path_m).input_torque_Nm(d)
        return np.asarray(half[:, None] * np.where(carried == 0.0, faces(d)[:, None], np.sign(carried)))
    return lags_and_drum_rad(d, input_angle_rad, load_Nm, path_m, play_rad)[0]


def lags_and_drum_rad(
    d: DriveSI, input_angle_rad: Floats, load_Nm: Floats, path_m: Floats | None, play_rad: Sequence[float]
) -> tuple[Floats, Floats]:
    """The same for a drive of several inputs, and with it the drum angle that this balances, rad (n,).

    The drum angle is that of :func:`mbcdm_cad.model.hysteresis.simulate` with the pulleys in these positions.
    """
    half = 0.5 * np.asarray(play_rad, dtype=float)
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    lever = d.sigma * d.input_radius_m
    begun = half * faces(d)
    offset = lever[:, None] * angle[list(d.input_of)] + path_offset_m(d, path_m, load.size)
    offset += (lever * begun[list(d.input_of)])[:, None]
    found = np.empty((d.n_inputs + 1, load.size))
    turns = np.empty((d.n_cables, load.size + 2, 2))
    pulleys = np.stack([lever, np.array(d.input_of, dtype=float)], axis=1)
    failed = _run(constants(d), pulleys, np.stack([half, begun], axis=1), offset, load, turns, found)
    if failed >= 0:
        raise ModelError(f"sample {failed}: no drum angle balances a load of {load[failed]:.6g} N m with this play")
    return found[:-1], found[-1]


def faces(d: DriveSI) -> Floats:
    """+1 or -1 for each input: the flank to which the preload presses the pulley, (n_inputs,)."""
    bias = [float(np.sum(d.sigma * d.input_radius_m * d.preload_N * d.of_input(k))) for k in range(d.n_inputs)]
    return np.where(np.array(bias) >= 0.0, 1.0, -1.0)


@compiled
def _run(
    table: Floats, pulleys: Floats, faces: Floats, offsets: Floats, load: Floats, turns: Floats, found: Floats
) -> int:
    """Fill ``found``, the lag of each pulley and last the drum angle; the first sample that cannot be balanced, or -1.

    ``pulleys`` (n_cables, 2): lever of each cable at its input, and that input; ``faces`` (n_inputs, 2): half the play,
    and where the pulley begins; ``offsets`` (n_cables, n): stretch with all pulleys in the middle of their play.
    """
    n_cables, n_inputs = table.shape[0], faces.shape[0]
    state, theta = at_preload(table), 0.0
    lag, offset, before = faces[:, 1].copy(), np.empty(n_cables), np.zeros(n_cables)
    pulled = np.empty((n_cables, 2))
    least = NO_TORQUE * abs(table[0, PRELOAD] * pulleys[0, 0])
    for k in range(load.size):
        push, grip = 0.0, 0.0
        for j in range(n_cables):
            offset[j] = offsets[j, k] - pulleys[j, 0] * lag[int(pulleys[j, 1])]
            push += table[j, SIGMA] * table[j, DRUM] / table[j, FREE] * (offset[j] - before[j])
            grip += table[j, DRUM] ** 2 / table[j, FREE]
        theta, balanced = balance(table, state, turns, offset, load[k], theta + push / grip, pulled)
        for _ in range(ROUNDS):
            moved = 0
            for i in range(n_inputs):
                half = faces[i, 0]
                low, high = -half, half
                for _ in range(STEPS if half > 0.0 and balanced else 0):
                    torque, own, crossed, drum = 0.0, 0.0, 0.0, 0.0
                    for j in range(n_cables):
                        at_drum = table[j, SIGMA] * table[j, DRUM]
                        drum += at_drum * at_drum * pulled[j, 1]
                        if int(pulleys[j, 1]) == i:
                            torque += pulleys[j, 0] * pulled[j, 0]
                            own += pulleys[j, 0] * pulleys[j, 0] * pulled[j, 1]
                            crossed += pulleys[j, 0] * at_drum * pulled[j, 1]
                    if abs(torque) <= least or (torque > 0.0 and lag[i] >= half) or (torque < 0.0 and lag[i] <= -half):
                        break
                    if torque > 0.0:
                        low = lag[i]
                    else:
                        high = lag[i]
                    following = min(max(lag[i] + torque / (own - crossed * crossed / drum), -half), half)
                    if not (low <= following <= high) or following == lag[i]:
                        following = 0.5 * (low + high)
                    if following == lag[i]:
                        break
                    for j in range(n_cables):
                        if int(pulleys[j, 1]) == i:
                            offset[j] -= pulleys[j, 0] * (following - lag[i])
                    lag[i] = following
                    moved += 1
                    theta, balanced = balance(table, state, turns, offset, load[k], theta, pulled)
            if moved == 0 or n_inputs == 1:
                break
        if not balanced:
            return k
        settle(table, state, turns, offset, theta, pulled)
        found[n_inputs, k] = theta
        for j in range(n_cables):
            before[j] = offset[j]
        for i in range(n_inputs):
            found[i, k] = lag[i]
    return -1
