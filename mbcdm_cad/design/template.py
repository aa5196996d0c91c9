"""A new design file: the reference design, written from the schema, with unit, meaning and source beside each value."""

from __future__ import annotations

import copy
import re
import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

from mbcdm_cad.design.describe import Node, SchemaNodes, flow
from mbcdm_cad.design.entries import OwnEntries
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
