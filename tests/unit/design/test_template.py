"""Files written from the schema: the starting file, the reference design, the reference page, the JSON Schema."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.fields import SLUG
from mbcdm_cad.design.template import reference_page, slug
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.layouts.loader import design_file, load_design, load_text, new_design_text, reference_data

ROOT = Path(__file__).parents[3]
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
