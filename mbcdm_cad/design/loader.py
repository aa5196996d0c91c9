"""Reading a design file: bytes, YAML, schema, rules, ``Drive``; every fault becomes an ``InputError``."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loaded import FieldPath, LoadedDesign
from mbcdm_cad.design.resolve import resolve
from mbcdm_cad.design.rules import broken_rules
from mbcdm_cad.design.schema import Design
from mbcdm_cad.design.sigmas import split_sigmas
from mbcdm_cad.design.source import read_text
from mbcdm_cad.errors import InputError, Problem


def load_design(path: str | Path) -> LoadedDesign:
    """Read, validate and resolve a design file. Raises InputError with all problems found at one stage."""
    path = Path(path)
    return load_text(read_text(path), path)


def load_text(text: str, path: str | Path = "<text>") -> LoadedDesign:
    """As :func:`load_design`, from the text of a file; ``path`` names it in errors."""
    return load_tree(yamltree.parse(text, str(path)), text, path)


def load_tree(tree: yamltree.Tree, text: str, path: str | Path) -> LoadedDesign:
    """As :func:`load_text`, from a tree that was read from ``text`` or holds the same values."""
    design, drive = resolved(tree, path)
    return LoadedDesign(drive, Path(path), _sha256(design, drive), design, text, tree.lines)


def resolved(tree: yamltree.Tree, path: str | Path) -> tuple[Design, Drive]:
    """The design and its ``Drive`` from a tree of the file's values. Raises as :func:`load_design`."""
    tree, sigmas = _split(tree, str(path))
    design = _validated(tree, path)
    _refuse_broken_rules(design, tree, path)
    return design, resolve(design, sigmas)


def _split(tree: yamltree.Tree, file: str) -> tuple[yamltree.Tree, dict[FieldPath, float]]:
    """The tree with plain values, and the sigmas."""
    if isinstance(tree.data, dict) and tree.data.get("as_built", ()) is None:
        tree.data["as_built"] = []  # all entries are comments still, as 'mbcdm loop --apply' writes what is undecided
    return split_sigmas(tree, file)


def _validated(tree: yamltree.Tree, path: str | Path) -> Design:
    try:
        return Design.model_validate(tree.data)
    except ValidationError as error:
        from mbcdm_cad.design.problems import schema_problems  # costs a start nothing while the file is right

        raise InputError(schema_problems(error, tree, str(path))) from None


def _refuse_broken_rules(design: Design, tree: yamltree.Tree, path: str | Path) -> None:
    broken = [
        Problem(str(path), tree.line_of(rule.path), yamltree.dotted(rule.path), *rule[1:])
        for rule in broken_rules(design)
    ]
    if broken:
        raise InputError(sorted(broken, key=lambda problem: problem.line))


def _sha256(design: Design, drive: Drive) -> str:
    content = {"design": design.model_dump(mode="json"), "drive": dataclasses.asdict(drive)}
    return hashlib.sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
