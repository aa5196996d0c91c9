"""Read YAML text into plain data, with the line of every field, safely for any input; places of fields in it.

Folders, devices and files that are too large are refused. PyYAML only scans and parses; the tree is built here from its
events, without recursion, so that depth, size and aliases are bounded as they come in. Scalars follow the YAML 1.2 core
schema, less what people misread (octal, sexagesimal, ``yes``): those are refused, or stay text."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from mbcdm_cad.errors import InputError, Problem, shortened

FieldPath = tuple[str | int, ...]


def dotted(path: FieldPath) -> str:
    """``('cables', 0, 'step')`` as ``cables[0].step``, the form used in messages."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if len(part) <= 40 else part[:37] + "..."
            text += ("." if text else "") + (name if name.isprintable() else repr(name))
    return text


def nearest_line(lines: Mapping[FieldPath, int], path: FieldPath) -> int:
    """Line of the field, or of the nearest block above it in the file."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


def value_at(data: Any, field: str) -> Any:
    """Value of a field, None if it is left out."""
    for part in field.split("."):
        if not isinstance(data, dict):
            return None
        data = data.get(part)
    return data


def put(data: dict[str, Any], field: str, value: Any) -> None:
    """Set a field; blocks above it that are missing are created."""
    *blocks, last = field.split(".")
    for block in blocks:
        if not isinstance(data.get(block), dict):
            data[block] = {}
        data = data[block]
    data[last] = value


def take_out(data: dict[str, Any], field: str) -> None:
    """Remove a field and each block above it that becomes empty; nothing happens if the field is left out."""
    *blocks, last = field.split(".")
    above: list[tuple[dict[str, Any], str]] = []
    for block in blocks:
        if not isinstance(data.get(block), dict):
            return
        above.append((data, block))
        data = data[block]
    data.pop(last, None)
    for outer, block in reversed(above):
        if not outer[block]:
            del outer[block]


def leaves(data: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every field that is not a block, with its value; an empty block gives nothing."""
    for key, value in data.items():
        name = f"{above}{key}"
        if isinstance(value, dict):
            yield from leaves(value, f"{name}.")
        else:
            yield name, value


MAX_BYTES = 1 << 20
NEW_DESIGN = "; 'mbcdm init NEW.yaml' writes a file to start from"


def read_text(path: Path, kind: str = "design file", hint: str = NEW_DESIGN) -> str:
    """Text of the file; at most MAX_BYTES + 1 bytes are ever read, so that a device or pipe cannot hang or fill us.

    ``kind`` and ``hint`` say in errors what the file should be, and what helps where there is none.
    """
    try:
        if path.exists() and not path.is_file():
            raise _error(path, 1, "", "not a regular file", remedy=f"give the path of the {kind}")
        with open(path, "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise _error(
            path, 1, "", f"cannot be read: {error.strerror or error}", remedy="check the path" + hint
        ) from None
    except ValueError as error:
        raise _error(path, 1, "", f"cannot be read: {error}", remedy="check the path") from None
    if len(content) > MAX_BYTES:
        limit, remedy = f"{MAX_BYTES} bytes", f"{kind}s are about 10 kB at most; check that this is one"
        raise _error(path, 1, "", "too big", value=f"over {limit}", limit=limit, remedy=remedy)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        value, remedy = f"byte 0x{content[error.start]:02x}", "save the file as UTF-8"
        raise _error(path, line, "", "not UTF-8 text", value=value, remedy=remedy) from None


MAX_DEPTH = 16
MAX_NODES = 5000  # the reference design has about 150; every use of an alias counts what it stands for
MAX_SCALAR = 2000

_INTEGER = re.compile(r"[-+]?(0|[1-9][0-9]*)\Z")
_FLOAT = re.compile(r"[-+]?((0|[1-9][0-9]*)(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?\Z")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)\Z|\.(nan|NaN|NAN)\Z")
_MISREAD = re.compile(
    r"[-+]?(0[0-9_]+(\.[0-9_]*)?|0[xob][0-9A-Fa-f_]+|[0-9]+(:[0-9]+)+(\.[0-9]*)?|[0-9]+(_[0-9.]+)+)\Z"
)
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass
class Tree:
    """Plain data (dict, list, str, int, float, bool, None) and the line of each field by its path."""

    data: Any
    lines: dict[FieldPath, int]

    def line_of(self, path: FieldPath) -> int:
        """Line of the field, or of the nearest block above it that the file holds."""
        return nearest_line(self.lines, path)


@dataclass
class _Open:
    """A mapping or list still being read."""

    value: dict[str, Any] | list[Any]
    path: FieldPath
    line: int
    anchor: str | None
    nodes_before: int
    key: str | None = None


def parse(text: str, file: str, kind: str = "design file", hint: str = NEW_DESIGN) -> Tree:
    """The one YAML document in ``text``; ``file`` names it in errors. Raises InputError.

    ``kind`` and ``hint`` say in errors what the file should be, and what helps where there is nothing in it.
    """
    bad = _UNPRINTABLE.search(text)
    if bad:
        line = text.count("\n", 0, bad.start()) + 1
        raise _error(
            file,
            line,
            "",
            "a character that YAML does not allow",
            value=f"U+{ord(bad[0]):04X}",
            remedy="remove it, or save the file as plain UTF-8 text",
        )
    try:
        return _TreeBuilder(file, kind, hint).build(yaml.parse(text, Loader=_LOADER))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        what = " ".join(word for word in (error.context, error.problem) if word) or "unreadable"
        line = mark.line + 1 if mark else 1
        raise _error(
            file,
            line,
            "",
            f"the {kind} is not valid YAML: {what}",
            remedy="check indentation, colons, brackets and quotes on this line and the one above",
        ) from None
    except yaml.YAMLError as error:
        what = f"the {kind} is not valid YAML: {shortened(str(error))}"
        raise _error(file, 1, "", what, remedy="check the file's text") from None


class _TreeBuilder:
    """Builds the tree from parse events, holding open blocks on a stack of its own."""

    def __init__(self, file: str, kind: str, hint: str) -> None:
        self.file, self.kind, self.hint = file, kind, hint
        self.lines: dict[FieldPath, int] = {}
        self.nodes = 0
        self.stack: list[_Open] = []
        self.anchors: dict[str, tuple[Any, int]] = {}
        self.roots: list[Any] = []

    def build(self, events: Iterator[yaml.Event]) -> Tree:
        for event in events:
            line = event.start_mark.line + 1 if event.start_mark else 1
            if isinstance(event, yaml.DocumentStartEvent) and self.roots:
                raise self._error(line, "a second document", remedy="keep one document in a file: remove the '---'")
            if isinstance(event, yaml.AliasEvent):
                self._alias(event, line)
            elif isinstance(event, yaml.ScalarEvent):
                self._scalar(event, line)
            elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
                self._open(event, line)
            elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
                block = self.stack.pop()
                self._remember(block.anchor, block.value, self.nodes - block.nodes_before)
                self._place(block.value)
        if not self.roots or self.roots[0] is None:
            raise self._error(1, f"the {self.kind} is empty", remedy=f"fill it{self.hint}")
        return Tree(self.roots[0], self.lines)

    def _open(self, event: yaml.CollectionStartEvent, line: int) -> None:
        self._count(1, line)
        self._refuse_tag(event, line)
        if len(self.stack) >= MAX_DEPTH:
            raise self._error(line, "nested too deeply", limit=f"{MAX_DEPTH} levels", remedy="write it flatter")
        if self.stack and isinstance(self.stack[-1].value, dict) and self.stack[-1].key is None:
            raise self._error(line, "a list or block used as a key", remedy="keys are plain names; check the brackets")
        value: dict[str, Any] | list[Any] = {} if isinstance(event, yaml.MappingStartEvent) else []
        self.stack.append(_Open(value, self._next_path(line), line, event.anchor, self.nodes - 1))

    def _scalar(self, event: yaml.ScalarEvent, line: int) -> None:
        self._count(1, line)
        self._refuse_tag(event, line)
        if len(event.value) > MAX_SCALAR:
            raise self._error(
                line,
                "a text too long",
                value=f"{len(event.value)} characters",
                limit=f"{MAX_SCALAR} characters",
                remedy="shorten it",
            )
        top = self.stack[-1] if self.stack else None
        if top is not None and isinstance(top.value, dict) and top.key is None:
            self._key(top, event.value, line)
            return
        path = self._next_path(line)
        value = self._number_or_word(event.value, line, path) if event.style in (None, "") else event.value
        self._remember(event.anchor, value, 1)
        self._place(value)

    def _key(self, block: _Open, key: str, line: int) -> None:
        path = (*block.path, key)
        if key == "<<":
            raise self._error(line, f"merge keys are not part of {self.kind}s", path, remedy="write the fields out")
        if key in block.value:
            raise self._error(
                line, "given twice", path, value=f"first on line {self.lines[path]}", remedy="keep one of the two"
            )
        block.key = key
        self.lines[path] = line

    def _alias(self, event: yaml.AliasEvent, line: int) -> None:
        top = self.stack[-1] if self.stack else None
        if top is not None and isinstance(top.value, dict) and top.key is None:
            raise self._error(line, "an alias used as a key", remedy="write the key out")
        if event.anchor not in self.anchors:
            raise self._error(
                line,
                f"alias *{event.anchor} refers to no finished anchor",
                remedy="define the anchor above, or write the value out",
            )
        value, nodes = self.anchors[event.anchor]
        self._count(nodes, line)
        self._next_path(line)
        self._place(value)

    def _next_path(self, line: int) -> FieldPath:
        """FieldPath of the value about to come; items of a list get their line here, fields got it with their key."""
        if not self.stack:
            return ()
        block = self.stack[-1]
        if isinstance(block.value, list):
            path: FieldPath = (*block.path, len(block.value))
            self.lines[path] = line
            return path
        return (*block.path, block.key or "")

    def _place(self, value: Any) -> None:
        if not self.stack:
            self.roots.append(value)
            return
        block = self.stack[-1]
        if isinstance(block.value, list):
            block.value.append(value)
        else:
            block.value[block.key or ""] = value
            block.key = None

    def _remember(self, anchor: str | None, value: Any, nodes: int) -> None:
        if anchor:
            self.anchors[anchor] = (value, nodes)

    def _number_or_word(self, text: str, line: int, path: FieldPath) -> Any:
        if text in ("", "~", "null", "Null", "NULL"):
            return None
        if text in ("true", "True", "TRUE", "false", "False", "FALSE"):
            return text[0] in "tT"
        if _NOT_FINITE.match(text):
            raise self._error(line, "not a finite number", path, value=text, remedy="give a plain number")
        if _MISREAD.match(text):
            raise self._error(
                line,
                "a number that can be read in two ways",
                path,
                value=shortened(text),
                remedy="write plain decimals such as 12.5, or put text in quotes",
            )
        if not _FLOAT.match(text):
            return text
        number = float(text)
        if abs(number) > 1e15 or len(text) > 40:
            raise self._error(
                line,
                "a number out of all bounds",
                path,
                value=shortened(text),
                limit="1e15 and 40 digits",
                remedy="check the exponent and the unit",
            )
        return int(text) if _INTEGER.match(text) else number

    def _refuse_tag(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent, line: int) -> None:
        if event.tag is not None:
            raise self._error(
                line, f"tags are not part of {self.kind}s", value=shortened(event.tag), remedy="remove the tag"
            )

    def _count(self, nodes: int, line: int) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            raise self._error(
                line,
                "too many values, aliases counted as often as they are used",
                limit=str(MAX_NODES),
                remedy=f"{self.kind}s need some hundred at most; write only what is needed",
            )

    def _error(self, line: int, what: str, path: FieldPath | None = None, **more: str) -> InputError:
        if path is None:
            path = self.stack[-1].path if self.stack else ()
        return _error(self.file, line, dotted(path), what, **more)


def _error(
    file: str | Path, line: int, where: str, what: str, *, value: str = "", limit: str = "", remedy: str
) -> InputError:
    return InputError([Problem(str(file), line, where, what, value, limit, remedy)])
