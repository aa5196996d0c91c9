"""Reading a design file: YAML, schema, rules, ``Drive``; every fault becomes an ``InputError``.

The caller says which configuration the file has, and so its :class:`~mbcdm_cad.design.design_file.DesignFile`: this
room does not know the configurations (:mod:`mbcdm_cad.layouts.loader`).
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from mbcdm_cad.design.as_built import with_as_built
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.derived_bounds import blame_requirements
from mbcdm_cad.design.design_file import DesignFile
from mbcdm_cad.design.drive import Drive, met
from mbcdm_cad.design.duty_record import by_rows, with_record
from mbcdm_cad.design.fieldpath import FieldPath, dotted
from mbcdm_cad.design.fields import is_block
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.ranges import refuse_ranges
from mbcdm_cad.design.rules import Broken, every_broken_rule
from mbcdm_cad.design.sigmas import split_sigmas
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError
from mbcdm_cad.design.template import slug
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError, Problem


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
    if file.sizing is None or not isinstance(tree.data, dict) or not _has_gaps(tree, path, file):
        return None
    data = _with_blocks(tree, path, file)
    recorded = by_rows(data, Path(path))
    try:
        sizing = file.sizing.size(data, moved, similar)
    except SizingError as error:
        _refuse_broken_rules(iter(error.broken), tree, path)
        raise
    if recorded is not None:
        sizing.data["loads"]["duty"] = recorded
    return sizing


def _with_blocks(tree: Tree, path: str, file: DesignFile) -> dict[str, Any]:
    """A copy of the data with the blocks that rules will fill."""
    data: dict[str, Any] = copy.deepcopy(tree.data)
    for name, field in file.schema.model_fields.items():
        if field.is_required() and is_block(field.annotation) and data.get(name) is None:
            data[name] = {}
    data.setdefault("name", slug(Path(path).stem))
    return data


def _has_gaps(tree: Tree, path: str, file: DesignFile) -> bool:
    """Whether fields are missing. Raises InputError if given fields are invalid, or items of a list lack a field."""
    filled = {name: value for name, value in tree.data.items() if value is not None or not _may_be_left_out(name, file)}
    try:
        file.schema.model_validate(filled)
    except ValidationError as error:
        problems = schema_problems(error, tree, path, file.node_at, wanted=_is_wrong)
        if problems:
            raise InputError(problems) from None
        return True
    return False


def _may_be_left_out(name: str, file: DesignFile) -> bool:
    field = file.schema.model_fields.get(name)
    return field is not None and is_block(field.annotation)


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
