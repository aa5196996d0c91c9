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

from mbcdm_cad.report.page import content
from mbcdm_cad.report.page.scene import Scene

# Scripts in the order in which they run; the tables' own come first, so that they work before the 3D part has loaded.
_TABLE_SCRIPTS = ("charts.js", "tables.js")
_VIEW_SCRIPTS = ("decode.js", "tube.js", "section.js", "explode.js", "viewer.js", "main.js")
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
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.report.page", "assets"),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"figure": _figure, "json": _json, "words": lambda text: text.replace("_", " ")}
    text = environment.get_template("page.html.j2").render(
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
        table_of=content.legend_table,
        links=links,
        asset=_asset,
        table_scripts=_TABLE_SCRIPTS,
        view_scripts=_VIEW_SCRIPTS,
        three=THREE,
        licence=LICENCE,
    )
    return text.encode()


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
