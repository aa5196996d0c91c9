"""The reference page of the design file in Markdown, written from the schema and the catalogue."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.describe import Node, SchemaNodes, flow, limit_text, named_values
from mbcdm_cad.design.entries import KINDS

_INTRO = """\
# The design file

Written by `mbcdm schema --reference` from the schema; do not edit by hand. `mbcdm init NEW.yaml --reference`
writes a file with the reference values to start from, `mbcdm schema` the JSON Schema for completion in an editor.

This page describes the configuration `miso_bevel`. For `siso_bevel`, `siso_spur` or `miso_spur` add
`--configuration NAME` to the command. Most fields of a `miso_bevel` file may be left out: sizing rules then compute
them ([size a drive](how-to/size-a-drive.md)).

Fields marked "+- sigma" may be given as `{value: 70.0, sigma: 3.0}`, also single items of a list; `mbcdm analyse` and
the report then give backlash and torque with a 95 % interval. Sigma is one standard deviation, from 0 to a third of
the value. A ratio has no sigma: state the radii to give sigmas for guide and inputs.

Lengths are in mm and angles in degrees; the unit is part of each name. "Paper", "Table", "section" and "Fig." refer to
the paper that describes the mechanism; "estimate" marks an estimated value. Fields without a reference value are
optional.

Some rules concern several fields and are checked too: names, steps and sides must suit the layout, references must name
catalogue entries, radii are given either by ratios or explicitly, and a modulus is given with its area.
"""


def reference_page(nodes: SchemaNodes) -> str:
    """The whole page."""
    schema = nodes.solid(nodes.root)
    top = {key: nodes.solid(raw) for key, raw in schema["properties"].items()}
    blocks = {key: node for key, node in top.items() if "properties" in node and key != "catalogue"}
    lines = [_INTRO, "## Top level", "", *_table(nodes, {key: node for key, node in top.items() if key not in blocks})]
    for key, node in blocks.items():
        lines += [f"## {key}", "", _sentence(node), "", *_table(nodes, _flattened(nodes, node))]
    for key in ("inputs", "cables", "waivers", "as_built"):
        lines += [f"## Items of {key}", "", *_table(nodes, _flattened(nodes, nodes.solid(top[key]["items"])))]
    lines.append("## Catalogue\n")
    lines.append("A design may add or override entries under `catalogue: {KIND: {NAME: {...}}}`, with these fields.\n")
    for kind in KINDS:
        entry = nodes.solid(named_values(nodes.solid(top["catalogue"]["properties"][kind])) or {})
        lines += [f"### {kind}", "", _sentence(entry), "", *_fields(nodes, entry), *_entries(kind)]
    return "\n".join(lines).rstrip() + "\n"


def _flattened(nodes: SchemaNodes, node: Node, prefix: str = "") -> dict[str, Node]:
    rows: dict[str, Node] = {}
    for key, raw in node["properties"].items():
        child = nodes.solid(raw)
        if "properties" in child and child.get("in_reference"):
            rows |= _flattened(nodes, child, f"{prefix}{key}.")
        else:
            rows[prefix + key] = child
    return rows


def _sentence(node: Node) -> str:
    return str(node.get("description", "")).split("\n")[0].rstrip(".") + "."


def _table(nodes: SchemaNodes, rows: dict[str, Node]) -> Iterator[str]:
    yield "| field | unit | limits | reference | meaning | source |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for key, node in rows.items():
        reference = f"`{flow(node['examples'][0])}`" if node.get("in_reference") else ""
        if node.get("type") == "array" and "properties" in nodes.solid(node.get("items", {})):
            reference = "see `mbcdm init --reference`" if node["examples"][0] else reference
        cells = (
            f"`{key}`",
            node.get("unit", "-"),
            _limits(node),
            reference,
            node.get("description", ""),
            node.get("source", "-"),
        )
        yield _row(cells)
    yield ""


def _fields(nodes: SchemaNodes, entry: Node) -> Iterator[str]:
    yield "| field | unit | limits | meaning |"
    yield "| --- | --- | --- | --- |"
    yield from _field_rows(nodes, entry)
    yield ""


def _field_rows(nodes: SchemaNodes, entry: Node, prefix: str = "") -> Iterator[str]:
    """A row for each field; a block inside the entry, such as that of a servo, is followed by its own fields."""
    for key, raw in entry["properties"].items():
        node = nodes.solid(raw)
        yield _row((f"`{prefix}{key}`", node.get("unit", "-"), _limits(node), node.get("description", "")))
        if "properties" in node:
            yield from _field_rows(nodes, node, f"{prefix}{key}.")


def _limits(node: Node) -> str:
    return limit_text(node) + (", +- sigma" if node.get("uncertain") else "")


def _entries(kind: str) -> Iterator[str]:
    yield "| in the package | source |"
    yield "| --- | --- |"
    yield from (_row((f"`{name}`", entry["source"])) for name, entry in package_entries(kind).items())
    yield ""


def _row(cells: tuple[str, ...]) -> str:
    return "| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |"
