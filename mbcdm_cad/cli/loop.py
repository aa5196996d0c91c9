"""The command ``mbcdm loop``: reads, vets, closes the loop, prints and writes."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.measurement.reading import MeasurementFile, load_file, read_run
from mbcdm_cad.measurement.run import Run, VettingNote, doubts
from mbcdm_cad.measurement.vet import arranged, refusals, vet
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.storage.files import write_whole

REPORT_PAGE, REPORT_JSON = REPORT_FILES = ("report.html", "result.json")


@dataclass(frozen=True, eq=False)
class Vetted:
    """A run that can be judged: what it was read from, what its reading met, what was found of it."""

    file: MeasurementFile
    run: Run
    notes: tuple[str, ...]
    findings: tuple[VettingNote, ...]

    @property
    def doubts(self) -> list[str]:
        """What speaks against taking the finding at its word."""
        return doubts(self.notes, self.findings)


@dataclass(frozen=True)
class Outputs:
    """Files to write: the result as JSON, the design as built, and the folder of the report page; None for none."""

    json: Path | None = None
    as_built: Path | None = None
    report: Path | None = None


def loop_command(loaded: LoadedDesign, measurements: Sequence[Path], wanted: Outputs) -> int:
    """Judge the runs together. 0 when they could be judged; bad input raises InputError with all that is wrong."""
    files = [load_file(path) for path in measurements]
    _refuse_outputs(loaded, files, wanted)
    if any(file.content.published is not None for file in files):
        return _published(loaded, files, wanted)
    drive = _drive_of(loaded, files)
    if drive is None and wanted.as_built is not None:
        remedy = "leave --apply out, or judge runs of the design"
        raise InputError([files[0].problem(("ratio",), "a drive of its own, not the design's", remedy=remedy)])
    vetted = _vetted(files, drive)
    from mbcdm_cad.identification.engine import (
        close_loop,  # the model and its compiled parts, once the input is known to be good
    )
    from mbcdm_cad.identification.result import result_text

    try:
        result = close_loop(drive, [one.run for one in vetted])
    except ModelError as error:
        names = ", ".join(str(file.path) for file in files)
        raise MbcdmError(f"{names}: the declared model cannot follow the run: {error}") from None
    click.echo(result_text(result, [f"doubt: {words}" for one in vetted for words in one.doubts]))
    for one in vetted:
        click.echo("")
        click.echo("\n".join(vetting_lines(one)))
    content = {**result.to_json(), "design": _design(loaded, drive), "runs": [_run_json(one) for one in vetted]}
    outputs, applied = {} if wanted.json is None else {wanted.json: json_bytes(content)}, ""
    if wanted.as_built is not None:
        from mbcdm_cad.identification.as_built import applied_words, as_built_text

        text = as_built_text(loaded, result, ", ".join(one.run.source for one in vetted))
        outputs[wanted.as_built] = text.encode()
        applied = applied_words(result)
    if wanted.report is not None:
        from mbcdm_cad.identification.report import report_page

        page = report_page(result, _design(loaded, drive), [(one.run, one.findings, one.notes) for one in vetted])
        outputs |= {wanted.report / REPORT_PAGE: page, wanted.report / REPORT_JSON: json_bytes(content)}
    write_whole(outputs)
    for path in outputs:
        click.echo(f"{path} written" + (f": {applied}" if path == wanted.as_built else ""))
    return 0


def vetting_lines(one: Vetted) -> list[str]:
    """What the run is and what it can tell, one sentence a line, doubts first."""
    lines = [f"{one.file.path}: {one.run.time_s.size} samples of {one.run.source}"]
    lines += [f"  doubt: {words}" for words in one.doubts]
    return lines + [f"  run: {finding}" for finding in one.findings if finding.level == "fact"]


def json_bytes(content: dict[str, Any]) -> bytes:
    """JSON text; what is no number is null."""
    return (json.dumps(_finite(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_finite(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value


def _drive_of(loaded: LoadedDesign, files: Sequence[MeasurementFile]) -> Drive | None:
    """The drive that all runs are of; None for one of which only the ratio is known."""
    first = files[0].content.ratio
    for file in files[1:]:
        if file.content.ratio != first:
            remedy = "judge runs of one drive together, each with the same ratio or none"
            value, limit = (str(v) if v else "none" for v in (file.content.ratio, first))
            what = f"another ratio than in {files[0].path}"
            raise InputError([file.problem(("ratio",), what, value, limit, remedy=remedy)])
    return loaded.drive if first is None else None


def _vetted(files: Sequence[MeasurementFile], drive: Drive | None) -> list[Vetted]:
    """All runs, read and vetted. Raises InputError with the refusals of all of them."""
    vetted: list[Vetted] = []
    problems = []
    for file in files:
        reading = read_run(file)
        run = reading.run if drive is None else arranged(reading.run, drive)
        findings = vet(run, drive)
        problems += [file.problem(f.field, f.text, remedy=f.remedy) for f in refusals(findings)]
        for one in vetted:
            if one.run.sha256 == run.sha256:
                what, remedy = f"the same data as {one.file.path}", "give each run once: twice the same proves nothing"
                problems.append(file.problem(("data",), what, run.source, remedy=remedy))
        vetted.append(Vetted(file, run, reading.notes, tuple(findings)))
    if problems:
        raise InputError(problems)
    return vetted


def _published(loaded: LoadedDesign, files: Sequence[MeasurementFile], wanted: Outputs) -> int:
    """Figures of a paper: no search, what could explain them."""
    from mbcdm_cad.paper.published import judge_published

    if len(files) > 1 or wanted.as_built is not None:
        remedy = "give it alone, without --apply"
        wrong = next(file for file in files if file.content.published is not None)
        raise InputError([wrong.problem(("published",), "figures of a paper, not a run", remedy=remedy)])
    result = judge_published(loaded.drive, files[0])
    click.echo(result.text().rstrip())
    content = json_bytes(result.to_json())
    outputs = {} if wanted.json is None else {wanted.json: content}
    if wanted.report is not None:
        from mbcdm_cad.paper.published_page import published_page

        page = published_page(result, loaded.drive.name)
        outputs |= {wanted.report / REPORT_PAGE: page, wanted.report / REPORT_JSON: content}
    write_whole(outputs)
    for path in outputs:
        click.echo(f"{path} written")
    return 0


def _refuse_outputs(loaded: LoadedDesign, files: Sequence[MeasurementFile], wanted: Outputs) -> None:
    """An output must not take the place of an input or of another output, and needs a folder to be in."""
    taken = [("design file", loaded.path), *(("measurement file", file.path) for file in files)]
    data = [(file.path, file.content.data) for file in files if file.content.data]
    taken += [("data of " + path.name, path.parent / name) for path, name in data]
    outputs = [] if wanted.json is None else [("--json", wanted.json)]
    outputs += [] if wanted.as_built is None else [("--apply", wanted.as_built)]
    if wanted.report is not None:
        if wanted.report.exists() and not wanted.report.is_dir():
            remedy = "the report needs a folder; give another name"
            raise InputError([Problem(str(wanted.report), 1, "--report", "a file", remedy=remedy)])
        outputs += [("--report", wanted.report / name) for name in REPORT_FILES]
    problems = []
    for option, output in outputs:
        where = (str(output), 1, option)
        for word, path in taken:
            if _same_file(output, path):
                what = f"would overwrite the {word}, {path}"
                problems.append(Problem(*where, what, remedy="nothing was done; give another name"))
        if output.is_dir():
            problems.append(Problem(*where, "a folder, and a file is to be written", remedy="give another name"))
        there = next((folder for folder in output.parents if folder.exists()), Path())
        if not there.is_dir() or (option != "--report" and there != output.parent):
            what = f"there is no folder {output.parent}" if there.is_dir() else f"{there} is no folder"
            problems.append(Problem(*where, what, remedy="make it, or choose another path"))
        elif not os.access(there, os.W_OK):
            problems.append(Problem(*where, f"nothing may be written in {there}", remedy="choose another path"))
        taken.append((f"output of {option}", output))
    if problems:
        raise InputError(problems)


def _same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file, however they are spelt and linked, and whether or not it is there yet."""
    try:
        return one.resolve() == other.resolve() or (one.exists() and other.exists() and one.samefile(other))
    except (OSError, ValueError, RuntimeError):  # a path that leads nowhere, or round in a circle
        return False


def _design(loaded: LoadedDesign, drive: Drive | None) -> dict[str, str] | None:
    return None if drive is None else {"name": drive.name, "file": loaded.path.name, "sha256": loaded.sha256}


def _run_json(one: Vetted) -> dict[str, Any]:
    return {
        "file": one.file.path.name,
        "data": one.run.source,
        "sha256": one.run.sha256,
        "samples": one.run.time_s.size,
        "notes": list(one.notes),
        "findings": [{"kind": f.kind, "level": f.level, "text": f.text, "remedy": f.remedy} for f in one.findings],
    }
