"""The YAML reader: lines, bounds, and refused content."""

import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.fields import SLUG
from mbcdm_cad.design.template import reference_page, slug
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.loader import design_file, layout_of, load_design, load_text, new_design_text, reference_data
from tests.support.reference import REFERENCE as PARAMS
from tests.support.reference import ROOT


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        yamltree.parse(text, "f.yaml")
    return str(caught.value)


def test_every_field_of_the_real_file_has_the_line_it_stands_on() -> None:
    text = PARAMS.read_text("utf-8")
    tree = yamltree.parse(text, "f.yaml")
    lines = text.split("\n")
    for path, line in tree.lines.items():
        if isinstance(path[-1], str):
            assert f"{path[-1]}:" in lines[line - 1], f"{path} is said to be on line {line}: {lines[line - 1]!r}"


def test_values_agree_with_a_full_yaml_reader_on_the_real_file() -> None:
    text = PARAMS.read_text("utf-8")
    assert yamltree.parse(text, "f.yaml").data == yaml.safe_load(text)


def test_the_pure_python_parser_gives_the_same_tree_as_the_compiled_one(monkeypatch: pytest.MonkeyPatch) -> None:
    text = PARAMS.read_text("utf-8") + "\nextra: {a: \"1\", b: '2', c: 3, d: [x, ~, true, |\n  ]}\n".replace(
        "|\n  ", "-1.5"
    )
    compiled = yamltree.parse(text, "f.yaml")
    monkeypatch.setattr(yamltree, "_LOADER", yaml.SafeLoader)
    assert yamltree.parse(text, "f.yaml") == compiled


def test_line_of_a_field_not_given_is_that_of_the_block_above() -> None:
    tree = yamltree.parse("a:\n  b:\n    c: 1\n", "f.yaml")
    assert tree.line_of(("a", "b", "missing", 3)) == 2
    assert tree.line_of(("other",)) == 1


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("-3.5", -3.5),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("0", 0),
        ("+7", 7),
        ("true", True),
        ("False", False),
        ("yes", "yes"),
        ("no", "no"),
        ("on", "on"),
        ("'12'", "12"),
        ('"1.5"', "1.5"),
        ("~", None),
        ("2020-01-01", "2020-01-01"),
        ("618/8", "618/8"),
        ("7x7", "7x7"),
        ("-x", "-x"),
        ("1.2.3", "1.2.3"),
        ("inf", "inf"),
    ],
)
def test_scalars(text: str, value: object) -> None:
    read = yamltree.parse(f"a: {text}", "f.yaml").data["a"]
    assert read == value and type(read) is type(value), f"{text} was read as {read!r}"


@pytest.mark.parametrize("text", ["010", "0o17", "0x1F", "0b11", "1:30", "190:20:30.15", "1_000", "1_0.5", "007.5"])
def test_numbers_that_can_be_read_in_two_ways_are_refused(text: str) -> None:
    assert "f.yaml:2: b: a number that can be read in two ways" in refusal(f"a: 1\nb: {text}\n")


@pytest.mark.parametrize(
    "text", [".nan", ".NaN", ".inf", "-.INF", "1e400", "-1e16", "9" * 5000, "1" * 41, "1e99999999999"]
)
def test_numbers_that_are_not_finite_or_out_of_bounds_are_refused(text: str) -> None:
    message = refusal(f"a: 1\nb: {text}\n")
    assert message.startswith("f.yaml:2: "), message
    assert len(message) < 300, f"a message of {len(message)} characters"


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", 1, "the design file is empty"),
        ("# only a comment\n", 1, "the design file is empty"),
        ("---\n", 1, "the design file is empty"),
        ("a: 1\n---\nb: 2\n", 2, "a second document"),
        ("a: 1\nb: 2\na: 3\n", 3, "a: given twice (value first on line 1)"),
        ("a:\n  b: 1\n  b: 2\n", 3, "a.b: given twice"),
        ("a: [1, 2\nb: 3\n", 2, "not valid YAML"),
        ("a: 1\n\tb: 2\n", 2, "not valid YAML"),
        ("a: 'x\n\n", 3, "not valid YAML"),
        ("a: !!python/object/apply:os.system [ls]\n", 1, "tags are not part of design files"),
        ("a: 1\nb: !!python/name:os.system\n", 2, "tags are not part"),
        ("a: !!float 3\n", 1, "tags are not part"),
        ("a: ! x\n", 1, "tags are not part"),
        ("a: !!binary aGk=\n", 1, "tags are not part"),
        ("a: &x 1\nb:\n  <<: {c: 1}\n", 3, "merge keys"),
        ("a: *x\n", 1, "refers to no finished anchor"),
        ("a: &x [1, *x]\n", 1, "refers to no finished anchor"),
        ("? [1, 2]\n: 3\n", 1, "used as a key"),
        ("x: &k 1\n? *k\n: 3\n", 2, "an alias used as a key"),
        ("a: 1\nb: \x00\n", 2, "a character that YAML does not allow (value U+0000)"),
        ("a: 1\nb: \x1b[31m\n", 2, "value U+001B"),
        ("a: " + "x" * 3000, 1, "a text too long"),
        ("%YAML 3.0\n---\na: 1\n", 1, "not valid YAML"),
    ],
)
def test_what_is_refused_and_where(text: str, line: int, what: str) -> None:
    message = refusal(text)
    assert message.startswith(f"f.yaml:{line}: ") and what in message, message


def test_aliases_stand_for_what_they_name_and_keep_the_line_of_their_use() -> None:
    tree = yamltree.parse("a: &x {b: 1}\nc: *x\n", "f.yaml")
    assert tree.data == {"a": {"b": 1}, "c": {"b": 1}}
    assert tree.line_of(("c", "b")) == 2


def bomb(levels: int) -> str:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("aliases, 10^9 values", bomb(9)),
        ("aliases, 10^400 values", bomb(400)),
        ("brackets", "[" * 500_000),
        ("braces", "{a: " * 200_000),
        ("indentation", "\n".join(" " * k + "a:" for k in range(1200))),
        ("long list", "[" + "1, " * 300_000 + "1]"),
        ("many keys", "\n".join(f"k{i}: 1" for i in range(90_000))),
        ("one long text", "a: '" + "x" * 1_000_000 + "'"),
        ("one long comment", "#" * 1_000_000),
        ("many comments", "#\n" * 500_000),
        ("question marks", "? " * 400_000),
        ("dashes", "- " * 400_000),
        ("anchors", " ".join(f"&a{k}" for k in range(100_000))),
    ],
)
def test_bombs_are_refused_before_they_cost_much(name: str, text: str) -> None:
    start = time.process_time()
    message = refusal(text)
    took = time.process_time() - start
    assert took < 10.0, f"{name}: {took:.2f} s of processor time"
    assert len(message) < 400, f"{name}: a message of {len(message)} characters"


DESIGN = """name: wrist
configuration: siso_spur
travel: {half_angle_deg: 35}
transmission: {input_to_drum: 10, drum_radius_mm: 60}
loads: {peak_torque_Nm: 0.8, duty: {record: logs/day.csv, ambient_C: 30}}
targets: {life_h: 10}
"""


def written(folder: Path, record: str, design: str = DESIGN) -> Path:
    (folder / "logs").mkdir(exist_ok=True)
    (folder / "logs" / "day.csv").write_text(record)
    (folder / "wrist.yaml").write_text(design)
    return folder / "wrist.yaml"


@pytest.mark.parametrize(
    "record",
    [
        "time_s,angle_deg,torque_Nm\n0,0,0.2\n1,30,0.5\n2,0,0.2\n",
        "# a comment\ntorque [mN m];time [ms];note;angle [deg]\n200;0;a;0\n\n500;1000;b;30\n200;2000;c;0\n",
        "time_min,angle_rad,torque_kNm\n0,0,0.0002\n0.016666666667,0.5235987756,0.0005\n0.033333333333,0,0.0002\n",
    ],
)
def test_a_record_gives_the_same_duty_in_any_units(record: str, tmp_path: Path) -> None:
    layout = layout_of(load_design(written(tmp_path, record)).drive)
    duty = layout.duty
    assert duty.stated and duty.assumed == () and duty.ambient_C == 30.0
    assert duty.period_s == pytest.approx(2.0) and duty.largest_speed_deg_s == pytest.approx(30.0)
    # A straight line from 0.2 to 0.5: mean square (0.04 + 0.1 + 0.25)/3.
    assert duty.rms_torque_Nm == pytest.approx(0.13**0.5, rel=1e-6)
    assert [s.range_deg for s in duty.strokes] == pytest.approx([30.0, 30.0]) and duty.cycles_per_h == pytest.approx(
        1800
    )
    # Ten hours of 1800 cycles.
    assert life_of(layout).wanted_cycles == pytest.approx(18000.0)


@pytest.mark.parametrize(
    ("record", "line", "words"),
    [
        ("time_s,angle_deg\n0,0\n1,1\n", 1, "no column with the torque"),
        ("time_s,angle_deg,torque\n0,0,1\n1,1,1\n", 1, "no column with the torque"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,x,0.1\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,3\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,nan,0.1\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n\n1,3,0.1\n1,4,0.1\n", 5, "does not grow"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,3,0.9\n", 3, "more than the peak torque"),
        ("time_s,angle_deg,torque_Nm\n0,-36,0.1\n1,36,0.1\n", 3, "more than the whole travel"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n", 1, "too short"),
        ("", 1, "too short"),
    ],
)
def test_a_record_that_does_not_do_is_told_by_its_line(record: str, line: int, words: str, tmp_path: Path) -> None:
    path = written(tmp_path, record)
    with pytest.raises(InputError) as error:
        load_design(path)
    problem = error.value.problems[0]
    assert problem.file == str(tmp_path / "logs/day.csv") and (problem.line, words in problem.what) == (line, True), (
        str(error.value)
    )


def test_what_contradicts_the_record_is_told_by_the_design_files_line(tmp_path: Path) -> None:
    record = "time_s,angle_deg,torque_Nm\n0,0,0.2\n1,30,0.5\n"
    for old, new, words in (
        ("ambient_C: 30", "period_s: 3", "given beside record"),
        ("ambient_C: 30", "rows: [{torque_Nm: 0.1, share: 1}]", "both rows and record"),
        ("record: logs/day.csv, ", "", "neither rows nor record"),
        ("life_h: 10", "life_h: 10, life_cycles: 3", "given beside life_cycles"),
        (", duty: {record: logs/day.csv, ambient_C: 30}", "", "hours without a duty"),
        ("day.csv", "night.csv", "cannot be read"),
    ):
        with pytest.raises(InputError, match=words):
            load_design(written(tmp_path, record, DESIGN.replace(old, new)))


def test_the_hash_follows_the_record(tmp_path: Path) -> None:
    hashes = set()
    for load in (0.2, 0.3, 0.2):
        loaded = load_design(written(tmp_path, f"time_s,angle_deg,torque_Nm\n0,0,{load}\n1,30,0.5\n"))
        assert loaded.data["loads"]["duty"] == {"record": "logs/day.csv", "ambient_C": 30}
        hashes.add(loaded.sha256)
    assert len(hashes) == 2


def test_many_movements_count_by_classes_that_take_no_life_away(tmp_path: Path) -> None:
    """A noisy walk of a thousand turns back: as many movements, none smaller than it was."""
    rng = np.random.default_rng(1)
    angle, torque = rng.uniform(-30, 30, 1000), rng.uniform(-0.7, 0.7, 1000)
    rows = "\n".join(f"{k},{a:.4f},{m:.4f}" for k, (a, m) in enumerate(zip(angle, torque, strict=True)))
    duty = layout_of(load_design(written(tmp_path, f"time_s,angle_deg,torque_Nm\n{rows}\n")).drive).duty
    assert len(duty.strokes) <= 72
    turns = np.flatnonzero(np.diff(np.sign(np.diff(np.append(angle, angle[0]))))).size
    assert duty.cycles_per_h == pytest.approx(0.5 * turns * 3600.0 / 999.0, rel=0.02)
    mean = sum(s.range_deg * s.per_h for s in duty.strokes) / duty.cycles_per_h
    exact = np.abs(np.diff(angle)).sum() / turns
    assert exact <= mean <= 1.2 * exact, (exact, mean)


NODES = design_file().nodes


def test_new_file_equals_the_reference_design_but_for_the_name() -> None:
    new = load_text(new_design_text("trial")).design
    reference = load_design(ROOT / "params" / "mbcdm.yaml").design
    assert new.name == "trial"
    assert new.model_copy(update={"name": reference.name}) == reference


def test_params_file_is_what_the_schema_writes() -> None:
    """The reference design and its comments live in the schema; change them there, then
    ``rm params/mbcdm.yaml && mbcdm init params/mbcdm.yaml --reference``."""
    assert (ROOT / "params" / "mbcdm.yaml").read_text("utf-8") == new_design_text("mbcdm")


def test_reference_page_in_docs_is_what_the_schema_writes() -> None:
    """After a change of the schema: ``mbcdm schema --reference > docs/design-file.md``."""
    assert (ROOT / "docs" / "design-file.md").read_text("utf-8") == reference_page(NODES)


def test_each_value_of_a_new_file_has_a_comment_and_fits_the_page() -> None:
    lines = new_design_text("trial").split("\n")
    assert max(map(len, lines)) <= 120, max(lines, key=len)
    bare = [
        line
        for line in lines
        if re.match(r"\s*\w+: \S", line) and "#" not in line and line not in ("waivers: []", "as_built: []")
    ]
    assert bare == [], f"values without a comment: {bare}"


def test_explicit_radii_shown_as_a_comment_are_those_the_ratios_give() -> None:
    text = new_design_text("trial")
    ratios = re.search(r"  ratios:.*\n(    .*\n)+", text)
    assert ratios is not None
    explicit = text.replace(ratios[0], "").replace("  # guide_radii_mm", "  guide_radii_mm")
    explicit = explicit.replace("  # input_radii_mm", "  input_radii_mm")
    assert load_text(explicit).drive.cables == load_text(text).drive.cables


def test_inline_rope_shown_as_a_comment_is_accepted_when_uncommented() -> None:
    text = new_design_text("trial")
    text = re.sub(r"\n  type:.*", "", text)
    text = re.sub(r"\n  modulus_(GPa|area):.*(\n {20,}#.*)*", "", text)
    text = re.sub(r"\n  # (  )?(?=\w+:)(?!preload|guide_radii|input_radii)", r"\n  \1", text)
    assert load_text(text).drive.cable.diameter_mm == load_text(new_design_text("trial")).drive.cable.diameter_mm


@given(st.text())
def test_any_text_gives_a_legal_name(text: str) -> None:
    assert re.match(SLUG, slug(text)), f"{text!r} gave {slug(text)!r}"


@given(
    st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn")), max_size=50)
    | st.integers(-(10**9), 10**9)
    | st.floats(-1e9, 1e9)
    | st.booleans()
)
def test_a_value_written_on_one_line_reads_back_as_itself(value: Any) -> None:
    assert parse("a: " + flow({"b": [value]}), "f.yaml").data == {"a": {"b": [value]}}, flow(value)


def fields(node: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    if isinstance(node, dict):
        for key, child in node.get("properties", {}).items():
            yield f"{path}.{key}", child
        for key, child in node.items():
            yield from fields(child, f"{path}.{key}")


def test_every_field_has_a_meaning_and_a_unit_and_every_number_its_bounds() -> None:
    defs = NODES.root["$defs"]
    for path, node in fields(NODES.root):
        leaf = next((n for n in node.get("anyOf", [node]) if n.get("type") != "null"), node)
        if "$ref" in leaf and "description" not in node:
            assert defs[leaf["$ref"].rsplit("/", 1)[1]]["description"], path
            continue
        assert node.get("description"), f"{path} has no line of meaning"
        if "catalogue" not in path and "OwnEntries" not in path:
            assert node.get("unit"), f"{path} has no unit"
        if leaf.get("type") in ("number", "integer"):
            assert {"minimum", "exclusiveMinimum"} & leaf.keys(), f"{path} has no lower bound"
            assert {"maximum", "exclusiveMaximum"} & leaf.keys(), f"{path} has no upper bound"


UNITS = {
    "_arcmin": "arcmin",
    "_mm": "mm",
    "_deg": "deg",
    "_deg_s": "deg/s",
    "_s": "s",
    "_h": "h",
    "_C": "C",
    "_K_W": "K/W",
    "_N": "N",
    "_N_mm": "N/mm",
    "_Nm": "N m",
    "_Nm_rad": "N m/rad",
    "_mNm": "mN m",
    "_GPa": "GPa",
    "_MPa": "MPa",
    "_g": "g",
    "_kg": "kg",
    "_kg_m2": "kg m2",
    "_mrad": "mrad",
    "_urad": "urad",
    "_mm2": "mm2",
    "_g_m": "g/m",
    "_g_cm3": "g/cm3",
    "_g_cm2": "g cm2",
    "_mNm_A": "mN m/A",
    "_kJ_mol": "kJ/mol",
    "_ohm": "ohm",
    "_A": "A",
    "_V": "V",
    "_EUR": "EUR",
}


def test_units_in_names_and_in_the_schema_agree() -> None:
    for path, node in fields(NODES.root):
        suffix = next((s for s in sorted(UNITS, key=len, reverse=True) if path.endswith(s)), "")
        if "unit" in node:
            assert node["unit"] == UNITS.get(suffix, "-"), f"{path} is said to be in {node['unit']}"


def test_json_schema_is_plain_json_with_the_reference_among_its_examples() -> None:
    schema = json.loads(json.dumps(NODES.root))
    assert schema["additionalProperties"] is False
    assert schema["$defs"]["Travel"]["properties"]["half_angle_deg"]["examples"] == [35.0]


def test_reference_data_survives_another_yaml_writer() -> None:
    assert load_text(yaml.safe_dump(reference_data())).sha256 == load_text(new_design_text("mbcdm")).sha256


@pytest.mark.parametrize("word", ["schema", "init"])
def test_page_names_the_commands(word: str) -> None:
    assert f"mbcdm {word}" in reference_page(NODES)


def test_reference_is_written_before_any_design_was_read() -> None:
    """Blocks are built when they first validate something, so only a process of its own shows that none is needed."""
    code = "from mbcdm_cad.layouts.loader import new_design_text; print(len(new_design_text('new', 'siso_bevel')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert found.returncode == 0 and int(found.stdout) > 1000, found.stderr[-500:]
