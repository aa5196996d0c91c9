"""The command ``mbcdm plan``: compute what a run could find, before it is made."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.build.progress import progress
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.loop.judge import json_bytes
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.planning.bench_runs import experiment_text, run_of
from mbcdm_cad.planning.best_run import best_run
from mbcdm_cad.planning.plan import noise_from, plan_of
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.reading import read_bench, read_experiment
from mbcdm_cad.storage.files import write_whole


def plan_command(
    drive: Drive,
    experiment: Path | None,
    within: Path | None,
    pilot: Path | None,
    *,
    written: Path | None,
    as_json: Path | None,
) -> int:
    """Print what the run of ``experiment`` could find, or the best run within the limits of a bench."""
    if experiment is None and within is None:
        raise MbcdmError(
            "plan: give an experiment file, --within BENCH.yaml, or both; docs/measure-your-drive.md shows them"
        )
    if written is not None and within is None:
        raise MbcdmError("--write: needs --within BENCH.yaml, which finds the best run")
    files = {}
    try:
        noise = None if pilot is None else noise_from(drive, load_measurement(pilot))
        own = [] if experiment is None else [planned(experiment)]
        if within is None:
            plan = plan_of(drive, run_of(drive, own[0]), noise)
            click.echo(plan.text())
        else:
            limits = read_bench(within)
            with progress() as note:
                best = best_run(drive, limits, noise, own, note)
            plan = best.plan
            if written is not None:
                about = f"the best run within {within.name}: {best.experiment.about}"
                files[written] = experiment_text(best.experiment, about).encode()
            click.echo(best.text())
    except ModelError as error:
        raise MbcdmError(f"{experiment}: the model cannot follow the run: {error}") from None
    if as_json is not None:
        files[as_json] = json_bytes(plan.to_json())
    if files:
        write_whole(files)
        click.echo("\n".join(f"{path} written" for path in files))
    return 0


def planned(path: Path) -> Experiment:
    """An experiment of the quasi-static rig."""
    wanted = read_experiment(path)
    if not isinstance(wanted, Experiment):
        remedy = "use one of the quasi-static rig; motion, load and sensors are the same for the plan"
        raise InputError([Problem(str(path), 1, "format", "an experiment of the dynamic rig", remedy=remedy)])
    return wanted
