"""The schema without pydantic: what a right design file needs of it, read from a table made from the schema.

Loading pydantic and building its models costs more than all the rest of ``mbcdm check``. Most files are right, and
then only their values are wanted. So ``plain_schema.json`` holds the bounds of every field, and a file that keeps
within them is read here. Anything else (a fault, an entry of the design's own, a table older than the schema) is left
to pydantic, which alone tells users what is wrong. A test holds the two to the same answers.

After a change of the schema: ``python -m mbcdm_cad.design.plain``.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

_FOLDER = Path(__file__).parent
TABLE = _FOLDER / "plain_schema.json"
_SOURCES = ("schema.py", "entries.py", "fields.py")
_LEFT_OUT = {"description", "title", "unit", "source", "examples", "in_reference", "uncertain"}
_KNOWN = {
    "number": {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"},
    "integer": {"minimum", "maximum"},
    "string": {"minLength", "maxLength", "pattern", "enum", "const"},
    "array": {"items", "prefixItems", "minItems", "maxItems"},
    "object": {"properties", "required", "additionalProperties"},
}
Node = dict[str, Any]


class PlainBlock(SimpleNamespace):
    """A block of the design file, its values as attributes, as in the schema's model of the same name."""

    def model_dump(self, mode: str = "json") -> dict[str, Any]:
        """Nested dictionaries, as pydantic's models give them."""
        return {name: _dumped(value) for name, value in vars(self).items()}


class _ElsewhereError(Exception):
    """Not for this reader: wrong, or out of what it knows."""


def read_plainly(data: Any) -> PlainBlock | None:
    """The design in ``data`` (YAML's values), None if pydantic has to look at it."""
    try:
        table = json.loads(TABLE.read_bytes())
        if table["sources"] != _sources():
            return None
        block: PlainBlock = _value(table["schema"], data)
    except (_ElsewhereError, OSError, ValueError, KeyError, OverflowError):
        return None
    return block


def _sources() -> str:
    return hashlib.sha256(b"\0".join((_FOLDER / name).read_bytes() for name in _SOURCES)).hexdigest()


def _dumped(value: Any) -> Any:
    if isinstance(value, PlainBlock):
        return value.model_dump()
    return [_dumped(item) for item in value] if isinstance(value, tuple) else value


def _value(node: Node, value: Any) -> Any:
    if node.get("or_nothing") and value is None:
        return None
    return _READERS[node["type"]](node, value)


def _wanted(holds: bool) -> None:
    if not holds:
        raise _ElsewhereError


def _number(node: Node, value: Any) -> float:
    _wanted(type(value) in (int, float))
    number = float(value)
    _wanted(math.isfinite(number))
    _within(node, number)
    return number


def _integer(node: Node, value: Any) -> int:
    _wanted(type(value) is int)
    _within(node, value)
    return int(value)


def _within(node: Node, value: float) -> None:
    _wanted(node.get("minimum", -math.inf) <= value <= node.get("maximum", math.inf))
    _wanted(node.get("exclusiveMinimum", -math.inf) < value < node.get("exclusiveMaximum", math.inf))


def _string(node: Node, value: Any) -> str:
    # Some fields drop blanks at their ends: which, only the schema knows.
    _wanted(isinstance(value, str) and value == value.strip())
    _wanted(node.get("minLength", 0) <= len(value) <= node.get("maxLength", math.inf))
    _wanted("enum" not in node or value in node["enum"])
    _wanted("pattern" not in node or re.fullmatch(node["pattern"], value) is not None)
    return str(value)


def _array(node: Node, value: Any) -> tuple[Any, ...]:
    _wanted(isinstance(value, list) and node.get("minItems", 0) <= len(value) <= node.get("maxItems", math.inf))
    first: list[Node] = node.get("prefixItems", [])
    nodes = first + [node["items"]] * (len(value) - len(first)) if "items" in node else first
    _wanted(len(nodes) == len(value))
    return tuple(_value(inner, item) for inner, item in zip(nodes, value, strict=True))


def _object(node: Node, value: Any) -> PlainBlock:
    _wanted(isinstance(value, dict) and value.keys() <= node["properties"].keys())
    fields = {}
    for name, inner in node["properties"].items():
        if name in value:
            fields[name] = _value(inner, value[name])
        else:
            _wanted("default" in inner)
            fields[name] = None if inner["default"] is None else _value(inner, inner["default"])
    return PlainBlock(**fields)


def _entries(_node: Node, value: Any) -> dict[str, Any]:
    """Entries of the design's own catalogue: none."""
    _wanted(value == {})
    return {}


def _constant(node: Node, value: Any) -> Any:
    _wanted(type(value) is type(node["const"]) and value == node["const"])
    return value


def _never(_node: Node, _value: Any) -> Any:
    raise _ElsewhereError


_READERS = {
    "number": _number,
    "integer": _integer,
    "string": _string,
    "array": _array,
    "object": _object,
    "entries": _entries,
    "constant": _constant,
    "never": _never,
}


def plain_table() -> str:
    """Content of ``plain_schema.json``, from the schema. Raises ``ValueError`` where the schema says what it cannot."""
    from mbcdm_cad.design.describe import json_schema

    schema = json_schema()
    table = {"sources": _sources(), "schema": _plain(schema, schema["$defs"])}
    return json.dumps(table, indent=1) + "\n"


def _plain(node: Node, definitions: Node) -> Node:
    """The node with its references in place, and nothing but what :func:`_value` reads."""
    extra = {"default": node["default"]} if "default" in node else {}
    if "anyOf" in node:
        (branch,) = (b for b in node["anyOf"] if b != {"type": "null"})
        if len(node["anyOf"]) != 2:
            raise ValueError(f"more than a value or nothing: {node}")
        return {**_plain(branch, definitions), **extra, "or_nothing": True}
    if "$ref" in node:
        name = node["$ref"].rsplit("/", 1)[1]
        # Rules on entries ask for their class.
        target = {"type": "never"} if name.endswith("Entry") else _plain(definitions[name], definitions)
        return {**target, **extra}
    if "patternProperties" in node:
        return {"type": "entries", **extra}
    if "const" in node:
        return {"type": "constant", "const": node["const"], **extra}
    kind = node["type"]
    unknown = node.keys() - _KNOWN[kind] - _LEFT_OUT - {"type", "default", "$schema", "$defs"}
    if unknown or not node.get("pattern", "^$").startswith("^") or not node.get("pattern", "^$").endswith("$"):
        raise ValueError(f"no plain way to read {sorted(unknown)} of {node}")
    plain = {key: value for key, value in node.items() if key in _KNOWN[kind] | {"type"}} | extra
    plain.pop("additionalProperties", None)
    required = plain.pop("required", [])
    if kind == "object":
        plain["properties"] = {name: _plain(inner, definitions) for name, inner in node["properties"].items()}
        for name, inner in plain["properties"].items():
            if name in required:
                inner.pop("default", None)
            elif "default" not in inner:
                raise ValueError(f"{name} is neither required nor has a default")
    if "items" in plain:
        plain["items"] = _plain(node["items"], definitions)
    if "prefixItems" in plain:
        plain["prefixItems"] = [_plain(inner, definitions) for inner in node["prefixItems"]]
    return plain


if __name__ == "__main__":
    TABLE.write_text(plain_table(), "utf-8")
