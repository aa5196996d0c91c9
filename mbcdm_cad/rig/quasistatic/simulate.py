"""Run one experiment: motion, effects, equilibrium at each sample, sensors."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig import chain, through
from mbcdm_cad.rig.bench import Bench, bench_of
from mbcdm_cad.rig.quasistatic import equilibrium
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.quasistatic.load import brake
from mbcdm_cad.rig.result import RigError, SimulatedRun
from mbcdm_cad.rig.sensors import counted, late
from mbcdm_cad.routes import Floats

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
    input_of, sides = np.array([c.input_index for c in bench.cables]), through.pairs_of(bench.cables)
    rub, slide = np.zeros(n_cables), np.zeros(n)
    if bench.friction is not None:
        rub, slide = bench.friction.drum_share, brake(bench.drum_rad, np.ones(n), _PRESLIDING_RAD)
        total = total + bench.friction.drum_bearings_Nm * slide
    course = equilibrium.QuasistaticCourse(
        input_of, gears, motor, path, lever, bench.drum_rad, total, strains, sides, rub, slide
    )
    failed = equilibrium.run(chains, course, pulleys, drum, tension)
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
