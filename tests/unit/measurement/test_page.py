"""The reference page of the measurement file, and the files that it shows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reference import measurement_page
from mbcdm_cad.measurement.schema import Measurement, json_schema, node_at

ROOT = Path(__file__).parents[3]


def test_page_in_docs_is_what_the_schema_writes() -> None:
    # To write it anew: mbcdm schema --measurement --reference > docs/measurement-file.md
    assert (ROOT / "docs" / "measurement-file.md").read_text("utf-8") == measurement_page()


def test_examples_on_the_page_are_measurement_files(tmp_path: Path) -> None:
    examples = re.findall(r"```yaml\n(.*?)```", measurement_page(), re.DOTALL)
    assert len(examples) == 2
    for text in examples:
        (tmp_path / "m.yaml").write_text(text)
        assert load_file(tmp_path / "m.yaml").content.data


def test_every_field_is_on_the_page() -> None:
    page = measurement_page()
    for name in (*Measurement.model_fields, *node_at(("columns", "time"))["properties"]):  # type: ignore[index]
        assert f"`{name}`" in page or f"## {name}" in page, name


def test_schema_has_no_reference_left() -> None:
    assert "$ref" not in str(json_schema()) and "$defs" not in json_schema()


def test_messages_show_the_example_of_this_schema(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text("data: run.csv\ncolumns: {time: {column: t}}\n")
    with pytest.raises(InputError) as caught:
        load_file(tmp_path / "m.yaml")
    text = str(caught.value)
    assert "m.yaml:2: columns.time.unit: missing; add it, for example unit: rad" in text, text
    assert "columns.output: missing" in text, text
