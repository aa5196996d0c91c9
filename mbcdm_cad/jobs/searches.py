"""Searches from a user's files: the best designs by their wishes, and what the next run on the bench should be."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.template import slug
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.errors import InputError, MbcdmError, OutputError, Problem
from mbcdm_cad.measurement.file import describes_runs, load_file
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.vet import vetted_runs
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.optimising.evaluate import refuse_unknown
from mbcdm_cad.optimising.result import Optimum, optimum_of, optimum_page
from mbcdm_cad.optimising.search import FrontSearch, Journal, Told, sole_search
from mbcdm_cad.optimising.variables import variables_of
from mbcdm_cad.optimising.wishes import Effort, Wishes
from mbcdm_cad.planning.best_run import BestRun, best_run, run_of
from mbcdm_cad.planning.plan import RunPlan, noise_from, plan_of
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, read_bench, read_experiment
from mbcdm_cad.solving.question import Question, question_of
from mbcdm_cad.storage.cache import code_hash, content_key
from mbcdm_cad.storage.files import Manifest, versions
from mbcdm_cad.storage.folders import output_folder
from mbcdm_cad.workshop.store import Progress


def optimise(
    files: Sequence[tuple[str, Path]],
    wishes: Wishes,
    out: Path,
    effort: Effort,
    told: Told,
    beside: Sequence[LoadedDesign] = (),
) -> Optimum:
    """Search over ``files``, each its text and path, and write ``out/NAME-optimum``.

    Evaluated points go into ``out/NAME-optimum.jsonl`` on the way. The front is shown ``beside`` other designs. An
    interrupted search writes what it has. Raises ``InputError`` for mistakes in a file, ``MbcdmError`` for wishes that
    the layouts cannot answer, and ``OutputError`` if files cannot be written or a search before is there and ``effort``
    does not resume it.
    """
    text, path = files[0]
    data = parse(text, str(path)).data
    name = slug(str((data.get("name") if isinstance(data, dict) else None) or path.stem))
    folder = out / f"{name}-optimum"
    journal_path = out / f"{name}-optimum.jsonl"
    request = _request(files, wishes)
    # Small systems of equations: threads of the linear algebra would only wait for each other.
    with threadpool_limits(1), sole_search(journal_path):
        # Before any file is sized, which may take long: a search that is refused is refused at once.
        with Journal(journal_path, request, resume=effort.resume) as journal:
            questions = [question_of(text, path) for text, path in files]
            refuse_unknown([*(aim.figure for aim in wishes.aims), *(keep.figure for keep in wishes.keeps)], questions)
            variables = [variables_of(question, wishes) for question in questions]
            search = FrontSearch(questions, variables, wishes, journal, told)
            searched = search.run(effort)
        found = optimum_of(questions, searched, folder, name, beside)
        _write(found, questions, request)
    return found


def _request(files: Sequence[tuple[str, Path]], wishes: Wishes) -> dict[str, Any]:
    """All that the results depend on; a search goes on only with an equal one."""
    return {
        "files": [[path.name, text] for text, path in files],
        "aims": [str(aim) for aim in wishes.aims],
        "keeps": [str(keep) for keep in wishes.keeps],
        "free": [[freed.field, list(freed.values), freed.low, freed.high] for freed in wishes.free],
        "only_free": wishes.only_free,
        "package": code_hash(),
        "versions": versions() | {"pymoo": metadata.version("pymoo")},
    }


def _write(found: Optimum, questions: Sequence[Question], request: dict[str, Any]) -> None:
    key = content_key("optimum", request)
    try:
        with output_folder(found.folder, Manifest(key, key), design=questions[0].path) as folder:
            folder.write("optimum.json", json.dumps(found.to_dict(), indent=1, allow_nan=False) + "\n")
            folder.write("front.csv", _csv(found))
            folder.write("optimum.html", optimum_page(found))
            for point in found.points:
                folder.write(f"front/{point.name}.yaml", point.text)
    except OutputError as error:
        raise OutputError(f"{error}; the evaluated points are kept: go on with --resume") from error


def _csv(found: Optimum) -> str:
    """All figures of the front; neither names nor numbers contain a comma."""
    table = found.all_figures()
    lines = [",".join("" if cell is None else str(cell) for cell in row) for row in (table.columns, *table.rows)]
    return "\n".join(lines) + "\n"


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
