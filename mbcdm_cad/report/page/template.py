"""Templates, styles and scripts that all pages share, and how figures and data are written into them."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
import markupsafe

from mbcdm_cad.design.describe import flow
from mbcdm_cad.report.page import content
from mbcdm_cad.report.table import designs_shown


@cache
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
    words: dict[str, Any] = {"words": lambda text: text.replace("_", " "), "flow": flow, "designs": designs_shown}
    environment.filters |= {"figure": _figure, "json": _json, **words}
    environment.globals |= {"asset": _asset, "table_of": content.legend_table}
    return environment


@cache
def _asset(name: str) -> Any:
    """Text of a file of this package, for the inside of a <style> or <script>."""
    folder = files("mbcdm_cad.report.page")
    path = folder / name if name.startswith("vendor/") else folder / "assets" / name
    return markupsafe.Markup(path.read_text("utf-8").replace("</script", "<\\/script"))


def _json(value: Any) -> Any:
    """JSON for the inside of a <script>, without characters that could end the element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, sort_keys=True)
    return markupsafe.Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


def _figure(value: Any, digits: int = 4) -> str:
    if value is None:
        return "–"
    if isinstance(value, list | tuple):
        return ", ".join(_figure(v, digits) for v in value)
    if isinstance(value, float | int):
        if value != 0 and abs(value) < 1e-9:
            value = 0.0  # rounding error of a sum that is zero
        text = f"{value:.{digits}g}"
        if "e" in text and 1e3 <= abs(value) < 1e7:
            text = f"{value:.0f}"
        return text.replace("-", "−")
    return str(value)
