"""Measured runs: read and draft them, close the loop on them, find the next one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbcdm_cad.api.design import DriveDesign

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.loop.judge import LoopReport
    from mbcdm_cad.loop.trend import TrendReport
    from mbcdm_cad.measurement.file import MeasurementFile
    from mbcdm_cad.measurement.reading import Reading
    from mbcdm_cad.measurement.run import Run
    from mbcdm_cad.paper.published import PublishedResult
    from mbcdm_cad.planning.next_run import NextRun


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """One measured run, read from its measurement file: ``run`` in SI units, and ``notes`` of the reader."""

    file: MeasurementFile
    reading: Reading

    @property
    def run(self) -> Run:
        """Samples in SI units: ``time_s``, ``input_rad``, ``output_rad``, ``load_Nm``."""
        return self.reading.run

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about peculiarities of the file that the reader found."""
        return self.reading.notes

    def to_dict(self) -> dict[str, Any]:
        """Columns as lists: time, each input, output, and load and temperature if they were logged."""
        return {name: column.tolist() for name, column in self._columns().items()}

    def to_pandas(self) -> pandas.DataFrame:
        """One row for each sample. Raises ``MbcdmError`` without pandas."""
        from mbcdm_cad.report.table import data_frame

        return data_frame(self._columns())

    def _columns(self) -> dict[str, Any]:
        run = self.run
        columns = {"time_s": run.time_s}
        columns |= {f"input_{name}_rad": row for name, row in zip(run.input_names, run.input_rad, strict=False)}
        columns["output_rad"] = run.output_rad
        optional = {"load_Nm": run.load_Nm, "temperature_C": run.temperature_C}
        return columns | {name: column for name, column in optional.items() if column is not None}

    def __repr__(self) -> str:
        """File, number of samples, duration."""
        run = self.run
        length = run.time_s[-1] - run.time_s[0]
        return f"<MeasuredRun {self.file.path}: {run.time_s.size} samples over {length:.4g} s>"


def load_run(path: str | Path) -> MeasuredRun:
    """Read a measurement file (YAML) and its data. Raises ``InputError`` with file, line and remedy."""
    from mbcdm_cad.measurement.file import load_file
    from mbcdm_cad.measurement.reading import read_run

    file = load_file(path)
    return MeasuredRun(file, read_run(file))


def close_loop(
    design: DriveDesign | None,
    runs: MeasuredRun | str | Path | Iterable[MeasuredRun | str | Path],
    *,
    ratio: float | None = None,
) -> LoopReport:
    """Find effects that the model of ``design`` lacks, from all measured runs together, as ``mbcdm loop``.

    ``runs``: runs or paths of measurement files, or the path of one study file, whose runs may have values of their
    own. Without a design the runs state their drive's ratio, or ``ratio`` does: then only what hangs on no cable can be
    found. Raises ``InputError`` with all mistakes in them.
    """
    from mbcdm_cad.loop.judge import judge
    from mbcdm_cad.loop.study import is_study, load_study
    from mbcdm_cad.measurement.file import load_file, with_ratio

    loaded = None if design is None else design.loaded
    listed = [runs] if isinstance(runs, MeasuredRun | str | Path) else list(runs)
    if len(listed) == 1 and not isinstance(listed[0], MeasuredRun) and is_study(Path(listed[0])):
        study = load_study(listed[0])
        return judge(loaded, [with_ratio(file, ratio) for file in study.files], study.differs)
    files = [one.file if isinstance(one, MeasuredRun) else load_file(one) for one in listed]
    return judge(loaded, [with_ratio(file, ratio) for file in files])


def trend(study: str | Path, design: DriveDesign | None = None) -> TrendReport:
    """How what differs from run to run changes from date to date, as ``mbcdm trend``: courses, odds, day at a limit.

    ``study``: the study file with the dates of its runs; ``design``: in place of the one that it names, if any. Raises
    ``InputError`` with all mistakes in the files, ``MbcdmError`` where dates, runs or figures that differ are missing.
    """
    from mbcdm_cad.api.designs import load
    from mbcdm_cad.loop.judge import judge
    from mbcdm_cad.loop.study import load_study
    from mbcdm_cad.loop.trend import refuse_no_trend, trends_of

    found = load_study(study)
    refuse_no_trend(found)
    if design is None:
        if found.content.design is not None:
            design = load(found.path.parent / found.content.design)
        elif any(file.content.ratio is None for file in found.files):
            remedy = "add design: my_drive.yaml, its path from the study file, or ratio to each measurement file"
            raise found.problem((), "no design", remedy=remedy)
    return trends_of(found, judge(None if design is None else design.loaded, found.files, found.differs))


def next_run(report: LoopReport) -> NextRun | None:
    """The experiment that best separates the effects between which the loop could not decide, as ``mbcdm loop --next``.

    None where no set of possible effects is left, or the runs are of another drive than the design's.
    """
    from mbcdm_cad.planning.next_run import next_run

    if report.drive is None:
        return None
    return next_run(report.drive, [one.run for one in report.runs], report.result)


def judge_published(design: DriveDesign, path: str | Path) -> PublishedResult:
    """Possible causes of a paper's figures, without a fit, as ``mbcdm loop`` on a file that holds such figures.

    Raises ``InputError`` for mistakes in the file, and for one that describes a run.
    """
    from mbcdm_cad.measurement.file import load_file
    from mbcdm_cad.paper.published import judge_published

    return judge_published(design.drive, load_file(path))


def draft_measurement(data: str | Path, design: DriveDesign | None = None, *, ratio: float | None = None) -> str:
    """Text of a first measurement file for a logger's CSV, as ``mbcdm measurement-init``; guesses are marked in it.

    ``ratio``: total ratio of a drive without a design, from the input's encoder to the output. Save the text beside the
    data. Raises ``InputError`` for data that cannot be read as a table, ``MbcdmError`` unless one of the two is given.
    """
    from mbcdm_cad.errors import MbcdmError
    from mbcdm_cad.measurement.draft import draft_text
    from mbcdm_cad.measurement.roles import Expected

    if design is not None and ratio is None:
        return draft_text(Path(data), Expected.of_drive(design.drive))
    if design is None and ratio is not None:
        return draft_text(Path(data), Expected.of_ratio(ratio))
    raise MbcdmError("draft_measurement: give a design or the ratio, one of the two")
