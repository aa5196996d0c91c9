"""The JSON Schema for completion in editors: that of design files, with the form ``{value, sigma}`` written out."""

from __future__ import annotations

import copy

from mbcdm_cad.design.describe import Node, SchemaNodes


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
