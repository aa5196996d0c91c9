"""The command ``mbcdm plan``: what a run will be able to say, before it is made."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.identification.judge import json_bytes
from mbcdm_cad.identification.plan import noise_from, plan_of
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.quasistatic.simulate import simulate
from mbcdm_cad.rig.reading import read_experiment
from mbcdm_cad.storage.files import write_whole


def plan_command(drive: Drive, experiment: Path, pilot: Path | None, json_path: Path | None) -> int:
    """Print what the run of ``experiment`` could say of ``drive``."""
    run = planned_run(drive, experiment)
    try:
        noise = None if pilot is None else noise_from(drive, load_measurement(pilot))
        plan = plan_of(drive, run, noise)
    except ModelError as error:
        raise MbcdmError(f"{experiment}: the model cannot follow the run: {error}") from None
    click.echo(plan.text())
    if json_path is not None:
        write_whole({json_path: json_bytes(plan.to_json())})
        click.echo(f"{json_path} written")
    return 0


def planned_run(drive: Drive, path: Path) -> Run:
    """The run as the bench would log it if the drive were as declared."""
    wanted = read_experiment(path)
    if not isinstance(wanted, Experiment):
        remedy = "give one of the quasi-static rig; motion, load and sensors are planned the same"
        raise InputError([Problem(str(path), 1, "format", "an experiment of the dynamic rig", remedy=remedy)])
    return run_of(drive, wanted)


def run_of(drive: Drive, wanted: Experiment) -> Run:
    """The same of an experiment that need not be a file."""
    plain = wanted.physics.model_copy(update={"cable_transport": False})
    run = simulate(drive, wanted.model_copy(update={"effects": (), "physics": plain}))
    s = wanted.sensors
    sensors = Sensors(
        s.input_resolution_rad or None,
        s.output_resolution_rad or None,
        s.torque_noise_Nm or None,
        s.input_noise_rad or None,
        s.output_noise_rad or None,
    )
    return Run(
        run.time_s,
        run.measured_input_rad,
        run.measured_output_rad,
        run.measured_load_Nm,
        run.measured_temperature_C,
        sensors,
        tuple(drive.input_names) if len(drive.input_names) > 1 else ("input",),
        wanted.name,
    )
