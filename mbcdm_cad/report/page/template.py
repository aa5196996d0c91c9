"""What all pages share: templates, styles, scripts, and tables and bars prepared from the report's data."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
import markupsafe

from mbcdm_cad.design.describe import flow
from mbcdm_cad.model.equations import papers_test
from mbcdm_cad.report.table import chart, designs_shown

_RANK = {"fail": 0, "warn": 1, "pass": 2}
# Tolerance for rounding: a wall exactly at its limit may be computed as 1e-15 below it.
_ROUNDING = 1e-9


def used_share(check: Mapping[str, Any]) -> float | None:
    """The share of its limit that a check uses: 1 at the limit, more beyond it; None if there is no such ratio.

    It is the figure over an upper limit, or a lower limit over the figure.
    """
    actual, limit, margin = check["actual"], check["limit"], check["margin"]
    if actual is None or limit is None or margin is None or actual < 0.0 or limit < 0.0:
        return None
    upper = abs((limit - actual) - margin) <= abs((actual - limit) - margin)
    over, under = (actual, limit) if upper else (limit, actual)
    return float(over / under) if under > 0.0 else None


def sorted_checks(checks: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Checks as the page lists them: fails, warnings, then passes by the margin left; each with its ``used`` share."""
    rows: list[dict[str, Any]] = []
    for check in checks:
        margin = check["margin"]
        if margin is not None and abs(margin) < _ROUNDING:
            margin = 0.0
        rows.append({**check, "used": used_share(check), "margin": margin})

    def order(row: dict[str, Any]) -> tuple[int, float]:
        used = row["used"]
        return _RANK[row["status"]], -(used if used is not None else -1.0)

    return sorted(rows, key=order)


def check_counts(checks: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """How many checks fail, warn and pass."""
    return {status: sum(check["status"] == status for check in checks) for status in _RANK}


def tightest(checks: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    """The passing check that uses most of its limit."""
    rows = [row for row in sorted_checks(checks) if row["status"] == "pass" and row["used"] is not None]
    return rows[0] if rows else None


def derived(report: Mapping[str, Any], bodies: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Derived values: name, value with unit, and the values from which it follows."""
    a = report["analysis"]
    text = (
        page_environment()
        .overlay(autoescape=False)
        .get_template("derived.txt.j2")
        .render(
            r=report,
            a=a,
            bodies=bodies,
            structure=report["structure"],
            papers_test=papers_test(a["test"][0]["load_Nm"]),
            ends="; ".join(dict.fromkeys(way[0]["cause"] for _, way in travel_limits(report))) or "paths of the cables",
        )
    )
    rows = (line.split(" | ") for line in text.splitlines() if line)
    return [{"what": what, "value": value.replace("-", "−"), "from": source} for what, value, source in rows]


def speed_chart(report: Mapping[str, Any]) -> dict[str, Any] | None:
    """Torque at the drum over its speed, as a chart of the page; None where the motor's values are not known."""
    m = report["analysis"]["motor"]
    if not m:
        return None
    speeds = [point["drum_speed_deg_s"] for point in m["curve"]]
    lines = (("continuous", "continuous_Nm"), ("short-time", "peak_Nm"))
    drawn = [{"label": label, "x": speeds, "y": [point[key] for point in m["curve"]]} for label, key in lines]
    title = f"Torque at the drum over its speed, {m['bus_voltage_V']:g} V"
    return chart(title, ("speed of the drum", "deg/s"), ("torque", "N m"), drawn)


# Units at the end of a field's name, how they are shown, and the digits after the point.
_UNITS = {"mm": ("mm", 2), "deg": ("°", 1)}


def cable_rows(report: Mapping[str, Any]) -> dict[str, Any]:
    """The cables' table: every figure in mm or degrees that this configuration's paths have, lists as their range.

    Lists count if they hold a figure for each drum angle; others are points.
    """
    poses, model = len(report["paths"]["drum_angle_deg"]), {c["name"]: c for c in report["analysis"]["cables"]}
    paths = report["paths"]["cables"]
    columns = []
    for field, value in paths[0].items():
        stem, _, unit = field.rpartition("_")
        along_travel = isinstance(value, list) and len(value) == poses
        if unit in _UNITS and (along_travel or isinstance(value, float)):
            shown, digits = _UNITS[unit]
            columns.append((field, f"{stem.replace('_', ' ')} {shown}", digits))
    rows = []
    for path in paths:
        own = model[path["name"]]
        cells = [f"{own['preload_N']:g}", f"{own['total_ratio']:.6g}"]
        for field, _, digits in columns:
            value = path[field] if isinstance(path[field], list) else [path[field]]
            ends = (f"{end:.{digits}f}".replace("-", "−") for end in (min(value), max(value)))
            cells.append(" to ".join(dict.fromkeys(ends)))
        rows.append((path["name"], cells))
    return {"head": ["preload N", "total ratio", *(heading for _, heading, _ in columns)], "rows": rows}


def travel_limits(report: Mapping[str, Any]) -> list[tuple[str, Sequence[Mapping[str, Any]]]]:
    """Limits of the travel in each direction, nearest first; empty if the configuration gives none."""
    ways = [("Negative", report["paths"].get("limits_negative")), ("Positive", report["paths"].get("limits_positive"))]
    return [(name, way) for name, way in ways if way]


def groups(scene: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The list of parts: one entry for each body with its items by mass, then the cables."""
    found = []
    for body in scene["bodies"]:
        items = [item for item in scene["items"] if item["body"] == body["name"]]
        found.append({"name": body["name"], "ratio": body["ratio"], "turns": body["ratio"] != 0.0, "items": items})
    found.append({"name": "cables", "ratio": 0.0, "turns": False, "items": list(scene["cables"])})
    for group in found:
        group["items"] = sorted(group["items"], key=lambda item: (-item["mass_g"], item["name"]))
        group["mass_g"] = sum(item["mass_g"] for item in group["items"])
    return [group for group in found if group["items"]]


def legend_table(chart: Mapping[str, Any], rows: int = 9) -> dict[str, Any]:
    """A chart as a short table for screen readers; None if its lines have different abscissas."""
    lines = chart["lines"]
    if any(line["x"] != lines[0]["x"] for line in lines):
        return {"head": [], "rows": []}
    places = lines[0]["x"]
    chosen = sorted({round(k * (len(places) - 1) / (rows - 1)) for k in range(rows)})
    return {
        "head": [line["label"] for line in lines],
        "rows": [[places[k], *(line["y"][k] for line in lines)] for k in chosen],
    }


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
    words["figures"] = lambda values, between=", ": between.join(f"{value:.4g}" for value in values)
    environment.filters |= {"figure": _figure, "json": _json, **words}
    environment.globals |= {"asset": _asset, "table_of": legend_table}
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
