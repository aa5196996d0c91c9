"""Functions of the interface: read, find and compare designs; read, judge and plan measured runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mbcdm_cad.api.design import DriveDesign, Progress, cache_of, silent
from mbcdm_cad.errors import MbcdmError

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.jobs.build import ComparisonReport
    from mbcdm_cad.loop.judge import LoopReport
    from mbcdm_cad.loop.trend import TrendReport
    from mbcdm_cad.measurement.file import MeasurementFile
    from mbcdm_cad.measurement.reading import Reading
    from mbcdm_cad.measurement.run import Run
    from mbcdm_cad.optimising import Effort
    from mbcdm_cad.optimising.prices import Prices
    from mbcdm_cad.optimising.result import Optimum
    from mbcdm_cad.paper.published import PublishedResult
    from mbcdm_cad.paper.reproduce import PaperTable
    from mbcdm_cad.planning.best_run import NextRun
    from mbcdm_cad.report.catalogue_list import CatalogueList, Machine
    from mbcdm_cad.report.comparison import Sweep
    from mbcdm_cad.report.solve_report import SolveReport
    from mbcdm_cad.solving.question import Question


# Content of a new design file.
Form = Literal["short", "full", "reference"]


def load(path: str | Path) -> DriveDesign:
    """Read a design file. Raises ``InputError`` with file, line, value, limit and remedy of all mistakes."""
    from mbcdm_cad.layouts.loader import load_design

    return DriveDesign(load_design(path))


def reference_design(name: str = "mbcdm") -> DriveDesign:
    """The reference design of the paper, as ``mbcdm init --reference`` writes it, without a file."""
    return new_design(name, form="reference")


def new_design(name: str, configuration: str | None = None, *, form: Form = "short") -> DriveDesign:
    """A new design without a file, sized from the requirements that :func:`new_design_text` states; ``save`` it."""
    from mbcdm_cad.layouts.loader import load_text

    return DriveDesign(load_text(new_design_text(name, configuration, form=form), f"<{name}>"))


def new_design_text(name: str, configuration: str | None = None, *, form: Form = "short") -> str:
    """Text of a new design file, as ``mbcdm init`` writes it: the requirements, from which all other values follow.

    ``configuration``: the layout, by default miso_bevel. ``form`` "full" adds the derived values as comments,
    "reference" gives the reference design with all its values; a layout without sizing rules always gets that. Raises
    ``MbcdmError`` for a layout that there is not.
    """
    from mbcdm_cad.design.template import slug
    from mbcdm_cad.layouts.loader import DEFAULT, design_file, new_design_text, short_design_text

    of = configuration or DEFAULT
    if form == "reference" or (form == "short" and not design_file(of).starting):
        return new_design_text(slug(name), of)
    return short_design_text(slug(name), of, derived=form == "full")


def solve(
    design: DriveDesign | str | Path, *, jobs: int | None = None, progress: Callable[[str, int], None] | None = None
) -> SolveReport:
    """The nearest design that passes every check, or the requirements that exclude it, as ``mbcdm solve``.

    Changes only fields that the file leaves out or gives as a range (``{min: 30, max: 60}``, in the file ``design``).
    The result prints itself; its ``save`` writes the file that passes. ``progress`` is called with the stage and the
    number of designs tried, ``jobs`` is the number of processes. Raises ``InputError`` for mistakes that no search can
    correct, ``MbcdmError`` for a layout without sizing rules.
    """
    from mbcdm_cad.report.solve_report import solve_design

    return solve_design(_question(design), progress, jobs)


def optimise(
    designs: DriveDesign | str | Path | Iterable[DriveDesign | str | Path],
    aims: Sequence[str],
    out: str | Path = "out",
    *,
    keeps: Sequence[str] = (),
    free: Sequence[str] = (),
    only_free: bool = False,
    over: Literal["tolerances"] | None = None,
    beside: Iterable[DriveDesign | str | Path] = (),
    effort: Effort | None = None,
    progress: Callable[[str, int], None] | None = None,
) -> Optimum:
    """The best designs that pass every check, as ``mbcdm optimise``; writes ``out/NAME-optimum``.

    ``designs``: files of requirements, with ranges if wanted, one for each layout that shall compete. ``aims``: 1 to 4
    such as ``"mass_g:min"``; ``keeps`` such as ``"torque_Nm:>=3"``; ``free`` fields besides those that ``solve`` may
    change, such as ``"drum.material=aluminium,pa12"`` or ``"rope.preload_N=30..90"``; ``only_free``: no others.
    ``over="tolerances"`` takes of each figure what 95 % of the drives reach, as made; ``"swing_mrad_p95:min"`` takes it
    of one figure. ``beside``: designs to mark beside the front. The search ends when the front no longer grows, or when
    its :class:`Effort` is spent. ``progress`` is called with the best so far and the number of designs. Raises
    ``InputError`` for mistakes in a file, ``MbcdmError`` for wishes that the layouts cannot answer.
    """
    from mbcdm_cad.jobs.outputs import optimise
    from mbcdm_cad.optimising import Effort
    from mbcdm_cad.optimising.wishes import over_tolerances, wishes_of

    listed = [designs] if isinstance(designs, DriveDesign | str | Path) else list(designs)
    if over == "tolerances":
        aims, keeps = over_tolerances(aims), over_tolerances(keeps)
    elif over is not None:
        raise MbcdmError(f"over: no such spread (value {over}, limit tolerances)")
    wishes = wishes_of(aims, keeps, free, only_free=only_free)
    told = progress or (lambda words, count: None)
    others = [(one if isinstance(one, DriveDesign) else load(one)).loaded for one in beside]
    return optimise([_text_of(one) for one in listed], wishes, Path(out), effort or Effort(), told, others)


def prices(
    design: DriveDesign | str | Path,
    figures: Sequence[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Prices:
    """What each requirement of a design costs, as ``mbcdm prices``: the change of ``figures`` for one unit of it.

    Each number of the file is moved by 5 % both ways, and the design is solved again. Figures are those of
    :func:`optimise`; ``workers`` and ``scheduler`` are as in :class:`Effort`. Raises ``MbcdmError`` for a design that
    fails a check.
    """
    from threadpoolctl import threadpool_limits

    from mbcdm_cad.optimising import Effort
    from mbcdm_cad.optimising.prices import prices_of

    with threadpool_limits(1):
        effort = Effort(workers=workers, scheduler=scheduler)
        return prices_of(_question(design), figures, effort, progress or silent)


def _question(design: DriveDesign | str | Path) -> Question:
    from mbcdm_cad.solving.question import question_of

    return question_of(*_text_of(design))


def _text_of(design: DriveDesign | str | Path) -> tuple[str, Path]:
    """A design's file: its text and path."""
    from mbcdm_cad.design.yamltree import read_text

    if isinstance(design, DriveDesign):
        return design.loaded.text, design.loaded.path
    return read_text(Path(design)), Path(design)


def compare(
    designs: Iterable[DriveDesign | str | Path],
    out: str | Path = "out",
    *,
    page: str | Path | None = None,
    jobs: int | None = None,
    cache: bool = True,
    progress: Progress | None = None,
) -> ComparisonReport:
    """Built designs side by side, as ``mbcdm compare``; those that are not built in ``out`` yet are built first.

    ``page``: write a page with pictures and plots to this file. Raises ``MbcdmError`` for a design that fails a check.
    """
    from mbcdm_cad.jobs.build import compare

    found = [one if isinstance(one, DriveDesign) else load(one) for one in designs]
    where = None if page is None else Path(page)
    loaded = [one.loaded for one in found]
    return compare(loaded, Path(out), cache_of(cache), page=where, jobs=jobs, progress=progress or silent)


def analyse_many(design: DriveDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> Sweep:
    """Analyse many designs at once: ``ranges`` has an array for each field, with one value for each design.

    ``analyse_many(design, {"transmission.centre_distance_mm": np.linspace(34.6, 60.0, 1000)})["reversal_swing_mrad"]``
    is an array of 1000 backlashes. With ``grid`` all combinations of the values are analysed. Raises ``InputError`` for
    a value that is not valid in a design file, ``MbcdmError`` for arrays of different lengths.
    """
    from mbcdm_cad.report.comparison import sweep

    return sweep(design.loaded, ranges, grid=grid)


def reproduce(design: DriveDesign | None = None) -> PaperTable:
    """The paper's figures beside those of the model, as ``mbcdm reproduce``; for the reference design by default."""
    from mbcdm_cad.paper.reproduce import PaperTable, reproduce

    drive = (design or reference_design()).drive
    return PaperTable(drive.name, reproduce(drive))


def catalogue(kind: str | None = None) -> CatalogueList:
    """Ropes, motors, bearings and other parts of the catalogue, as ``mbcdm catalogue``; of one kind or of all.

    Values are in ``to_dict()``. Raises ``MbcdmError`` for a kind that there is not.
    """
    from mbcdm_cad.report.catalogue_list import CatalogueList

    return CatalogueList(kind)


def schema(configuration: str | None = None, *, measurement: bool = False) -> dict[str, Any]:
    """The JSON Schema of the design files of a layout (by default miso_bevel), or of measurement files.

    Raises ``MbcdmError`` for a layout that there is not.
    """
    from mbcdm_cad.design.describe import editor_schema
    from mbcdm_cad.layouts.loader import DEFAULT, design_file

    if measurement:
        from mbcdm_cad.measurement.schema import json_schema

        return json_schema()
    return editor_schema(design_file(configuration or DEFAULT).nodes)


def schema_page(configuration: str | None = None, *, measurement: bool = False) -> str:
    """The same fields as a page in Markdown: unit, bounds, source and meaning of each."""
    from mbcdm_cad.design.template import reference_page
    from mbcdm_cad.layouts.loader import DEFAULT, design_file

    if measurement:
        from mbcdm_cad.measurement.draft import measurement_page

        return measurement_page()
    return reference_page(design_file(configuration or DEFAULT).nodes)


def doctor(*, cache: bool = False) -> Machine:
    """Which programs and libraries this machine has, as ``mbcdm doctor``; takes some seconds.

    With ``cache`` every entry of the cache is read, and broken ones are removed.
    """
    from mbcdm_cad.report.catalogue_list import examine

    return examine(verify=cache)


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
    from mbcdm_cad.loop.judge import is_study, judge, load_study
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
    from mbcdm_cad.loop.judge import judge, load_study
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
    from mbcdm_cad.planning.best_run import next_run

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
    from mbcdm_cad.measurement.draft import draft_text
    from mbcdm_cad.measurement.roles import Expected

    if design is not None and ratio is None:
        return draft_text(Path(data), Expected.of_drive(design.drive))
    if design is None and ratio is not None:
        return draft_text(Path(data), Expected.of_ratio(ratio))
    raise MbcdmError("draft_measurement: give a design or the ratio, one of the two")
