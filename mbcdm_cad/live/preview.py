"""A preview of a design: draw its changed parts and make its page, before interference and frame are computed."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from mbcdm_cad.build.run import drawn
from mbcdm_cad.build.store import MadePart, Progress
from mbcdm_cad.checks.built import envelope_check, mass_check
from mbcdm_cad.configurations.check_design import run_checks
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.report.data import checks_data, report_data
from mbcdm_cad.report.explain import fields_data
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import page_of
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.files import write_whole


@dataclass(frozen=True)
class Preview:
    """The page as bytes, and the names of the parts whose files were written for it."""

    page: bytes
    written: tuple[str, ...]


class Previewer:
    """Draws one design after the other; a part is written when its content is not what was written last."""

    def __init__(self, folder: Path, cache: Cache) -> None:
        self._folder = folder
        self._cache = cache
        self._written: dict[str, str] = {}

    def preview(self, loaded: LoadedDesign, progress: Progress) -> Preview:
        """STEP and STL of each changed part in the folder, and the page.

        Raises ``MbcdmError`` for a part that cannot be drawn; ``progress`` may raise to give up in between.
        """
        drive = loaded.drive
        _, parts = drawn(drive, 0.0, self._cache, progress)
        written = self._write(parts)
        progress("page")
        kind = configuration(drive.configuration)
        dims = kind.layout(drive)
        data = report_data(dims, kind.bill(dims), parts, (), (), None, drum_angle_deg=0.0, design_sha256=loaded.sha256)
        checks = (
            *run_checks(loaded),
            mass_check(drive, data["mass"]["mass_g"], data["mass"]["sigma_g"]),
            envelope_check(drive, data["envelope"]["size_mm"]),
        )
        data |= checks_data(checks) | fields_data(loaded)
        return Preview(page_of(drive, data, parts, self._cache), written)

    def complete(self, loaded: LoadedDesign, built: Path, progress: Progress) -> bytes:
        """The page of a whole build in the folder ``built``, written there."""
        _, parts = drawn(loaded.drive, 0.0, self._cache, progress)
        data = json.loads((built / "report.json").read_text("utf-8"))
        page = page_of(loaded.drive, data, parts, self._cache)
        write_whole({built / PAGE: page}, durable=False)
        return page

    def _write(self, parts: dict[str, MadePart]) -> tuple[str, ...]:
        changed = {name: part for name, part in parts.items() if self._written.get(name) != part.key}
        for name, part in changed.items():
            stem = self._folder / "parts" / name
            write_whole(
                {stem.with_suffix(".step"): part.files.step, stem.with_suffix(".stl"): part.files.stl}, durable=False
            )
        self._written |= {name: part.key for name, part in changed.items()}
        return tuple(changed)
