"""The loop over time: position loops at their own rate, the plant at a finer step, the log at a coarser one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig import chain
from mbcdm_cad.rig.chain import Chains
from mbcdm_cad.rig.dynamic import controller
from mbcdm_cad.rig.dynamic import plant as columns
from mbcdm_cad.rig.dynamic.controller import control
from mbcdm_cad.rig.dynamic.plant import Plant, State, Torques, advance, drum_friction, payload_at, stored
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# Entries of the load's row.
LOAD_INERTIA, STATIC_RATIO, STATIC_SPEED, UNBALANCE, UNBALANCE_ANGLE = range(5)
# Columns of an input encoder's row.
RESOLUTION, NOISE, DELAY = range(3)
# Columns of the log before those of the inputs (pulley, encoder, motor's torque, rotor) and of the cables (tension).
DRUM, PAYLOAD, TORQUE = range(3)
LOG_FIRST = 3


@compiled
def quantised(angle_rad: float, resolution_rad: float) -> float:
    """The count nearest to the angle, in rad; a resolution of 0 leaves the angle unchanged."""
    if resolution_rad <= 0.0:
        return angle_rad
    return math.floor(angle_rad / resolution_rad + 0.5) * resolution_rad


@compiled
def brake_capacity(level_Nm: float, speed_rad_s: float, load: Floats) -> float:
    """Friction of the brake, N m: at standstill ``STATIC_RATIO`` times its level, falling off with the speed."""
    fade = math.exp(-((speed_rad_s / load[STATIC_SPEED]) ** 2))
    return float(level_Nm * (1.0 + (load[STATIC_RATIO] - 1.0) * fade))


class Loops(NamedTuple):
    """``gains`` (n_inputs, ..) of the position loops; ``turns`` (n_inputs,) of an input for one of the drum;
    ``current_share`` (n_inputs,): share of its error that the current loop removes in a step; ``encoders`` (n_inputs,
    3): resolution and noise in rad, delay in periods; ``noise`` (n, n_inputs): standard normal."""

    gains: Floats
    turns: Floats
    current_share: Floats
    encoders: Floats
    noise: Floats


class DynamicCourse(NamedTuple):
    """``reference`` (n, 3): commanded drum angle, speed and acceleration at each period; ``torque`` and ``brake`` (n,):
    torque motor and level of the brake, N m; ``load``: the load's row; ``paths`` (n, n_cables, 3), or (0, ..) if there
    is none: extra path of each cable at the reference, m, and its slopes over the drum's and the input's angle."""

    reference: Floats
    torque: Floats
    brake: Floats
    load: Floats
    paths: Floats


class Clock(NamedTuple):
    """Step of the plant in s, steps a period, periods a row of the log, how far the drum may be off its reference."""

    h: float
    steps: int
    log_every: int
    give_up_rad: float


class Record(NamedTuple):
    """Arrays that a run fills: the log (rows, ..) and the energy balance, J."""

    log: Floats
    account: Floats


@compiled
def run(
    plant: Plant, chains: Chains, loops: Loops, course: DynamicCourse, clock: Clock, record: Record
) -> tuple[float, int]:
    """Run the periods of the position loops and fill ``record``; the change of stored energy, J, and the periods done.

    The run ends early, like a bench with a safety stop, when the drum is off its reference by ``give_up_rad``.
    """
    inputs, cables, input_of, drum = plant.inputs, plant.cables, plant.input_of, plant.drum
    gains, turns, current_share, encoders, noise = (
        loops.gains,
        loops.turns,
        loops.current_share,
        loops.encoders,
        loops.noise,
    )
    reference, torque, brake, load, paths = course.reference, course.torque, course.brake, course.load, course.paths
    log, account, log_every, h = record.log, record.account, clock.log_every, clock.h
    n_inputs, n_cables = inputs.shape[0], cables.shape[0]
    last, out = 2 * n_inputs, payload_at(plant)
    q, v, before = np.zeros(out + 1), np.zeros(out + 1), np.zeros(out + 1)
    motion = State(q, v, np.zeros(out + 1), np.zeros(out + 1))
    push = motion.push
    tension, tension_before = chains.tension.copy(), np.empty(n_cables)
    motor, command, target = np.zeros(n_inputs), np.zeros(n_inputs), np.empty(3)
    state = np.zeros((n_inputs, controller.STATES))
    now = cables.copy()
    bent = Plant(inputs, now, input_of, drum)
    seen = np.zeros((int(encoders[:, DELAY].max()) + 1, n_inputs))
    _hold(inputs, cables, input_of, tension, q, motor, state)
    energy = stored(plant, motion)
    felt = 0.0
    for k in range(reference.shape[0]):
        for i in range(n_inputs):
            angle = q[n_inputs + i] + encoders[i, NOISE] * noise[k, i]
            seen[k % seen.shape[0], i] = quantised(angle, encoders[i, RESOLUTION])
            measured = seen[max(k - int(encoders[i, DELAY]), 0) % seen.shape[0], i]
            for c in range(3):
                target[c] = reference[k, c] * turns[i]
            command[i] = control(gains[i], state[i], target, measured)
        if k % log_every == 0:
            row = log[k // log_every]
            row[DRUM], row[PAYLOAD], row[TORQUE] = q[last], q[out], felt
            for i in range(n_inputs):
                row[LOG_FIRST + i] = q[n_inputs + i]
                row[LOG_FIRST + n_inputs + i] = seen[max(k - int(encoders[i, DELAY]), 0) % seen.shape[0], i]
                row[LOG_FIRST + 2 * n_inputs + i] = motor[i]
                row[LOG_FIRST + 3 * n_inputs + i] = q[i]
            for j in range(n_cables):
                row[LOG_FIRST + 4 * n_inputs + j] = tension[j]
        if paths.shape[0] > 0:
            _bend(cables, paths[k], now)
        felt = 0.0
        for _ in range(clock.steps):
            for i in range(n_inputs):
                motor[i] += current_share[i] * (command[i] - motor[i])
            before[:] = q
            tension_before[:] = tension
            speed = v[out]
            outer = torque[k] + load[UNBALANCE] * math.sin(q[out] + load[UNBALANCE_ANGLE])
            capacity = brake_capacity(brake[k], speed, load)
            own = 0.0 if out > last else drum_friction(bent, tension, speed, outer + math.copysign(capacity, speed))
            advance(bent, motion, tension, Torques(motor, outer, capacity), h, account)
            for j in range(n_cables):
                p = n_inputs + input_of[j]
                extra = 0.0
                if paths.shape[0] > 0:
                    ahead = q[last] - reference[k, 0]
                    extra = paths[k, j, 0] + paths[k, j, 1] * ahead
                    extra += paths[k, j, 2] * (q[p] - turns[input_of[j]] * reference[k, 0])
                tension[j] = chain.advance(chains, j, q[p], q[last], extra)
                inner = now[j, columns.INPUT_RADIUS] * (q[p] - before[p])
                rest = now[j, columns.DRUM_RADIUS] * (q[last] - before[last])
                stretch = cables[j, columns.SIGMA] * (inner - rest)
                account[columns.CABLE_WORK] += 0.5 * (tension[j] + tension_before[j]) * stretch
            # The sensor sits between drum and load, so it does not measure the friction of the bearings.
            share = capacity / max(capacity + own, 1e-300)
            felt += (outer - push[out] * share / h + load[LOAD_INERTIA] * (v[out] - speed) / h) / clock.steps
        if abs(q[last] - reference[k, 0]) > clock.give_up_rad:
            return stored(plant, motion) - energy, k + 1
    return stored(plant, motion) - energy, reference.shape[0]


@compiled
def _bend(cables: Floats, path: Floats, now: Floats) -> None:
    """Lever arms that an extra path gives each cable: its slopes, by virtual work."""
    for j in range(cables.shape[0]):
        sense = cables[j, columns.SIGMA]
        now[j, columns.DRUM_RADIUS] = cables[j, columns.DRUM_RADIUS] - sense * path[j, 1]
        now[j, columns.INPUT_RADIUS] = cables[j, columns.INPUT_RADIUS] + sense * path[j, 2]


@compiled
def _hold(
    inputs: Floats,
    cables: Floats,
    input_of: NDArray[np.int64],
    tension: Floats,
    q: Floats,
    motor: Floats,
    state: Floats,
) -> None:
    """Start at rest: each motor holds the torque of the preloads on its input, and its gearhead is twisted by it."""
    for i in range(inputs.shape[0]):
        bias = 0.0
        for j in range(cables.shape[0]):
            if input_of[j] == i:
                bias += cables[j, columns.SIGMA] * cables[j, columns.INPUT_RADIUS] * tension[j]
        motor[i] = bias
        state[i, controller.SUM] = bias
        q[i] = bias / inputs[i, columns.STIFFNESS]
        if inputs[i, columns.LASH] > 0.0:
            q[i] += 0.5 * inputs[i, columns.LASH] * np.sign(bias)
