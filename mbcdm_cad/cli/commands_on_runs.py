"""Commands of the model, of the test rig and of the loop on measured runs.

Each calls a function of :mod:`mbcdm_cad.api` and prints its result.
"""

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbcdm_cad import api
from mbcdm_cad.cli.commands_on_designs import write_new
from mbcdm_cad.cli.group import (
    DESIGN,
    FILE,
    SCHEDULER,
    WORKERS,
    examples,
    load,
    mbcdm,
    out_folder,
    print_report,
    progress,
    screen_width,
    sign_of_life,
)
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.storage.folders import refuse_missing_folder, write_whole

if TYPE_CHECKING:
    from mbcdm_cad.measurement.file import MeasurementFile

RATIO = click.option(
    "--ratio",
    type=click.FloatRange(0.0, 1e6, min_open=True),
    help="Total ratio of a drive without a design file, from the input's encoder to the output.",
)


@mbcdm.command(epilog=examples("mbcdm analyse my_drive.yaml", "mbcdm analyse my_drive.yaml --json > figures.json"))
@DESIGN
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def analyse(design: Path, as_json: bool) -> None:
    """Compute tensions, backlash, load sharing, torque limits."""
    with sign_of_life(f"{design}: sizing and analysing"):
        report = api.load(design).analyse()
    print_report(report, as_json)


@mbcdm.command(
    epilog=examples(
        "mbcdm preload my_drive.yaml", "mbcdm preload my_drive.yaml --log left=left.csv --log right=right.csv"
    )
)
@DESIGN
@click.option(
    "--log", "logs", multiple=True, metavar="INPUT=FILE", help="Measured ramps of an input, a CSV: docs/preload.md."
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
@out_folder("Folder that the procedure's folder, NAME-preload, is written into.")
def preload(design: Path, logs: tuple[str, ...], as_json: bool, out: Path) -> None:
    """Show what the preload is made of and how to measure it.

    Writes the expected curves of torque over angle of each input with the drum at its stop, a ramp in C and its
    evaluation in Python. With --log: the preloads found, and which nut to turn by how much.
    """
    named = {}
    for log in logs:
        name, equals, path = log.partition("=")
        if not (name and equals and path):
            raise click.BadParameter(f"{log!r} is not INPUT=FILE, such as left=left.csv", param_hint="--log")
        named[name] = path
    report = load(design).preload(out, logs=named)
    print_report(report, as_json)
    if report.folder is not None and not as_json:
        click.echo(f"{report.folder}: expected curves, ramp in C, evaluation in Python")


@mbcdm.command(epilog=examples("mbcdm sensitivity my_drive.yaml"))
@DESIGN
@WORKERS
@SCHEDULER
@out_folder("Folder that the study's folder, NAME-sensitivity, is written into.")
def sensitivity(design: Path, workers: int | None, scheduler: str | None, out: Path) -> None:
    """Show which parameters change backlash and torque most.

    Writes plots and CSV: the panels of the paper's figure 5, global indices, the tolerance stack over the travel, and
    95 % intervals.
    """
    found = load(design).sensitivity(out, workers=workers, scheduler=scheduler)
    click.echo(found.text(screen_width()))


@mbcdm.command(epilog=examples("mbcdm reproduce", "mbcdm reproduce my_drive.yaml"))
@click.argument("design", type=FILE, required=False)
def reproduce(design: Path | None) -> int:
    """Compare the paper's figures with the model's.

    For DESIGN, or for the reference design. Exit code 1 if a figure is outside its tolerance.
    """
    found = api.reproduce(None if design is None else load(design))
    click.echo(found.text(), nl=False)
    for figure in found.outside:
        click.echo(
            f"{figure.name}: {figure.computed:.5g} {figure.unit} is {figure.difference:+.2%} from the paper's "
            f"{figure.paper:.5g} (tolerance {figure.tolerance:.2%})",
            err=True,
        )
    return 1 if found.outside else 0


@mbcdm.command(
    epilog=examples(
        "mbcdm loop my_drive.yaml run1.yaml run2.yaml --report out/loop",
        "mbcdm loop my_drive.yaml run1.yaml --apply my_drive_as_built.yaml",
        "mbcdm loop run1.yaml --ratio 8",
    )
)
@DESIGN
@click.argument("measurements", type=FILE, nargs=-1)
@RATIO
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the result as JSON.")
@click.option(
    "--apply",
    "as_built",
    type=FILE,
    metavar="AS_BUILT.yaml",
    help="Write the design file with the effects that were found.",
)
@click.option("--report", type=FILE, metavar="FOLDER", help="Write a page with plots to this folder.")
@click.option(
    "--correction", type=FILE, metavar="FOLDER", help="Write a correction table for the controller to this folder."
)
@click.option(
    "--next",
    "next_path",
    type=FILE,
    metavar="NEXT.yaml",
    help="If several effects are possible, write the experiment that separates them best.",
)
def loop(
    design: Path,
    measurements: tuple[Path, ...],
    ratio: float | None,
    json_path: Path | None,
    as_built: Path | None,
    report: Path | None,
    correction: Path | None,
    next_path: Path | None,
) -> int:
    """Find effects that the model lacks, from measured runs.

    Each MEASUREMENTS file (YAML) describes one run and names the columns of its CSV file. All runs are used together.
    In place of them, one study file lists the runs and what differs from run to run. DESIGN may be left out where
    --ratio or the measurement files give the ratio: the loop then finds errors of angle, play, friction and drift.
    """
    from mbcdm_cad.measurement.file import describes_runs

    if ratio is not None or describes_runs(design):
        loaded, measurements = None, (design, *measurements)
    elif not measurements:
        raise click.UsageError("give the measurement files after the design, or --ratio in place of a design")
    else:
        loaded = load(design)  # before the other imports, so that bad input is reported at once
    return loop_command(loaded, measurements, ratio, Outputs(json_path, as_built, report, correction, next_path))


@mbcdm.command(epilog=examples("mbcdm trend study.yaml", "mbcdm trend study.yaml --picture trend.png"))
@click.argument("study", type=FILE)
@click.option("--picture", type=FILE, metavar="FILE.png", help="Draw values, courses and limits over the dates.")
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the result as JSON.")
def trend(study: Path, picture: Path | None, json_path: Path | None) -> None:
    """Show how a drive changes from date to date.

    STUDY (YAML) names the design (unless its runs state a ratio), lists the runs with their dates, and says what
    differs from run to run. Prints each figure with its course, the odds that it changed, and the day on which a limit
    of the design is reached.
    """
    for path in filter(None, (picture, json_path)):
        refuse_missing_folder(path)
        if path.exists():
            raise InputError(
                [Problem(str(path), 1, "", "is there already", remedy="choose another name, or remove it")]
            )
    report = api.trend(study)
    click.echo(report.text())
    outputs = {} if picture is None else {picture: report.picture()}
    if json_path is not None:
        from mbcdm_cad.loop.judge import json_bytes

        outputs[json_path] = json_bytes(report.to_dict())
    write_whole(outputs)
    for path in outputs:
        click.echo(f"{path} written")


@mbcdm.command(
    epilog=examples(
        "mbcdm plan my_drive.yaml params/experiments/null-long-levels.yaml",
        "mbcdm plan my_drive.yaml planned.yaml --noise-from pilot.yaml",
        "mbcdm plan my_drive.yaml --within bench.yaml --write planned.yaml",
    )
)
@DESIGN
@click.argument("experiment", type=FILE, required=False)
@click.option("--within", type=FILE, metavar="BENCH.yaml", help="Find the best run that this bench can make.")
@click.option("--noise-from", "pilot", type=FILE, metavar="RUN.yaml", help="Take the noise of a measured run.")
@click.option("--write", "written", type=FILE, metavar="FILE", help="Write the best run as an experiment file.")
@click.option("--json", "as_json", type=FILE, metavar="FILE", help="Write the plan as JSON.")
def plan(
    design: Path,
    experiment: Path | None,
    within: Path | None,
    pilot: Path | None,
    written: Path | None,
    as_json: Path | None,
) -> None:
    """Compute what a run could find, before it is made.

    For each effect: the smallest size that the loop would name, and each effect with which it could be confused, with
    the size up to which this happens.
    """
    loaded = load(design)
    if experiment is None and within is None:
        raise MbcdmError(
            "plan: give an experiment file, --within BENCH.yaml, or both; docs/measure-your-drive.md shows them"
        )
    if written is not None and within is None:
        raise MbcdmError("--write: needs --within BENCH.yaml, which finds the best run")
    files = {}
    if within is not None:
        with progress() as note:
            best = loaded.best_run(within, experiment=experiment, noise_from=pilot, progress=note)
        found = best.plan
        click.echo(best.text())
        if written is not None:
            files[written] = best.experiment_text(within.name).encode()
    else:
        assert experiment is not None, "refused above"
        found = loaded.plan(experiment, noise_from=pilot)
        click.echo(found.text())
    if as_json is not None:
        from mbcdm_cad.loop.judge import json_bytes

        files[as_json] = json_bytes(found.to_json())
    if files:
        write_whole(files)
        click.echo("\n".join(f"{path} written" for path in files))


@mbcdm.command(epilog=examples("mbcdm simulate my_drive.yaml params/experiments/winding-short-brake.yaml"))
@DESIGN
@click.argument("experiment", type=FILE)
@out_folder("Folder that the experiment's folder is written into.")
def simulate(design: Path, experiment: Path, out: Path) -> None:
    """Run an experiment on the test rig in software.

    Writes the measured run for 'mbcdm loop', and in a separate file the truth, which the loop does not read.
    """
    click.echo(load(design).simulate(experiment, out))


@mbcdm.command(
    "measurement-init",
    epilog=examples("mbcdm measurement-init run.csv my_drive.yaml", "mbcdm measurement-init run.csv --ratio 100"),
)
@click.argument("data", type=FILE)
@click.argument("design", type=FILE, required=False)
@RATIO
@click.option("--out", type=FILE, metavar="FILE", help="Measurement file; by default with the name of the data.")
def measurement_init(data: Path, design: Path | None, ratio: float | None, out: Path | None) -> int:
    """Draft the measurement file of a logger's CSV.

    Guesses the content of each column from names, units, ranges and the ratio of the design, and marks each guess. Of a
    drive without a design file give the ratio in place of DESIGN.
    """
    if (design is None) == (ratio is None):
        raise click.UsageError("give a design file or --ratio, one of the two")
    path = out or data.parent / f"{data.stem}.yaml"
    refuse_missing_folder(path)
    text = api.draft_measurement(data, None if design is None else load(design), ratio=ratio)
    if path.parent.resolve() != data.parent.resolve():
        remedy = "write it into the folder of the data, because it names the data relative to itself"
        raise InputError([Problem(str(path), 1, "", "in another folder than the data", remedy=remedy)])
    write_new(path, text, "choose another name with --out, or remove it")
    click.echo(text, nl=False)
    where = " ".join(shlex.quote(str(one)) for one in (design, path) if one is not None)
    click.echo(f"{path} written; check the guesses in it, then: mbcdm loop {where}")
    return 0


REPORT_PAGE, REPORT_JSON = REPORT_FILES = ("report.html", "result.json")
CORRECTION_FILES = ("correction.csv", "correction.json", "correction.h")


@dataclass(frozen=True)
class Outputs:
    """Files and folders to write, or None: JSON result, design as built, report, correction table, next run."""

    json: Path | None = None
    as_built: Path | None = None
    report: Path | None = None
    correction: Path | None = None
    next: Path | None = None


def loop_command(
    loaded: api.DriveDesign | None, measurements: Sequence[Path], ratio: float | None, wanted: Outputs
) -> int:
    """Judge the runs together. 0 if they could be judged; raises InputError with all mistakes of bad input.

    ``ratio``: total ratio of a drive without a design.
    """
    from mbcdm_cad.loop.as_built import applied_words
    from mbcdm_cad.loop.correction import correction_words
    from mbcdm_cad.loop.judge import drive_of, is_study, json_bytes, load_study
    from mbcdm_cad.measurement.file import load_file, with_ratio
    from mbcdm_cad.measurement.schema import MOTION

    study = measurements[0] if len(measurements) == 1 and is_study(measurements[0]) else None
    files = list(load_study(study).files) if study else [load_file(path) for path in measurements]
    files = [with_ratio(file, ratio) for file in files]
    _refuse_outputs(loaded, files, wanted)
    if any(file.content.published is not None for file in files):
        return _published(loaded, files, wanted)
    if files[0].content.kind != MOTION:
        for option, path in (("--correction", wanted.correction), ("--next", wanted.next)):
            if path is not None:
                remedy = f"leave {option} out; it works from runs of kind {MOTION}"
                raise files[0].refusal(("kind",), f"given with {option}", files[0].content.kind, remedy=remedy)
    if loaded is None or drive_of(loaded.loaded, files) is None:
        for option, path in (("--apply", wanted.as_built), ("--next", wanted.next)):
            if path is not None:
                remedy = f"leave {option} out, or judge runs of the design"
                raise files[0].refusal(("ratio",), "a drive of its own, not the design's", remedy=remedy)
    report = api.close_loop(loaded, measurements, ratio=ratio)
    click.echo(report.text())
    content = json_bytes(report.to_dict())
    outputs, applied = {} if wanted.json is None else {wanted.json: content}, ""
    if wanted.as_built is not None:
        outputs[wanted.as_built] = report.as_built_text().encode()
        applied = applied_words(report.result)
    if wanted.report is not None:
        outputs |= {wanted.report / REPORT_PAGE: report.page(), wanted.report / REPORT_JSON: content}
    if wanted.correction is not None and report.correction is not None:
        outputs |= {wanted.correction / name: text for name, text in report.correction_files().items()}
        click.echo(f"\ncorrection: {correction_words(report.correction)}")
    if wanted.next is not None:
        following = api.next_run(report)
        if following is None:
            click.echo(f"\nno set of possible effects is left: {wanted.next} is not written")
        elif not following.useful:
            click.echo(f"\n{following.words()}\n{wanted.next} is not written")
        else:
            outputs[wanted.next] = following.text().encode()
            click.echo(f"\nnext run, {following.words()}")
    write_whole(outputs)
    for path in outputs:
        click.echo(f"{path} written" + (f": {applied}" if path == wanted.as_built else ""))
    return 0


def _published(loaded: api.DriveDesign | None, files: Sequence["MeasurementFile"], wanted: Outputs) -> int:
    """Judge the figures of a paper: possible causes, without a fit."""
    from mbcdm_cad.loop.judge import json_bytes

    if len(files) > 1 or any(one is not None for one in (wanted.as_built, wanted.correction, wanted.next)):
        remedy = "use it alone, without --apply, --correction and --next"
        wrong = next(file for file in files if file.content.published is not None)
        raise wrong.refusal(("published",), "figures of a paper, not a run", remedy=remedy)
    if loaded is None:
        raise files[0].refusal(("published",), "no design", remedy="give the design file first")
    result = api.judge_published(loaded, files[0].path)
    click.echo(result.text().rstrip())
    content = json_bytes(result.to_json())
    outputs = {} if wanted.json is None else {wanted.json: content}
    if wanted.report is not None:
        from mbcdm_cad.paper.published import published_page

        page = published_page(result, loaded.name)
        outputs |= {wanted.report / REPORT_PAGE: page, wanted.report / REPORT_JSON: content}
    write_whole(outputs)
    for path in outputs:
        click.echo(f"{path} written")
    return 0


def _refuse_outputs(loaded: api.DriveDesign | None, files: Sequence["MeasurementFile"], wanted: Outputs) -> None:
    """Raise InputError if an output would replace an input or another output, or if its folder does not exist."""
    taken = [("measurement file", file.path) for file in files]
    taken += [] if loaded is None else [("design file", loaded.loaded.path)]
    data = [(file.path, file.content.data) for file in files if file.content.data]
    taken += [("data of " + path.name, path.parent / name) for path, name in data]
    outputs = [] if wanted.json is None else [("--json", wanted.json)]
    outputs += [] if wanted.as_built is None else [("--apply", wanted.as_built)]
    outputs += [] if wanted.next is None else [("--next", wanted.next)]
    folders = (("--report", wanted.report, REPORT_FILES), ("--correction", wanted.correction, CORRECTION_FILES))
    for option, folder, names in folders:
        if folder is None:
            continue
        if folder.exists() and not folder.is_dir():
            remedy = f"the {option.removeprefix('--')} needs a folder; give another name"
            raise InputError([Problem(str(folder), 1, option, "a file", remedy=remedy)])
        outputs += [(option, folder / name) for name in names]
    problems = []
    for option, output in outputs:
        where = (str(output), 1, option)
        for word, path in taken:
            if _same_file(output, path):
                what = f"would overwrite the {word}, {path}"
                problems.append(Problem(*where, what, remedy="nothing was done; give another name"))
        if output.is_dir():
            problems.append(Problem(*where, "is a folder, but a file is to be written", remedy="give another name"))
        there = next((folder for folder in output.parents if folder.exists()), Path())
        if not there.is_dir() or (option not in ("--report", "--correction") and there != output.parent):
            what = f"there is no folder {output.parent}" if there.is_dir() else f"{there} is no folder"
            problems.append(Problem(*where, what, remedy="make it, or choose another path"))
        elif not os.access(there, os.W_OK):
            problems.append(Problem(*where, f"nothing may be written in {there}", remedy="choose another path"))
        taken.append((f"output of {option}", output))
    if problems:
        raise InputError(problems)


def _same_file(one: Path, other: Path) -> bool:
    """Whether two paths are the same file, which need not exist, for any spelling and links."""
    try:
        return one.resolve() == other.resolve() or (one.exists() and other.exists() and one.samefile(other))
    except (OSError, ValueError, RuntimeError):  # an invalid path, or links in a circle
        return False
