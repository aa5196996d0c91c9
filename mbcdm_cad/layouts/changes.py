"""Change fields of a design from a program; the result is validated like an edited file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.design_file import DesignFile
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fieldpath import FieldPath, dotted
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.loader import open_data, resolved
from mbcdm_cad.design.sigmas import SIGMA, VALUE
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError, MbcdmError, Problem, shortened
from mbcdm_cad.layouts.loader import design_file_of, load_for_reader, resolve_tree
from mbcdm_cad.sizing.bulk import Alike, Rows
from mbcdm_cad.sizing.known import KnownFields

SEPARATOR = "__"


def with_changes(loaded: LoadedDesign, changes: Mapping[str, Any]) -> LoadedDesign:
    """The design with ``changes`` applied to its file's content; ``loaded`` does not change.

    Keys are fields, ``transmission__centre_distance_mm`` or ``transmission.centre_distance_mm``, or blocks whose value
    is a mapping of their fields; the item of a list is named by its index from 0, ``cables__0__preload_N``. A value
    that carries a sigma keeps it. Raises ``InputError`` with the messages that the edited file would get; lines are
    those of ``loaded``'s file.
    """
    tree = yamltree.parse(loaded.text, str(loaded.path))
    data = _changed(tree.data, changes, loaded)
    text = yaml.safe_dump(data, sort_keys=False, allow_unicode=True)
    return load_for_reader(yamltree.Tree(data, tree.lines), text, loaded.path)


def changed_drives(loaded: LoadedDesign, rows: Iterable[Mapping[str, Any]]) -> Iterator[Drive]:
    """As :func:`with_changes` for each of many rows, but only the drives: about a thousand a second of a whole file."""
    tree = yamltree.parse(loaded.text, str(loaded.path))
    for changes in rows:
        yield resolve_tree(yamltree.Tree(_changed(tree.data, changes, loaded), tree.lines), loaded.path)


class ManySized(NamedTuple):
    """Designs sized together: the fields that the rules fill, the groups of designs, and the drive of a group.

    ``drive_of`` is called with a group and a drive of the same file.
    """

    fields: tuple[str, ...]
    groups: Sequence[Alike]
    drive_of: Callable[[Any, Drive], Drive]


def sized_many(loaded: LoadedDesign, columns: Mapping[str, Any]) -> ManySized:
    """The designs with the ``columns`` applied, sized; one by one if losses count, if a stiffness is asked for, or if
    the configuration cannot size them together.

    Columns hold numbers or names, one for each design. Raises ``InputError`` for a value that the file could not hold,
    ``MbcdmError`` for a field of another kind.
    """
    tree = yamltree.parse(loaded.text, str(loaded.path))
    file = design_file_of(tree, str(loaded.path))
    for field, values in columns.items():
        if values.dtype.kind not in "iufU":
            raise MbcdmError(f"{field}: only numbers and names can differ from design to design; give one of them each")

    def changed(row: Mapping[str, Any]) -> yamltree.Tree:
        return yamltree.Tree(_changed(tree.data, row, loaded), tree.lines)

    # Limits of single fields hold for all values between the smallest and the largest.
    for end in (np.min, np.max):
        row = {field: end(values) for field, values in columns.items() if values.dtype.kind != "U"}
        data = open_data(changed(row), loaded.path, file)
    # Losses are those of bearings and gearheads at their places in the frame, which only a whole design has.
    together = "limits.losses" not in columns and not loaded.drive.limits.counts_losses
    # So do a stiffness, a share of the structure and an ease of turning.
    for wish in ("stiffness_Nm_rad", "structure_share", "backdrive_Nm"):
        together = together and f"loads.{wish}" not in columns and getattr(loaded.drive.loads, wish) is None
    # A ratio that no file states is that of the lightest of several drives.
    together = together and not any(value.field == "transmission.ratio" for value in loaded.sized)
    if file.size_many is not None and together:
        many = file.size_many()
        return ManySized(many.fields, list(many.size(data, columns)), many.drive)
    rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    alone = sized_one_by_one(map(changed, rows), loaded.path, file)
    fields = dict.fromkeys(field for one in alone for field in one.fields)
    return ManySized(tuple(fields), alone, lambda group, like: group.drive)


def _changed(data: Any, changes: Mapping[str, Any], loaded: LoadedDesign) -> Any:
    copy = _plain(data)
    for key, value in changes.items():
        _put(copy, tuple(key.replace(SEPARATOR, ".").split(".")), _plain(value), loaded, key)
    return copy


def _plain(value: Any) -> Any:
    """A deep copy that has only dicts, lists and plain scalars; numbers and arrays of numpy are converted."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(item) for item in value]
    return value


def _put(data: Any, path: tuple[str, ...], value: Any, loaded: LoadedDesign, key: str) -> None:
    """Apply ``value`` to the data at ``path``; missing blocks on the way are created."""
    at, passed = data, list[str | int]()
    for part in path[:-1]:
        at = _child(at, part, tuple(passed), loaded, key)
        passed.append(part)
    last = _index(at, path[-1], tuple(passed), loaded, key)
    there = at[last] if isinstance(at, list) else at.get(last)
    at[last] = _merged(there, value)


def _child(at: Any, part: str, passed: FieldPath, loaded: LoadedDesign, key: str) -> Any:
    index = _index(at, part, passed, loaded, key)
    if isinstance(at, list):
        return at[index]
    if at.get(index) is None:
        at[index] = {}
    return at[index]


def _index(at: Any, part: str, passed: FieldPath, loaded: LoadedDesign, key: str) -> Any:
    """``part`` as the key of a block or the index of a list. Raises ``InputError`` where there is neither."""
    where = dotted(passed)
    if isinstance(at, dict):
        return part
    if not isinstance(at, list):
        what, limit = f"{where} is no block", ""
        remedy = f"give {where} itself"
    elif part.isdigit() and int(part) < len(at):
        return int(part)
    else:
        what, limit = f"{where} has no item {part}", f"0 to {len(at) - 1}"
        remedy = "give an index within the list, or the whole list"
    problem = Problem(str(loaded.path), loaded.line_of(*passed), key, what, shortened(at), limit, remedy)
    raise InputError([problem])


def _merged(there: Any, value: Any) -> Any:
    """``value`` applied to the old one: blocks field by field; a number in place of a value with a sigma keeps it."""
    if isinstance(there, dict) and isinstance(value, dict):
        return {**there, **{key: _merged(there.get(key), item) for key, item in value.items()}}
    if isinstance(there, dict) and set(there) == {VALUE, SIGMA} and isinstance(value, int | float):
        return {VALUE: value, SIGMA: there[SIGMA]}
    return value


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
