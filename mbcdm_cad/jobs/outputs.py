"""Files beside the build of a design: drawings, prints, pictures, description for robot simulators, studies.

And searches from a user's files: the best designs by their wishes, and what the next run on the bench should be.

Each function makes the files, writes them completely or not at all, and says what it wrote. Libraries for drawing and
plots are imported inside, because they take long to load.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.template import slug
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.errors import InputError, MbcdmError, OutputError, Problem
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.measurement.datafile import read_table
from mbcdm_cad.measurement.file import describes_runs, load_file
from mbcdm_cad.measurement.kinds import LEAST_TRAVEL_RAD
from mbcdm_cad.measurement.logformat import find_format, wrong
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.vet import vetted_runs
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.optimising import Effort
from mbcdm_cad.optimising.evaluate import refuse_unknown
from mbcdm_cad.optimising.result import Optimum, optimum_of, optimum_page
from mbcdm_cad.optimising.search import FrontSearch, Journal, Told, sole_search
from mbcdm_cad.optimising.wishes import Wishes, variables_of
from mbcdm_cad.planning.best_run import BestRun, best_run, run_of
from mbcdm_cad.planning.plan import RunPlan, noise_from, plan_of
from mbcdm_cad.report.table import TextReport
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, read_bench, read_experiment
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.question import Question, question_of
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.cache import Cache, code_hash, content_key
from mbcdm_cad.workshop.drawings import drawings_folder, drawings_of
from mbcdm_cad.workshop.interference import bodies, is_cable
from mbcdm_cad.workshop.store import Progress, drawn

if TYPE_CHECKING:
    from mbcdm_cad.report.preload import PreloadReport
    from mbcdm_cad.robot.mjcf import UrdfOptions


@dataclass(frozen=True)
class Written(TextReport):
    """Files that were written: their ``folder``, all of them by path, and ``words`` about them."""

    folder: Path
    files: tuple[Path, ...]
    words: str

    def text(self) -> str:
        """What the command prints."""
        return self.words


def _written(loaded: LoadedDesign, folder: Path, files: Mapping[str, bytes], words: str) -> Written:
    folders.write_from(loaded.path, folder, files)
    return Written(folder, tuple(folder / name for name in files), f"{folder}: {words}")


def preload_of(loaded: LoadedDesign, logs: Mapping[str, Path], out: Path | None) -> PreloadReport:
    """The report of the preload, and with ``out`` the files of the procedure; a report without ramps has none.

    ``logs``: files of measured ramps by input. Raises ``MbcdmError`` for a log that does not do.
    """
    from mbcdm_cad.report.preload import preload_report

    report = preload_report(layout_of(loaded.drive), logs, _read_log)
    made = {} if out is None else report.files()
    if out is None or not made:
        return report
    folder = out / f"{loaded.drive.name}-preload"
    folders.refuse_other_origin(folder, loaded.path)
    return replace(report, folder=_written(loaded, folder, made, "").folder)


def _read_log(path: Path) -> tuple[Floats, Floats, bool]:
    """Angles and torques of a log, and whether they are the motor's: a table with ``angle_rad`` and a torque's column.

    It is read as ``mbcdm loop`` reads a run. Raises ``MbcdmError``, also where nothing moves.
    """
    from mbcdm_cad.report.preload import AT_MOTOR, HEAD

    try:
        layout = find_format(path, "auto", "point", "#", 0, "auto")
        at_motor = AT_MOTOR in layout.names and "torque_Nm" not in layout.names
        head = ("angle_rad", AT_MOTOR) if at_motor else HEAD
        if missing := [name for name in head if name not in layout.names]:
            what = f"no column {missing[0]}; columns: {', '.join(layout.names or ('none',))}"
            raise wrong(path, layout.header_line or 1, what, f"name them angle_rad and torque_Nm or {AT_MOTOR}")
        table = read_table(path, layout, [layout.names.index(name) for name in head], skip_broken=False).values
    except OSError as error:
        raise MbcdmError(f"{path}: cannot be read: {error.strerror}") from None
    for name, values in zip(head, table, strict=True):
        if not np.ptp(values) > LEAST_TRAVEL_RAD:  # far below what a ramp turns, rad, or takes, N m
            raise wrong(path, layout.begin_line, f"{name} does not change", "log it while the input turns to the knee")
    return table[0], table[1], at_motor


def write_drawings(
    loaded: LoadedDesign, out: Path, cache: Cache, *, part: str | None, jobs: int | None, progress: Progress
) -> Written:
    """Write a sheet of each made part and of the assembly, or of ``part`` alone, as DXF, PDF and SVG.

    Each made part comes as STEP AP242 with its tolerances too.

    Raises ``MbcdmError`` for a part that the design does not make.
    """
    folder = drawings_folder(out, loaded.drive.name)
    folders.refuse_other_origin(folder, loaded.path)
    files = drawings_of(loaded.drive, cache, part=part, jobs=jobs, progress=progress)
    sheets = sum(name.endswith(".pdf") for name in files)
    return _written(
        loaded, folder, files, f"{len(files)} files, {sheets} sheets as DXF, PDF and SVG, made parts as STEP AP242"
    )


def write_prints(
    loaded: LoadedDesign, out: Path, cache: Cache, *, every_made_part: bool, progress: Progress
) -> Written:
    """Write the parts of printed materials, or all made parts, for a 3D printer: one 3MF file a part.

    Raises ``MbcdmError`` if no part is printed.
    """
    from mbcdm_cad.workshop.prints import prints_of

    folder = out / f"{loaded.drive.name}-prints"
    folders.refuse_other_origin(folder, loaded.path)
    files = prints_of(loaded.drive, cache, progress, every_made_part=every_made_part)
    wider = loaded.drive.printing.hole_allowance_mm
    holes = f", round holes of printed materials {wider:g} mm wider than drawn" if wider else ""
    return _written(loaded, folder, files, f"{len(files)} parts as 3MF, each on its largest flat face{holes}")


def write_pictures(loaded: LoadedDesign, out: Path, cache: Cache, progress: Progress) -> Written:
    """Write the pictures for the assembly: each step, an exploded view, a section, as PNG."""
    from mbcdm_cad.workshop.pictures import pictures_of

    folder = out / f"{loaded.drive.name}-pictures"
    folders.refuse_other_origin(folder, loaded.path)
    files = pictures_of(loaded.drive, cache, progress)
    return _written(loaded, folder, files, ", ".join(files))


def write_picture(
    loaded: LoadedDesign, png: Path, cache: Cache, *, angle_deg: float, view: str, progress: Progress
) -> Written:
    """Draw the assembly into one PNG, without a display. Raises ``InputError`` for a file that cannot be a PNG."""
    _refuse_other_kind(png, ".png", "pictures are PNG files")
    folders.refuse_missing_folder(png)
    from mbcdm_cad.workshop.export.picture import picture_png

    _refuse_other_view(view)
    items, parts = drawn(loaded.drive, angle_deg, cache, progress)
    folders.write_whole({png: picture_png(items, {name: part.files.mesh for name, part in parts.items()}, view)})
    return Written(png.parent, (png,), f"{png}: {view} view, drum at {angle_deg:g} deg")


def write_moving_picture(loaded: LoadedDesign, gif: Path, cache: Cache, *, view: str, progress: Progress) -> Written:
    """Draw the travel into one GIF, without a display. Raises ``InputError`` for a file that cannot be a GIF."""
    _refuse_other_kind(gif, ".gif", "moving pictures are GIF files")
    from mbcdm_cad.workshop.export.picture import travel_gif

    _refuse_other_view(view)
    drive = loaded.drive
    layout = layout_of(drive)
    centred = layout.bill()
    _, parts = drawn(drive, 0.0, cache, progress)
    progress("moving picture")
    colour = next(item.material.colour for item in centred.items if is_cable(item))
    data = travel_gif(
        [item for item in centred.items if not is_cable(item)],
        {name: part.files.mesh for name, part in parts.items()},
        bodies(layout.moving_bodies, centred),
        (layout.all_cable_paths, drive.cable.diameter_mm, colour),
        drive.half_travel_deg,
        view=view,
    )
    folders.write_whole({gif: data})
    words = f"{gif}: {view} view, drum to +-{drive.half_travel_deg:g} deg, {len(data) / 1e6:.2f} MB"
    return Written(gif.parent, (gif,), words)


def _refuse_other_kind(path: Path, suffix: str, what: str) -> None:
    if path.suffix.lower() != suffix:
        remedy = f"name it {path.stem}{suffix}"
        raise InputError([Problem(str(path), 1, "", what, path.suffix, suffix, remedy)])


def _refuse_other_view(view: str) -> None:
    from mbcdm_cad.workshop.export.picture import VIEWS

    if view not in VIEWS:
        raise MbcdmError(f"view: no such view (value {view}, limit one of {', '.join(VIEWS)}); choose one of them")


def write_robot(
    loaded: LoadedDesign,
    out: Path,
    cache: Cache,
    *,
    form: str,
    elastic: bool,
    options: UrdfOptions | None,
    progress: Progress,
) -> Written:
    """Write ``out/<name>-<form>``: the description for robot simulators (``urdf`` or ``mjcf``) and its meshes.

    ``elastic`` in MJCF and ``options`` in URDF only.
    """
    from mbcdm_cad.robot.elastic import elastic_drive, left_out
    from mbcdm_cad.robot.mechanism import mechanism
    from mbcdm_cad.robot.mjcf import robot_files

    _, parts = drawn(loaded.drive, 0.0, cache, progress)
    robot = mechanism(loaded.drive, {name: part.files for name, part in parts.items()})
    missing = _not_in_file(left_out(loaded.drive, "elastic" if elastic else form))
    soft = elastic_drive(loaded.drive) if elastic else None
    files = robot_files(replace(robot, note=missing), form, elastic=soft, options=options)
    target = out / f"{loaded.drive.name}-{form}"
    inputs = content_key("export", (loaded.sha256, form, elastic, options))
    with folders.output_folder(target, folders.Manifest(loaded.sha256, inputs), design=loaded.path) as folder:
        for name, content in files.items():
            folder.write(name, content)
    mass = sum(link.mass for link in (robot.base, *robot.links))
    size = sum(map(len, files.values())) / 1e6
    first, *_ = paths = tuple(target / name for name in files)
    words = f"{first}: {len(robot.joints)} joints, {mass * 1e3:.1f} g, {size:.1f} MB with meshes"
    return Written(target, paths, "\n".join(filter(None, (words, missing))))


def _not_in_file(found: tuple[str, ...]) -> str:
    return f"found on the built drive, but not in this file: {'; '.join(found)}" if found else ""


def write_fmu(loaded: LoadedDesign, out: Path) -> Written:
    """Write ``out/<name>-fmu/<name>.fmu``: the drive for co-simulation (FMI 2.0)."""
    from mbcdm_cad.robot.elastic import elastic_drive, left_out
    from mbcdm_cad.robot.fmu import fmu_file

    content, platform = fmu_file(loaded.drive, elastic_drive(loaded.drive))
    target = out / f"{loaded.drive.name}-fmu"
    path = target / f"{loaded.drive.name}.fmu"
    inputs = content_key("fmu", loaded.sha256)
    with folders.output_folder(target, folders.Manifest(loaded.sha256, inputs), design=loaded.path) as folder:
        folder.write(path.name, content)
    library = f"library for {platform}" if platform else "no library: no C compiler 'cc' here; compile the sources"
    words = f"{path}: FMI 2.0 for co-simulation, {len(content) / 1e3:.0f} kB, {library}"
    missing = _not_in_file(left_out(loaded.drive, "fmu"))
    return Written(target, (path,), "\n".join(filter(None, (words, missing))))


@dataclass(frozen=True)
class SensitivityStudy(TextReport):
    """The study in ``folder``; ``summary`` is its sensitivity.json as plain data, in SI units."""

    folder: Path
    summary: dict[str, Any]

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm sensitivity`` prints: the files, and 95 % intervals in readable units."""
        from mbcdm_cad.model.figures import readable_figure
        from mbcdm_cad.report.table import ReportTable

        rows = []
        for name, interval in self.summary["intervals"].items():
            plain, unit, scale = readable_figure(name)
            rows.append((plain.replace("_", " "), unit, *(interval[key] * scale for key in ("value", "low", "high"))))
        table = ReportTable(("figure", "unit", "value", "low", "high"), tuple(rows))
        files = f"{self.folder}: fig5_a to fig5_d, indices, tolerance, loop as plots; sensitivity.json"
        return "\n".join([files, "95 % intervals:", *table.text(width, "  ")])

    def to_dict(self) -> dict[str, Any]:
        """The content of sensitivity.json."""
        return self.summary


def write_sensitivity(
    loaded: LoadedDesign, out: Path, workers: int | None = None, scheduler: str | None = None
) -> SensitivityStudy:
    """Write the sensitivity study into ``out/<name>-sensitivity``; its draws are shared by the workers."""
    from mbcdm_cad.model.bulk import block_figures
    from mbcdm_cad.model.study import write_study
    from mbcdm_cad.parallel.forks import crew
    from mbcdm_cad.parts.making import model_tolerances

    target = out / f"{loaded.drive.name}-sensitivity"
    inputs = content_key("sensitivity", loaded.sha256)
    with folders.output_folder(target, folders.Manifest(loaded.sha256, inputs), design=loaded.path) as folder:
        stacks = layout_of(loaded.drive).tolerance_stacks
        with crew(block_figures, workers, scheduler) as shared:
            summary = write_study(layout_of(loaded.drive), folder.path, model_tolerances(loaded.drive), stacks, shared)
    return SensitivityStudy(target, summary)


def write_dependencies(loaded: LoadedDesign, svg: Path) -> Written:
    """Draw which field follows from which into one SVG.

    Raises ``InputError`` for a file that cannot be an SVG, ``MbcdmError`` for a layout without sizing rules.
    """
    from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg
    from mbcdm_cad.report.explain import fields_data

    _refuse_other_kind(svg, ".svg", "graphs are SVG files")
    found = dependency_graph(fields_data(loaded)["fields"])
    if not found.nodes:
        raise MbcdmError(f"{loaded.path}: no graph, because {loaded.drive.configuration} has no sizing rules")
    folders.refuse_missing_folder(svg)
    folders.write_whole({svg: dependency_svg(found, f"{loaded.drive.name}: dependencies of all values").encode()})
    return Written(svg.parent, (svg,), f"{svg}: {len(found.nodes)} fields, {len(found.lines)} lines")


def write_experiment(drive: Drive, experiment: Path, out: Path) -> Written:
    """Run an experiment file on the test rig and write ``out/<its name>``: measurement file, data, truth, picture.

    Raises ``InputError`` for mistakes in the file, ``RigError`` if the rig stops.
    """
    from mbcdm_cad.rig.experiment import read_experiment

    wanted = read_experiment(experiment)
    from mbcdm_cad.rig.command import simulate_command  # loads compiled code: only for a valid file

    words = simulate_command(drive, wanted, out)
    folder = out / wanted.name
    return Written(folder, tuple(sorted(folder.iterdir())), words)


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
        folders.refuse_other_origin(folder, path)
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
        "versions": folders.versions() | {"pymoo": metadata.version("pymoo")},
    }


def _write(found: Optimum, questions: Sequence[Question], request: dict[str, Any]) -> None:
    key = content_key("optimum", request)
    try:
        with folders.output_folder(found.folder, folders.Manifest(key, key), design=questions[0].path) as folder:
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
        wanted = read_experiment(experiment)
        chirped = isinstance(wanted, DynamicExperiment) and wanted.motion.shape == "chirp"
        planned = run_of(drive, wanted if chirped else _quasistatic(experiment), known)
        return plan_of(drive, planned, noise)


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


def _quasistatic(path: Path) -> Experiment:
    wanted = read_experiment(path)
    if not isinstance(wanted, Experiment):
        remedy = "use one of the quasi-static rig; motion, load and sensors are the same for the plan"
        raise InputError([Problem(str(path), 1, "format", "an experiment of the dynamic rig", remedy=remedy)])
    return wanted
