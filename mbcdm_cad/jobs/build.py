"""``mbcdm build``: checks, parts, assembly, interference, report; all files appear at once. And its page.

Pages and comparisons build those designs first that are not built yet.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbcdm_cad.checks.comparison import CheckResult, failed
from mbcdm_cad.checks.size import envelope_check, interference_check, mass_check, overhang_check, printed_walls_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import GeometryError, MbcdmError
from mbcdm_cad.layouts.check_design import run_checks
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import Item
from mbcdm_cad.report import comparison
from mbcdm_cad.report.check_report import BuildReport, CheckReport
from mbcdm_cad.report.explain import fields_data
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import comparison_page, page_figures, page_of
from mbcdm_cad.report.table import TextReport
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.cache import Cache, content_key
from mbcdm_cad.workshop.drawings import drawings_folder
from mbcdm_cad.workshop.export.files import with_description, with_note
from mbcdm_cad.workshop.interference import travel_poses
from mbcdm_cad.workshop.prints import overhang_mm2, thinnest_wall
from mbcdm_cad.workshop.store import Progress, Store, StoredPart, drawn, exported_parts, made_parts, refuse_angle

if TYPE_CHECKING:
    import pandas


POSES = 9


def build(
    loaded: LoadedDesign,
    out: Path,
    *,
    angle_deg: float = 0.0,
    force: bool = False,
    cache: Cache,
    jobs: int | None = None,
    progress: Progress = lambda name: None,
) -> BuildReport:
    """Build a design into ``out/<name>``, the assembly drawn with the drum at ``angle_deg``.

    A design that fails a check is refused unless ``force``; then every file says so. Nothing is written if nothing has
    changed. Raises ``MbcdmError`` for an angle beyond the travel, for a part that cannot be drawn, and where the system
    refuses to write.
    """
    drive = loaded.drive
    refuse_angle(drive, angle_deg)
    target = out / drive.name
    inputs = content_key("build", (loaded.sha256, angle_deg, force))
    manifest = folders.read_manifest(target)
    if manifest is not None and manifest.inputs_sha256 == inputs and not folders.altered_files(target, manifest):
        kept = json.loads((target / "report.json").read_text("utf-8"))
        kept_checks = tuple(CheckResult(**check) for check in kept["checks"])
        return replace(_outcome(loaded, target, kept_checks, kept), unchanged=True)
    folders.refuse_other_origin(target, loaded.path)

    checks = run_checks(loaded)
    if failed(checks) and not force:
        return _outcome(loaded, None, checks)
    layout = layout_of(drive)
    processes = jobs or os.cpu_count() or 1
    store = Store(cache, progress)
    posed, centred = layout.bill(angle_deg), layout.bill()
    poses = tuple(sorted({*travel_poses(drive.half_travel_deg, POSES), *layout.passing_deg}))
    # Imported here, so that a build that has nothing to do starts fast.
    from mbcdm_cad.report import data as reported

    figures: reported.DesignFigures | None = None

    def prepared() -> None:
        from mbcdm_cad.workshop.separation import prepare

        nonlocal figures
        prepare()
        figures = reported.design_figures(layout, centred)

    try:
        parts = made_parts(store, posed, drive.export.mesh_tolerance_mm, processes, prepared)
        clashes, frame = store.judged(layout, parts, poses, processes, () if failed(checks) else posed.items)
    except GeometryError as error:
        why = "the checks did not foresee it, so please report the design file"
        if names := ", ".join(check.id for check in failed(checks)):
            why = f"the design was drawn although checks fail ({names}): their messages name the changes needed"
        raise GeometryError(f"{error}; {why}") from error

    tested = reported.Tested(clashes, poses, frame)
    data = reported.report_data(
        layout, centred, parts, tested, drum_angle_deg=angle_deg, design_sha256=loaded.sha256, figures=figures
    )
    checks = (
        *checks,
        mass_check(drive, data["mass"]["mass_g"], data["mass"]["sigma_g"]),
        envelope_check(drive, data["envelope"]["size_mm"]),
        interference_check(drive, clashes),
        *_printing_checks(drive, centred.items, parts),
    )
    failing = failed(checks)
    if failing and not force:
        return replace(_outcome(loaded, None, checks, data, store.made), cache_problem=cache.problem)
    data |= reported.checks_data(checks) | fields_data(loaded)
    manifest = folders.Manifest(loaded.sha256, inputs, forced=bool(failing), failed_checks=tuple(c.id for c in failing))
    files = exported_parts(store, posed, parts, drive, processes)
    note = f"FORCED, fails {', '.join(manifest.failed_checks)}" if failing else ""
    assembly = store.assembly(posed.items, parts, drive.name, note)
    # An old page would show other figures than the new report; `mbcdm page` makes a new one.
    with folders.output_folder(target, manifest, design=loaded.path, without=PAGE) as folder:
        for part, made in files.items():
            step, stl = made.files.step, made.files.stl
            if note:
                step, stl = with_description(step.decode(), note).encode(), with_note(stl, part, note)
            folder.write(f"parts/{part}.step", step)
            folder.write(f"parts/{part}.stl", stl)
        folder.write(f"{drive.name}.step", assembly["step"])
        folder.write(f"{drive.name}.glb", assembly["glb"])
        folder.write("report.json", json.dumps(data, indent=1, sort_keys=True, allow_nan=False) + "\n")
        folder.write("report.md", reported.report_markdown(data, layout.paths_template()))
    return replace(_outcome(loaded, target, checks, data, store.made), cache_problem=cache.problem)


def _printing_checks(drive: Drive, items: Sequence[Item], parts: dict[str, StoredPart]) -> list[CheckResult]:
    """Checks of the meshes of printed parts; empty if nothing is printed."""
    printed = {item.part: item.material for item in items if item.kind == "made" and item.material.printed}
    walls = []
    for name, material in printed.items():
        wall = thinnest_wall(parts[name].files.mesh)
        if wall is not None:
            where = ", ".join(f"{v:.1f}" for v in wall.at_mm)
            walls.append((name, wall.thickness_mm, material.min_wall_mm, f"({where})"))
    filament = {
        name: overhang_mm2(parts[name].files.mesh) for name, metal in printed.items() if metal.process == "printed"
    }
    return [
        *([printed_walls_check(drive, walls)] if walls else []),
        *([overhang_check(drive, filament)] if filament else []),
    ]


def _outcome(
    loaded: LoadedDesign,
    folder: Path | None,
    checks: Sequence[CheckResult],
    data: dict[str, Any] | None = None,
    made: Sequence[str] = (),
) -> BuildReport:
    name = loaded.drive.name
    return BuildReport(name, folder, CheckReport(name, loaded.sha256, tuple(checks)), data, tuple(made))


@dataclass(frozen=True)
class PageReport(TextReport):
    """The page at ``path`` of ``size`` bytes; ``path`` is None where the ``build`` was refused."""

    build: BuildReport
    path: Path | None = None
    size: int = 0

    @property
    def passed(self) -> bool:
        """Whether the page was written and no check fails."""
        return self.path is not None and self.build.passed

    def text(self) -> str:
        """What ``mbcdm page`` prints."""
        if self.path is None:
            return self.build.text()
        return f"{self.path}: {self.size / 1e6:.1f} MB, opens in any browser, needs no network"


def write_page(loaded: LoadedDesign, out: Path, cache: Cache, *, force: bool, progress: Progress) -> PageReport:
    """Write ``out/<name>/report.html``; a design that fails a check has a page only with ``force``."""
    report = build(loaded, out, force=force, cache=cache, progress=progress)
    if report.folder is None or report.data is None:
        return PageReport(report)
    _, parts = drawn(loaded.drive, 0.0, cache, progress)
    progress("page")
    figures = page_figures(loaded.drive, report.data["fields"], cache)
    page = page_of(loaded.drive, report.data, parts, figures, drawings_folder(out, loaded.drive.name))
    target = report.folder / PAGE
    folders.write_whole({target: page})
    return PageReport(report, target, len(page))


_VIEW, _PICTURE_PX = "output", (900, 720)


@dataclass(frozen=True)
class ComparisonReport(TextReport):
    """Figures of several built designs, in the order in which they were given."""

    designs: tuple[comparison.ComparedDesign, ...]

    def text(self) -> str:
        """What ``mbcdm compare`` prints: one column a design."""
        return "\n".join([*comparison.comparison_table(self.designs).text(), *comparison.torque_notes(self.designs)])

    def markdown(self) -> str:
        """The same table in Markdown."""
        notes = [f"\n{note}" for note in comparison.torque_notes(self.designs)]
        return "\n".join([*comparison.comparison_table(self.designs).markdown(), *notes])

    def html(self) -> str:
        """For notebooks."""
        return comparison.comparison_table(self.designs).html()

    def to_dict(self) -> list[dict[str, Any]]:
        """Plain data, one record a design; units stand in the names."""
        return comparison.comparison_data(self.designs)

    def to_pandas(self) -> pandas.DataFrame:
        """One row a design. Raises ``MbcdmError`` where pandas is not installed."""
        from mbcdm_cad.report.table import data_frame

        rows = self.to_dict()
        return data_frame({name: [row[name] for row in rows] for name in rows[0]})


def compare(
    designs: Sequence[LoadedDesign],
    out: Path,
    cache: Cache,
    *,
    page: Path | None = None,
    jobs: int | None = None,
    progress: Progress,
) -> ComparisonReport:
    """Build what is not built yet in ``out`` and compare; with ``page`` also a page with pictures and plots.

    Swings are those at the smallest test torque of all. Designs that share a name are told apart by their files, and
    built in folders of their own. Raises ``MbcdmError`` for no design, and for one that fails a check.
    """
    if not designs:
        raise MbcdmError("no designs to compare; give at least one")
    if page is not None:
        folders.refuse_missing_folder(page)
    load = min(design.drive.loads.test_torque_Nm for design in designs)
    labels = comparison.distinct_labels([(design.drive.name, design.path) for design in designs])
    found = []
    for design, label in zip(designs, labels, strict=True):
        folder = out if label == design.drive.name else out / comparison.own_folder(label)
        report = build(design, folder, cache=cache, jobs=jobs, progress=progress)
        if report.folder is None or report.data is None:
            failed = ", ".join(check.id for check in report.checks.failed)
            raise MbcdmError(f"{design.path}: not compared, because it fails {failed}; see mbcdm check {design.path}")
        found.append(replace(comparison.compared(design.drive, report.data, load), name=label))
    if page is not None:
        folders.write_whole({page: _page(designs, found, cache, progress)})
    return ComparisonReport(tuple(found))


def _page(
    designs: Sequence[LoadedDesign], found: Sequence[comparison.ComparedDesign], cache: Cache, progress: Progress
) -> bytes:
    # Imported here because they load the drawing libraries, which the table does not need.
    from mbcdm_cad.workshop.export.picture import picture_png

    pictures = []
    for design in designs:
        items, parts = drawn(design.drive, 0.0, cache, progress)
        progress(f"picture of {design.drive.name}")
        meshes = {name: part.files.mesh for name, part in parts.items()}
        pictures.append(picture_png(items, meshes, _VIEW, _PICTURE_PX))
    return comparison_page(found, [design.drive for design in designs], pictures)
