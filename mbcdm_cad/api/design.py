"""One design as an object: what a script does with a design file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from mbcdm_cad.errors import MbcdmError

if TYPE_CHECKING:
    import cadquery

    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.design.loader import LoadedDesign
    from mbcdm_cad.jobs.build import PageReport
    from mbcdm_cad.jobs.outputs import SensitivityStudy, Written
    from mbcdm_cad.planning.best_run import BestRun
    from mbcdm_cad.planning.plan import RunPlan
    from mbcdm_cad.report.analysis_report import AnalysisReport
    from mbcdm_cad.report.check_report import BuildReport, CheckReport
    from mbcdm_cad.report.explain import Explanation
    from mbcdm_cad.report.preload import PreloadReport
    from mbcdm_cad.storage.cache import Cache

# Is called with the name of each item while it is made.
Progress = Callable[[str], None]


def silent(name: str) -> None:
    """Tell nobody."""


def cache_of(use: bool) -> Cache:
    """The cache of drawn parts; with ``use`` False one that is empty and keeps nothing."""
    from mbcdm_cad.storage.cache import Cache, cache_folder

    return Cache(cache_folder() if use else None)


@dataclass(frozen=True, eq=False)
class DriveDesign:
    """One design of a cable drive: the content of its file and all values that follow from it. Immutable.

    ``loaded`` is the file as read; ``drive`` contains the resolved values that the rest of the package uses.

    Methods that draw take their parts from the cache, unless ``cache`` is False; ``progress`` is called with the name
    of each item while it is made. Those that write into ``out`` use a folder with the design's name there, and raise
    ``MbcdmError`` if it holds the output of another design file of the same name, or cannot be written.
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
        """Every check that needs no CAD, with figure, limit, margin and remedy, as ``mbcdm check``."""
        from mbcdm_cad.report.check_report import check_design

        return check_design(self.loaded)

    def analyse(self) -> AnalysisReport:
        """Tensions, backlash, load sharing, torque limits, cable paths, as ``mbcdm analyse``."""
        from mbcdm_cad.report.analysis_report import analyse_design

        return analyse_design(self.loaded.drive, self.loaded.design.as_built)

    def preload(self, out: str | Path | None = None, *, logs: Mapping[str, str | Path] | None = None) -> PreloadReport:
        """Shares of the preload, and how the built drive measures its own, as ``mbcdm preload``.

        With ``out`` expected curves, a ramp in C and its evaluation in Python are written into ``out/NAME-preload``.
        ``logs``: for each input a CSV of its measured ramps (angle_rad, and torque_Nm on its shaft or motor_torque_Nm);
        the report then has the preloads found and the turns of the nuts. Raises ``MbcdmError`` for a log that does
        not do.
        """
        from mbcdm_cad.jobs.outputs import preload_of

        paths = {name: Path(path) for name, path in (logs or {}).items()}
        return preload_of(self.loaded, paths, None if out is None else Path(out))

    def explain(self, field: str | None = None) -> Explanation:
        """Why fields have their values, as ``mbcdm explain``: all that have a sizing rule, or one by its dotted name.

        Raises ``MbcdmError`` for a field that the design does not have.
        """
        from mbcdm_cad.report.explain import explain

        return explain(self.loaded, field)

    def explain_graph(self, svg: str | Path) -> Written:
        """Draw which field follows from which into an SVG file, as ``mbcdm explain --graph``.

        Raises ``InputError`` for another kind of file, ``MbcdmError`` for a layout without sizing rules.
        """
        from mbcdm_cad.jobs.outputs import write_dependencies

        return write_dependencies(self.loaded, Path(svg))

    def sensitivity(
        self, out: str | Path = "out", *, workers: int | None = None, scheduler: str | None = None
    ) -> SensitivityStudy:
        """Which parameters change backlash and torque most, as ``mbcdm sensitivity``; writes ``out/NAME-sensitivity``.

        Takes some seconds. ``workers`` and ``scheduler`` are as in :class:`Effort`; the result does not depend on them.
        Figures in the summary are in SI units.
        """
        from mbcdm_cad.jobs.outputs import write_sensitivity

        return write_sensitivity(self.loaded, Path(out), workers, scheduler)

    def part_names(self) -> tuple[str, ...]:
        """Names of all parts."""
        from mbcdm_cad.workshop.store import part_names

        return part_names(self.drive)

    def part(self, name: str) -> cadquery.Solid:
        """One part as a cadquery solid, in its own frame, mm. Raises ``MbcdmError`` for a name that no part has."""
        from mbcdm_cad.workshop.store import part_solid

        solid: cadquery.Solid = part_solid(self.drive, name)
        return solid

    def assembly(self, angle_deg: float = 0.0) -> cadquery.Assembly:
        """All parts in place with the drum at ``angle_deg``. Raises ``MbcdmError`` for an angle beyond the travel."""
        from mbcdm_cad.workshop.store import assembled

        whole: cadquery.Assembly = assembled(self.drive, angle_deg)
        return whole

    def build(
        self,
        out: str | Path = "out",
        *,
        angle_deg: float = 0.0,
        force: bool = False,
        jobs: int | None = None,
        cache: bool = True,
        progress: Progress | None = None,
    ) -> BuildReport:
        """Write parts, assembly and report into ``out/NAME``, as ``mbcdm build``; ``jobs``: number of processes.

        A design that fails a check is built only with ``force``; otherwise the report's ``folder`` is None. Raises
        ``MbcdmError`` for an angle beyond the travel.
        """
        from mbcdm_cad.jobs.build import build

        return build(
            self.loaded,
            Path(out),
            angle_deg=angle_deg,
            force=force,
            cache=cache_of(cache),
            jobs=jobs,
            progress=progress or silent,
        )

    def page(
        self, out: str | Path = "out", *, force: bool = False, cache: bool = True, progress: Progress | None = None
    ) -> PageReport:
        """Write ``out/NAME/report.html``, the drive in 3D with all figures, as ``mbcdm page``; builds first if needed.

        A design that fails a check has a page only with ``force``; otherwise the result's ``path`` is None.
        """
        from mbcdm_cad.jobs.build import write_page

        return write_page(self.loaded, Path(out), cache_of(cache), force=force, progress=progress or silent)

    def drawings(
        self,
        out: str | Path = "out",
        *,
        part: str | None = None,
        jobs: int | None = None,
        cache: bool = True,
        progress: Progress | None = None,
    ) -> Written:
        """Write the workshop drawings into ``out/NAME-drawings`` as DXF, PDF and SVG, as ``mbcdm drawings``.

        ``part``: only the sheet of this part. Raises ``MbcdmError`` for a part that the design does not make.
        """
        from mbcdm_cad.jobs.outputs import write_drawings

        return write_drawings(
            self.loaded, Path(out), cache_of(cache), part=part, jobs=jobs, progress=progress or silent
        )

    def prints(
        self,
        out: str | Path = "out",
        *,
        every_made_part: bool = False,
        cache: bool = True,
        progress: Progress | None = None,
    ) -> Written:
        """Write the parts of printed materials as 3MF files (mm) into ``out/NAME-prints``, as ``mbcdm prints``.

        ``every_made_part``: those that are milled or turned too. Raises ``MbcdmError`` if no part is printed.
        """
        from mbcdm_cad.jobs.outputs import write_prints

        return write_prints(
            self.loaded, Path(out), cache_of(cache), every_made_part=every_made_part, progress=progress or silent
        )

    def pictures(self, out: str | Path = "out", *, cache: bool = True, progress: Progress | None = None) -> Written:
        """Write a picture of each assembly step and others into ``out/NAME-pictures``, as ``mbcdm pictures``."""
        from mbcdm_cad.jobs.outputs import write_pictures

        return write_pictures(self.loaded, Path(out), cache_of(cache), progress or silent)

    def picture(
        self,
        png: str | Path,
        *,
        angle_deg: float = 0.0,
        view: str = "output",
        cache: bool = True,
        progress: Progress | None = None,
    ) -> Written:
        """Draw the assembly into a PNG file, as ``mbcdm picture``.

        ``view``: output, iso, iso_rear, front, rear, left, right, top or bottom. Raises ``InputError`` for another kind
        of file, ``MbcdmError`` for an angle beyond the travel or another view.
        """
        from mbcdm_cad.jobs.outputs import write_picture

        return write_picture(
            self.loaded, Path(png), cache_of(cache), angle_deg=angle_deg, view=view, progress=progress or silent
        )

    def moving_picture(
        self, gif: str | Path, *, view: str = "output", cache: bool = True, progress: Progress | None = None
    ) -> Written:
        """Draw the drum's travel into a GIF file, as ``mbcdm picture --travel``. Views and errors as of a picture."""
        from mbcdm_cad.jobs.outputs import write_moving_picture

        return write_moving_picture(self.loaded, Path(gif), cache_of(cache), view=view, progress=progress or silent)

    def export(
        self,
        form: Literal["urdf", "mjcf", "fmu"],
        out: str | Path = "out",
        *,
        elastic: bool = False,
        package: str | None = None,
        xacro: bool = False,
        ros2_control: bool = False,
        cache: bool = True,
        progress: Progress | None = None,
    ) -> Written:
        """Write the drive for robot simulators into ``out/NAME-FORM`` (SI units), as ``mbcdm export``.

        ``fmu`` is for co-simulation.

        ``elastic``: cables with their hysteresis, parts that give, motors, in MJCF only. In URDF only: ``package``, the
        ROS package that the meshes are in; ``xacro``, a macro with a prefix for all names; ``ros2_control``, a block
        for its controllers. Raises ``MbcdmError`` for what the format has not, or a name that no package has.
        """
        from mbcdm_cad.jobs.outputs import write_fmu, write_robot
        from mbcdm_cad.robot.mjcf import UrdfOptions

        if elastic and form != "mjcf":
            raise MbcdmError("elastic: URDF has no springs between joints, an FMU always; export mjcf")
        if form != "urdf" and (package is not None or xacro or ros2_control):
            raise MbcdmError("package, xacro, ros2_control: they belong to ROS, which reads URDF; export urdf")
        if form == "fmu":
            return write_fmu(self.loaded, Path(out))
        return write_robot(
            self.loaded,
            Path(out),
            cache_of(cache),
            form=form,
            elastic=elastic,
            options=UrdfOptions(package, xacro, ros2_control) if form == "urdf" else None,
            progress=progress or silent,
        )

    def simulate(self, experiment: str | Path, out: str | Path = "out") -> Written:
        """Run an experiment file on the test rig in software, as ``mbcdm simulate``; writes ``out/EXPERIMENT``.

        The folder holds the measurement file EXPERIMENT.yaml for :func:`close_loop`, its data, and the truth, which the
        loop does not read. Raises ``InputError`` for mistakes in the file, ``MbcdmError`` if the rig stops.
        """
        from mbcdm_cad.jobs.outputs import write_experiment

        return write_experiment(self.drive, Path(experiment), Path(out))

    def plan(self, experiment: str | Path, *, noise_from: str | Path | None = None) -> RunPlan:
        """What the run of an experiment file could find, as ``mbcdm plan``: the smallest size of each effect.

        ``noise_from``: the measurement file of a run whose noise is taken. Raises ``InputError`` for mistakes in the
        files, ``MbcdmError`` for a run that the model cannot follow.
        """
        from mbcdm_cad.jobs.outputs import plan_run

        return plan_run(self.drive, Path(experiment), None if noise_from is None else Path(noise_from))

    def best_run(
        self,
        bench: str | Path,
        *,
        experiment: str | Path | None = None,
        noise_from: str | Path | None = None,
        progress: Progress | None = None,
    ) -> BestRun:
        """The best run that a bench can make, as ``mbcdm plan --within``.

        ``bench``: file with the limits of the bench; ``experiment``: a run of your own to compare with. Raises as
        :meth:`plan`.
        """
        from mbcdm_cad.jobs.outputs import plan_within

        own, pilot = (None if path is None else Path(path) for path in (experiment, noise_from))
        return plan_within(self.drive, Path(bench), experiment=own, pilot=pilot, progress=progress or silent)

    def save(self, path: str | Path) -> None:
        """Write the design file; after ``with_`` it has no comments. Raises ``OSError`` if it cannot be written."""
        from mbcdm_cad.storage.folders import write_whole

        write_whole({Path(path): self.loaded.text.encode("utf-8")})

    def __repr__(self) -> str:
        """Name and file."""
        return f"<DriveDesign {self.name} from {self.loaded.path}>"
