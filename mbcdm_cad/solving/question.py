"""The question of a search: design file, fixed and free fields, form of a trial; its answer written into the file."""

import copy
import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import yaml

from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loader import DesignFile, Resolved, blamed, resolved
from mbcdm_cad.design.ranges import Range, split_ranges
from mbcdm_cad.design.sized import Freedom, Sizing
from mbcdm_cad.design.yamltree import Tree, leaves, parse, put, read_text, take_out, value_at
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.layouts.loader import design_file_of, reference_data
from mbcdm_cad.layouts.together import FEW

# Factors within which a number that a rule gives may be changed, unless the configuration states others.
DERIVED_LOW, DERIVED_HIGH = 0.5, 2.0
# Blocks whose fields describe or present a design and are no requirements: never changed, never named as a cause.
ASIDE = ("schema_version", "name", "configuration", "inputs", "cables", "catalogue", "waivers", "as_built", "export")
# Releases of a complete file, in the order in which they are tried.
PIN, CHOICE, WISH, ASKED = 1, 2, 3, 4
# A rope that the file names is never changed, even if it is the rope of the reference design.
_KEPT = ("rope.type",)
_WISHES, _ASKED = ("targets", "limits", "rope"), ("transmission",)


@dataclass(frozen=True)
class Times:
    """The value that the rule gives, times a factor."""

    factor: float


@dataclass(frozen=True)
class Fixed:
    """A value that replaces the value of the rule or of the file; a list is given as a tuple."""

    value: Any


@dataclass(frozen=True)
class Out:
    """Removed from the file, so that its rule gives the value."""


Setting = Times | Fixed | Out
Point = Mapping[str, Setting]


def round_to(value: float) -> float:
    """Four significant digits."""
    return float(f"{value:.4g}")


@dataclass(frozen=True)
class Question:
    """One design file and the changes that a search may make to it.

    ``data`` is the file's content without its ranges; ``releases`` the fields of the file that may be removed, with
    their place in the order in which this is tried (:data:`PIN` to :data:`ASKED`). ``complete``: the file states all
    derived dimensions, as ``mbcdm init --reference`` writes them.
    """

    path: Path
    text: str
    tree: Tree
    data: dict[str, Any]
    file: DesignFile
    ranges: Mapping[str, Range]
    releases: Mapping[str, int]
    complete: bool

    @cached_property
    def freedoms(self) -> dict[str, Freedom]:
        """Fields that may change if the file leaves them to their rules: choices first, then derived dimensions."""
        named = {freedom.field: freedom for freedom in self.file.freedoms()}
        derived = [field for field in self.file.derived() if field not in named]
        found = {**named, **{field: Freedom(field, DERIVED_LOW, DERIVED_HIGH) for field in derived}}
        # Idlers and stages, which the blocks of their fields describe, are there only if stated.
        blocks = self.file.schema.model_fields
        return {
            field: freedom
            for field, freedom in found.items()
            if (block := field.split(".")[0]) in self.data or blocks[block].default is not None
        }

    @cached_property
    def unruled(self) -> frozenset[str]:
        """Fields given as a range that have no sizing rule: a trial needs a value for each."""
        found = set()
        for field in self.ranges:
            others = {name: Fixed(self.middle(name)) for name in self.ranges if name != field}
            data, _ = self.trial(others, open_ranges=True)
            take_out(data, field)
            try:
                self.resolve(data, {})
            except InputError as error:
                if any(problem.field == field for problem in error.problems):
                    found.add(field)
        return frozenset(found)

    def middle(self, field: str) -> float:
        """The middle of a range; the geometric mean of its ends if their ratio is above four."""
        found = self.ranges[field]
        if found.low > 0.0 and found.high > 4.0 * found.low:
            return round_to((found.low * found.high) ** 0.5)
        return round_to(0.5 * (found.low + found.high))

    def open_fields(self, point: Point) -> Iterator[Freedom]:
        """The freedoms whose field the file leaves out at this point, or gives as a range that has a rule."""
        for field, freedom in self.freedoms.items():
            around = [field, *(field[:k] for k, sign in enumerate(field) if sign == ".")]
            if value_at(self.data, field) is None or any(isinstance(point.get(name), Out) for name in around):
                yield freedom

    def trial(self, point: Point, *, open_ranges: bool = False) -> tuple[dict[str, Any], dict[str, Any]]:
        """(data, functions that change the values of rules, by field) of a point.

        A range without a setting takes the value of its rule, limited to its ends, or its middle if it has no rule;
        with ``open_ranges`` its rule is used in both cases.
        """
        data, moved = copy.deepcopy(self.data), {}
        for field in [name for name, setting in point.items() if isinstance(setting, Out)]:
            instead = self.freedoms[field].instead(data) if field in self.freedoms else {}
            take_out(data, field)
            for other, value in instead.items():
                put(data, other, value)
        for field, found in self.ranges.items():
            if field in point:
                continue
            if open_ranges or field not in self.unruled:
                moved[field] = found.within
            else:
                put(data, field, self.middle(field))
        for field, setting in point.items():
            if isinstance(setting, Fixed):
                put(data, field, _listed(setting.value))
            elif isinstance(setting, Times):
                moved[field] = partial(self._moved, field, setting.factor)
        return data, moved

    def _moved(self, field: str, factor: float, value: Any) -> Any:
        found = self.freedoms[field].stretch(value, factor) if factor != 1.0 else value
        return self.ranges[field].within(found) if field in self.ranges else found

    def resolve(self, data: dict[str, Any], moved: Mapping[str, Any], similar: Sizing | None = None) -> Resolved:
        """The drive of this data; ``similar``: a sizing whose values are the first guesses of the rules.

        Raises InputError if the data describe no drive.
        """
        return resolved(Tree(data, self.tree.lines), self.path, self.file, moved, similar)

    def as_written(self, point: Point) -> dict[str, Any]:
        """The data of a file that states every changed value. Raises InputError as :meth:`resolve`."""
        data, moved = self.trial(point)
        return stated(data, moved, self.resolve(data, moved)) if moved else data

    def relaxed(self, point: Point) -> "Question":
        """The same question for the file with the values of ``point``."""
        data, _ = self.trial(point)
        ranges = {field: found for field, found in self.ranges.items() if field not in point}
        for field in ranges:
            take_out(data, field)
        return replace(self, data=data, ranges=ranges)


def read_question(path: str | Path) -> Question:
    """The question of a design file. Raises ``InputError`` for mistakes that no search can correct."""
    path = Path(path)
    return question_of(read_text(path), path)


def question_of(text: str, path: str | Path = "<text>") -> Question:
    """As :func:`read_question`, from the text of a file."""
    path = Path(path)
    whole = parse(text, str(path))
    file = design_file_of(whole, str(path))
    if not file.sizing:
        raise MbcdmError(f"{path}: this configuration has no sizing rules; solve changes only fields that have one")
    tree, ranges = split_ranges(whole, str(path), file.node_at)
    found = Question(path, text, whole, tree.data, file, {r.field: r for r in ranges}, {}, complete=False)
    pins = [field for field in file.derived() if value_at(tree.data, field) is not None]
    complete = len(pins) > FEW
    releases = dict.fromkeys(pins, PIN)
    if complete:
        releases |= _of_the_template(found)
    found = replace(found, releases=releases, complete=complete)
    _refuse_what_is_wrong(found)
    return found


def _of_the_template(question: Question) -> dict[str, int]:
    """Fields of a complete file with the value of the reference design: these may be unchanged defaults."""
    reference = reference_data(question.data["configuration"])
    same = [field for field, value in leaves(question.data) if value_at(reference, field) == value]
    found = {}
    for freedom in question.file.freedoms():
        value = None if freedom.only_named else value_at(question.data, freedom.field)
        if value is not None and value == value_at(reference, freedom.field) and freedom.field not in _KEPT:
            found[freedom.field] = ASKED if freedom.field.split(".")[0] in _ASKED else CHOICE
    for field in same:
        if field.split(".")[0] in _WISHES and field not in found and field not in _KEPT:
            found[field] = WISH
    return found


def _refuse_what_is_wrong(question: Question) -> None:
    """Raise InputError for what no search can correct: a wrong name, a value out of bounds, pins that conflict."""
    data, moved = question.trial({})
    try:
        question.resolve(data, moved)
    except InputError as error:
        # The search may change values for which a rule or a layout finds no drive; all else is a mistake in the file.
        if all(problem.may_move for problem in error.problems):
            return
        raise blamed(error, Tree(data, question.tree.lines), question.path, question.file) from None


def stated(data: Mapping[str, Any], moved: Mapping[str, Any], found: Resolved) -> dict[str, Any]:
    """A trial's data with the values that its design ``found`` has for the fields whose rules were changed."""
    whole = copy.deepcopy(dict(data))
    sized = {value.field: value.value for value in found.sized}
    for field in moved:
        if field in sized:
            put(whole, field, sized[field])
    return whole


def _listed(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


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
