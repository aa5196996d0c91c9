"""Description of a field from its JSON Schema, for messages, the reference page and new files."""

import copy
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from mbcdm_cad.design.fields import PATTERN_WORDS
from mbcdm_cad.design.yamltree import FieldPath

Node = dict[str, Any]

_PLAIN = re.compile(
    r"(?!(?i:true|false|null)\Z)([A-Za-z][A-Za-z0-9_./+-]*|[-+][a-z]|[0-9]+/[0-9]+|[0-9]+x[0-9.]+-?[0-9.]*)\Z"
)


class _InOrder(GenerateJsonSchema):
    """Keeps the order of the schema's source, also of examples; ``ORDER`` says which fields of a block come first."""

    def sort(self, value: Any, parent_key: str | None = None) -> Any:
        return value

    def model_schema(self, schema: Any) -> Any:
        return self._ordered(super().model_schema(schema), schema)

    def dataclass_schema(self, schema: Any) -> Any:
        return self._ordered(super().dataclass_schema(schema), schema)

    @staticmethod
    def _ordered(node: Any, schema: Any) -> Any:
        first = getattr(schema["cls"], "ORDER", ())
        if first:
            order = dict.fromkeys([*(name for name in first if name in node["properties"]), *node["properties"]])
            node["properties"] = {name: node["properties"][name] for name in order}
            node["required"] = [name for name in order if name in node["required"]]
        return node


@dataclass(frozen=True)
class Given:
    """Value of the reference design for a field of a shared block, and its source."""

    value: Any = None
    source: str = "-"


class SchemaNodes:
    """The JSON Schema of one kind of design file, and its node for each field."""

    def __init__(self, schema: type[BaseModel], reference: Mapping[str, Given]) -> None:
        """``reference``: values for fields of shared blocks by their place, ``"rope.preload_N"`` or ``"cables.name"``.

        Raises ``KeyError`` for a place that the schema has not.
        """
        for field in schema.model_fields.values():
            # pydantic builds blocks when they first validate data; a default cannot be written before.
            if isinstance(field.default, BaseModel):
                type(field.default).model_rebuild()
        root: Node = schema.model_json_schema(schema_generator=_InOrder)
        self.root: Node = {"$schema": "https://json-schema.org/draft/2020-12/schema", **root}
        for place, given in reference.items():
            node = self.root  # as the schema holds it, reached through blocks and the items of lists
            for name in place.split("."):
                node = node.get("items", node)
                node = (self._definition(node["$ref"]) if "$ref" in node else node)["properties"][name]
            node["source"] = given.source
            if given.value is not None:
                node |= {"examples": [given.value], "in_reference": True}

    def at(self, path: FieldPath) -> Node | None:
        """The node for a field path, with references followed and "or nothing" dropped; None if unknown."""
        node: Node | None = self.solid(self.root)
        for part in path:
            if node is None:
                return None
            if isinstance(part, int):
                child = _item(node, part)
            else:
                child = node.get("properties", {}).get(part) or named_values(node)
            node = self.solid(child) if isinstance(child, dict) else None
        return node

    def solid(self, node: Node) -> Node:
        """The node with its ``$ref`` followed and its non-null branch merged in; the field's own values win."""
        merged = dict(node)
        for branch in merged.pop("anyOf", []):
            if branch.get("type") != "null":
                merged = {**branch, **merged}
        reference = merged.pop("$ref", None)
        if reference is not None:
            merged = {**self.solid(self._definition(reference)), **merged}
        return merged

    def _definition(self, reference: str) -> Node:
        found: Node = self.root["$defs"][reference.rsplit("/", 1)[1]]
        return found


def named_values(node: Node) -> Node | None:
    """The node of the values of a block whose keys are chosen by the user, such as the entries of a catalogue."""
    return next(iter(node.get("patternProperties", {}).values()), None)


def _item(node: Node, index: int) -> Node | None:
    """The node of an item of a list, with the list's unit and permission for a sigma if it has none of its own."""
    prefix = node.get("prefixItems", [])
    item = prefix[index] if index < len(prefix) else node.get("items")
    if not isinstance(item, dict):
        return None
    inherited = {key: node[key] for key in ("unit", "uncertain") if key in node}
    return {"unit": "-", **inherited, **item}


def limit_text(node: Node) -> str:
    """The bounds of a field in words: ``1 to 120 deg``, ``over 0, up to 5 mm``, ``one of -x, +x``, ``4 values``."""
    if "enum" in node or "const" in node:
        return "one of " + ", ".join(str(word) for word in node.get("enum", [node.get("const")]))
    if "pattern" in node:
        return PATTERN_WORDS[node["pattern"]]
    if node.get("type") == "array":
        low, high = node.get("minItems", 0), node.get("maxItems")
        count = str(low) if low == high else f"{low} to {high}" if high is not None else f"{low} or more"
        each = limit_text(_item(node, 0) or {})
        return f"{count} values" + (f", each {each}" if each else "")
    unit = node.get("unit", "-")
    suffix = "" if unit == "-" else f" {unit}"
    low = _end(node, "minimum", "", "exclusiveMinimum", "over ")
    high = _end(node, "maximum", "", "exclusiveMaximum", "under ")
    if low and high:
        if low == high:
            return f"{low}{suffix}"
        return f"{low} to {high}{suffix}"
    return f"{low or high}{suffix}" if low or high else ""


def _end(node: Node, closed: str, closed_word: str, open_: str, open_word: str) -> str:
    if closed in node:
        return f"{closed_word}{node[closed]:g}"
    return f"{open_word}{node[open_]:g}" if open_ in node else ""


def flow(value: Any) -> str:
    """A value as YAML on one line: ``[1.0, 2.0]``, ``{name: left, side: -x}``; text in quotes where YAML needs them."""
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow(item) for item in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, str):
        return value if _PLAIN.match(value) else json.dumps(value, ensure_ascii=False)
    return json.dumps(value)


def editor_schema(nodes: SchemaNodes) -> Node:
    """JSON Schema of the files a user may write; a field or list item that may carry a sigma has both forms."""
    schema = copy.deepcopy(nodes.root)
    for block in (schema, *schema["$defs"].values()):
        properties = block.get("properties", {})
        for name, node in properties.items():
            if node.pop("uncertain", False):
                properties[name] = _both_forms(node)
    return schema


def _both_forms(node: Node) -> Node:
    if "anyOf" in node:
        branches = [_both_forms(branch) for branch in node["anyOf"]]
        return {**node, "anyOf": [part for branch in branches for part in branch.get("anyOf", [branch])]}
    if node["type"] == "array":
        lists = {key: [_both_forms(item) for item in node[key]] for key in ("prefixItems",) if key in node}
        return {**node, **lists, **({"items": _both_forms(node["items"])} if "items" in node else {})}
    if node["type"] != "number":
        return node
    words: Node = {key: node[key] for key in ("title", "description", "examples", "default") if key in node}
    number = {key: value for key, value in node.items() if key not in words}
    sigma = {"type": "number", "minimum": 0, "description": "one standard deviation, up to a third of the value"}
    both = {"value": number, "sigma": sigma}
    measured = {"type": "object", "properties": both, "required": list(both), "additionalProperties": False}
    return {**words, "anyOf": [number, measured]}
