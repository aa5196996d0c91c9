"""What all pages share: templates, styles, scripts, and tables and bars prepared from the report's data."""

from __future__ import annotations

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
CAUSES = {
    "motor": "motor's rated torque, without losses",
    "motor_with_losses": "motor's rated torque, all losses counted",
    "gearhead_rated": "gearhead's continuous rating",
    "gearhead_maximum": "gearhead's intermittent rating",
    "motor_alone": "motor's continuous torque",
    "motor_alone_peak": "motor's torque at its peak current",
    "strength": "tension limit of a cable",
    "slack": "a cable goes slack",
    "slip": "the cable slips on its input",
}


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


def capability(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Torque limits by cause in both directions, N m; None if a cause sets no limit."""
    rows: dict[str, dict[str, Any]] = {}
    names = CAUSES | ({"gearhead_rated": "torque that the first stage is made for"} if "stages" in report else {})
    for limit in report["analysis"]["limits"]:
        if "stages" in report and limit["cause"] == "gearhead_maximum":
            continue  # a first stage has one torque
        row = rows.setdefault(limit["cause"], {"cause": names.get(limit["cause"], limit["cause"])})
        row["plus" if limit["direction"] > 0 else "minus"] = limit
    return list(rows.values())


def derived(report: Mapping[str, Any], bodies: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Derived values: name, value with unit, and the values from which it follows."""
    a, paths, torsion = report["analysis"], report["paths"], report["torsion"]
    spans = [c["free_span_mm"] for c in a["cables"]]
    moving = report["inertia_moving_g_mm2"]
    rows = [
        (f"ratio of {b['name'].replace('_', ' ')} to drum", f"{b['ratio']:+.6g}", "pitch radii along the cable")
        for b in bodies
        if b["ratio"] not in (0.0, 1.0)
    ]
    rows += [
        (
            "axial stiffness of the rope, EA",
            f"{a['axial_stiffness_kN']:.4g} kN",
            f"E = {a['modulus_GPa']:g} GPa on the {a['modulus_area']} area {a['area_mm2']:.4f} mm²",
        ),
        ("free spans", f"{min(spans):.4g} to {max(spans):.4g} mm", "centre distance and pitch radii"),
        *_turn_rows(report),
        (
            "lowest mode, inputs held",
            f"{torsion['lowest_inputs_held_Hz']:.4g} Hz",
            "cables, structure, and the inertia of what turns",
        ),
        ("lowest mode by the cables alone", f"{torsion['cables_alone_Hz']:.4g} Hz", "all else rigid, no payload"),
        (
            "modes, inputs free",
            ", ".join(f"{f:.4g}" for f in torsion["inputs_free_Hz"]) + " Hz",
            "rotors of the motors through the gearheads",
        ),
        (
            "inertia at the drum, without rotors",
            f"{moving['at_drum_without_rotors']:.6g} g mm²",
            "each body times its ratio squared",
        ),
        ("inertia at a motor's shaft", f"{moving['at_motor']:.4g} g mm²", "all of it, over the whole ratio squared"),
        (
            "usable travel",
            f"{paths['usable_deg'][0]:.2f} to {paths['usable_deg'][1]:+.2f} deg",
            "; ".join(dict.fromkeys(way[0]["cause"] for _, way in travel_limits(report))) or "paths of the cables",
        ),
        (
            "preloads that leave no bias",
            ", ".join(f"{t:.4g}" for t in a["balanced_preload_N"]) + " N",
            "T ~ 1/r within the cables of one input",
        ),
        (
            "peak torque with them",
            " / ".join(f"{t:.4g}" for t in a["balanced_peak_torque_Nm"]) + " N m",
            "as the peak torque, both ways",
        ),
        (
            "torque to weight",
            f"{report['torque']['torque_to_weight_Nm_kg']:.4g} N m/kg",
            "weaker direction over the mass as drawn",
        ),
    ]
    for line in a["creep"]:
        days, share = line["days"][2], line["share"][2]
        told = (f"preload left after {days:.0f} days at {line['temperature_C']:g} °C", f"{share:.1%}")
        rows.append((*told, "creep of the rope between fixed ends"))
    if a["motor"]:
        rows += _motor_rows(a["motor"])
    if report["frame"]:
        windup = report["frame"]["windup_urad_Nm"]
        rows.append(("frame's windup", f"{windup:.4g} µrad per N m", "stiffness of the support's walls"))
    return [{"what": what, "value": value.replace("-", "−"), "from": source} for what, value, source in rows]


def _turn_rows(report: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Turn, swing and stiffness at each place; of the drum on rigid parts where the structure has no figures."""
    a, found = report["analysis"], report["structure"]
    places = found["places"] if found else {}
    torque = f"{a['test'][0]['load_Nm']:g} N m"
    rows = []
    for key, name in (("payload", "at the payload"), ("drum_encoder", "at the drum's encoder")):
        if at := places.get(key):
            rows += [
                (f"turn {name}", f"{at['turn_mrad']:.4g} mrad", f"{torque}, first loading; cables and structure"),
                (f"swing {name}", f"{at['swing_mrad']:.4g} mrad", f"full reversal of {torque}"),
                (f"stiffness {name}, secant", f"{at['stiffness_Nm_rad']:.4g} N m/rad", torque),
                (f"stiffness {name}, small motion", f"{at['sticking_stiffness_Nm_rad']:.4g} N m/rad", "wraps sticking"),
            ]
    if found and papers_test(a["test"][0]["load_Nm"]):
        words = ", ".join(
            f"{x:.1f} GPa ({name})" if x else f"none ({name})" for name, x in found["implied_moduli_GPa"].items()
        )
        alone = ", ".join(
            f"{x['modulus_GPa']:.1f} GPa ({x['reading']})" for x in a["implied_modulus"] if x["route"] == "all_cables"
        )
        measured = f"{a['measured_backlash_mrad']:g} mrad of the paper"
        rows.append(("E implied, structure counted", words, f"{measured}; by the cables alone {alone}"))
    return [
        *rows,
        (
            "turn by the cables alone",
            f"{abs(a['test'][0]['turn_mrad']):.4g} mrad",
            f"{torque}, first loading, inputs locked",
        ),
        (
            "swing by the cables alone",
            f"{a['reversal_swing_mrad']:.4g} mrad",
            "full reversal of the test torque; friction, preload, EA",
        ),
        (
            "stiffness of the cables, wraps sticking",
            f"{a['sticking_stiffness_Nm_rad']:.4g} N m/rad",
            "EA, radii, free spans and wraps",
        ),
        (
            "stiffness of the cables at the test torque, secant",
            f"{a['test'][0]['secant_stiffness_Nm_rad']:.4g} N m/rad",
            "friction lets the wraps slip",
        ),
    ]


def _motor_rows(m: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Derived values of the motor."""
    return [
        (
            "speed of the drum, no load",
            f"{m['drum_no_load_speed_deg_s']:.4g} deg/s",
            f"{m['bus_voltage_V']:g} V over torque constant and whole ratio",
        ),
        (
            "motor at the peak torque",
            f"{m['at_peak_load_torque_mNm']:.4g} mN m, {m['at_peak_load_current_A']:.3g} A, "
            f"{m['at_peak_load_loss_W']:.3g} W lost",
            "torque constant and resistance, copper alone",
        ),
        (
            "motor's continuous torque",
            f"{m['continuous_torque_mNm']:.4g} mN m, {m['continuous_loss_W']:.3g} W lost",
            "catalogue; copper alone",
        ),
        (
            "rotors seen at the drum",
            f"{m['reflected_inertia_kg_m2'] * 1e3:.4g} g m²",
            "rotor times the whole ratio squared, all inputs",
        ),
    ]


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
        cells = [_range(path[field], digits) for field, _, digits in columns]
        rows.append((path["name"], [f"{own['preload_N']:g}", f"{own['total_ratio']:.6g}", *cells]))
    return {"head": ["preload N", "total ratio", *(heading for _, heading, _ in columns)], "rows": rows}


def _range(value: Any, digits: int) -> str:
    ends = (min(value), max(value)) if isinstance(value, list) else (value, value)
    low, high = (f"{end:.{digits}f}".replace("-", "−") for end in ends)
    return low if low == high else f"{low} to {high}"


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
