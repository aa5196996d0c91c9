"""The graph of dependencies: its lines are what the rules read, its drawing has no overlaps."""

from __future__ import annotations

import subprocess
import sys
from itertools import combinations
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import networkx as nx
import pytest

from mbcdm_cad.cli import run
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.report.dependencies import DependencyGraph, dependency_graph, dependency_svg
from mbcdm_cad.report.explain import fields_data

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
