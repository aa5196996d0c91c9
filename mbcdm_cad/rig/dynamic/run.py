"""A run of the dynamic rig: motors under position loops drive the cables, the drum turns a load, sensors record.

Equations are in :mod:`mbcdm_cad.rig.dynamic.plant`, the loop over time in :mod:`mbcdm_cad.rig.dynamic.run`.
"""

import math
from dataclasses import dataclass
from math import exp, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig import chain
from mbcdm_cad.rig.chain import Chains, chains
from mbcdm_cad.rig.dynamic import plant as columns
from mbcdm_cad.rig.dynamic import train
from mbcdm_cad.rig.dynamic.plant import Plant, State, Torques, advance, drum_friction, payload_at, stored
from mbcdm_cad.rig.dynamic.train import DynamicRig, EncoderSpec, control, inertias, input_turns
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# Half the step of the difference quotient for an extra path's slope, rad.
SLOPE_RAD = 1e-5


def input_table(rig: DynamicRig) -> Floats:
    """Rotor, gearhead and pulley of each input, in the order of :mod:`mbcdm_cad.rig.dynamic.plant`."""
    moved = inertias(rig.drive)
    table = np.zeros((len(rig.motors), columns.INPUT_COLUMNS))
    for i, (motor, gear) in enumerate(zip(rig.motors, rig.gearheads, strict=True)):
        N = gear.ratio
        table[i, columns.ROTOR] = motor.rotor_inertia_kg_m2 * N**2
        table[i, columns.DRAG] = motor.coulomb_Nm * N + gear.drag_Nm
        table[i, columns.LOSS] = gear.loss_share
        table[i, columns.VISCOUS] = motor.viscous_Nms * N**2
        table[i, columns.STIFFNESS] = gear.stiffness_Nm_rad
        table[i, columns.LASH] = gear.lash_rad
        table[i, columns.MESH] = gear.mesh_error_rad
        table[i, columns.MESH_ORDER] = gear.mesh_per_motor_turn * N
        table[i, columns.COGGING] = motor.cogging_Nm * N
        table[i, columns.COGGING_ORDER] = motor.cogging_per_turn * N
        table[i, columns.COGGING_PHASE] = motor.cogging_phase_rad
        table[i, columns.PULLEY_DRAG] = rig.input_drag_Nm
        if rig.friction is not None:
            table[i, columns.PULLEY_DRAG] += rig.friction.input_bearings_Nm[i]
        table[i, columns.PULLEY] = moved.inputs_kg_m2[i]
    return table


def cable_table(rig: DynamicRig) -> Floats:
    """Sense, radii in m, stiffness of the free span in N/m and shares of friction of each cable."""
    table = np.zeros((len(rig.cables), columns.DRUM_SHARE + 1))
    for row, c in zip(table, rig.cables, strict=True):
        row[: columns.INPUT_SHARE] = c.sigma, c.input_radius_m, c.drum_radius_m, c.stiffness_N / c.free_span_m
    if rig.friction is not None:
        table[:, columns.INPUT_SHARE], table[:, columns.DRUM_SHARE] = rig.friction.input_share, rig.friction.drum_share
    return table


def drum_row(rig: DynamicRig) -> Floats:
    """Inertia, drag and viscous friction at drum and passed bodies; inertia of the load; stiffness of the parts; the
    friction of the bearings by speed and load."""
    moved = inertias(rig.drive)
    turns = sum(abs(body.turns_per_drum) for body in moved.routes.passed)
    drag = rig.load.bearing_drag_Nm + rig.passed_drag_Nm * turns
    drag += rig.friction.drum_bearings_Nm if rig.friction is not None else 0.0
    give = rig.compliance.land_to_payload
    stiffness = 1.0 / give if give > 0.0 else 0.0
    drum = moved.drum_and_passed_kg_m2
    load = rig.load
    laws = (
        load.bearing_stribeck_Nm,
        load.bearing_stribeck_rad_s,
        load.bearing_driving_share,
        load.bearing_driven_share,
    )
    return np.array([drum, drag, load.bearing_viscous_Nms, load.inertia_kg_m2, stiffness, *laws])


def path_table(rig: DynamicRig, reference: Floats) -> Floats:
    """Extra path of each cable at the reference and its slopes over drum and input, (n, n_cables, 3) or (0, ...)."""
    n, n_cables = (reference.shape[0] if rig.paths else 0), len(rig.cables)
    table = np.zeros((n, n_cables, 3))
    if not rig.paths:
        return table
    drum = reference[:, 0]
    inputs = np.array(input_turns(rig.drive))[:, None] * drum
    for of in rig.paths:
        table[:, :, 0] += of(inputs, drum).T
        table[:, :, 1] += (of(inputs, drum + SLOPE_RAD) - of(inputs, drum - SLOPE_RAD)).T / (2.0 * SLOPE_RAD)
        # Each cable's path depends on its own input only, so all inputs may be moved together.
        table[:, :, 2] += (of(inputs + SLOPE_RAD, drum) - of(inputs - SLOPE_RAD, drum)).T / (2.0 * SLOPE_RAD)
    return table


def plant_tables(rig: DynamicRig) -> Plant:
    """All tables of the plant."""
    input_of = np.array([c.input_index for c in rig.cables], dtype=np.int64)
    return Plant(input_table(rig), cable_table(rig), input_of, drum_row(rig))


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
    gains, turns, encoders, noise = loops.gains, loops.turns, loops.encoders, loops.noise
    reference, torque, brake, load, paths = course.reference, course.torque, course.brake, course.load, course.paths
    log, account, log_every, h = record.log, record.account, clock.log_every, clock.h
    n_inputs, n_cables = inputs.shape[0], cables.shape[0]
    last, out = 2 * n_inputs, payload_at(plant)
    q, v, before = np.zeros(out + 1), np.zeros(out + 1), np.zeros(out + 1)
    motion = State(q, v, np.zeros(out + 1), np.zeros(out + 1))
    push = motion.push
    tension, tension_before = chains.tension.copy(), np.empty(n_cables)
    motor, command, target = np.zeros(n_inputs), np.zeros(n_inputs), np.empty(3)
    state = np.zeros((n_inputs, train.STATES))
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
        for j in range(n_cables if paths.shape[0] > 0 else 0):
            # Lever arms that an extra path gives each cable: its slopes, by virtual work.
            sense = cables[j, columns.SIGMA]
            now[j, columns.DRUM_RADIUS] = cables[j, columns.DRUM_RADIUS] - sense * paths[k, j, 1]
            now[j, columns.INPUT_RADIUS] = cables[j, columns.INPUT_RADIUS] + sense * paths[k, j, 2]
        felt = 0.0
        for _ in range(clock.steps):
            for i in range(n_inputs):
                motor[i] += loops.current_share[i] * (command[i] - motor[i])
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
        state[i, train.SUM] = bias
        q[i] = bias / inputs[i, columns.STIFFNESS]
        if inputs[i, columns.LASH] > 0.0:
            q[i] += 0.5 * inputs[i, columns.LASH] * np.sign(bias)


LOG_RATE_HZ = 100.0
# Far more than elasticity explains: the position loops no longer control the drum.
GIVE_UP_RAD = 0.05
_ACCOUNTS = ("motor", "load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables")


@dataclass(frozen=True, eq=False)
class DynamicRun:
    """A run at the log's samples: truth and readings of the sensors. Arrays (n,) or (n_inputs or n_cables, n).

    ``motor_Nm`` and ``rotor_rad`` are reflected to the gearhead's output; ``torque_Nm`` is the torque between drum and
    load, averaged over a period of the loops; ``energy_J`` the energy balance of the whole run. ``drum_rad`` is the
    drum's angle at its encoder.
    """

    time_s: Floats
    reference_rad: Floats
    drum_rad: Floats
    payload_rad: Floats
    input_rad: Floats
    torque_Nm: Floats
    motor_Nm: Floats
    rotor_rad: Floats
    tension_N: Floats
    measured_drum_rad: Floats
    measured_input_rad: Floats
    measured_torque_Nm: Floats
    energy_J: dict[str, float]


def run_dynamic(
    rig: DynamicRig,
    reference: Floats,
    torque_Nm: Floats | float = 0.0,
    brake_Nm: Floats | float = 0.0,
    seed: int = 0,
    log_rate_Hz: float = LOG_RATE_HZ,
    give_up_rad: float = GIVE_UP_RAD,
) -> DynamicRun:
    """Run ``reference`` (n, 3), the drum's angle, speed and acceleration at each period of the loops.

    ``torque_Nm`` is what a torque motor applies and ``brake_Nm`` the level of a brake, one value or one a period. The
    same seed gives the same run. It ends early when the drum is off its reference by ``give_up_rad``. ValueError where
    rates do not divide each other.
    """
    n_inputs, n = len(rig.motors), reference.shape[0]
    rate = rig.loops[0].rate_Hz
    steps = _whole(1.0 / rate / rig.step_s, "step_s", "rate_Hz")
    log_every = _whole(rate / log_rate_Hz, "rate_Hz", "log_rate_Hz")
    rng = np.random.default_rng(seed)
    rows = -(-n // log_every)
    log = np.zeros((rows, LOG_FIRST + 4 * n_inputs + len(rig.cables)))
    account = np.zeros(columns.ACCOUNTS)
    state = chains(
        rig.cables,
        piece_rad=rig.piece_rad,
        transport=rig.transport,
        passed_slip=rig.passed_slip,
        reach_rad=float(np.abs(reference[:, 0]).max()) + 2.0 * give_up_rad,
    )
    noise = rng.standard_normal((n, n_inputs))
    load, brake = rig.load, (rig.load.static_ratio, rig.load.static_speed_rad_s)
    loops = Loops(
        np.array([loop.gains() for loop in rig.loops]),
        np.array(input_turns(rig.drive)),
        np.array([1.0 - exp(-2.0 * pi * motor.current_bandwidth_Hz * rig.step_s) for motor in rig.motors]),
        np.array([[e.resolution_rad, e.noise_rad, round(e.delay_s * rate)] for e in rig.encoders]),
        noise,
    )
    course = DynamicCourse(
        np.ascontiguousarray(reference, dtype=float),
        _series(torque_Nm, n),
        _series(brake_Nm, n),
        np.array([load.inertia_kg_m2, *brake, load.unbalance_Nm, load.unbalance_angle_rad]),
        path_table(rig, reference),
    )
    change, done = run(
        plant_tables(rig), state, loops, course, Clock(rig.step_s, steps, log_every, give_up_rad), Record(log, account)
    )
    rows = -(-done // log_every)
    log = log[:rows]
    time = np.arange(rows) * log_every / rate
    ends = [LOG_FIRST + k * n_inputs for k in range(5)]
    _, pulley, counts, motor, rotor, tension = np.split(log.T, ends)
    land, payload, torque = log[:, DRUM], log[:, PAYLOAD], log[:, TORQUE]
    # The encoder sits between the cables on the drum and the payload.
    give = rig.compliance
    drum = (
        land if give.land_to_payload == 0.0 else land - give.land_to_encoder / give.land_to_payload * (land - payload)
    )
    return DynamicRun(
        time_s=time,
        reference_rad=reference[:done:log_every, 0],
        drum_rad=drum,
        payload_rad=payload,
        input_rad=pulley,
        torque_Nm=torque,
        motor_Nm=motor,
        rotor_rad=rotor,
        tension_N=tension,
        measured_drum_rad=_read(rig.drum_encoder, time, drum, rng),
        measured_input_rad=counts,
        measured_torque_Nm=torque + rig.torque_noise_Nm * rng.standard_normal(rows),
        energy_J={**dict(zip(_ACCOUNTS, account.tolist(), strict=True)), "stored": float(change)},
    )


def _whole(ratio: float, divisor: str, dividend: str) -> int:
    if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{divisor} and {dividend} do not divide: their ratio is {ratio:.6g}; choose a whole number")
    return round(ratio)


def _series(value: Floats | float, n: int) -> Floats:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), (n,)))


def _read(encoder: EncoderSpec, time: Floats, angle: Floats, rng: np.random.Generator) -> Floats:
    """Readings of an encoder outside the loops: delayed, with noise, in whole counts."""
    seen = np.interp(time - encoder.delay_s, time, angle) + encoder.noise_rad * rng.standard_normal(angle.size)
    step = encoder.resolution_rad
    return seen if step == 0.0 else np.floor(seen / step + 0.5) * step
