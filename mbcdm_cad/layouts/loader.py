"""Read, create and describe design files of any configuration; the field ``configuration`` of a file names it."""

from contextlib import suppress
from pathlib import Path
from typing import Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import DesignFile, LoadedDesign, blamed, loaded, resolved
from mbcdm_cad.design.problems import at_most_listed
from mbcdm_cad.design.template import new_text, reference_values, with_derived
from mbcdm_cad.design.yamltree import Tree, parse, read_text
from mbcdm_cad.errors import InputError, MbcdmError, Problem, did_you_mean, shortened
from mbcdm_cad.layouts.registry import DEFAULT, design_file_named, layout_of, names

__all__ = [
    "DEFAULT",
    "design_file",
    "design_file_of",
    "layout_of",
    "load_design",
    "load_for_reader",
    "load_text",
    "load_tree",
    "new_design_text",
    "reference_data",
    "resolve_tree",
    "short_design_text",
]


def load_design(path: str | Path) -> LoadedDesign:
    """Read, validate and resolve a design file. Raises InputError with all problems found at one stage."""
    path = Path(path)
    return load_text(read_text(path), path)


def load_text(text: str, path: str | Path = "<text>") -> LoadedDesign:
    """As :func:`load_design`, from the text of a file; ``path`` names it in errors."""
    return load_for_reader(parse(text, str(path)), text, path)


def load_for_reader(tree: Tree, text: str, path: str | Path) -> LoadedDesign:
    """As :func:`load_text`, from a tree that was read from ``text`` or has the same values."""
    file = design_file_of(tree, str(path))
    try:
        return loaded(tree, text, Path(path), file)
    except InputError as error:
        raise blamed(error, tree, Path(path), file) from None


def load_tree(tree: Tree, text: str, path: str | Path) -> LoadedDesign:
    """As :func:`load_for_reader`, for searches: a derived value out of bounds is not traced to its requirement."""
    return loaded(tree, text, Path(path), design_file_of(tree, str(path)))


def resolve_tree(tree: Tree, path: str | Path) -> Drive:
    """The drive alone of a tree of the file's values. Raises as :func:`load_design`."""
    return resolved(tree, Path(path), design_file_of(tree, str(path))).drive


def new_design_text(name: str, of: str = DEFAULT) -> str:
    """Text of a design file called ``name`` (a slug): the reference design of the configuration ``of``, commented."""
    return new_text(design_file(of).nodes, name)


def short_design_text(name: str, of: str = DEFAULT, *, derived: bool = False) -> str:
    """Text of a short design file called ``name`` (a slug): the requirements of a drive of configuration ``of``.

    ``derived``: with every value that follows, as a comment. Raises ``MbcdmError`` for a configuration without rules.
    """
    file = design_file(of)
    if not file.starting:
        raise MbcdmError(f"{of}: no sizing rules yet; leave --full out for a file with all values")
    text = file.starting.format(name=name)
    return with_derived(text, load_text(text, f"{name}.yaml").sized) if derived else text


def reference_data(of: str = DEFAULT) -> dict[str, Any]:
    """The reference design of a configuration as plain data, as its file would be read."""
    return reference_values(design_file(of).nodes)


def design_file(name: str = DEFAULT) -> DesignFile:
    """The design files of one layout. Raises ``MbcdmError`` if there is none of that name."""
    return design_file_named(name)


def design_file_of(tree: Tree, path: str) -> DesignFile:
    """The design files of the file's ``configuration``. Raises ``InputError`` if it names none that there is.

    A file that is no block at all goes to the default, whose schema reports that.
    """
    if not isinstance(tree.data, dict):
        return design_file_named(DEFAULT)
    if "configuration" not in tree.data:
        raise InputError(at_most_listed(_without_configuration(tree, path), path))
    name: Any = tree.data["configuration"]
    if isinstance(name, str):
        with suppress(MbcdmError):
            return design_file_named(name)
    where = path, tree.line_of(("configuration",)), "configuration", "not a known word", shortened(name)
    raise InputError([Problem(*where, "one of " + ", ".join(names()), did_you_mean(str(name), names()))])


def _without_configuration(tree: Tree, path: str) -> list[Problem]:
    """That the configuration is missing, and the blocks that no layout has; other faults depend on the layout."""
    limit, remedy = "one of " + ", ".join(names()), f"add it, for example configuration: {DEFAULT}"
    known = {field for name in names() for field in design_file_named(name).schema.model_fields}
    unknown = [
        Problem(path, tree.line_of((key,)), str(key), "unknown field", remedy=did_you_mean(str(key), sorted(known)))
        for key in tree.data
        if key not in known
    ]
    if 2 * len(unknown) > len(tree.data):
        return [Problem(path, 1, "", "most of its fields are none of a design", remedy="give the design file first")]
    return [Problem(path, 1, "configuration", "missing", "", limit, remedy, missing=True), *unknown]
