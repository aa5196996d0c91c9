"""The page: template, styles, scripts and data joined into one file that needs no other file."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import markupsafe

from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg
from mbcdm_cad.report.duty import duty_shown
from mbcdm_cad.report.life import life_shown
from mbcdm_cad.report.losses import losses_shown
from mbcdm_cad.report.page import content
from mbcdm_cad.report.page.scene import Scene
from mbcdm_cad.report.page.template import page_environment
from mbcdm_cad.report.preload import preload_shown

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
