"""The command ``mbcdm loop``: reads and vets the runs, closes the loop, prints and writes the result.

Pages and published figures are imported inside: most runs need neither, and their templates take time to load.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from mbcdm_cad import api
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.loop.as_built import applied_words
from mbcdm_cad.loop.correction_files import correction_words
from mbcdm_cad.loop.judge import drive_of, json_bytes
from mbcdm_cad.loop.study import is_study, load_study
from mbcdm_cad.measurement.file import MeasurementFile, load_file, with_ratio
from mbcdm_cad.measurement.schema import MOTION
from mbcdm_cad.storage.folders import write_whole

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


def _published(loaded: api.DriveDesign | None, files: Sequence[MeasurementFile], wanted: Outputs) -> int:
    """Judge the figures of a paper: possible causes, without a fit."""
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


def _refuse_outputs(loaded: api.DriveDesign | None, files: Sequence[MeasurementFile], wanted: Outputs) -> None:
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
