"""Make the page of a built design, and the charts that only it shows; curves and cables are computed once and kept."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import markupsafe
import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import turns_of
from mbcdm_cad.model.capability import requirements
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.sensitivity import elasticities, figure_5
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.tolerance import Tolerances, ToleranceStack, tolerance_stack
from mbcdm_cad.report.analysis_report import capability, duty_shown, life_shown, path_data_or_reason
from mbcdm_cad.report.comparison import ComparedDesign, comparison_table, torque_notes
from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg
from mbcdm_cad.report.losses import losses_shown
from mbcdm_cad.report.page import template
from mbcdm_cad.report.page.scene import Lines, Scene, cable_lines, design_scene
from mbcdm_cad.report.page.template import page_environment
from mbcdm_cad.report.preload import preload_shown
from mbcdm_cad.report.table import chart
from mbcdm_cad.storage.cache import Cache, content_key
from mbcdm_cad.workshop.drawings import ASSEMBLY

if TYPE_CHECKING:
    from mbcdm_cad.workshop.store import StoredPart


_PRELOAD_SHARES = (0.5, 0.75, 1.0, 1.25, 1.5)
_POINTS = 41
# Only the linear theory of the stack is shown, which needs no draws; `mbcdm sensitivity` has the Monte Carlo.
_DRAWS = 2


def studies(drive: Drive) -> dict[str, Any]:
    """Charts by name, each with its axes and lines as plain lists. Angles in mrad or urad, torques in N m."""
    d, need = layout_of(drive).si, requirements(layout_of(drive))
    load = float(need.load_Nm)
    stack = tolerance_stack(d, float(need.half_travel_rad), Tolerances(), draws=_DRAWS, poses=61)
    charts = {
        "load": _over_load(d, drive.loads.peak_torque_Nm),
        "preload": _over_preload(d, load),
        "travel": _over_travel(drive, d, load),
        "loop": _loop(d, load),
        "tolerance": _tolerance(stack),
    }
    for panel in figure_5(d, load):
        unit = "" if panel.unit == "-" else f" {panel.unit}"
        charts[f"figure_5_{panel.letter}"] = _chart(
            f"Fig. 5 ({panel.letter}): {panel.parameter}",
            ("preload", "N"),
            ("backlash", "mrad"),
            panel.preload_N,
            [(f"{value:.4g}{unit}", line * 1e3) for value, line in zip(panel.value, panel.backlash_rad, strict=True)],
        )
    return {"charts": charts, "elasticities": _rounded(elasticities(d, need)), "tolerance_sources": _sources(stack)}


def charts_under_load(drives: Sequence[tuple[str, Drive]]) -> dict[str, Any]:
    """Turn and swing of the payload over the load, a line a drive, each up to its own peak torque."""
    loads, turns, swings = [], [], []
    for name, drive in drives:
        d, at = layout_of(drive).si, np.linspace(0.0, drive.loads.peak_torque_Nm, _POINTS)
        idle = solve_equilibrium(d, 0.0).drum_angle_rad
        loaded = solve_equilibrium(d.spread(_POINTS), at)
        back = solve_equilibrium(d.spread(_POINTS), -at, turned_at_N=loaded.tension_N)
        structure = turns_of(layout_of(drive)).felt.structure_urad_Nm * at * 1e-3
        loads.append(at)
        turns.append((name, np.abs(loaded.drum_angle_rad - idle) * 1e3 + structure))
        swings.append((name, np.abs(back.drum_angle_rad - loaded.drum_angle_rad) * 1e3 + 2.0 * structure))
    x = ("load", "N m")
    return {
        "turn": _chart("Turn of the payload, first loading", x, ("turn", "mrad"), loads, turns),
        "swing": _chart("Swing of the payload at a reversal", x, ("swing", "mrad"), loads, swings),
    }


def _chart(
    title: str, x: tuple[str, str], y: tuple[str, str], places: Any, lines: list[tuple[str, Any]]
) -> dict[str, Any]:
    """A chart with one set of places for all its lines, or one each where ``places`` is a list."""
    each = places if isinstance(places, list) else [places] * len(lines)
    drawn = [
        {"label": label, "x": _rounded(np.asarray(at).tolist()), "y": _rounded(np.asarray(line).tolist())}
        for at, (label, line) in zip(each, lines, strict=True)
    ]
    return chart(title, x, y, drawn)


def _over_load(d: DriveSI, peak_Nm: float) -> dict[str, Any]:
    loads = np.linspace(0.0, peak_Nm, _POINTS)
    lines = []
    for share in _PRELOAD_SHARES:
        pulled = d.with_(preload_N=d.preload_N * share)
        idle = solve_equilibrium(pulled, 0.0).drum_angle_rad
        turned = solve_equilibrium(pulled.spread(_POINTS), loads).drum_angle_rad
        lines.append((f"{share:.0%} preload ({float(np.mean(pulled.preload_N)):g} N)", np.abs(turned - idle) * 1e3))
    return _chart("Turn of the drum, inputs locked, first loading", ("load", "N m"), ("turn", "mrad"), loads, lines)


def _over_travel(drive: Drive, d: DriveSI, load_Nm: float) -> dict[str, Any]:
    """Turn both ways with the wraps that are there at each angle, beside that of endless wraps."""
    paths, _ = path_data_or_reason(drive)
    angles, turned = (paths["drum_angle_deg"], paths["test_turn_mrad"]) if paths else ([0.0], {})
    endless = abs(float(solve_equilibrium(d, load_Nm).drum_angle_rad - solve_equilibrium(d, 0.0).drum_angle_rad)) * 1e3
    ways = {"positive": f"load +{load_Nm:g} N m", "negative": f"load -{load_Nm:g} N m"}
    lines = [(ways[way], np.abs(values)) for way, values in turned.items()]
    lines.append(("endless wraps", np.full(len(angles), endless)))
    title = "Turn of the drum over the travel, with the wraps that are left"
    return _chart(title, ("drum angle", "deg"), ("turn", "mrad"), np.asarray(angles), lines)


def _over_preload(d: DriveSI, load_Nm: float) -> dict[str, Any]:
    shares = np.linspace(0.3, 2.0, _POINTS)
    many = d.spread(_POINTS)
    many = many.with_(preload_N=many.preload_N * shares)
    mean = np.mean(many.preload_N, axis=0)
    idle = solve_equilibrium(many, 0.0)
    loaded = solve_equilibrium(many, load_Nm)
    back = solve_equilibrium(many, -load_Nm, turned_at_N=loaded.tension_N)
    lines = [
        ("first loading", np.abs(loaded.drum_angle_rad - idle.drum_angle_rad) * 1e3),
        ("swing at a reversal", np.abs(back.drum_angle_rad - loaded.drum_angle_rad) * 1e3),
    ]
    return _chart(f"Backlash at {load_Nm:g} N m", ("mean preload", "N"), ("turn", "mrad"), mean, lines)


def _loop(d: DriveSI, load_Nm: float) -> dict[str, Any]:
    turns = np.array([0.0, 1.0, -1.0, 1.0, -0.2, 0.4, -0.2, 1.0]) * load_Nm
    load = np.concatenate([np.linspace(a, b, 40)[1:] for a, b in pairwise(turns)])
    drum = simulate(d, np.zeros((d.n_inputs, load.size)), load).drum_angle_rad
    # The unloaded drum is added before the run: as its first sample it would be a motion with a reversal of its own.
    idle = float(solve_equilibrium(d, 0.0).drum_angle_rad)
    load, drum = np.concatenate([turns[:1], load]), np.concatenate([[idle], drum]) * 1e3
    parts = {"first loading": slice(0, 40), "loop": slice(39, 118), "minor loop": slice(117, None)}
    return _chart(
        "Friction's loop, inputs locked",
        ("load", "N m"),
        ("drum angle", "mrad"),
        [load[s] for s in parts.values()],
        [(name, drum[s]) for name, s in parts.items()],
    )


def _tolerance(stack: ToleranceStack) -> dict[str, Any]:
    return _chart(
        "Transmission error from tolerances, zeroed at the centre",
        ("drum angle", "deg"),
        ("standard deviation", "µrad"),
        np.degrees(stack.pose_rad),
        [("linear theory", stack.linear_rad * 1e6)],
    )


def _sources(stack: ToleranceStack) -> list[dict[str, Any]]:
    """RMS over the travel from one standard deviation of each source, urad, largest first."""
    found = [
        {"source": name, "rms_urad": _rounded(float(size) * 1e6)}
        for name, size in zip(stack.contributor, stack.contribution_rad, strict=True)
        if size > 0.0
    ]
    return sorted(found, key=lambda source: (-source["rms_urad"], source["source"]))


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if np.isfinite(value) else None


def comparison_page(designs: Sequence[ComparedDesign], drives: Sequence[Drive], pictures: Sequence[bytes]) -> bytes:
    """The page as UTF-8; needs no other file. ``pictures``: a PNG of each design, in the same order."""
    text = (
        page_environment()
        .get_template("compare.html.j2")
        .render(
            designs=designs,
            pictures=[base64.b64encode(png).decode() for png in pictures],
            rows=[_row(label.strip(), cells) for label, *cells in comparison_table(designs).rows],
            notes=torque_notes(designs),
            charts=charts_under_load([(design.name, drive) for design, drive in zip(designs, drives, strict=True)]),
        )
    )
    return text.encode()


def _row(label: str, values: Sequence[Any]) -> dict[str, Any]:
    """A row of the table; comparable figures have their share of the largest, for a bar."""
    numbers = all(isinstance(value, float | int) for value in values)
    most = max(values) if numbers else 0.0
    cells = [{"value": value, "share": value / most if numbers and most > 0.0 else None} for value in values]
    return {"label": label, "cells": cells}


@dataclass(frozen=True)
class PageFigures:
    """Content of the page that needs no drawn part: curves, cables over the travel, graph of the fields."""

    studies: Mapping[str, Any]
    lines: Lines
    graph: str


def page_figures(drive: Drive, fields: Sequence[Mapping[str, Any]], cache: Cache) -> PageFigures:
    """The figures of the page; ``fields`` as in the report."""
    paths_at = layout_of(drive).all_cable_paths
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
    # As text, because limits that a drive does not have are infinite, which content_key refuses.
    layout = layout_of(drive)
    read = [asdict(layout.si), asdict(requirements(layout)), asdict(drive.loads), layout.wraps_at_ends_rad]
    inputs = json.dumps(read, sort_keys=True, default=lambda array: array.tolist())
    key = content_key("studies", inputs)
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
            groups=template.groups(view.data),
            checks=template.sorted_checks(report["checks"]),
            counts=template.check_counts(report["checks"]),
            tightest=template.tightest(report["checks"]),
            capability=capability(report),
            speed_chart=template.speed_chart(report),
            losses=losses_shown(report["losses"]),
            life=life_shown(report["life"]),
            preload=preload_shown(report["preload"]),
            duty=duty_shown(report["duty"]),
            derived=template.derived(report, view.data["bodies"]),
            cables=template.cable_rows(report),
            limits=template.travel_limits(report),
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
