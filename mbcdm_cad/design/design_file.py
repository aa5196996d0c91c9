"""What a configuration supplies about its design files; the loader, shared by all configurations, reads it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.describe import Given, Node, SchemaNodes
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.rules import Broken, NamedEntry
from mbcdm_cad.design.sized import Moved, Sizing

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


class LazySizing:
    """The sizing rules of a layout, a module that is imported when first used: only files with gaps need it."""

    def __init__(self, module: str) -> None:
        """``module``: its name; it has a function ``size`` and the constants ``DERIVED`` and ``FREEDOMS``."""
        self.module = module

    def size(self, data: dict[str, Any], moved: Moved, similar: Sizing | None) -> Sizing:
        """Fill the open fields of the data, which it may change.

        ``moved`` has the functions with which a search changes the values of rules; ``similar``, the sizing of a
        similar design, makes the search for values shorter.
        """
        sized: Sizing = import_module(self.module).size(data, moved, similar)
        return sized

    def derived(self) -> tuple[str, ...]:
        """See :meth:`DesignFile.derived`."""
        fields: tuple[str, ...] = import_module(self.module).DERIVED
        return fields

    def freedoms(self) -> tuple[Freedom, ...]:
        """See :meth:`DesignFile.freedoms`."""
        found: tuple[Freedom, ...] = import_module(self.module).FREEDOMS
        return found


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
    # The configuration's sizing rules, if it has any.
    sizing: LazySizing | None = None
    # Text of a short file of requirements, with a place for the design's ``name``; empty without sizing rules.
    starting: str = ""

    def derived(self) -> tuple[str, ...]:
        """Fields that are neither requirement nor choice: given in a file, they are pins."""
        return () if self.sizing is None else self.sizing.derived()

    def freedoms(self) -> tuple[Freedom, ...]:
        """Fields that a search for a passing design may change, besides derived numbers."""
        return () if self.sizing is None else self.sizing.freedoms()

    @cached_property
    def nodes(self) -> SchemaNodes:
        """The schema's node of each field; writing the schema takes a tenth of a second."""
        return SchemaNodes(self.schema, self.reference)

    def node_at(self, path: FieldPath) -> Node | None:
        """The schema's node of one field, None if unknown; the schema is written only when this is called."""
        return self.nodes.at(path)
