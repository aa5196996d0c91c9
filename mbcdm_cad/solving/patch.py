"""Write changed fields into the text of a YAML file; all other text, comments too, stays the same."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

import yaml

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.fieldpath import leaves, value_at
from mbcdm_cad.design.yamltree import parse
from mbcdm_cad.errors import InputError, MbcdmError

INDENT = 2


def patched(text: str, path: str, wanted: Mapping[str, Any]) -> str:
    """The text of the file, changed so that its content is ``wanted``.

    Raises ``MbcdmError`` if fields of the text cannot be changed one at a time (aliases).
    """
    now = parse(text, path).data
    before, after = dict(leaves(now)), dict(leaves(wanted))
    ranged = {field for field in after if isinstance(value_at(now, field), dict)}
    for field in before:
        if field not in after and not any(field.startswith(f"{outer}.") for outer in ranged):
            text = _without(text, field.split("."))
    for field, value in after.items():
        if before.get(field) != value or field in ranged:
            text = _with(text, field.split("."), value)
    try:
        same = dict(leaves(parse(text, path).data)) == after
    except InputError:
        same = False
    if not same:
        raise MbcdmError(f"{path}: cannot be changed field by field; write aliases and quoted keys out, then try again")
    return text


def difference(before: str, after: str, path: str) -> str:
    """The change as a unified diff, which the program ``patch`` can apply."""
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), path, path, lineterm="", n=1)
    return "\n".join(lines)


def _with(text: str, path: list[str], value: Any) -> str:
    """The text with a field set: its value replaced, or the field added to the innermost block that exists."""
    node = _root(text)
    for depth, name in enumerate(path):
        found = _item(node, name)
        if found is None:
            for inner in reversed(path[depth + 1 :]):
                value = {inner: value}
            return _added(text, node, name, value)
        _, below = found
        if depth + 1 == len(path) or not isinstance(below, yaml.MappingNode):
            for inner in reversed(path[depth + 1 :]):
                value = {inner: value}
            return _replaced(text, below, flow(value))
        node = below
    return text


def _without(text: str, path: list[str]) -> str:
    """The text without a field, and without the blocks that it leaves empty."""
    nodes = [_root(text)]
    for name in path[:-1]:
        found = _item(nodes[-1], name)
        if found is None or not isinstance(found[1], yaml.MappingNode):
            return text
        nodes.append(found[1])
    depth = len(path) - 1
    while depth > 0 and len(nodes[depth].value) == 1:
        depth -= 1
    found = _item(nodes[depth], path[depth])
    return text if found is None else _cut(text, nodes[depth], *found)


def _root(text: str) -> yaml.MappingNode:
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    assert isinstance(root, yaml.MappingNode), "a design file that was read is a mapping"
    return root


def _item(node: yaml.MappingNode, name: str) -> tuple[yaml.Node, yaml.Node] | None:
    return next(((key, value) for key, value in node.value if key.value == name), None)


def _end(text: str, node: yaml.Node) -> int:
    """Index of the first character after a node.

    The end mark of a block includes the blanks and comments after it, so that its last item is used instead.
    """
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(text, last[1] if isinstance(last, tuple) else last)
    return int(node.end_mark.index)


def _replaced(text: str, node: yaml.Node, value: str) -> str:
    start, end = node.start_mark.index, _end(text, node)
    if start == end:  # no value is written: insert after the colon
        return f"{text[:start].rstrip(' ')} {value}{text[start:]}"
    if isinstance(node, yaml.CollectionNode) and not node.flow_style:  # a block becomes a value on the line of its key
        start = text.rindex(":", 0, start) + 1
        value = f" {value}"
    return text[:start] + value + text[end:]


def _added(text: str, node: yaml.MappingNode, name: str, value: Any) -> str:
    if node.flow_style:
        at = node.end_mark.index - 1
        return f"{text[:at].rstrip()}{', ' if node.value else ''}{name}: {flow(value)}{text[at:]}"
    column = node.value[0][0].start_mark.column
    end = max(_end(text, below) for _, below in node.value)
    line_end = text.find("\n", end)
    at = len(text) if line_end < 0 else line_end
    pad = " " * column
    block = not column and isinstance(value, dict)
    lines = (
        [f"{name}:", *(f"{' ' * INDENT}{key}: {flow(item)}" for key, item in value.items())]
        if block
        else [f"{pad}{name}: {flow(value)}"]
    )
    return text[:at] + "\n" + "\n".join(lines) + text[at:]


def _cut(text: str, node: yaml.MappingNode, key: yaml.Node, value: yaml.Node) -> str:
    start, end = key.start_mark.index, _end(text, value)
    if node.flow_style:
        k = next(k for k, (other, _) in enumerate(node.value) if other is key)
        if k + 1 < len(node.value):
            return text[:start] + text[node.value[k + 1][0].start_mark.index :]
        before = _end(text, node.value[k - 1][1]) if k else start
        return text[:before] + text[end:]
    first = text.rfind("\n", 0, start) + 1
    last = text.find("\n", end)
    if last < 0:
        return text[:first]
    column, rest = text[end:last].find("#"), text[last + 1 :].split("\n")
    if column >= 0:  # remove the further lines of its comment too
        mark = end + column - (text.rfind("\n", 0, end) + 1)
        while rest and rest[0][:mark].strip() == "" and rest[0][mark : mark + 1] == "#":
            rest.pop(0)
    return text[:first] + "\n".join(rest)
