"""Turn pydantic's errors into messages for the user, with file, line, value, limit and remedy."""

from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from mbcdm_cad.design.describe import Node, flow, limit_text
from mbcdm_cad.design.fields import PATTERN_WORDS
from mbcdm_cad.design.yamltree import FieldPath, Tree, dotted
from mbcdm_cad.errors import Problem, did_you_mean, shortened

MAX_LISTED = 50

_WANTED = {"number": "a number", "integer": "a whole number", "string": "text", "array": "a list", "object": "a block"}
# Parts of pydantic's paths that are not fields: keys, and the branches of "a name or a number".
_NO_FIELDS = ("[key]", "constrained-str", "int")
# What pydantic calls a key that a model, or a dataclass, does not have.
_UNKNOWN_FIELD = ("extra_forbidden", "unexpected_keyword_argument")

NodeAt = Callable[[FieldPath], Node | None]


def schema_problems(
    error: ValidationError, tree: Tree, file: str, node_at: NodeAt, wanted: Callable[[Any], bool] = lambda item: True
) -> list[Problem]:
    """All findings by line, at most ``MAX_LISTED`` with the number of further ones.

    ``node_at`` returns the schema's node of a field; ``wanted`` decides which of pydantic's findings count.
    """
    items = [item for item in error.errors(include_url=False) if wanted(item)]
    # A list that is too short only because its items were refused, which is reported.
    items = [x for x in items if not (x["type"] == "too_short" and len(x["input"]) >= x["ctx"]["min_length"])]
    # Every branch of "a name or a number" gives the same error.
    return at_most_listed(list(dict.fromkeys(_problem(item, tree, file, node_at) for item in items)), file)


def at_most_listed(problems: list[Problem], file: str) -> list[Problem]:
    """The problems by line, at most ``MAX_LISTED`` with the number of further ones."""
    found = sorted(problems, key=lambda problem: problem.line)
    if len(found) > MAX_LISTED:
        rest = len(found) - MAX_LISTED
        last = Problem(
            file, found[MAX_LISTED].line, "", f"{rest} more problems are not listed", remedy="put these right first"
        )
        found = [*found[:MAX_LISTED], last]
    return found


def _problem(item: Any, tree: Tree, file: str, node_at: NodeAt) -> Problem:
    path: FieldPath = tuple(part for part in item["loc"] if part not in _NO_FIELDS)
    kind, value = item["type"], item["input"]
    node = node_at(path) or {}
    line, where, limit = tree.line_of(path), dotted(path), limit_text(node)
    example = next(iter(node.get("examples", [])), None)
    if kind == "missing":
        shown = f"add it, for example {path[-1]}: {flow(example)}" if _simple(example) else "add it"
        return Problem(file, line, where, "missing", "", limit, f"{shown}{_meaning(node)}", missing=True)
    if kind in _UNKNOWN_FIELD and value is None and str(path[-1]).isdigit():
        number, block = _before_comma(tree, path), dotted(path[:-1])
        remedy = f"the decimal sign is a point: write {number}" if number else "the decimal sign is a point"
        return Problem(file, line, block, "a decimal comma, which ends the value", str(path[-1]), remedy=remedy)
    if kind in _UNKNOWN_FIELD and path in _REMOVED:
        return Problem(file, line, where, "removed field", remedy=_REMOVED[path])
    if kind in _UNKNOWN_FIELD:
        return Problem(file, line, where, "unknown field", remedy=_unknown_remedy(path, node_at))
    if kind == "string_pattern_mismatch":
        signs = PATTERN_WORDS[item["ctx"]["pattern"]]
        return Problem(file, line, where, "not a plain name", shortened(value), signs, "use these signs only")
    if kind == "literal_error":
        words = [str(word) for word in node.get("enum", [node.get("const")])]
        return Problem(file, line, where, "not a known word", shortened(value), limit, did_you_mean(str(value), words))
    if kind.endswith(("_type", "_attributes_type", "from_float")):
        return Problem(
            file,
            line,
            where,
            f"not {_WANTED.get(node.get('type', ''), 'of the right kind')}",
            shortened(value),
            limit,
            _type_remedy(node, value, example),
        )
    if kind in ("too_short", "too_long") or kind.startswith("string_too"):
        what = "too short" if kind.endswith("short") else "too long"
        return Problem(file, line, where, what, shortened(value), _length(item, limit), f"give {_length(item, limit)}")
    return Problem(
        file,
        line,
        where,
        "out of bounds" if limit else str(item["msg"]),
        shortened(value),
        limit,
        f"choose a value within the limit{_meaning(node)}",
    )


def _before_comma(tree: Tree, path: FieldPath) -> str:
    """The number that was meant, where the field before the stray digits has the whole part: ``{angle_deg: 40,5}``."""
    block = tree.data
    for part in path[:-1]:
        block = block[part]
    names = list(block)
    before = names[names.index(path[-1]) - 1] if names.index(path[-1]) else ""
    whole = block.get(before)
    is_whole = isinstance(whole, int) and not isinstance(whole, bool)
    return f"{before}: {whole}.{path[-1]}" if is_whole else ""


# What a file may call a second pair of capstan and drum, and what it can say in its place.
_SECOND_CABLE_STAGE: tuple[FieldPath, ...] = (("stages",), ("first_stage",), ("second_stage",))
SECOND_CABLE_STAGE = (
    "a second cable stage is the block first_stage: {total_ratio: 24.0} of a siso_spur file, before its own; state "
    "any other as stage: {kind: belt, ratio: 3.0}, or kind: gears (spur layouts), with its stiffness_Nm_rad, "
    "lash_arcmin and efficiency"
)
# Words of the layouts with parallel axes, and why the others have none.
_WITH_PARALLEL_AXES: dict[FieldPath, str] = {
    (
        "idlers",
    ): "idlers lead a cable from one parallel axis to another; where axes cross, the cable changes from pulley "
    "to pulley at one point of their common pitch line, which idlers would move; choose configuration: siso_spur or "
    "miso_spur",
    ("input_pulleys", "carried_by"): "where axes cross, the pulley's step must stay on the pitch line, within the "
    "tolerance of its transfer points, and a motor's shaft that bends would take it away: it has a bearing at both "
    "ends; choose configuration: siso_spur or miso_spur",
}


# Fields that files may still have, and what to do instead.
_REMOVED: dict[FieldPath, str] = {
    ("transmission", "equaliser"): "remove it; a drum.spring under the nuts, a longer span, less travel or less ratio "
    "keep the preloads of parallel cables more alike",
    ("transmission", "rocker_mm"): "remove it, with transmission.equaliser",
    ("transmission", "matched_lands_mm"): "remove it; checks count what the tolerances of the lands allow",
    ("transmission", "parallel_spread"): "remove it; it is worked out from nuts, lands and the pitch of a span",
    ("rope", "preload_by"): "remove it; for the knee, state as preload_N the one that 'mbcdm preload' names",
}


def _unknown_remedy(path: FieldPath, node_at: NodeAt) -> str:
    """The similar field, or the block beside or within that has a field of this name."""
    known = (node_at(path[:-1]) or {}).get("properties", {})
    if path in _SECOND_CABLE_STAGE:
        return SECOND_CABLE_STAGE
    if path in _WITH_PARALLEL_AXES:
        return _WITH_PARALLEL_AXES[path]
    for block in known:
        node = node_at((*path[:-1], block)) or {}
        if path[-1] in node.get("properties", {}):
            if "type" in known:
                return f"name a catalogue entry with type:, or write {path[-1]} under {block}:{_meaning(node)}"
            return f"write it under {block}:{_meaning(node)}"
    if len(path) == 2:
        nodes = {block: node_at((block,)) or {} for block in (node_at(()) or {}).get("properties", {})}
        others = [block for block, node in nodes.items() if path[-1] in node.get("properties", {})]
        if len(others) == 1:
            return f"write it under {others[0]}:{_meaning(nodes[others[0]])}"
    return did_you_mean(str(path[-1]), known)


def _length(item: Any, limit: str) -> str:
    context = item.get("ctx", {})
    if item["type"].startswith("string"):
        return " ".join(
            f"{word} {context[key]} characters"
            for key, word in (("min_length", "at least"), ("max_length", "at most"))
            if key in context
        )
    return limit


def _type_remedy(node: Node, value: Any, example: Any) -> str:
    wanted = node.get("type", "")
    if wanted == "string" and isinstance(value, int | float):
        return f'put it in quotes: "{value}"'
    if wanted in ("number", "integer") and isinstance(value, str):
        unit = node.get("unit", "-")
        return "write the bare number" + ("" if unit == "-" else f", in {unit}") + ", without quotes or unit"
    if wanted == "object":
        return "give its fields, indented below it"
    return f"write for example {flow(example)}" if _simple(example) else f"write {_WANTED.get(wanted, 'another')}"


def _meaning(node: Node) -> str:
    words = node.get("description", "").split("\n")[0]
    return f" ({words})" if words else ""


def _simple(example: Any) -> bool:
    return isinstance(example, int | float | str) or (isinstance(example, list) and bool(example))
