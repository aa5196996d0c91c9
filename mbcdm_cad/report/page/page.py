"""The page: template, styles, scripts and data joined into one file that needs nothing beside it."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
import markupsafe

from mbcdm_cad.design.describe import flow
from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg
from mbcdm_cad.report.page import content
from mbcdm_cad.report.page.scene import Scene

# Scripts in the order in which they run; the tables' own come first, so that they work before the 3D part has loaded.
_TABLE_SCRIPTS = ("charts.js", "graph.js", "tables.js")
_VIEW_SCRIPTS = ("decode.js", "tube.js", "section.js", "explode.js", "viewer.js", "pictures.js", "main.js")
THREE = "vendor/three.min.js"
THREE_SHA256 = "983d954c5638a41e1513090773dd87ebf75c63e539c2f46b6856feee58d4479a"  # printed by vendor/make.sh
LICENCE = "vendor/three-LICENSE.txt"

Files = Mapping[str, Sequence[tuple[str, str]]]


def report_page(report: Mapping[str, Any], view: Scene, figures: Mapping[str, Any], links: Files) -> bytes:
    """``report.html`` as UTF-8.

    ``report`` is the content of report.json, ``view`` and ``figures`` are from :func:`scene` and :func:`studies`.
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
            derived=content.derived(report, view.data["bodies"]),
            cables=content.cable_rows(report),
            limits=content.travel_limits(report),
            studies=figures,
            graph=_graph(report),
            check_ids={check["id"] for check in report["checks"]},
            links=links,
            table_scripts=_TABLE_SCRIPTS,
            view_scripts=_VIEW_SCRIPTS,
            three=THREE,
            licence=LICENCE,
        )
    )
    return text.encode()


def page_environment(*more: tuple[str, str]) -> jinja2.Environment:
    """Templates of all pages: those of this package, and of ``more`` (package, folder in it).

    They share ``parts.html.j2`` and the function ``asset``, which gives a script or the styles as they are.
    """
    folders = (("mbcdm_cad.report.page", "assets"), *more)
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(*folder) for folder in folders]),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    words = {"words": lambda text: text.replace("_", " "), "flow": flow}
    environment.filters |= {"figure": _figure, "json": _json, **words}
    environment.globals |= {"asset": _asset, "table_of": content.legend_table}
    return environment


def _graph(report: Mapping[str, Any]) -> Any:
    """The graph of the fields as SVG; empty where no field has a rule."""
    graph = dependency_graph(report["fields"])
    title = f"{report['design']}: what follows from what"
    return markupsafe.Markup(dependency_svg(graph, title)) if graph.nodes else ""


@cache
def _asset(name: str) -> Any:
    """A file of this package as it is, for the inside of a <style> or <script>."""
    folder = files("mbcdm_cad.report.page")
    path = folder / name if name.startswith("vendor/") else folder / "assets" / name
    return markupsafe.Markup(path.read_text("utf-8").replace("</script", "<\\/script"))


def _json(value: Any) -> Any:
    """JSON for the inside of a <script>: no sign that could end it."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return markupsafe.Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


def _figure(value: Any, digits: int = 4) -> str:
    if value is None:
        return "–"
    if isinstance(value, list | tuple):
        return ", ".join(_figure(v, digits) for v in value)
    if isinstance(value, float | int):
        if value != 0 and abs(value) < 1e-9:
            value = 0.0  # rounding of a sum that comes to nothing
        text = f"{value:.{digits}g}"
        if "e" in text and 1e3 <= abs(value) < 1e7:
            text = f"{value:.0f}"
        return text.replace("-", "−")
    return str(value)
