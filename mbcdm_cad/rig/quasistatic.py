"""The quasi-static rig: an experiment sample by sample, at the angles at which every torque balances.

Unknown are the drum's angle and the angle of each input pulley that a gearhead with compliance or play drives:

    drum    sum_j (sigma_j r_oj - lever_j - z s_j r_oj) T_j = M
    input   s(phi - theta) = sum_j sigma_j r_ij T_j         s: gearhead's shaft with play, phi the gearhead's angle

lever_j is what the path of cable j grows by per drum angle, s_j the share of its tension that it loses where it bends
on passed bodies and drum, against the motion: z is from -1 to 1.

Newton steps with a line search, and where these stop at the end of a play, bisection; the tensions come from
:mod:`mbcdm_cad.rig.chain` without a change of its state, which is updated when the balance is found. The drum wrap
moves with the predicted drum angle (that of the inputs over the ratio), whose error is below a milliradian and is
corrected one sample later.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.bench import Bench, bench_of, counted, late
from mbcdm_cad.rig.chain import Chains, carry, go_over, look, settle, strain
from mbcdm_cad.rig.experiment import Experiment, RigError, SimulatedRun
from mbcdm_cad.rig.motion import brake
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

_STEPS = 80
_HALVINGS, _MOST_HALVINGS = 12, 40
# Bisection: first reach to each side in rad, how often it is doubled, and how often an interval is halved.
_REACH_RAD, _DOUBLINGS, _BISECTIONS = 1e-7, 24, 48
# Share of the shaft's stiffness inside its play, so that a pulley free within its play has one equilibrium angle.
_IN_PLAY = 1e-4


@compiled
def shaft(twist_rad: float, stiffness: float, play_rad: float) -> tuple[float, float]:
    """Torque of a shaft with play, N m, and its slope, which is small but not zero inside the play."""
    inside = min(max(twist_rad, -0.5 * play_rad), 0.5 * play_rad)
    slope = stiffness * _IN_PLAY if abs(twist_rad) < 0.5 * play_rad else stiffness
    return stiffness * (twist_rad - inside) + stiffness * _IN_PLAY * inside, slope


class QuasistaticCourse(NamedTuple):
    """The course of a run over n samples.

    ``input_of`` (n_cables,) is the input of each cable; ``gears`` (n_inputs, 2): stiffness in N m/rad (infinite: held)
    and play in rad; ``motor`` (n_inputs, n) gearhead angles; ``path`` and ``lever`` (n_cables, n) extra path in m and
    its slope in m/rad about the ``predicted`` drum angle (n,); ``load`` (n,) N m; ``strains`` (n_cables, w, n)
    stress-free strain of rope over bed on each wrap, or n = 0; ``through`` (m, 2) the two sides of each cable that is
    anchored nowhere on its input. ``rub`` (n_cables,): share of its tension that a cable loses by bending on passed
    bodies and drum; ``slide`` (n,): sense of the motion that friction opposes, -1 to 1.
    """

    input_of: NDArray[np.int64]
    gears: Floats
    motor: Floats
    path: Floats
    lever: Floats
    predicted: Floats
    load: Floats
    strains: Floats
    through: NDArray[np.int64]
    rub: Floats
    slide: Floats


class _Leftover(NamedTuple):
    """Residual torques (pulleys, then drum), their slopes, and the tensions."""

    miss: Floats
    slopes: Floats
    tension: Floats


@compiled
def _misses(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> float:
    """Fill ``left`` for the angles ``x`` (pulleys, then drum) in sample ``k``; returns the sum of squares."""
    input_of, gears, miss, slopes, tension = course.input_of, course.gears, left.miss, left.slopes, left.tension
    n_inputs = gears.shape[0]
    miss[:] = 0.0
    slopes[:] = 0.0
    for j in range(input_of.size):
        c, i, lever = chains.constants[j], input_of[j], course.lever[j, k]
        inner, outer = c[chain.SIGMA] * c[chain.INPUT_RADIUS], c[chain.SIGMA] * c[chain.DRUM_RADIUS] - lever
        delta = inner * x[i] - outer * x[n_inputs] + course.path[j, k] - lever * course.predicted[k]
        tension[j], rate = look(chains, j, delta)
        pull = outer - course.slide[k] * course.rub[j] * c[chain.DRUM_RADIUS]
        miss[n_inputs] += pull * tension[j]
        miss[i] -= inner * tension[j]
        slopes[n_inputs, n_inputs] -= pull * outer * rate
        slopes[i, i] -= inner * inner * rate
        slopes[i, n_inputs] += inner * outer * rate
        slopes[n_inputs, i] += inner * pull * rate
    miss[n_inputs] -= course.load[k]
    for i in range(n_inputs):
        if math.isinf(gears[i, 0]):
            # A rigid gearhead holds the pulley at the motor's angle: not an unknown.
            miss[i] = 0.0
            slopes[i, :] = 0.0
            slopes[:, i] = 0.0
            slopes[i, i] = -1.0
        else:
            torque, slope = shaft(course.motor[i, k] - x[i], gears[i, 0], gears[i, 1])
            miss[i] += torque
            slopes[i, i] -= slope
    total = 0.0
    for i in range(n_inputs + 1):
        total += miss[i] * miss[i]
    return total


@compiled
def _newton(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover, scale: float) -> float:
    """Bring the angles ``x`` to balance by Newton steps; returns the sum of squares (N m)^2 that is left."""
    trial = np.empty_like(x)
    size = _misses(chains, course, k, x, left)
    for _ in range(_STEPS):
        if size <= (1e-12 * scale) ** 2:
            break
        step = np.linalg.solve(left.slopes - 1e-9 * np.eye(x.size), left.miss)
        share, better = 1.0, False
        for halved in range(_MOST_HALVINGS):
            # At the end of a play the slope changes by orders of magnitude: only there many are needed.
            if halved >= _HALVINGS and size <= (1e-7 * scale) ** 2:
                break
            trial[:] = x - share * step
            there = _misses(chains, course, k, trial, left)
            if there < size:
                better = True
                break
            share *= 0.5
        if not better:
            break
        x[:] = trial
        size = there
    return size


@compiled
def _bisect(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> None:
    """Bring the angles ``x`` to balance by bisection of the drum's angle; as they were where no interval has a balance.

    At the end of a play the sum of squares has a valley that Newton steps do not leave. But the torque on each pulley
    falls with its own angle, and that on the drum with the drum's where the pulleys follow.
    """
    begun, drum = x.copy(), x.size - 1
    low = high = x[drum]
    reach = _REACH_RAD
    for _ in range(_DOUBLINGS):
        _follow(chains, course, k, x, left)
        if left.miss[drum] > 0.0:
            low, high = x[drum], x[drum] + reach
            x[drum] = high
            _follow(chains, course, k, x, left)
            if left.miss[drum] <= 0.0:
                break
        else:
            low, high = x[drum] - reach, x[drum]
            x[drum] = low
            _follow(chains, course, k, x, left)
            if left.miss[drum] > 0.0:
                break
        reach *= 2.0
    else:
        x[:] = begun
        return
    for _ in range(_BISECTIONS):
        x[drum] = 0.5 * (low + high)
        _follow(chains, course, k, x, left)
        if left.miss[drum] > 0.0:
            low = x[drum]
        else:
            high = x[drum]


@compiled
def _follow(chains: Chains, course: QuasistaticCourse, k: int, x: Floats, left: _Leftover) -> None:
    """Turn every pulley to where its own torques balance at the drum's angle, by bisection; a held one stays."""
    n_inputs = x.size - 1
    low, high = x[:n_inputs].copy(), x[:n_inputs].copy()
    reach = _REACH_RAD
    for _ in range(_DOUBLINGS):
        between = True
        x[:n_inputs] = low
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] < 0.0:
                low[i] -= reach
                between = False
        x[:n_inputs] = high
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] > 0.0:
                high[i] += reach
                between = False
        if between:
            break
        reach *= 2.0
    for _ in range(_BISECTIONS):
        x[:n_inputs] = 0.5 * (low + high)
        _misses(chains, course, k, x, left)
        for i in range(n_inputs):
            if left.miss[i] > 0.0:
                low[i] = x[i]
            else:
                high[i] = x[i]


@compiled
def run(chains: Chains, course: QuasistaticCourse, pulleys: Floats, drum: Floats, tension: Floats) -> int:
    """Fill ``pulleys`` (n_inputs, n), ``drum`` (n,) in rad and ``tension`` (n_cables, n) in N; the sample at which no
    balance was found, or -1."""
    motor, predicted, strains, input_of = course.motor, course.predicted, course.strains, course.input_of
    n_inputs, n_cables = motor.shape[0], input_of.size
    x = np.zeros(n_inputs + 1)
    left = _Leftover(np.empty(n_inputs + 1), np.empty((n_inputs + 1, n_inputs + 1)), np.empty(n_cables))
    scale = 0.0
    for j in range(n_cables):
        scale += chains.constants[j, chain.PRELOAD] * chains.constants[j, chain.DRUM_RADIUS]
    before = np.zeros(n_inputs + 1)
    for k in range(predicted.size):
        for i in range(n_inputs):
            x[i] += motor[i, k] - before[i]
            before[i] = motor[i, k]
        x[n_inputs] += predicted[k] - before[n_inputs]
        before[n_inputs] = predicted[k]
        for j in range(n_cables):
            carry(chains, j, float(x[input_of[j]]), float(x[n_inputs]))
            if strains.shape[2] > 0 and k > 0:
                strain(chains, j, strains[j, :, k] - strains[j, :, k - 1])
        size = _newton(chains, course, k, x, left, scale)
        if not size <= (1e-7 * scale) ** 2:
            _bisect(chains, course, k, x, left)
            size = _newton(chains, course, k, x, left, scale)
        if not size <= (1e-7 * scale) ** 2:
            return k
        for j in range(n_cables):
            settle(chains, j, left.tension[j])
            tension[j, k] = left.tension[j]
        for m in range(course.through.shape[0]):
            if not go_over(chains, course.through[m, 0], course.through[m, 1]):
                return k
        pulleys[:, k] = x[:n_inputs]
        drum[k] = x[n_inputs]
    return -1


# Half the step of drum angle in the difference quotient for an extra path's slope, rad.
_SLOPE_RAD = 1e-5
# Drum angle over which friction at the drum changes its sign: a choice, as for the friction of bearings.
_PRESLIDING_RAD = 1e-4


def simulate(drive: Drive, experiment: Experiment) -> SimulatedRun:
    """Run ``experiment`` on the bench with ``drive``. The same seed gives the same run. Raises RigError."""
    bench = set_up(drive, experiment)
    load = experiment.load.torque_Nm(bench.time_s, bench.drum_rad, experiment.motion.period_s, bench.stick_slip)
    pulleys, land, tension = balance(bench, experiment, load)
    # What the parts give, the payload's torque alone turns: the encoder sits between the cables and the payload.
    drum = land - bench.compliance.land_to_encoder * load
    every = slice(None, None, experiment.physics.substeps)
    return _read(bench, experiment, pulleys, drum, load, tension, every)


def set_up(drive: Drive, experiment: Experiment) -> Bench:
    """The bench of ``experiment`` with all its effects applied."""
    rng = np.random.default_rng(experiment.seed)
    rate = experiment.sample_rate_Hz * experiment.physics.substeps
    time = np.arange(round(experiment.duration_s * rate)) / rate
    drum = experiment.motion.drum_rad(time)
    strays = experiment.motion.strays_rad(time, len(drive.input_names), rng)
    try:
        bench = bench_of(drive, time, drum, strays, rng, experiment.physics, experiment.sensors.input_at)
    except ValueError as error:
        raise RigError(f"{drive.name}: the rig cannot simulate this drive: {error}") from None
    for effect in experiment.effects:
        try:
            effect.apply(bench)
        except KeyError as error:
            names = ", ".join([c.name for c in bench.cables] + [body.name for body in bench.routes.bodies])
            raise RigError(
                f"{experiment.name}: effects: {effect.effect}: the drive has no {error.args[0]}; known: {names}"
            ) from None
    return bench


def balance(bench: Bench, experiment: Experiment, load_Nm: Floats) -> tuple[Floats, Floats, Floats]:
    """Angles of the pulleys (n_inputs, n) and the drum (n,), tensions (n_cables, n). Raises RigError."""
    physics = experiment.physics
    reach = 1.05 * float(np.abs(bench.drum_rad).max()) + 1e-3
    turns = max(c.drum_radius_m / c.input_radius_m for c in bench.cables)
    on_input, on_drum = physics.wraps_rad(reach, turns)
    try:
        chains = chain.chains(
            bench.cables,
            piece_rad=physics.piece_mrad * 1e-3,
            transport=physics.cable_transport,
            passed_slip=bench.passed_slip,
            input_wrap_rad=on_input,
            drum_wrap_rad=on_drum,
            reach_rad=reach,
        )
    except ValueError as error:
        raise RigError(
            f"{experiment.name}: {error}; lower motion.amplitude_mrad or lengthen physics.*_wrap_rad"
        ) from None
    motor = bench.command_rad.copy()
    for i, of in bench.gear_errors:
        motor[i] += of(bench.command_rad[i])
    n_cables, n = len(bench.cables), load_Nm.size
    path, lever = np.zeros((n_cables, n)), np.zeros((n_cables, n))
    for of_angles in bench.paths:
        path += of_angles(motor, bench.drum_rad)
        ahead, behind = bench.drum_rad + _SLOPE_RAD, bench.drum_rad - _SLOPE_RAD
        lever += (of_angles(motor, ahead) - of_angles(motor, behind)) / (2.0 * _SLOPE_RAD)
    gears = np.array([bench.gear_stiffness_Nm_rad, bench.gear_play_rad]).T.copy()
    pulleys, drum, tension = np.empty_like(motor), np.empty(n), np.empty((n_cables, n))
    total = load_Nm + sum(bench.hidden_Nm, np.zeros(n))
    strains = np.zeros((*chains.wraps.shape[:2], 0)) if bench.strains is None else bench.strains
    input_of, sides = np.array([c.input_index for c in bench.cables]), chain.pairs_of(bench.cables)
    rub, slide = np.zeros(n_cables), np.zeros(n)
    if bench.friction is not None:
        rub, slide = bench.friction.drum_share, brake(bench.drum_rad, np.ones(n), _PRESLIDING_RAD)
        total = total + bench.friction.drum_bearings_Nm * slide
    course = QuasistaticCourse(input_of, gears, motor, path, lever, bench.drum_rad, total, strains, sides, rub, slide)
    failed = run(chains, course, pulleys, drum, tension)
    if failed >= 0:
        raise RigError(
            f"{experiment.name}: at {bench.time_s[failed]:.2f} s no drum angle balances {total[failed]:.4g} N m: "
            "lower load.levels_Nm or an effect"
        )
    return pulleys, drum, tension


def _read(
    bench: Bench, experiment: Experiment, pulleys: Floats, drum: Floats, load: Floats, tension: Floats, every: slice
) -> SimulatedRun:
    sensors, rng, time = experiment.sensors, bench.rng, bench.time_s
    shafts = pulleys if sensors.input_at == "pulley" else bench.command_rad
    output_stage = bench.routes.drum.name
    seen = {body.name: shafts[i].copy() for i, body in enumerate(bench.routes.inputs)}
    seen[output_stage] = drum - bench.output_twist_rad_Nm * load - bench.slow_twist_rad(load)
    for stage, of in bench.encoder_errors:
        seen[stage] += of(drum if stage == output_stage else shafts[bench.input_index(stage)])
    inputs = [
        counted(
            late(time, seen[body.name], bench.input_delay_s)[every],
            sensors.input_resolution_rad,
            sensors.input_noise_rad,
            rng,
        )
        for body in bench.routes.inputs
    ]
    output = late(time, seen[output_stage], bench.output_delay_s)[every]
    torque = late(time, load, sensors.torque_delay_s)[every]
    temperature = bench.temperature_C
    return SimulatedRun(
        time_s=time[every],
        input_rad=pulleys[:, every],
        drum_rad=drum[every],
        payload_rad=(drum - bench.compliance.encoder_to_payload * load)[every],
        load_Nm=load[every],
        tension_N=tension[:, every],
        measured_input_rad=np.stack(inputs),
        measured_output_rad=counted(output, sensors.output_resolution_rad, sensors.output_noise_rad, rng),
        measured_load_Nm=torque + sensors.torque_noise_Nm * rng.standard_normal(torque.size)
        if sensors.log_torque
        else None,
        measured_temperature_C=None
        if temperature is None
        else temperature[every] + sensors.temperature_noise_K * rng.standard_normal(torque.size),
        truth=_truth(bench, experiment),
    )


def _truth(bench: Bench, experiment: Experiment) -> list[dict[str, Any]]:
    """The truth: the effects of the experiment, and physics of the rig that the declared model leaves out."""
    truth = list(bench.truth)
    if experiment.physics.cable_transport and experiment.load.kind != "none":
        truth.append({"name": "winding_history", "in_vocabulary": True, "parameters": {}})
    if bench.unseen_slip:
        slipped = [body.name for body in bench.routes.passed]
        truth += [{"name": "passed_slip", "in_vocabulary": True, "stage": name, "parameters": {}} for name in slipped]
    return truth
