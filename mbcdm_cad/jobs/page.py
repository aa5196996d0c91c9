"""The page of a design: builds it if that is not done yet, and writes ``report.html`` into the folder of the build."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.jobs.build import build
from mbcdm_cad.report.build_report import BuildReport
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import page_figures, page_of
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.files import write_whole
from mbcdm_cad.workshop.drawings import drawings_folder
from mbcdm_cad.workshop.made_parts import drawn
from mbcdm_cad.workshop.store import Progress


@dataclass(frozen=True)
class PageReport:
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

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()


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
