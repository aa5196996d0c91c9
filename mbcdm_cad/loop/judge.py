"""Judge measured runs of one drive together: reading, vetting and the loop in one call, with its result.

The command line prints and writes it, the Python API returns it. A study file lists runs of one drive with their dates,
and what differs on purpose from run to run.
"""

from __future__ import annotations

import datetime
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.fields import Block, Number, Text, choice
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.yamltree import read_text
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.result import FIRST_FIELDS, LoopResult, result_text
from mbcdm_cad.measurement.file import MeasurementFile, load_file
from mbcdm_cad.measurement.schema import MOTION
from mbcdm_cad.measurement.vet import Vetted, vetted_runs, vetting_lines
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.report.table import TextReport, data_frame, preformatted
from mbcdm_cad.storage.cache import rounded

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.design.loader import LoadedDesign
    from mbcdm_cad.loop.correction import Correction


@dataclass(frozen=True, eq=False)
class LoopReport(TextReport):
    """``result`` of the loop on ``runs``, with the findings of their vetting.

    ``loaded`` is the design, None where none was given; ``drive`` is None where only the ratio of the runs' drive is
    known.
    """

    result: LoopResult
    runs: tuple[Vetted, ...]
    loaded: LoadedDesign | None
    drive: Drive | None

    @property
    def verdict(self) -> str:
        """One of "none", "explained", "partly_explained", "unknown", "not_testable"."""
        return self.result.verdict

    def text(self) -> str:
        """What ``mbcdm loop`` prints: the finding, the tables, and each run's vetting."""
        doubts = [f"doubt: {words}" for one in self.runs for words in one.doubts]
        parts = [result_text(self.result, doubts)]
        return "\n".join(parts + [line for one in self.runs for line in ("", *vetting_lines(one))])

    def _repr_html_(self) -> str:
        """For notebooks."""
        return preformatted(self.text())

    def design(self) -> dict[str, str] | None:
        """Name, file and hash of the design; None where the runs are of another drive."""
        if self.drive is None or self.loaded is None:
            return None
        return {"name": self.drive.name, "file": self.loaded.path.name, "sha256": self.loaded.sha256}

    def to_dict(self) -> dict[str, Any]:
        """The content of the result file, ready for JSON: a number that is not finite becomes None."""
        content = {**self.result.to_json(), "design": self.design(), "runs": [_run_json(one) for one in self.runs]}
        content["new_fields"] = [name for name in content if name not in FIRST_FIELDS]
        plain: dict[str, Any] = rounded(content)
        return plain

    @property
    def source(self) -> str:
        """Names of the runs' data."""
        return ", ".join(one.run.source for one in self.runs)

    def as_built_text(self) -> str:
        """The design file with the effects that were found in its list ``as_built``; nothing else of it changes.

        Raises ``MbcdmError`` where the runs are of another drive than the design's.
        """
        if self.drive is None or self.loaded is None:
            where = self.source if self.loaded is None else self.loaded.path
            raise MbcdmError(f"{where}: the runs are of a drive of their own, not of the design's")
        return as_built_text(self.loaded, self.result, self.source)

    @cached_property
    def correction(self) -> Correction | None:
        """The correction of the output angle for a controller, with its accuracy; None where the loop gives none."""
        return None if self.result.correction is None else self.result.correction()

    def correction_files(self) -> dict[str, bytes]:
        """The correction by file name: a table as CSV and JSON, and a C header; empty where there is none."""
        from mbcdm_cad.loop.correction import correction_files

        if self.correction is None:
            return {}
        of = self.source if self.loaded is None else f"{self.loaded.path.name} and {self.source}"
        return correction_files(self.correction, of)

    def page(self) -> bytes:
        """The page with plots, as ``mbcdm loop --report`` writes it: HTML that needs no other file."""
        from mbcdm_cad.loop.page import report_page

        return report_page(self.result, self.design(), [(one.run, one.findings, one.notes) for one in self.runs])

    def to_pandas(self) -> pandas.DataFrame:
        """The candidates that were tried, one row each. ``MbcdmError`` without pandas."""
        rows = self.to_dict()["candidates"]
        columns = ("effect", "held_out_rad", "fall_rad", "outcome")
        return data_frame({name: [row[name] for row in rows] for name in columns})


def judge(
    loaded: LoadedDesign | None, files: Sequence[MeasurementFile], differs: Sequence[Sequence[str]] = ()
) -> LoopReport:
    """Read, vet and judge the runs together. Raises ``InputError`` with all that is wrong with the files.

    ``loaded``: the design; None for a drive of which the files state the ratio.
    ``differs``: for each run the fields of the design, or the effects, of which it has values of its own.
    """
    if not files:
        raise MbcdmError("no runs to judge; give at least one measurement file")
    published = [file for file in files if file.content.published is not None]
    if published:
        remedy = "judge it with 'mbcdm loop', alone"
        raise published[0].refusal(("published",), "figures of a paper, not a run", remedy=remedy)
    refuse_kinds(files, differs)
    drive = drive_of(loaded, files)
    vetted = vetted_runs(files, drive)
    from mbcdm_cad.loop.search.engine import close_loop  # loads compiled code: only for valid input

    try:
        result = close_loop(drive, [one.run for one in vetted], differs)
    except ModelError as error:
        names = ", ".join(str(file.path) for file in files)
        raise MbcdmError(f"{names}: the declared model cannot follow the run: {error}") from None
    return LoopReport(result, tuple(vetted), loaded, drive)


def refuse_kinds(files: Sequence[MeasurementFile], differs: Sequence[Sequence[str]] = ()) -> None:
    """Raise ``InputError`` for runs of several kinds, and for tables that are declared to differ."""
    first = files[0].content.kind
    for file in files[1:]:
        if file.content.kind != first:
            remedy = "judge runs of one kind together; --apply writes what was found into the design for the rest"
            what = f"another kind of run than {files[0].path}"
            raise file.refusal(("kind",), what, file.content.kind, first, remedy=remedy)
    if first != MOTION and any(differs):
        remedy = "judge each run alone: what differs is told from runs of kind motion"
        raise files[0].refusal(("kind",), "declared to differ", first, MOTION, remedy=remedy)


def drive_of(loaded: LoadedDesign | None, files: Sequence[MeasurementFile]) -> Drive | None:
    """The drive that all runs are of; None for one of which only the ratio is known."""
    first = files[0].content.ratio
    for file in files[1:]:
        if file.content.ratio != first:
            remedy = "judge runs of one drive together, each with the same ratio or none"
            value, limit = (str(v) if v else "none" for v in (file.content.ratio, first))
            what = f"another ratio than in {files[0].path}"
            raise file.refusal(("ratio",), what, value, limit, remedy=remedy)
    if loaded is None and first is None:
        remedy = "give the design file before the measurement files, or --ratio"
        raise files[0].refusal(("ratio",), "neither a design nor a ratio", remedy=remedy)
    return loaded.drive if loaded is not None and first is None else None


def json_bytes(content: dict[str, Any]) -> bytes:
    """JSON text; a number that is not finite becomes null."""
    return (json.dumps(rounded(content), indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _run_json(one: Vetted) -> dict[str, Any]:
    return {
        "file": one.file.path.name,
        "data": one.run.source,
        "sha256": one.run.sha256,
        "samples": one.run.time_s.size,
        "notes": list(one.notes),
        "findings": [{"kind": f.kind, "level": f.level, "text": f.text, "remedy": f.remedy} for f in one.findings],
    }


_KIND = ("study file", "; docs/how-to/close-the-loop.md shows one")
MOST_RUNS, MOST_NAMES = 200, 8


class StudyRun(Block):
    """One run of a study."""

    run: Text = choice("measurement file of the run, relative to the study file", example="monday.yaml")
    date: datetime.datetime | datetime.date | None = choice(
        "day or time of the run, for a trend", default=None, example="2026-03-01"
    )
    differs: tuple[Text, ...] = choice(
        "fields of the design, or effects, of which this run has values of its own",
        default=(),
        max_length=MOST_NAMES,
        example="[rope.preload_N]",
    )


class StudyContent(Block):
    """Runs of one drive."""

    design: Text | None = choice(
        "design file, relative to the study file; for mbcdm trend, unless the runs state a ratio", default=None
    )
    differs: tuple[Text, ...] = choice(
        "the same for every run", default=(), max_length=MOST_NAMES, example="[rope.preload_N]"
    )
    limits: dict[str, Number] = choice(
        "figure of a field at which it is put right, in the unit of its name; without it the checks of the design",
        default={},
    )
    runs: tuple[StudyRun, ...] = choice("the runs, in the order of time", min_length=1, max_length=MOST_RUNS)


@dataclass(frozen=True)
class Study:
    """A study that was read: its file, content, and the measurement files of its runs."""

    path: Path
    content: StudyContent
    files: tuple[MeasurementFile, ...]

    @property
    def differs(self) -> tuple[tuple[str, ...], ...]:
        """What differs in each run."""
        return tuple(tuple(dict.fromkeys((*self.content.differs, *one.differs))) for one in self.content.runs)

    @property
    def dates(self) -> tuple[datetime.datetime, ...] | None:
        """Time of each run; None if not all runs have one."""
        given = [one.date for one in self.content.runs]
        if any(date is None for date in given):
            return None
        return tuple(_as_time(date) for date in given if date is not None)

    def problem(self, field: tuple[str | int, ...], what: str, value: str = "", *, remedy: str) -> InputError:
        """An error at one of its fields."""
        tree = yamltree.parse(read_text(self.path, *_KIND), str(self.path), *_KIND)
        name = ".".join(map(str, field))
        return InputError([Problem(str(self.path), tree.line_of(field), name, what, value, remedy=remedy)])


def is_study(path: Path) -> bool:
    """Whether a YAML file has a list of runs."""
    try:
        data = yamltree.parse(read_text(path, *_KIND), str(path), *_KIND).data
    except InputError:
        return False
    return isinstance(data, dict) and "runs" in data


def load_study(path: str | Path) -> Study:
    """The study of a file, with its measurement files read. Raises InputError with all mistakes."""
    path = Path(path)
    tree = yamltree.parse(read_text(path, *_KIND), str(path), *_KIND)
    try:
        content = StudyContent.model_validate(tree.data)
    except ValidationError as error:
        raise InputError(schema_problems(error, tree, str(path), lambda field: None)) from None
    study = Study(path, content, tuple(load_file(path.parent / one.run) for one in content.runs))
    dates = study.dates
    if dates is not None:
        back = next((k for k in range(1, len(dates)) if dates[k] < dates[k - 1]), None)
        if back is not None:
            when = str(content.runs[back].date)
            raise study.problem(("runs", back, "date"), "before the run above", when, remedy="list the runs in order")
    elif any(one.date is not None for one in content.runs):
        missing = next(k for k, one in enumerate(content.runs) if one.date is None)
        raise study.problem(("runs", missing), "no date, where others have one", remedy="give a date for every run")
    return study


def _as_time(date: datetime.date) -> datetime.datetime:
    """A time without zone; a day begins at midnight."""
    if isinstance(date, datetime.datetime):
        return date.astimezone(datetime.UTC).replace(tzinfo=None) if date.tzinfo else date
    return datetime.datetime.combine(date, datetime.time())
