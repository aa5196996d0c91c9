"""The public interface of the package, ``import mbcdm_cad as mc``. Names in ``__all__`` are stable, others may change.

    import mbcdm_cad as mc

    design = mc.load("my_drive.yaml")
    wider = design.with_(transmission__centre_distance_mm=36.0)
    print(wider.check())
    print(wider.analyse().figures.reversal_swing_mrad)
    wider.part("drum")                      # a cadquery solid
    wider.build("out")

Each call does the same as the command of the same name, with the same functions. Results print themselves, are shown
as tables in notebooks, and convert to plain data (``to_dict``) or, if pandas is installed, to frames (``to_pandas``).

The import is fast: the model, CAD and the loop are imported when they are first used.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbcdm_cad.errors import InputError, MbcdmError

if TYPE_CHECKING:
    import cadquery
    import pandas

    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.design.loaded import LoadedDesign
    from mbcdm_cad.loop.judge import LoopReport
    from mbcdm_cad.measurement.file import MeasurementFile
    from mbcdm_cad.measurement.reading import Reading
    from mbcdm_cad.measurement.run import Run
    from mbcdm_cad.report.analysis_report import AnalysisReport
    from mbcdm_cad.report.build_report import BuildReport
    from mbcdm_cad.report.check_report import CheckReport
    from mbcdm_cad.report.sized_designs import SizedDesigns
    from mbcdm_cad.report.sweep import Sweep

__all__ = [
    "load",
    "reference_design",
    "DriveDesign",
    "analyse_many",
    "size_many",
    "load_run",
    "MeasuredRun",
    "close_loop",
    "MbcdmError",
    "InputError",
]


@dataclass(frozen=True, eq=False)
class DriveDesign:
    """One design of a cable drive: the content of its file and all values that follow from it. Immutable.

    ``loaded`` is the file as read; ``drive`` contains the resolved values that the rest of the package uses.
    """

    loaded: LoadedDesign

    @property
    def name(self) -> str:
        """Name of the design and of its output folder."""
        return self.loaded.drive.name

    @property
    def drive(self) -> Drive:
        """All values, with the catalogue entries and the radii of every cable."""
        return self.loaded.drive

    def with_(self, changes: Mapping[str, Any] | None = None, /, **fields: Any) -> DriveDesign:
        """A design with some fields changed: ``with_(transmission__centre_distance_mm=36.0)``, or a nested mapping.

        An item of a list is named by its index from 0: ``cables__0__preload_N=65.0``. Raises ``InputError`` with the
        same messages as for the edited file.
        """
        from mbcdm_cad.layouts.changes import with_changes

        return DriveDesign(with_changes(self.loaded, {**(changes or {}), **fields}))

    def check(self) -> CheckReport:
        """Every check that needs no CAD, as ``mbcdm check``."""
        from mbcdm_cad.report.check_report import check_design

        return check_design(self.loaded)

    def analyse(self) -> AnalysisReport:
        """Tensions, backlash, load sharing, torque limits, cable paths, as ``mbcdm analyse``."""
        from mbcdm_cad.report.analysis_report import analyse_design

        return analyse_design(self.loaded.drive)

    def part_names(self) -> tuple[str, ...]:
        """Names of all parts."""
        from mbcdm_cad.build.solids import part_names

        return part_names(self.drive)

    def part(self, name: str) -> cadquery.Solid:
        """One part as a cadquery solid, in its own frame, mm. Raises ``MbcdmError`` for a name that no part has."""
        from mbcdm_cad.build.solids import part_solid

        return part_solid(self.drive, name)

    def assembly(self, angle_deg: float = 0.0) -> cadquery.Assembly:
        """All parts in place with the drum at ``angle_deg``. Raises ``MbcdmError`` for an angle beyond the travel."""
        from mbcdm_cad.build.solids import assembled

        return assembled(self.drive, angle_deg)

    def build(
        self, out: str | Path = "out", *, angle_deg: float = 0.0, force: bool = False, jobs: int | None = None
    ) -> BuildReport:
        """Write parts, assembly and report into ``out/NAME``, as ``mbcdm build``.

        A design that fails a check is built only with ``force``; otherwise the report's ``folder`` is None. Raises
        ``MbcdmError`` for an angle beyond the travel, or if the files cannot be written.
        """
        from mbcdm_cad.jobs.build import build
        from mbcdm_cad.storage.cache import Cache, cache_folder

        cache = Cache(cache_folder())
        return build(self.loaded, Path(out), angle_deg=angle_deg, force=force, cache=cache, jobs=jobs)

    def save(self, path: str | Path) -> None:
        """Write the design file; after ``with_`` it has no comments. Raises ``OSError`` if it cannot be written."""
        from mbcdm_cad.storage.files import write_whole

        write_whole({Path(path): self.loaded.text.encode("utf-8")})

    def __repr__(self) -> str:
        """Name and file."""
        return f"<DriveDesign {self.name} from {self.loaded.path}>"


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


def load(path: str | Path) -> DriveDesign:
    """Read a design file. Raises ``InputError`` with file, line, value, limit and remedy of all mistakes."""
    from mbcdm_cad.layouts.loader import load_design

    return DriveDesign(load_design(path))


def reference_design(name: str = "mbcdm") -> DriveDesign:
    """The reference design of the paper, as ``mbcdm init --reference`` writes it, without a file."""
    from mbcdm_cad.layouts.loader import load_text, new_design_text

    return DriveDesign(load_text(new_design_text(name), f"<{name}>"))


def analyse_many(design: DriveDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> Sweep:
    """Analyse many designs at once: ``ranges`` has an array for each field, with one value for each design.

    ``analyse_many(design, {"transmission.centre_distance_mm": np.linspace(34.6, 60.0, 1000)})["reversal_swing_mrad"]``
    is an array of 1000 backlashes. With ``grid`` all combinations of the values are analysed. Raises ``InputError`` for
    a value that is not valid in a design file, ``MbcdmError`` for arrays of different lengths.
    """
    from mbcdm_cad.report.sweep import sweep

    return sweep(design.loaded, ranges, grid=grid)


def size_many(design: DriveDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> SizedDesigns:
    """Size many designs from a file of requirements.

    ``size_many(design, {"loads.peak_torque_Nm": np.geomspace(0.5, 20.0, 1000)})["rope.type"]`` is an array of 1000
    ropes. Columns are the sized fields, and the figures of the cables as in :func:`analyse_many`; no checks run. For
    miso_bevel the fields are those before the frame (rope, motor, gearhead, bearings, radii, ratios, lead, centre
    distance, preload), up to ten thousand designs in a second; the other layouts are sized one by one with all fields,
    about twenty in a second. Raises as :func:`analyse_many`.
    """
    from mbcdm_cad.report.sized_designs import size_designs

    return size_designs(design.loaded, ranges, grid=grid)


def load_run(path: str | Path) -> MeasuredRun:
    """Read a measurement file (YAML) and its data. Raises ``InputError`` with file, line and remedy."""
    from mbcdm_cad.measurement.file import load_file
    from mbcdm_cad.measurement.reading import read_run

    file = load_file(path)
    return MeasuredRun(file, read_run(file))


def close_loop(design: DriveDesign, runs: MeasuredRun | str | Path | Iterable[MeasuredRun | str | Path]) -> LoopReport:
    """Find effects that the model of ``design`` lacks, from all measured runs together, as ``mbcdm loop``.

    ``runs``: runs or paths of measurement files. Raises ``InputError`` with all mistakes in them.
    """
    from mbcdm_cad.loop.judge import judge
    from mbcdm_cad.measurement.file import load_file

    listed = [runs] if isinstance(runs, MeasuredRun | str | Path) else list(runs)
    files = [one.file if isinstance(one, MeasuredRun) else load_file(one) for one in listed]
    return judge(design.loaded, files)
