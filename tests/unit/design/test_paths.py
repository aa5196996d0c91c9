"""Every path that code names by ``at`` is a field of a layout's design file, and every ``at`` of the source a path."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mbcdm_cad
from mbcdm_cad.api import schema
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.registry import names

PATHS = {path for block in vars(at).values() for path in vars(block).values()}


def _meant(node: dict[str, Any], schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The node of a schema that a reference or a choice leads to."""
    if "$ref" in node:
        yield from _meant(schema["$defs"][node["$ref"].rpartition("/")[2]], schema)
    for kind in ("anyOf", "oneOf", "allOf"):
        for inner in node.get(kind, ()):
            yield from _meant(inner, schema)
    yield node


def test_each_path_is_a_field_of_a_layout() -> None:
    fields = {
        f"{block}.{name}"
        for layout in names()
        for block, node in schema(layout)["properties"].items()
        for meant in _meant(node, schema(layout))
        for name in meant.get("properties", ())
    }
    assert sorted(PATHS - fields) == []


def test_the_source_names_no_other() -> None:
    texts = (file.read_text("utf-8") for file in Path(mbcdm_cad.__file__).parent.rglob("*.py"))
    nodes = [node for text in texts if "import at\n" in text for node in ast.walk(ast.parse(text))]
    used = re.findall(
        r"^at\.(\w+\.\w+)$", "\n".join(ast.unparse(n) for n in nodes if isinstance(n, ast.Attribute)), re.M
    )
    assert len(used) > len(PATHS)
    assert sorted(set(used) - PATHS) == []
