"""Run an experiment file on the dynamic rig; the result is a run and its truth."""

from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.bench import Bench, bench_of
from mbcdm_cad.rig.dynamic.run import DynamicRun, run_dynamic
from mbcdm_cad.rig.dynamic.train import LOOP_RATE_HZ, DynamicRig, EncoderSpec, LoadSpec, rig_of
from mbcdm_cad.rig.experiment import DynamicExperiment, RigError, SimulatedRun


def simulate(drive: Drive, experiment: DynamicExperiment) -> SimulatedRun:
    """Run ``experiment`` on the dynamic rig with ``drive``. The same seed gives the same run. Raises RigError."""
    run, bench, _ = simulate_dynamic(drive, experiment)
    return as_logged(run, truth_of(experiment, bench))


def simulate_dynamic(drive: Drive, experiment: DynamicExperiment) -> tuple[DynamicRun, Bench, DynamicRig]:
    """Run ``experiment``; the run, the bench with its effects, and the rig built from it. Raises RigError."""
    reference = experiment.motion.reference(experiment.duration_s, LOOP_RATE_HZ)
    bench = _bench(drive, experiment, reference[:, 0])
    rig = _rig(drive, experiment, bench)
    time = np.arange(reference.shape[0]) / LOOP_RATE_HZ
    torque = experiment.load.torque_Nm + experiment.load.ramp_Nm_s * time
    try:
        run = run_dynamic(
            rig, reference, torque, experiment.load.brake_Nm, experiment.seed, float(experiment.sample_rate_Hz)
        )
    except ValueError as error:
        raise RigError(f"{experiment.name}: {error}; lower motion.amplitude_mrad") from None
    return run, bench, rig


def _bench(drive: Drive, experiment: DynamicExperiment, drum: Any) -> Bench:
    time = np.arange(drum.size) / LOOP_RATE_HZ
    strays = np.zeros((len(drive.input_names), drum.size))
    try:
        bench = bench_of(drive, time, drum, strays, np.random.default_rng(experiment.seed), experiment.physics)
    except ValueError as error:
        raise RigError(f"{drive.name}: the rig cannot simulate this drive: {error}") from None
    for effect in experiment.effects:
        try:
            effect.apply(bench)
        except KeyError as error:
            raise RigError(f"{experiment.name}: effects: {effect.effect}: the drive has no {error.args[0]}") from None
        if _beyond(bench):
            raise RigError(
                f"{experiment.name}: effects: {effect.effect}: not on the dynamic rig; leave out 'rig: dynamic' or use "
                "its blocks drives, bearings, load and sensors"
            )
    return bench


def _beyond(bench: Bench) -> bool:
    """Whether an effect has changed something that the dynamic rig models differently or not at all."""
    asked = np.stack([bench.drum_rad * bench.turns(i) for i in range(len(bench.drive.input_names))])
    lists = bench.encoder_errors or bench.gear_errors or bench.hidden_Nm or bench.output_twist_rad_Nm
    lists = lists or bool(bench.slow_twist) or any(c.own_wrap_rad > 0.0 for c in bench.cables)
    arrays = (bench.strains, bench.stick_slip, bench.temperature_C)
    return bool(lists) or any(a is not None for a in arrays) or not np.array_equal(bench.command_rad, asked)


def _rig(drive: Drive, experiment: DynamicExperiment, bench: Bench) -> DynamicRig:
    load, drives, sensors, physics = experiment.load, experiment.drives, experiment.sensors, experiment.physics
    # The design's payload turns with what the bench adds.
    carried = drive.loads.carried.about_axis_kg_m2 if physics.structure else 0.0
    spec = LoadSpec(
        load.inertia_kg_m2 + carried,
        load.static_ratio,
        load.static_speed_rad_s,
        load.unbalance_Nm,
        bearing_drag_Nm=experiment.bearings.drum_Nm,
        bearing_viscous_Nms=experiment.bearings.viscous_Nms,
        bearing_stribeck_Nm=experiment.bearings.stribeck_Nm,
        bearing_stribeck_rad_s=experiment.bearings.stribeck_rad_s,
        bearing_driving_share=experiment.bearings.driving_share,
        bearing_driven_share=experiment.bearings.driven_share,
    )
    rig = rig_of(drive, spec, drives.lossless, drives.bandwidth_Hz)
    rubs, before = bench.friction, bench.compliance.before_inputs_Nm_rad
    cogging = drives.cogging_share * rig.motors[0].torque_limit_Nm
    motors = tuple(
        # Different phases, since the rotors of two motors are mounted at arbitrary angles.
        replace(m, cogging_Nm=cogging, cogging_per_turn=drives.cogging_per_turn, cogging_phase_rad=2.0 * i)
        for i, m in enumerate(rig.motors)
    )
    if rubs is not None:
        motors = tuple(replace(m, coulomb_Nm=rubs.motor_Nm) for m in motors)
    if drives.lossless:
        motors = tuple(replace(m, coulomb_Nm=0.0, viscous_Nms=0.0) for m in motors)
    gearheads = tuple(
        replace(
            g,
            lash_rad=drives.lash_mrad * 1e-3 + bench.gear_play_rad[i],
            drag_Nm=g.drag_Nm if rubs is None or drives.lossless else rubs.gear_idle_Nm,
            stiffness_Nm_rad=min(before if isfinite(before) else g.stiffness_Nm_rad, bench.gear_stiffness_Nm_rad[i]),
            mesh_error_rad=drives.mesh_error_urad * 1e-6,
            mesh_per_motor_turn=drives.mesh_per_motor_turn,
        )
        for i, g in enumerate(rig.gearheads)
    )
    encoder = EncoderSpec(
        sensors.input_resolution_rad, sensors.input_noise_rad, sensors.input_delay_s + bench.input_delay_s
    )
    late = sensors.output_delay_s + bench.output_delay_s
    return replace(
        rig,
        motors=motors,
        gearheads=gearheads,
        cables=bench.cables,
        paths=tuple(bench.paths),
        encoders=(encoder,) * len(motors),
        drum_encoder=EncoderSpec(sensors.output_resolution_rad, sensors.output_noise_rad, late),
        torque_noise_Nm=sensors.torque_noise_Nm,
        input_drag_Nm=experiment.bearings.input_Nm,
        passed_drag_Nm=experiment.bearings.passed_Nm,
        step_s=physics.step_us * 1e-6,
        piece_rad=physics.piece_mrad * 1e-3,
        transport=physics.cable_transport,
        passed_slip=bench.passed_slip,
        compliance=bench.compliance,
        friction=rubs,
    )


def truth_of(experiment: DynamicExperiment, bench: Bench) -> list[dict[str, Any]]:
    """Effects that the declared model leaves out, by the loop's names; causes outside its library by their own name."""
    drives, load, bearings, sensors = experiment.drives, experiment.load, experiment.bearings, experiment.sensors
    if experiment.physics.cable_transport:
        bench.tell("winding_history")
    passed = [body.name for body in bench.routes.passed]
    if bench.unseen_slip:
        for name in passed:
            bench.tell("passed_slip", stage=name)
    if drives.cogging_share > 0.0:
        bench.tell("ripple", cause="motor_cogging", parameters={"per_motor_turn": drives.cogging_per_turn})
    if drives.mesh_error_urad > 0.0:
        bench.tell("ripple", cause="gear_mesh", parameters={"per_motor_turn": drives.mesh_per_motor_turn})
    if drives.lash_mrad > 0.0:
        bench.tell("lash", seen=False, parameters={"lash_rad": drives.lash_mrad * 1e-3})
    if load.static_ratio > 1.0 and load.brake_Nm > 0.0:
        bench.tell("brake_stick_slip", in_vocabulary=False, parameters={"static_ratio": load.static_ratio})
    by_law = ("stribeck_Nm", "driving_share", "driven_share")
    laws = {name: float(value) for name in by_law if (value := getattr(bearings, name)) > 0.0}
    if bearings.drum_Nm > 0.0 or bearings.passed_Nm > 0.0 or laws:
        drags = {f"{name}_Nm": bearings.passed_Nm for name in passed}
        bench.tell("friction", parameters={"drum_Nm": bearings.drum_Nm, **drags, **laws})
    if bearings.viscous_Nms > 0.0:
        bench.tell("delay", cause="viscous_drag", parameters={"drag_Nms": bearings.viscous_Nms})
    if sensors.output_delay_s > 0.0:
        bench.tell("delay", parameters={"delay_s": sensors.output_delay_s})
    return bench.truth


def as_logged(run: DynamicRun, truth: list[dict[str, Any]]) -> SimulatedRun:
    """The run in the form from which the files of all simulated runs are written."""
    return SimulatedRun(
        time_s=run.time_s,
        input_rad=run.input_rad,
        drum_rad=run.drum_rad,
        payload_rad=run.payload_rad,
        load_Nm=run.torque_Nm,
        tension_N=run.tension_N,
        measured_input_rad=run.measured_input_rad,
        measured_output_rad=run.measured_drum_rad,
        measured_load_Nm=run.measured_torque_Nm,
        measured_temperature_C=None,
        excitation_rad=run.reference_rad,
        truth=truth,
    )
