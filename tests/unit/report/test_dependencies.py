"""The graph of dependencies: its lines are what the rules read, its drawing has no overlaps.

Probabilities of the checks on a drive as built, against draws of the values; and the correlations in the file.

The text of a solved design.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import networkx as nx
import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.cli import run
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltCorrelation, AsBuiltValue
from mbcdm_cad.design.resolve import with_as_built
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.report.check_report import chance_lines, chances_of
from mbcdm_cad.report.dependencies import DependencyGraph, dependency_graph, dependency_svg
from mbcdm_cad.report.explain import fields_data
from mbcdm_cad.report.solve_report import SolveReport
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import Change, Solution

ROOT = Path(__file__).parents[3]
SHORT, FULL = ROOT / "params" / "gallery" / "wrist.yaml", ROOT / "params" / "mbcdm.yaml"
SVG = "{http://www.w3.org/2000/svg}"
BOX_PX = (208.0, 34.0)


def record(field: str, **rests_on: Any) -> dict[str, Any]:
    return {"field": field, "value": 1.0, "given": False, "rule": "a rule", "driver": "check", "rests_on": rests_on}


def ends(graph: DependencyGraph) -> set[tuple[str, str]]:
    return {(line.source, line.target) for line in graph.lines}


@pytest.fixture(scope="module")
def records() -> dict[Path, list[dict[str, Any]]]:
    return {path: fields_data(load_design(path))["fields"] for path in (SHORT, FULL)}


def test_what_a_longer_way_shows_has_no_line_of_its_own() -> None:
    graph = dependency_graph([record("b", a=2.0), record("c", a=2.0, b=1.0), record("lonely")])
    assert ends(graph) == {("a", "b"), ("b", "c")}
    assert graph.alone == ("lonely",)
    kinds = {node.field: (node.kind, node.value) for node in graph.nodes}
    assert kinds == {"a": ("asked", "2.0"), "b": ("follows", "1.0"), "c": ("follows", "1.0")}


def test_rules_that_rest_on_each_other_make_no_circle() -> None:
    graph = dependency_graph([record("a", b=1.0) | {"given": True}, record("b", a=1.0) | {"given": True}])
    assert ends(graph) == {("b", "a")}


@pytest.mark.parametrize("path", [SHORT, FULL], ids=["short", "full"])
def test_lines_lead_to_all_that_a_rule_reads(path: Path, records: dict[Path, list[dict[str, Any]]]) -> None:
    lines = nx.DiGraph(ends(dependency_graph(records[path])))
    missing = [
        (source, entry["field"])
        for entry in records[path]
        for source in entry["rests_on"]
        if not (lines.has_node(source) and nx.has_path(lines, source, entry["field"]))
    ]
    circular = [pair for pair in missing if nx.has_path(lines, pair[1], pair[0])]
    assert missing == circular, missing
    assert path == FULL or not missing, missing


@pytest.mark.parametrize("path", [SHORT, FULL], ids=["short", "full"])
def test_boxes_do_not_overlap_and_lines_run_to_the_right(path: Path, records: dict[Path, Any]) -> None:
    graph = dependency_graph(records[path])
    for one, other in combinations(graph.nodes, 2):
        apart = abs(one.x - other.x) >= BOX_PX[0] or abs(one.y - other.y) >= BOX_PX[1]
        assert apart, (one.field, other.field)
    for line in graph.lines:
        across = [x for x, _ in line.points]
        assert across == sorted(across) and across[0] < across[-1], (line.source, line.target)
    assert len(graph.nodes) > 50, len(graph.nodes)


def test_command_writes_an_svg_with_every_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    svg = tmp_path / "why.svg"
    assert run(["explain", str(SHORT), "--graph", str(svg)]) == 0
    assert "fields" in capsys.readouterr().out
    root = ElementTree.fromstring(svg.read_text("utf-8"))
    drawn = {group.get("data-field") for group in root.iter(f"{SVG}g")}
    assert {"transmission.centre_distance_mm", "rope.type", "loads.peak_torque_Nm"} <= drawn, drawn
    assert len(root.findall(f"{SVG}path")) > 60


@pytest.mark.slow
def test_bytes_do_not_depend_on_the_process() -> None:
    code = (
        "import hashlib; from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg;"
        "same = {'value': 1, 'given': False, 'rule': '', 'driver': ''};"
        "fields = [same | {'field': f'f{i}', 'rests_on': {f'f{j}': j for j in range(i % 3, i, 3)}} for i in range(20)];"
        "print(hashlib.sha256(dependency_svg(dependency_graph(fields), 't').encode()).hexdigest())"
    )
    found = set()
    for seed in ("1", "2"):
        environment = {"PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        found.add(done.stdout.strip())
    assert len(found) == 1 and len(found.pop()) == 64


@pytest.mark.parametrize(
    ("design", "target", "words"), [(FULL, "why.png", "graphs are SVG files"), (SHORT, "nowhere/why.svg", "nowhere")]
)
def test_what_cannot_be_drawn_is_one_sentence(
    design: Path, target: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["explain", str(design), "--graph", str(tmp_path / target)]) == 2
    err = capsys.readouterr().err
    assert words in err and len(err.strip().splitlines()) == 1, err
    assert not list(tmp_path.iterdir())


def test_a_configuration_without_rules_has_no_graph(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mbcdm_cad.report.explain.explain_all", lambda loaded: ())
    assert run(["explain", str(FULL), "--graph", str(tmp_path / "why.svg")]) == 2
    assert "has no sizing rules" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_titles_are_escaped() -> None:
    text = dependency_svg(dependency_graph([record("b", **{"a<b": 1.0})]), "<t>")
    assert "<t>" not in text and "a<b" not in text
    ElementTree.fromstring(text)


DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
MIDDLE, DEVIATION, CORRELATION = np.array([-0.3, -0.2]), np.array([0.03, 0.025]), -0.8


def entries(correlation: float = CORRELATION) -> tuple[AsBuilt, ...]:
    forms = (("preload_error", "all cables"), ("stiffness_error", "modulus of the rope"))
    found = []
    for (name, form), middle, deviation in zip(forms, MIDDLE, DEVIATION, strict=True):
        low, high = middle - 1.96 * deviation, middle + 1.96 * deviation
        value = AsBuiltValue(name="share", value=float(middle), low=float(low), high=float(high))
        found.append(AsBuilt(name=name, form=form, values=(value,)))
    goes_with = AsBuiltCorrelation(own="share", entry=0, other="share", correlation=correlation)
    return found[0], replace(found[1], correlated=(goes_with,))


def test_the_probabilities_are_those_of_draws() -> None:
    base, found = load_design(DESIGN).drive, entries()
    chances = {one.check: one.probability for one in chances_of(with_as_built(base, found), found)}
    spread = np.outer(DEVIATION, DEVIATION) * np.array([[1.0, CORRELATION], [CORRELATION, 1.0]])
    draws = np.random.default_rng(3).multivariate_normal(MIDDLE, spread, 120)
    unsure = [name for name, chance in chances.items() if 0.05 < chance < 0.95]
    assert unsure, chances
    checks = [check for check in checks_of(base) if check.id in unsure]
    passed = dict.fromkeys(unsure, 0)
    for draw in draws:
        moved = [
            replace(entry, values=(AsBuiltValue(name="share", value=float(share)),), correlated=())
            for entry, share in zip(found, draw, strict=True)
        ]
        layout = layout_of(with_as_built(base, tuple(moved)))
        for check in checks:
            passed[check.id] += check.measure(layout).holds
    for name in unsure:
        # Three standard deviations of a share of 120 draws.
        assert passed[name] / 120 == pytest.approx(chances[name], abs=0.14), (name, passed[name], chances[name])


def test_a_design_that_was_not_measured_has_no_probabilities() -> None:
    drive = load_design(DESIGN).drive
    assert chances_of(drive, ()) == () and list(chance_lines(())) == []


def test_check_and_analyse_of_a_file_as_built_tell_them(tmp_path: Path) -> None:
    path = tmp_path / "built.yaml"
    text = DESIGN.read_text().replace(
        "as_built: []",
        "as_built:\n  - name: preload_error\n    form: all cables\n"
        "    values: [{name: share, value: -0.3, low: -0.36, high: -0.24}]",
    )
    path.write_text(text)
    design = mc.load(path)
    report = design.check()
    assert "as built, within what the loop knows" in report.text() and len(report.to_dict()["as_built"]) > 50
    assert "as built, within what the loop knows" in design.analyse().text()


def test_the_loop_writes_the_correlations_of_what_it_found() -> None:
    t = np.arange(0.0, 100.0, 0.02)
    angle = 0.6 * np.sin(2.0 * np.pi * t / 9.0)
    speed = np.gradient(angle, t)
    noise = 3e-5 * np.random.default_rng(0).normal(size=t.size)
    read = angle * 1.002 - 0.003 * speed + noise
    run = Run(t, 8.0 * angle[None], read, sensors=Sensors(2e-5, 2e-5), input_names=("input",), ratio=8.0)
    result = close_loop(None, [run])
    assert {one.name for one in result.effects} == {"ratio_error", "delay"}, result.sentence
    one, two = result.effects
    table, other = one.correlated[two.words], two.correlated[one.words]
    assert one.correlated[one.words] == pytest.approx(1.0) and two.correlated[two.words] == pytest.approx(1.0)
    assert table.shape == (1, 1) and table == pytest.approx(other.T) and abs(table[0, 0]) <= 1.0
    # What is too small to be named may stand in the figures: 0.03 of the floor along each.
    share = next(named for named in result.effects if named.name == "ratio_error").parameters["share"]
    least = 1.96 * 0.03 * result.errors.floor_rad / float(np.std(angle))
    assert least < 0.5 * (share.high - share.low) < 3.0 * least
    text = as_built_text(load_design(DESIGN), result)
    assert ("correlated:" in text) == (abs(table[0, 0]) >= 0.01), (table, text)


@pytest.mark.parametrize("ranges", [True, False])
def test_only_a_file_with_ranges_is_told_of_the_search_for_the_best(ranges: bool) -> None:
    text = mc.new_design_text("drive", "siso_spur")
    if ranges:
        text = text.replace("drum_radius_mm: 60.0", "drum_radius_mm: {min: 50, max: 70}")
        assert "{min: 50" in text
    question = question_of(text, Path("my drive.yaml"))
    solution = Solution(question, {}, (Change("transmission.drum_radius_mm", "range", 60.0, "chosen"),), 3)
    said = SolveReport(question.path, solution, text.replace("{min: 50, max: 70}", "60.0")).text()
    named = "the best one finds: mbcdm optimise 'my drive.yaml' --aim mass_g:min"
    assert (named in said) == ranges, said
