"""Plan runs from the files that a user has: an experiment, a bench, a pilot run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.measurement.file import describes_runs, load_file
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.vet import vetted_runs
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.best_run import BestRun, best_run
from mbcdm_cad.planning.candidates import run_of
from mbcdm_cad.planning.plan import RunPlan, noise_from, plan_of
from mbcdm_cad.rig.dynamic.experiment import DynamicExperiment
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.reading import read_bench, read_experiment
from mbcdm_cad.workshop.store import Progress


def plan_run(drive: Drive, experiment: Path, pilot: Path | None) -> RunPlan:
    """What the run of an experiment file could find, or a measured run by its measurement file; with the noise of a
    measured run ``pilot``, if one is given.

    Raises ``InputError`` for mistakes in the files, ``MbcdmError`` for a run that the model cannot follow.
    """
    with _followed(experiment):
        if describes_runs(experiment):
            (one,) = vetted_runs([load_file(experiment)], drive)
            return plan_of(drive, one.run)
        measured = None if pilot is None else load_measurement(pilot)
        noise = None if measured is None else noise_from(drive, measured)
        # The load of the planned run is known as well as that of the pilot.
        known = None if measured is None else measured.sensors.torque_class
        return plan_of(drive, run_of(drive, _plannable(experiment), known), noise)


def plan_within(
    drive: Drive, bench: Path, *, experiment: Path | None, pilot: Path | None, progress: Progress
) -> BestRun:
    """The best run that the bench can make, compared with that of ``experiment`` if given. Errors as of the other."""
    with _followed(experiment or bench):
        noise = None if pilot is None else noise_from(drive, load_measurement(pilot))
        own = [] if experiment is None else [_quasistatic(experiment)]
        return best_run(drive, read_bench(bench), noise, own, progress)


@contextmanager
def _followed(path: Path) -> Iterator[None]:
    try:
        yield
    except ModelError as error:
        raise MbcdmError(f"{path}: the model cannot follow the run: {error}") from None


def _plannable(path: Path) -> Experiment | DynamicExperiment:
    wanted = read_experiment(path)
    chirped = isinstance(wanted, DynamicExperiment) and wanted.motion.shape == "chirp"
    return wanted if chirped else _quasistatic(path)


def _quasistatic(path: Path) -> Experiment:
    wanted = read_experiment(path)
    if not isinstance(wanted, Experiment):
        remedy = "use one of the quasi-static rig; motion, load and sensors are the same for the plan"
        raise InputError([Problem(str(path), 1, "format", "an experiment of the dynamic rig", remedy=remedy)])
    return wanted
