"""Make the page of a built design as a separate stage; its curves and cables are computed once and kept."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import markupsafe

from mbcdm_cad.model.capability import requirements
from mbcdm_cad.model.si import to_si
from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg
from mbcdm_cad.report.duty import duty_shown
from mbcdm_cad.report.life import life_shown
from mbcdm_cad.report.losses import losses_shown
from mbcdm_cad.report.page import content
from mbcdm_cad.report.page.scene import Lines, Scene, cable_lines, design_scene
from mbcdm_cad.report.page.studies import studies
from mbcdm_cad.report.page.template import page_environment
from mbcdm_cad.report.preload import preload_shown
from mbcdm_cad.storage.keys import content_key, package_hash
from mbcdm_cad.storage.manifest import versions
from mbcdm_cad.workshop.drawings import ASSEMBLY

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.storage.cache import Cache
    from mbcdm_cad.workshop.store import StoredPart


@dataclass(frozen=True)
class PageFigures:
    """Content of the page that needs no drawn part: curves, cables over the travel, graph of the fields."""

    studies: Mapping[str, Any]
    lines: Lines
    graph: str


def page_figures(drive: Drive, fields: Sequence[Mapping[str, Any]], cache: Cache) -> PageFigures:
    """The figures of the page; ``fields`` as in the report."""
    paths_at = drive.layout.all_cable_paths
    lines, _ = cable_lines(paths_at, drive.half_travel_deg)
    return PageFigures(_studies(drive, cache), lines, fields_graph(drive.name, fields))


def page_of(
    drive: Drive,
    report: Mapping[str, Any],
    parts: Mapping[str, StoredPart],
    figures: PageFigures,
    drawings: Path | None = None,
) -> bytes:
    """``report.html`` of a design with the content of its report.json and its drawn parts.

    ``drawings``: the folder into which `mbcdm drawings` writes; its files are linked.
    """
    view = design_scene(drive, {name: part.files for name, part in parts.items()}, figures.lines)
    links = file_links(drive.name, parts)
    for sheet in sorted(drawings.glob("*.pdf")) if drawings else ():
        of = "" if sheet.stem == ASSEMBLY else sheet.stem
        if of in links:
            links[of].append(("drawing", f"../{sheet.parent.name}/{sheet.name}"))
    return report_page(report, view, figures.studies, figures.graph, links)


def _studies(drive: Drive, cache: Cache) -> dict[str, Any]:
    """The curves of the model, from the cache: they take seconds and depend only on what the model reads."""
    # The hash of the whole package is already known; that of the modules in use takes a second to compute.
    # As text, because limits that a drive does not have are infinite, which content_key refuses.
    read = [asdict(to_si(drive)), asdict(requirements(drive)), asdict(drive.loads), drive.layout.wraps_at_ends_rad]
    inputs = json.dumps(read, sort_keys=True, default=lambda array: array.tolist())
    key = content_key("studies", inputs, package_hash(), versions())
    kept = cache.get_or_make(key, lambda: {"studies": json.dumps(studies(drive)).encode()})
    found: dict[str, Any] = json.loads(kept["studies"])
    return found


def file_links(name: str, parts: Iterable[str]) -> dict[str, list[tuple[str, str]]]:
    """Files of the whole (key "") and of each part, by their place beside the page."""
    whole = [("STEP", f"{name}.step"), ("GLB", f"{name}.glb"), ("report.md", "report.md"), ("JSON", "report.json")]
    return {"": whole} | {part: [("STEP", f"parts/{part}.step"), ("STL", f"parts/{part}.stl")] for part in parts}


# Scripts in the order in which they run; those of the tables come first, so that they work before the 3D view is
# loaded.
_TABLE_SCRIPTS = ("charts.js", "graph.js", "tables.js")
_VIEW_SCRIPTS = ("decode.js", "tube.js", "section.js", "explode.js", "viewer.js", "pictures.js", "main.js")
THREE = "vendor/three.min.js"
THREE_SHA256 = "983d954c5638a41e1513090773dd87ebf75c63e539c2f46b6856feee58d4479a"  # printed by vendor/make.sh
LICENCE = "vendor/three-LICENSE.txt"

Files = Mapping[str, Sequence[tuple[str, str]]]


def report_page(report: Mapping[str, Any], view: Scene, figures: Mapping[str, Any], graph: str, links: Files) -> bytes:
    """``report.html`` as UTF-8.

    ``report`` is the content of report.json, ``view`` and ``figures`` are from :func:`scene` and :func:`studies`,
    ``graph`` is from :func:`fields_graph`.
    ``links`` maps a part to (label, address) of its files, addresses relative to the page; the key "" holds those of
    the whole. The same input gives the same bytes.
    """
    text = (
        page_environment()
        .get_template("page.html.j2")
        .render(
            r=report,
            a=report["analysis"],
            scene=view.data,
            binary=base64.b64encode(view.binary).decode(),
            groups=content.groups(view.data),
            checks=content.sorted_checks(report["checks"]),
            counts=content.check_counts(report["checks"]),
            tightest=content.tightest(report["checks"]),
            capability=content.capability(report),
            speed_chart=content.speed_chart(report),
            losses=losses_shown(report["losses"]),
            life=life_shown(report["life"]),
            preload=preload_shown(report["preload"]),
            duty=duty_shown(report["duty"]),
            derived=content.derived(report, view.data["bodies"]),
            cables=content.cable_rows(report),
            limits=content.travel_limits(report),
            studies=figures,
            graph=markupsafe.Markup(graph),
            check_ids={check["id"] for check in report["checks"]},
            links=links,
            table_scripts=_TABLE_SCRIPTS,
            view_scripts=_VIEW_SCRIPTS,
            three=THREE,
            licence=LICENCE,
        )
    )
    return text.encode()


def fields_graph(design: str, fields: Sequence[Mapping[str, Any]]) -> str:
    """The graph of the report's ``fields`` as SVG; empty where no field has a rule."""
    graph = dependency_graph(fields)
    return dependency_svg(graph, f"{design}: dependencies of all values") if graph.nodes else ""
