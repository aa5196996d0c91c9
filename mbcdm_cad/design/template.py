"""Texts written from the schema: a new design file, with unit, meaning and source beside each value; the reference."""

import copy
import re
import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

from mbcdm_cad.design.catalogue import KINDS, OwnEntries, package_entries
from mbcdm_cad.design.describe import Node, SchemaNodes, flow, limit_text, named_values
from mbcdm_cad.design.sized import SizedValue

WIDTH = 120
_MAX_COLUMN = 44  # comments stand no further right than this, so that long values do not push the others away

_HEADER = """\
# Design of a cable drive. Lengths in mm, angles in degrees; the unit of every value is in its name.
# Behind each value: what it means and, in brackets, where it comes from. "Table", "section" and "Fig." are those of the
# paper that describes the mechanism; an estimate says so. All fields: docs/design-file.md; for completion in an editor,
# save the output of 'mbcdm schema' beside this file and name it in a first line '# yaml-language-server: $schema=FILE'.
# Some values may carry a standard deviation, as in preload_N: {value: 70.0, sigma: 3.0}; figures then get intervals.

"""


def new_text(nodes: SchemaNodes, name: str) -> str:
    """Text of a design file called ``name`` (a slug) that loads and equals the reference design but for the name."""
    lines = list(_block(nodes, nodes.solid(nodes.root), indent=0, given={"name": name}))
    return _HEADER + "\n".join(lines) + "\n"


def with_derived(text: str, values: Iterable[SizedValue]) -> str:
    """A short file's text with what sizing filled, in its blocks as comments.

    If the mark of one line is removed, the file fixes the field of this line.
    """
    rows: dict[str, dict[str, str]] = {}
    inner: dict[tuple[str, str], dict[str, Any]] = {}
    for value in values:
        block, _, name = value.field.rpartition(".")
        block, _, sub = block.partition(".")
        shown: Any = value.value
        if sub:
            # Fields of an inner block stand on one line, so that this line alone is valid.
            shown = inner.setdefault((block, sub), {})
            shown[name], name = value.value, sub
        pad = "  " if block else ""
        rows.setdefault(block, {})[name] = f"{pad}# {name}: {flow(shown)}  # {value.reason}"
    lines = text.splitlines()
    for block in list(rows):
        if f"{block}:" in lines:
            start = end = lines.index(f"{block}:") + 1
            while end < len(lines) and lines[end].startswith("  "):
                end += 1
            own, added = lines[start:end], rows.pop(block)
            examples = tuple(f"  # {name}:" for name in added)
            lines[start:end] = [*(line for line in own if not line.startswith(examples)), *added.values()]
    # Below, each other block and field stands with its value, in place of an example of it.
    others = (*rows, *rows.get("", {}))
    lines = [line for line in lines if not line.startswith(tuple(f"# {name}:" for name in others if name))]
    lines += ["", "# The other blocks, all with values that follow."]
    for block, added in rows.items():
        lines += [*([f"{block}:"] if block else []), *added.values()]
    hint = "# A value behind a comment mark follows from the others; remove the mark of its line to fix it."
    return "\n".join([hint, *lines]) + "\n"


def slug(text: str) -> str:
    """A legal design name made from any text, such as a file's stem; ``design`` where nothing is left of it."""
    plain = re.sub(r"[^a-z0-9_-]+", "-", text.lower()).strip("-_")
    return plain[:64] or "design"


def reference_values(nodes: SchemaNodes) -> dict[str, Any]:
    """The reference design as plain data, as its file would be read."""
    return _data(nodes, nodes.solid(nodes.root))


def _data(nodes: SchemaNodes, node: Node) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for key, raw in node["properties"].items():
        child = nodes.solid(raw)
        if _is_block(child):
            data[key] = _data(nodes, child)
        elif child.get("in_reference"):
            data[key] = copy.deepcopy(child["examples"][0])  # the schema keeps its own
    return data


def _is_block(node: Node) -> bool:
    """Whether the node is a block of the reference design, not an optional one that it leaves out."""
    if "properties" not in node or node["title"] == OwnEntries.__name__:
        return False
    return "default" not in node or bool(node.get("in_reference"))


def _block(nodes: SchemaNodes, node: Node, indent: int, given: dict[str, Any]) -> Iterator[str]:
    """The lines of a block: its scalars with comments in one column, its inner blocks below their heading."""
    rows = [(key, nodes.solid(raw)) for key, raw in node["properties"].items()]
    entries = [(_entry(key, child, given), child) for key, child in rows if not _is_heading(nodes, child)]
    column = min(max((len(text) for text, _ in entries if text), default=0) + 2, _MAX_COLUMN)
    for key, child in rows:
        if _is_heading(nodes, child):
            yield from _heading(nodes, key, child, indent)
        elif text := _entry(key, child, given):
            yield from _commented(" " * indent + text, _comment(child), indent + column)
            if not child.get("in_reference") and "properties" in child:
                pad = " " * indent + "#   "
                yield from (f"{pad}{name}: {flow(value)}" for name, value in child["examples"][0].items())


def _is_heading(nodes: SchemaNodes, node: Node) -> bool:
    return _is_block(node) or (node.get("type") == "array" and "properties" in nodes.solid(node.get("items", {})))


def _heading(nodes: SchemaNodes, key: str, node: Node, indent: int) -> Iterator[str]:
    if indent == 0:
        yield ""
        comment = _comment(node)
        yield from textwrap.wrap(comment[0].upper() + comment[1:], WIDTH, initial_indent="# ", subsequent_indent="# ")
    pad = " " * indent
    if _is_block(node):
        yield f"{pad}{key}:" + (f"  # {_comment(node)}" if indent else "")
        yield from _block(nodes, node, indent + 2, {})
    elif items := node["examples"][0]:
        yield f"{pad}{key}:"
        yield from (f"{pad}  - {flow(item)}" for item in items)
    else:
        yield f"{pad}{key}: []"


def _entry(key: str, node: Node, given: dict[str, Any]) -> str:
    if key in given or node.get("in_reference"):
        return f"{key}: {flow(given.get(key, node['examples'][0]))}"
    if "examples" not in node:
        return ""
    return f"# {key}:" + ("" if "properties" in node else " " + flow(node["examples"][0]))


def _comment(node: Node) -> str:
    unit, source = node.get("unit", "-"), node.get("source", "-")
    meaning = str(node.get("description", "")).split("\n")[0].rstrip(".")
    return ("" if unit == "-" else f"{unit}: ") + meaning + ("" if source == "-" else f" [{source}]")


def _commented(text: str, comment: str, column: int) -> Iterator[str]:
    """``text`` with its comment from ``column`` on, carried on below where the line would be too long."""
    if len(text) + 2 > column:
        yield from (" " * column + "# " + line for line in textwrap.wrap(comment, WIDTH - column - 2))
        yield text
        return
    first, *rest = textwrap.wrap(comment, WIDTH - column - 2) or [""]
    yield f"{text:<{column}}# {first}".rstrip(" #")
    yield from (" " * column + "# " + line for line in rest)


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
