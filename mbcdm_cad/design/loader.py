"""Reading a design file: YAML, schema, rules, ``Drive``; every fault becomes an ``InputError``.

The caller says which configuration the file has, and so its :class:`DesignFile`, what the configuration supplies about
its design files: this room does not know the configurations (:mod:`mbcdm_cad.layouts.loader`). A design that was read
is a :class:`LoadedDesign`."""

import copy
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.describe import Given, Node, SchemaNodes
from mbcdm_cad.design.drive import Drive, met
from mbcdm_cad.design.duty_record import by_rows, with_record
from mbcdm_cad.design.fields import is_block
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.ranges import refuse_ranges, split_sigmas
from mbcdm_cad.design.resolve import Catalogue, with_as_built
from mbcdm_cad.design.rules import Broken, NamedEntry, every_broken_rule
from mbcdm_cad.design.sized import Freedom, Moved, SizedValue, Sizing, SizingError, blame_requirements
from mbcdm_cad.design.template import slug
from mbcdm_cad.design.yamltree import FieldPath, Tree, dotted, nearest_line
from mbcdm_cad.errors import InputError, Problem

__all__ = ["DesignFile", "Given"]


@dataclass(frozen=True)
class Reference:
    """The reference design of a layout: its inputs and cables as in a file, values of shared blocks by their place."""

    inputs: list[dict[str, Any]]
    cables: list[dict[str, Any]]
    values: dict[str, Given]


def reference_of(folder: Path) -> Reference:
    """The ``reference.json`` of a layout's ``design_file`` folder.

    "Table", "section" and "Fig." in its sources are those of the paper that describes the mechanism. A layout may name
    another one in ``like``, whose values then hold where the file gives none.
    """
    data = json.loads((folder / "reference.json").read_text("utf-8"))
    values = {place: Given(**given) for place, given in data["values"].items()}
    if "like" in data:
        values = reference_of(folder.parents[1] / data["like"] / folder.name).values | values
    return Reference(data["inputs"], data["cables"], values)


@dataclass(frozen=True)
class DesignFile:
    """The design files of one configuration.

    ``schema`` extends :class:`~mbcdm_cad.design.blocks.Design` by the configuration's own blocks; ``reference`` holds
    the reference values of the shared blocks' fields by their place. The three functions are called with a design of
    that schema: ``rules`` yields the configuration's rules that the design breaks, ``named`` the catalogue entries that
    its own blocks name, and ``drive`` makes the configuration's :class:`~mbcdm_cad.design.drive.Drive`, the sigmas
    given by field.
    """

    schema: type[Design]
    reference: Mapping[str, Given]
    rules: Callable[[Any], Iterator[Broken]]
    named: Callable[[Any], Iterator[NamedEntry]]
    drive: Callable[[Any, Catalogue, Mapping[FieldPath, float]], Drive]
    # Name of the module of the configuration's sizing rules, if it has any: only files with gaps import it.
    sizing: str = ""
    # Text of a short file of requirements, with a place for the design's ``name``; empty without sizing rules.
    starting: str = ""

    def size(self, data: dict[str, Any], moved: Moved, similar: Sizing | None = None) -> Sizing:
        """Fill the open fields of the data, which it may change. ``moved`` and ``similar``: see :func:`resolved`."""
        sized: Sizing = import_module(self.sizing).size(data, moved, similar)
        return sized

    def derived(self) -> tuple[str, ...]:
        """Fields that are neither requirement nor choice: given in a file, they are pins."""
        return import_module(self.sizing).DERIVED if self.sizing else ()

    def freedoms(self) -> tuple[Freedom, ...]:
        """Fields that a search for a passing design may change, besides derived numbers."""
        return import_module(self.sizing).FREEDOMS if self.sizing else ()

    @cached_property
    def nodes(self) -> SchemaNodes:
        """The schema's node of each field; writing the schema takes a tenth of a second."""
        return SchemaNodes(self.schema, self.reference)

    def node_at(self, path: FieldPath) -> Node | None:
        """The schema's node of one field, None if unknown; the schema is written only when this is called."""
        return self.nodes.at(path)


@dataclass(frozen=True)
class LoadedDesign:
    """A design file that passed schema and rules.

    ``design`` is the file as its schema's model, ``data`` the plain values of the fields that the file gives or sizing
    filled, ``sized`` those that sizing filled.
    """

    drive: Drive
    path: Path
    design: Design = field(repr=False)
    text: str = field(repr=False)
    lines: Mapping[FieldPath, int] = field(repr=False)
    data: Mapping[str, Any] = field(repr=False)
    sized: tuple[SizedValue, ...] = field(default=(), repr=False)

    @cached_property
    def sha256(self) -> str:
        """Hash of the content: all values and the catalogue entries that they use, without layout and comments."""
        content = {"design": self.design.model_dump(mode="json"), "drive": asdict(self.drive)}
        return hashlib.sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()

    @cached_property
    def given(self) -> dict[str, Any]:
        """The validated values of the fields in ``data``, without the defaults of the others, as JSON has them."""
        found: dict[str, Any] = _of_keys(self.design.model_dump(mode="json"), self.data)
        return found

    def line_of(self, *field_path: str | int) -> int:
        """Line of a field, as in ``line_of("cables", 0, "step")``; of the block above it where it is not given."""
        return nearest_line(self.lines, field_path)


def _of_keys(value: Any, like: Any) -> Any:
    """``value`` with those keys of its blocks that ``like`` has too, in the order of ``like``."""
    if isinstance(value, dict) and isinstance(like, Mapping):
        return {key: _of_keys(value[key], item) for key, item in like.items() if key in value}
    if isinstance(value, list) and isinstance(like, list):
        return [_of_keys(item, other) for item, other in zip(value, like, strict=True)]
    return value


def loaded(tree: Tree, text: str, path: Path, file: DesignFile) -> LoadedDesign:
    """The design in ``tree``, which was parsed from ``text`` or has the same values. Raises as :func:`resolved`."""
    found = resolved(tree, path, file)
    return LoadedDesign(found.drive, path, found.design, text, tree.lines, found.data, found.sized)


class Resolved(NamedTuple):
    """A valid design, its drive, its plain data, and its sizing; None where the file gives every field."""

    design: Design
    drive: Drive
    data: dict[str, Any]
    sizing: Sizing | None

    @property
    def sized(self) -> tuple[SizedValue, ...]:
        """The fields that sizing filled."""
        return () if self.sizing is None else self.sizing.values


def resolved(
    tree: Tree, path: Path, file: DesignFile, moved: Moved | None = None, similar: Sizing | None = None
) -> Resolved:
    """The design and its drive from a tree of the file's values. Raises InputError with all problems of one stage.

    The stages are: ranges, sigmas, schema, sizing of missing fields, schema of the whole, rules between fields.
    ``moved``: by field, the functions with which a search changes the values of rules; ``similar``: the sizing of a
    design that differs little, from which the rules begin.
    """
    tree, sigmas = _split(tree, str(path), file)
    sizing = _sized(tree, str(path), file, moved or {}, similar)
    tree = tree if sizing is None else Tree(sizing.data, tree.lines)
    design = _validated(tree, str(path), file)
    catalogue = Catalogue(design)
    broken = every_broken_rule(design, catalogue, file.rules(design), file.named(design))
    _refuse_broken_rules(broken, tree, str(path))
    drive = with_as_built(file.drive(design, catalogue, sigmas), design.as_built)
    drive = replace(drive, loads=with_record(drive.loads, path, 2.0 * drive.half_travel_deg))
    return Resolved(design, met(drive), tree.data, sizing)


def blamed(error: InputError, tree: Tree, path: Path, file: DesignFile) -> InputError:
    """``error`` of a file for its reader: a derived value out of bounds is told as of the requirement behind it.

    A value of the requirement that works is found by sizing the drive some ten times, so that searches, which only ask
    whether a file is valid, do without it.
    """
    try:
        given, _ = _split(tree, str(path), file)
        sizing = _sized(given, str(path), file, {}, None)
    except (InputError, SizingError):
        return error
    if sizing is None:
        return error
    try:
        _validated(Tree(sizing.data, given.lines), str(path), file)
    except InputError as bounds:
        fits = partial(_fits, path=path, file=file)
        return InputError(blame_requirements(list(bounds.problems), given, sizing, fits))
    return error


def _split(tree: Tree, path: str, file: DesignFile) -> tuple[Tree, dict[FieldPath, float]]:
    """The tree with plain values, and the sigmas."""
    refuse_ranges(tree, path, file.node_at)
    if isinstance(tree.data, dict) and tree.data.get("as_built", ()) is None:
        tree.data["as_built"] = []  # all entries are comments, as 'mbcdm loop --apply' writes the members of a set
    return split_sigmas(tree, path, lambda field: bool((file.node_at(field) or {}).get("uncertain")))


def _sized(tree: Tree, path: str, file: DesignFile, moved: Moved, similar: Sizing | None) -> Sizing | None:
    """The data with its open fields filled, and their records. The fields of the file must already be valid."""
    if not file.sizing or not isinstance(tree.data, dict) or not _has_gaps(tree, path, file):
        return None
    data = _with_blocks(tree, path, file)
    recorded = by_rows(data, Path(path))
    try:
        sizing = file.size(data, moved, similar)
    except SizingError as error:
        _refuse_broken_rules(iter(error.broken), tree, path)
        raise
    if recorded is not None:
        sizing.data["loads"]["duty"] = recorded
    return sizing


def _with_blocks(tree: Tree, path: str, file: DesignFile) -> dict[str, Any]:
    """A copy of the data with the blocks that rules will fill."""
    data: dict[str, Any] = copy.deepcopy(tree.data)
    for name, block in file.schema.model_fields.items():
        if block.is_required() and is_block(block.annotation) and data.get(name) is None:
            data[name] = {}
    data.setdefault("name", slug(Path(path).stem))
    return data


def _has_gaps(tree: Tree, path: str, file: DesignFile) -> bool:
    """Whether fields are left to rules. Raises InputError if one is invalid, or an item of a list lacks a field."""
    blocks = {name for name, field in file.schema.model_fields.items() if is_block(field.annotation)}
    try:
        design = file.schema.model_validate({k: v for k, v in tree.data.items() if v is not None or k not in blocks})
    except ValidationError as error:
        problems = schema_problems(error, tree, path, file.node_at, wanted=_is_wrong)
        if problems:
            raise InputError(problems) from None
        return True
    stage = design.stage  # whose values no schema demands: they depend on its kind
    if stage is None:
        return False
    own = (stage.belt, stage.belt_teeth) if stage.kind == "belt" else (stage.module_mm,)
    return None in (stage.ratio, stage.driver_teeth, stage.width_mm, *own)


def _is_wrong(item: Any) -> bool:
    """Whether one of pydantic's findings is a real error and not only a missing field, which sizing may fill.

    Rules fill no field of an item of a list, of an entry of the catalogue, or of a rope that is written inline.
    """
    path = item["loc"]
    never_filled = (
        any(isinstance(part, int) for part in path) or path[0] == "catalogue" or path[:2] == ("rope", "inline")
    )
    return item["type"] != "missing" or never_filled or path == ("configuration",)


def _fits(tree: Tree, path: Path, file: DesignFile) -> bool:
    """Whether every value of the file, given or from a rule, is within its bounds."""
    try:
        sizing = _sized(tree, str(path), file, {}, None)
        _validated(tree if sizing is None else Tree(sizing.data, tree.lines), str(path), file)
    except (InputError, SizingError):
        return False
    return True


def _validated(tree: Tree, path: str, file: DesignFile) -> Design:
    try:
        return file.schema.model_validate(tree.data)
    except ValidationError as error:
        raise InputError(schema_problems(error, tree, path, file.node_at)) from None


def _refuse_broken_rules(broken: Iterator[Broken], tree: Tree, path: str) -> None:
    problems = [Problem(path, tree.line_of(rule.path), dotted(rule.path), *rule[1:]) for rule in broken]
    if problems:
        raise InputError(sorted(problems, key=lambda problem: problem.line))
