"""The page of a built design as a stage of its own: what its curves and cables rest on is made once and kept."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from mbcdm_cad.model.ratings import requirements
from mbcdm_cad.model.si import to_si
from mbcdm_cad.report.page.page import report_page
from mbcdm_cad.report.page.scene import design_scene
from mbcdm_cad.report.page.studies import studies
from mbcdm_cad.storage.keys import content_key, source_hash
from mbcdm_cad.storage.manifest import versions

if TYPE_CHECKING:
    from mbcdm_cad.build.store import MadePart
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.storage.cache import Cache

PAGE = "report.html"


def page_of(drive: Drive, report: Mapping[str, Any], parts: Mapping[str, MadePart], cache: Cache) -> bytes:
    """``report.html`` of a design with the content of its report.json and its drawn parts."""
    view = design_scene(drive, {name: part.files for name, part in parts.items()})
    return report_page(report, view, _studies(drive, cache), file_links(drive.name, parts))


def _studies(drive: Drive, cache: Cache) -> dict[str, Any]:
    """The curves of the model take seconds and change only with what the model reads, so they are kept."""
    # As text, since limits that a drive does not have stand as infinity, which content_key refuses.
    read = [asdict(to_si(drive)), asdict(requirements(drive)), asdict(drive.loads)]
    inputs = json.dumps(read, sort_keys=True, default=lambda array: array.tolist())
    key = content_key("studies", inputs, source_hash("mbcdm_cad.report.page.studies"), versions())
    kept = cache.get_or_make(key, lambda: {"studies": json.dumps(studies(drive)).encode()})
    found: dict[str, Any] = json.loads(kept["studies"])
    return found


def file_links(name: str, parts: Iterable[str]) -> dict[str, list[tuple[str, str]]]:
    """Files of the whole (key "") and of each part, by their place beside the page."""
    whole = [("STEP", f"{name}.step"), ("GLB", f"{name}.glb"), ("report.md", "report.md"), ("JSON", "report.json")]
    return {"": whole} | {part: [("STEP", f"parts/{part}.step"), ("STL", f"parts/{part}.stl")] for part in parts}
