"""Equations of motion of rotors, input pulleys and drum, and one step of them in which a coordinate can stick.

The step solves A v = b + h lambda with |lambda_i| <= c_i, lambda_i = -c_i sign(v_i) where v_i is not 0, for
A = M + h D + h^2 K. As A is symmetric and positive definite there is one solution: the minimum of v.A v / 2 - b.v + h
sum c_i |v_i|. The solver assumes which coordinates stick and in which direction the others slide, solves, and corrects
the worst contradiction until there is none; if the corrections repeat, coordinate descent follows.

Coordinates, all positive in the sense that drives the drum positive: for each input the rotor, reflected to the
gearhead's output, and the pulley; the drum, with the bodies that the cables pass and turn; and the payload, which is on
the drum itself where all parts are rigid.

    rotor    J_r phi'' = tau + cogging - s du/dphi - b phi' - friction
    pulley   J_p p''   = s - sum_j sigma_j r_ij T_j - friction
    drum     J_o o''   = sum_j sigma_j r_oj T_j - k (o - w) - b o' - friction
    payload  J_w w''   = k (o - w) - M - friction

k is the stiffness of the parts between the cables and the payload; the friction of pulleys and drum holds a share of
the tension of each cable, which bends there. s is the gearhead's torque (:mod:`mbcdm_cad.rig.dynamic.train`), T_j
what the cables pull, M the torque motor's torque (> 0 opposes positive rotation). The step is linearly implicit
(:mod:`mbcdm_cad.rig.dynamic.plant`): cables enter its matrix with the stiffness of their free span, their largest
possible one, so that a step of any length is stable; a longer one only damps the fast modes more.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig.dynamic.train import shaft_torque
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

CORRECTIONS = 40
SWEEPS = 20000


@compiled
def solve_friction(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats, push: Floats) -> int:
    """Solve for ``v`` (n,); ``limit`` is h c (n,). ``push`` (n,) receives the friction impulses h lambda.

    ``guess`` holds -1, 0 (sticks) or 1 for each coordinate; it is the start and receives the result. Returns the number
    of corrections, or -1 if coordinate descent was needed.
    """
    n = b.size
    for trial in range(CORRECTIONS):
        _solve_guess(A, b, limit, guess, v)
        worst, at, to = 0.0, -1, 0.0
        for i in range(n):
            if limit[i] <= 0.0:
                push[i] = 0.0
            elif guess[i] == 0.0:
                total = -b[i]
                for k in range(n):
                    total += A[i, k] * v[k]
                push[i] = total
                # An impulse above its limit, as the error in speed that it means.
                over = (abs(total) - limit[i]) / A[i, i]
                if over > worst and abs(total) > limit[i] * (1.0 + 1e-12):
                    worst, at, to = over, i, -np.sign(total)
            else:
                push[i] = -limit[i] * guess[i]
                if v[i] * guess[i] < 0.0 and -v[i] * guess[i] > worst:
                    worst, at, to = -v[i] * guess[i], i, 0.0
        if at < 0:
            return trial
        guess[at] = to
    _descend(A, b, limit, guess, v, push)
    return -1


@compiled
def _solve_guess(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats) -> None:
    """Gauss elimination on the coordinates that do not stick."""
    n = b.size
    free = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        v[i] = 0.0
        if limit[i] <= 0.0 or guess[i] != 0.0:
            free[count] = i
            count += 1
    work = np.empty((count, count + 1))
    for i in range(count):
        p = free[i]
        for k in range(count):
            work[i, k] = A[p, free[k]]
        work[i, count] = b[p] - (limit[p] * guess[p] if limit[p] > 0.0 else 0.0)
    for i in range(count):
        for r in range(i + 1, count):
            if work[r, i] != 0.0:
                factor = work[r, i] / work[i, i]
                for k in range(i, count + 1):
                    work[r, k] -= factor * work[i, k]
    for i in range(count - 1, -1, -1):
        total = work[i, count]
        for k in range(i + 1, count):
            total -= work[i, k] * v[free[k]]
        v[free[i]] = total / work[i, i]


@compiled
def _descend(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats, push: Floats) -> None:
    """Coordinate descent to the same minimum; slow where A is stiff, but it always converges."""
    n = b.size
    for _ in range(SWEEPS):
        moved, size = 0.0, 1e-300
        for i in range(n):
            total = b[i]
            for k in range(n):
                if k != i:
                    total -= A[i, k] * v[k]
            now = 0.0
            if abs(total) > limit[i]:
                now = (total - np.sign(total) * limit[i]) / A[i, i]
            moved = max(moved, abs(now - v[i]))
            size = max(size, abs(now))
            v[i] = now
        if moved <= 1e-13 * size:
            break
    for i in range(n):
        total = -b[i]
        for k in range(n):
            total += A[i, k] * v[k]
        push[i] = total if limit[i] > 0.0 else 0.0
        guess[i] = np.sign(v[i])


# Columns of the table of inputs; all seen at the gearhead's output, orders in periods per radian there.
(
    ROTOR,
    DRAG,
    LOSS,
    VISCOUS,
    STIFFNESS,
    LASH,
    MESH,
    MESH_ORDER,
    COGGING,
    COGGING_ORDER,
    COGGING_PHASE,
    PULLEY,
    PULLEY_DRAG,
) = range(13)
INPUT_COLUMNS = 13
# Columns of the table of cables.
SIGMA, INPUT_RADIUS, DRUM_RADIUS, SPAN_STIFFNESS, INPUT_SHARE, DRUM_SHARE = range(6)
# Entries of the drum's row; a stiffness of 0: the parts are rigid, and the payload is on the drum.
(
    DRUM_INERTIA,
    DRUM_DRAG,
    DRUM_VISCOUS,
    PAYLOAD_INERTIA,
    PARTS_STIFFNESS,
    DRUM_STRIBECK,
    STRIBECK_SPEED,
    DRIVING_SHARE,
    DRIVEN_SHARE,
) = range(9)
# Entries of the energy balance, J.
(MOTOR_WORK, LOAD_WORK, ROTOR_LOSS, PULLEY_LOSS, DRUM_LOSS, VISCOUS_LOSS, CABLE_WORK) = range(7)
ACCOUNTS = 7


@compiled
def gear(row: Floats, rotor_rad: float, pulley_rad: float) -> tuple[float, float, float]:
    """Torque on the gearhead's shaft, its slope, and du/dphi of the mesh."""
    wave = row[MESH_ORDER] * rotor_rad
    twist = rotor_rad - pulley_rad + row[MESH] * math.sin(wave)
    torque, slope = shaft_torque(twist, row[LASH], row[STIFFNESS])
    return torque, slope, 1.0 + row[MESH] * row[MESH_ORDER] * math.cos(wave)


class Plant(NamedTuple):
    """Tables of inputs, cables and drum, and for each cable the number of its input."""

    inputs: Floats
    cables: Floats
    input_of: NDArray[np.int64]
    drum: Floats


class State(NamedTuple):
    """Angles (rad) and speeds (rad/s) of the coordinates; which of them stick (0) or slide; the friction impulses."""

    q: Floats
    v: Floats
    guess: Floats
    push: Floats


class Torques(NamedTuple):
    """``motor`` (n_inputs,) at the gearhead's output, ``load`` of the torque motor, capacity of the ``brake``; N m."""

    motor: Floats
    load: float
    brake: float


@compiled
def payload_at(plant: Plant) -> int:
    """Number of the coordinate on which the payload acts."""
    drum = 2 * plant.inputs.shape[0]
    return int(drum + 1 if plant.drum[PARTS_STIFFNESS] > 0.0 else drum)


@compiled
def drum_friction(plant: Plant, tension: Floats, speed: float, carried: float) -> float:
    """Largest friction on the drum besides that of the load, N m: bearings, and cables that bend.

    That of the bearings falls with the speed (rad/s) as an exponential, and grows with the torque that is carried (N
    m), by one share while the drum moves against it and by another while it moves the drum.
    """
    drum = plant.drum
    total = drum[DRUM_DRAG] + abs(carried) * (drum[DRIVING_SHARE] if carried * speed >= 0.0 else drum[DRIVEN_SHARE])
    if drum[DRUM_STRIBECK] > 0.0:
        total += drum[DRUM_STRIBECK] * math.exp(-abs(speed) / drum[STRIBECK_SPEED])
    for j in range(tension.size):
        total += plant.cables[j, DRUM_SHARE] * plant.cables[j, DRUM_RADIUS] * tension[j]
    return float(total)


@compiled
def advance(plant: Plant, state: State, tension: Floats, torques: Torques, h: float, account: Floats) -> None:
    """Advance ``state`` by one step ``h`` (s) and add its energies to ``account``."""
    inputs, cables, input_of, drum = plant.inputs, plant.cables, plant.input_of, plant.drum
    q, v, guess, push = state.q, state.v, state.guess, state.push
    motor, load, brake = torques.motor, torques.load, torques.brake
    n_inputs = inputs.shape[0]
    last, out = 2 * n_inputs, payload_at(plant)
    n = out + 1
    A = np.zeros((n, n))
    b = np.empty(n)
    limit = np.empty(n)
    drive = np.empty(n_inputs)
    for i in range(n_inputs):
        row, p = inputs[i], n_inputs + i
        carried, slope, lever = gear(row, q[i], q[p])
        drive[i] = motor[i] + row[COGGING] * math.sin(row[COGGING_ORDER] * q[i] + row[COGGING_PHASE])
        A[i, i] = row[ROTOR] + h * row[VISCOUS] + h * h * slope * lever * lever
        A[p, p] = row[PULLEY] + h * h * slope
        A[i, p] = A[p, i] = -h * h * slope * lever
        b[i] = row[ROTOR] * v[i] + h * (drive[i] - carried * lever)
        b[p] = row[PULLEY] * v[p] + h * carried
        limit[i] = h * (row[DRAG] + row[LOSS] * abs(carried))
        limit[p] = h * row[PULLEY_DRAG]
    A[last, last] = drum[DRUM_INERTIA] + h * drum[DRUM_VISCOUS]
    b[last] = drum[DRUM_INERTIA] * v[last]
    limit[last] = h * drum_friction(plant, tension, v[last], load + math.copysign(brake, v[last]))
    if out > last:
        limit[out] = b[out] = 0.0
        twisted = h * drum[PARTS_STIFFNESS] * (q[last] - q[out])
        b[last] -= twisted
        b[out] += twisted
        stiff = h * h * drum[PARTS_STIFFNESS]
        A[last, last] += stiff
        A[out, out] += stiff
        A[last, out] = A[out, last] = -stiff
    A[out, out] += drum[PAYLOAD_INERTIA]
    b[out] += drum[PAYLOAD_INERTIA] * v[out] - h * load
    limit[out] += h * brake
    for j in range(cables.shape[0]):
        p = n_inputs + input_of[j]
        inner, outer = cables[j, SIGMA] * cables[j, INPUT_RADIUS], cables[j, SIGMA] * cables[j, DRUM_RADIUS]
        stiff = h * h * cables[j, SPAN_STIFFNESS]
        A[p, p] += stiff * inner * inner
        A[last, last] += stiff * outer * outer
        A[p, last] -= stiff * inner * outer
        A[last, p] -= stiff * inner * outer
        b[p] -= h * inner * tension[j]
        b[last] += h * outer * tension[j]
        limit[p] += h * cables[j, INPUT_SHARE] * cables[j, INPUT_RADIUS] * tension[j]
    solve_friction(A, b, limit, guess, v, push)
    for i in range(n_inputs):
        p = n_inputs + i
        account[MOTOR_WORK] += h * drive[i] * v[i]
        account[ROTOR_LOSS] -= push[i] * v[i]
        account[PULLEY_LOSS] -= push[p] * v[p]
        account[VISCOUS_LOSS] += h * inputs[i, VISCOUS] * v[i] * v[i]
    account[LOAD_WORK] += h * load * v[out]
    account[DRUM_LOSS] -= push[last] * v[last]
    if out > last:
        account[DRUM_LOSS] -= push[out] * v[out]
    account[VISCOUS_LOSS] += h * drum[DRUM_VISCOUS] * v[last] * v[last]
    for k in range(n):
        q[k] += h * v[k]


@compiled
def stored(plant: Plant, state: State) -> float:
    """Kinetic energy and elastic energy of the gearheads' shafts and of the parts at the drum, J."""
    inputs, drum, q, v = plant.inputs, plant.drum, state.q, state.v
    n_inputs = inputs.shape[0]
    last, out = 2 * n_inputs, payload_at(plant)
    total = 0.5 * drum[DRUM_INERTIA] * v[last] ** 2 + 0.5 * drum[PAYLOAD_INERTIA] * v[out] ** 2
    total += 0.5 * drum[PARTS_STIFFNESS] * (q[last] - q[out]) ** 2
    for i in range(n_inputs):
        p = n_inputs + i
        carried = gear(inputs[i], q[i], q[p])[0]
        total += 0.5 * inputs[i, ROTOR] * v[i] ** 2 + 0.5 * inputs[i, PULLEY] * v[p] ** 2
        total += 0.5 * carried * carried / inputs[i, STIFFNESS]
    return float(total)
