"""Reading a design file: YAML, schema, rules, ``Drive``; every fault becomes an ``InputError``.

Which configuration the file is of, and so its :class:`~mbcdm_cad.design.design_file.DesignFile`, is for the caller to
say: this room knows of no configuration (:mod:`mbcdm_cad.configurations.loader`).
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

from pydantic import ValidationError

from mbcdm_cad.design.as_built import with_as_built
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.design_file import DesignFile
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fieldpath import FieldPath, dotted
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.resolve import as_built
from mbcdm_cad.design.rules import Broken, broken_names, broken_shared_rules, named_by_shared_blocks
from mbcdm_cad.design.sigmas import split_sigmas
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError, Problem


def loaded(tree: Tree, text: str, path: Path, file: DesignFile) -> LoadedDesign:
    """The design in ``tree``, which was parsed from ``text`` or holds the same values. Raises as :func:`resolved`."""
    design, drive = resolved(tree, path, file)
    return LoadedDesign(drive, path, _sha256(design, drive), design, text, tree.lines)


def resolved(tree: Tree, path: Path, file: DesignFile) -> tuple[Design, Drive]:
    """The design and its drive from a tree of the file's values. Raises InputError with all problems of one stage.

    The stages are: sigmas, schema, rules between fields.
    """
    tree, sigmas = _split(tree, str(path), file)
    design = _validated(tree, str(path), file)
    catalogue = Catalogue(design)
    _refuse_broken_rules(_broken(design, catalogue, file), tree, str(path))
    return design, with_as_built(file.drive(design, catalogue, sigmas), as_built(design))


def _split(tree: Tree, path: str, file: DesignFile) -> tuple[Tree, dict[FieldPath, float]]:
    """The tree with plain values, and the sigmas."""
    if isinstance(tree.data, dict) and tree.data.get("as_built", ()) is None:
        tree.data["as_built"] = []  # all entries are comments still, as 'mbcdm loop --apply' writes what is undecided
    return split_sigmas(tree, path, lambda field: bool((file.nodes.at(field) or {}).get("uncertain")))


def _validated(tree: Tree, path: str, file: DesignFile) -> Design:
    try:
        return file.schema.model_validate(tree.data)
    except ValidationError as error:
        raise InputError(schema_problems(error, tree, path, file.nodes.at)) from None


def _broken(design: Design, catalogue: Catalogue, file: DesignFile) -> Iterator[Broken]:
    yield from file.rules(design)
    yield from broken_shared_rules(design)
    yield from broken_names(catalogue, named_by_shared_blocks(design))
    yield from broken_names(catalogue, file.named(design))


def _refuse_broken_rules(broken: Iterator[Broken], tree: Tree, path: str) -> None:
    problems = [Problem(path, tree.line_of(rule.path), dotted(rule.path), *rule[1:]) for rule in broken]
    if problems:
        raise InputError(sorted(problems, key=lambda problem: problem.line))


def _sha256(design: Design, drive: Drive) -> str:
    content = {"design": design.model_dump(mode="json"), "drive": dataclasses.asdict(drive)}
    return hashlib.sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
