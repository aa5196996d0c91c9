"""The study file: runs of one drive with their dates, and what differs on purpose from run to run."""

import datetime
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.fields import Block, Number, Text, choice
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.yamltree import read_text
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement.file import MeasurementFile, load_file

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
