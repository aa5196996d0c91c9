"""The page of a design, and the comparison of designs: those that are not built yet are built first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.jobs.build import build
from mbcdm_cad.report.check_report import BuildReport
from mbcdm_cad.report.comparison import (
    ComparedDesign,
    compared,
    comparison_data,
    comparison_table,
    distinct_labels,
    own_folder,
    torque_notes,
)
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import comparison_page, page_figures, page_of
from mbcdm_cad.report.table import TextReport
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.files import refuse_missing_folder, write_whole
from mbcdm_cad.workshop.drawings import drawings_folder
from mbcdm_cad.workshop.store import Progress, drawn

if TYPE_CHECKING:
    import pandas


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
    write_whole({target: page})
    return PageReport(report, target, len(page))


_VIEW, _PICTURE_PX = "output", (900, 720)


@dataclass(frozen=True)
class ComparisonReport(TextReport):
    """Figures of several built designs, in the order in which they were given."""

    designs: tuple[ComparedDesign, ...]

    def text(self) -> str:
        """What ``mbcdm compare`` prints: one column a design."""
        return "\n".join([*comparison_table(self.designs).text(), *torque_notes(self.designs)])

    def markdown(self) -> str:
        """The same table in Markdown."""
        notes = [f"\n{note}" for note in torque_notes(self.designs)]
        return "\n".join([*comparison_table(self.designs).markdown(), *notes])

    def _repr_html_(self) -> str:
        """For notebooks."""
        return comparison_table(self.designs).html()

    def to_dict(self) -> list[dict[str, Any]]:
        """Plain data, one record a design; units stand in the names."""
        return comparison_data(self.designs)

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
        refuse_missing_folder(page)
    load = min(design.drive.loads.test_torque_Nm for design in designs)
    labels = distinct_labels([(design.drive.name, design.path) for design in designs])
    found = []
    for design, label in zip(designs, labels, strict=True):
        folder = out if label == design.drive.name else out / own_folder(label)
        report = build(design, folder, cache=cache, jobs=jobs, progress=progress)
        if report.folder is None or report.data is None:
            failed = ", ".join(check.id for check in report.checks.failed)
            raise MbcdmError(f"{design.path}: not compared, because it fails {failed}; see mbcdm check {design.path}")
        found.append(replace(compared(design.drive, report.data, load), name=label))
    if page is not None:
        write_whole({page: _page(designs, found, cache, progress)})
    return ComparisonReport(tuple(found))


def _page(designs: Sequence[LoadedDesign], found: Sequence[ComparedDesign], cache: Cache, progress: Progress) -> bytes:
    # Imported here because they load the drawing libraries, which the table does not need.
    from mbcdm_cad.workshop.export.picture import picture_png

    pictures = []
    for design in designs:
        items, parts = drawn(design.drive, 0.0, cache, progress)
        progress(f"picture of {design.drive.name}")
        meshes = {name: part.files.mesh for name, part in parts.items()}
        pictures.append(picture_png(items, meshes, _VIEW, _PICTURE_PX))
    return comparison_page(found, [design.drive for design in designs], pictures)
