"""Many designs of a configuration whose first rules already run checks on a trial drive: sized one by one.

Such rules cannot work on columns. Each design is sized as alone, so that it has the same values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mbcdm_cad.design.design_file import DesignFile
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import resolved
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError
from mbcdm_cad.sizing.bulk import Alike, Rows
from mbcdm_cad.sizing.known import KnownFields


@dataclass(frozen=True)
class Alone(Alike):
    """A group of one design, with its drive and the names of its sized fields; neither if the design is refused."""

    drive: Drive | None = None
    fields: tuple[str, ...] = ()


def sized_one_by_one(trees: Iterable[Tree], path: Path, file: DesignFile) -> list[Alone]:
    """The designs of some files' values, each sized alone. Lists of blocks, such as cables, are left out."""
    return [_sized(np.array([row]), tree, path, file) for row, tree in enumerate(trees)]


def _sized(rows: Rows, tree: Tree, path: Path, file: DesignFile) -> Alone:
    known = KnownFields({})
    try:
        found = resolved(tree, path, file)
    except InputError as error:
        first = error.problems[0]
        return Alone(rows, known, f"{first.field}: {first.what} (value {first.value})")
    values = [one for one in found.sized if not (isinstance(one.value, list) and isinstance(one.value[0], dict))]
    for one in values:
        known.put(one.field, one.value)
    return Alone(rows, known, drive=found.drive, fields=tuple(one.field for one in values))
