"""Comparison of designs: figures that follow from others by definition, and the content of table and JSON."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from xml.etree import ElementTree

import networkx as nx
import numpy as np
import pytest

import mbcdm_cad as mc
from benchmarks.studies.built_by_others import page, told
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltCorrelation, AsBuiltValue
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.resolve import with_as_built
from mbcdm_cad.jobs.build import ComparisonReport
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.report.check_report import chance_lines, chances_of
from mbcdm_cad.report.checks_page import checks_page
from mbcdm_cad.report.comparison import compared, comparison_data, comparison_table, distinct_labels, own_folder
from mbcdm_cad.report.dependencies import DependencyGraph, dependency_graph, dependency_svg
from mbcdm_cad.report.explain import fields_data
from mbcdm_cad.report.gallery_page import GalleryDrive
from mbcdm_cad.report.page.stage import charts_under_load, comparison_page
from mbcdm_cad.report.solve_report import SolveReport
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import Change, Solution
from tests.support.reference import PARAMS, ROOT, Says
from tests.support.reference import REFERENCE as DESIGN


def report(**changes: Any) -> dict[str, Any]:
    """What of a report counts."""
    data: dict[str, Any] = {
        "torque": {"peak_positive_Nm": 3.7, "peak_negative_Nm": 3.2, "above_gearhead": "the peak torque is above"},
        "mass": {"mass_g": 400.0},
        "envelope": {"size_mm": [100.0, 50.0, 40.0]},
        "torsion": {"lowest_inputs_held_Hz": 1234.0},
        "bill_of_materials": [
            {"kind": "made", "count": 2},
            {"kind": "made", "count": 1},
            {"kind": "bought", "count": 7},
        ],
        "checks": [
            {"id": "tension", "unit": "times", "limit": 5.0, "margin": 0.5, "status": "pass"},
            {"id": "motor_torque_back", "unit": "N m", "limit": 3.0, "margin": 0.15, "status": "pass"},
            {"id": "motor_losses", "unit": "N m", "limit": 3.0, "margin": -1.0, "status": "warn"},
            {"id": "walls", "unit": "mm", "limit": 1.0, "margin": 0.0, "status": "pass"},
        ],
    }
    return data | changes


def test_figures_follow_from_each_other() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    found = compared(drive, report(), 0.28)
    assert found.torque_to_weight_Nm_kg == pytest.approx(3.2 / 0.4)
    assert found.torque_per_volume_Nm_l == pytest.approx(3.2 / 0.2)
    assert found.lowest_mode_Hz == 1234.0
    structure = structure_of(layout_of(drive))
    assert structure is not None
    give = structure.payload_urad_Nm * 1e-6
    assert 1.0 / found.stiffness_Nm_rad == pytest.approx(1.0 / found.cable_stiffness_Nm_rad + give)
    assert (found.made_parts, found.made_kinds, found.bought_parts) == (3, 2, 7)
    # Of strength and torque, what passes nearest to its limit.
    assert (found.tightest_check, found.tightest_margin_share) == ("motor_torque_back", pytest.approx(0.05))
    assert found.toleranced_fits > 20
    assert found.undrawn == 0
    swing = float(drum_backlash(layout_of(drive).si, 0.28).reversal_swing_rad) * 1e3
    assert found.cable_swing_mrad == pytest.approx(swing)
    assert found.swing_mrad == pytest.approx(swing + 2.0 * give * 0.28 * 1e3)


def test_table_has_a_column_a_design_and_json_is_plain() -> None:
    designs = [compared(load_design(PARAMS / name).drive, report(), 0.28) for name in ("mbcdm.yaml", "siso_bevel.yaml")]
    table = comparison_table(designs)
    assert table.columns == ("", "mbcdm", "siso_bevel")
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["configuration"] == ("miso_bevel", "siso_bevel")
    assert rows["total ratio"] == (pytest.approx(9.0), pytest.approx(4.5))
    assert len({len(line.split("|")) for line in table.markdown()}) == 1
    compared_both = ComparisonReport(tuple(designs))
    for text in (compared_both.text(), compared_both.markdown()):
        assert "mbcdm: the peak torque is above" in text and "siso_bevel: the peak torque is above" in text
    plain = json.loads(json.dumps(comparison_data(designs)))
    assert [design["name"] for design in plain] == ["mbcdm", "siso_bevel"]
    assert plain[1]["box_mm"] == [100.0, 50.0, 40.0]


def test_page_holds_pictures_and_figures_and_needs_no_other_file() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    light = compared(drive, report(), 0.28)
    heavy = compared(drive, report(mass={"mass_g": 800.0}), 0.28)
    page = comparison_page([light, heavy], [drive, drive], [b"first", b"second"]).decode()
    assert page.count("data:image/png;base64,") == 2 and "://" not in page.replace("http://www.w3.org", "")
    row = page.split('<th scope="row">mass, g</th>')[1].split("</tr>")[0]
    assert ">400<" in row and "width:50.0%" in row and "width:100.0%" in row, row


def test_load_charts_agree_with_the_swings_of_the_table() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    swing = charts_under_load([("one", drive)])["swing"]["lines"][0]
    k = 12
    assert swing["y"][k] == pytest.approx(compared(drive, report(), swing["x"][k]).swing_mrad, rel=1e-4)


def test_designs_of_one_name_are_told_apart() -> None:
    left, right, other = Path("a/left.yaml"), Path("a/right.yaml"), Path("other.yaml")
    assert distinct_labels([("drive", left), ("drive", right), ("other", other)]) == [str(left), str(right), "other"]
    assert distinct_labels([("drive", left), ("drive", left)]) == ["drive 1", "drive 2"]
    assert [own_folder(label) for label in (str(left), "../x y.yaml", "drive 2")] == ["a-left", "x-y", "drive-2"]


FILES = sorted((ROOT / "params" / "built-by-others").glob("*.yaml"))
DRIVES_OF_OTHERS = ROOT / "docs" / "built-by-others.md"


def test_comments_are_what_it_is_what_is_published_and_what_differs() -> None:
    text = "# An arm.\n# Published: 8:1\n# and 3 N m.\nname: arm # 2 m\n# Differs: one stage.\n"
    assert told(text) == {"": "An arm.", "Published": "8:1 and 3 N m.", "Differs": "one stage."}


def test_there_are_ten_drives_the_printed_capstan_and_three_of_new_users() -> None:
    assert len(FILES) == 14, FILES


def test_a_drive_that_is_not_drawn_anew_stays_on_the_page() -> None:
    """The page of no new drive is the page."""
    text = DRIVES_OF_OTHERS.read_text("utf-8")
    assert page([], "pictures", text) == text


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_is_short_and_says_what_is_published_and_what_differs(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= 12, len(text.splitlines())
    assert set(told(text)) - {"Seen"} == {"", "Published", "Differs"}, told(text)
    assert f"name: {path.stem}\n" in text


def test_the_page_has_every_drive_and_a_picture_of_those_that_pass_and_are_not_large() -> None:
    written = DRIVES_OF_OTHERS.read_text("utf-8")
    sections = dict(re.findall(r"^## ([\w-]+)\n(.*?)(?=^## |\Z)", written, re.M | re.S))
    assert sorted(sections) == [path.stem for path in FILES]
    assert len(re.findall(r"\]\((pictures/[^)]+)\)", written)) >= 6
    for name, text in sections.items():
        pictures = re.findall(r"\]\((pictures/[^)]+)\)", text)
        fails = re.findall(r"^- `\w+` fails: ", text, re.M)
        assert not (pictures and fails), (name, pictures, fails)
        sizes = [(DRIVES_OF_OTHERS.parent / picture).stat().st_size for picture in pictures]
        assert all(4_000 < size < 60_000 for size in sizes), sizes


PAGE = ROOT / "docs" / "gallery.md"


@pytest.mark.parametrize(
    ("text", "words", "lines"),
    [
        (
            "# A wrist: thin rope. Everything else follows: mbcdm explain wrist.yaml\nname: a\n\n# b\nc: 1\n",
            "A wrist: thin rope.",
            2,
        ),
        ("# A small joint. mbcdm explain finger.yaml\nname: a\n", "A small joint.", 1),
        ("# Nothing more to say\nname: a\n", "Nothing more to say.", 1),
    ],
)
def test_words_are_the_files_own_first_sentence(text: str, words: str, lines: int) -> None:
    drive = GalleryDrive(cast(Any, SimpleNamespace(text=text)), {}, b"")
    assert (drive.words, drive.lines) == (words, lines)


def test_every_drive_on_the_page_has_its_file_and_its_picture() -> None:
    text = PAGE.read_text("utf-8")
    files = re.findall(r"`(params/gallery/[\w.-]+\.yaml)`:", text)
    pictures = re.findall(r"\]\((pictures/[^)]+)\)", text)
    assert len(files) == len(pictures) >= 12, (len(files), len(pictures))
    assert [name for name in files if not (ROOT / name).is_file()] == []
    sizes = {name: (PAGE.parent / name).stat().st_size for name in pictures}
    assert all(4_000 < size < 200_000 for size in sizes.values()), sizes


# docs/checks.md agrees with the registry.


# As the Makefile names them.
REFERENCES = ("mbcdm", "siso_bevel", "siso_spur", "miso_spur")


@pytest.fixture(scope="module")
def drives() -> list[Drive]:
    return [load_design(ROOT / "params" / f"{name}.yaml").drive for name in REFERENCES]


@pytest.fixture(scope="module")
def page_of(drives: list[Drive]) -> str:
    return checks_page(drives)


def test_page_in_docs_is_up_to_date(page_of: str) -> None:
    """Write it anew with: make docs."""
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page_of


def test_each_check_of_each_layout_stands_once_in_its_column(page_of: str, drives: list[Drive]) -> None:
    tables, _ = page_of.split("## Checks of the build")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in tables.splitlines() if line.startswith("| `")]
    for column, drive in enumerate(drives, start=3):
        found = sorted(row[0].split("`")[1] for row in rows if row[column])
        assert found == sorted(layout_of(drive).checks_by_id()), drive.name
        assert len(found) > 100


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
    assert len(graph.nodes) > 45, len(graph.nodes)


def test_command_writes_an_svg_with_every_field(tmp_path: Path, says: Says) -> None:
    svg = tmp_path / "why.svg"
    assert "fields" in says(["explain", str(SHORT), "--graph", str(svg)]).out
    root = ElementTree.fromstring(svg.read_text("utf-8"))
    drawn = {group.get("data-field") for group in root.iter(f"{SVG}g")}
    assert {"transmission.centre_distance_mm", "rope.type", "loads.peak_torque_Nm"} <= drawn, drawn
    assert len(root.findall(f"{SVG}path")) > 50


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
    design: Path, target: str, words: str, tmp_path: Path, says: Says
) -> None:
    err = says(["explain", str(design), "--graph", str(tmp_path / target)], 2).err
    assert words in err and len(err.strip().splitlines()) == 1, err
    assert not list(tmp_path.iterdir())


def test_a_configuration_without_rules_has_no_graph(
    tmp_path: Path, says: Says, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mbcdm_cad.report.explain.explain_all", lambda loaded: ())
    assert "has no sizing rules" in says(["explain", str(FULL), "--graph", str(tmp_path / "why.svg")], 2).err
    assert not list(tmp_path.iterdir())


def test_titles_are_escaped() -> None:
    text = dependency_svg(dependency_graph([record("b", **{"a<b": 1.0})]), "<t>")
    assert "<t>" not in text and "a<b" not in text
    ElementTree.fromstring(text)


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
