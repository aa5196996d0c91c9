"""Finds layouts: the folders beside this file, those of plug-ins, and those added by a program.

A plug-in announces its class as an entry point of the group ``mbcdm_cad.layouts``: ``name = "package.module:Class"``.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from mbcdm_cad.errors import MbcdmError, did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.design.loader import DesignFile
    from mbcdm_cad.layouts.base import Layout

ENTRY_POINTS = "mbcdm_cad.layouts"
# Layout of new design files by default.
DEFAULT = "miso_bevel"
_FOLDER = Path(__file__).parent
_added: dict[str, type[Layout]] = {}


def add(layout: type[Layout]) -> type[Layout]:
    """Add a layout from outside the package; a second one of the same name replaces it."""
    _added[layout.name] = layout
    return layout


def names() -> tuple[str, ...]:
    """Names of all layouts: those of the package first, in alphabetical order."""
    return tuple(dict.fromkeys([*_own(), *sorted(_added), *sorted(_plug_ins())]))


def layout_named(name: str) -> type[Layout]:
    """The layout called ``name``. Raises ``MbcdmError`` if there is none."""
    if name in _own() and name not in _added:
        found: type[Layout] = import_module(f"mbcdm_cad.layouts.{name}.layout").LAYOUT
        return found
    return _from_outside(name)


def layout_of(drive: Drive) -> Layout:
    """A design as an object of its layout: routes, parts, checks. The same object for the same drive."""
    return drive.once("layout", lambda one: layout_named(one.configuration)(one))


def design_file_named(name: str) -> DesignFile:
    """What the design files of a layout hold, without the rest of the layout: ``init`` and ``schema`` start fast."""
    if name in _own() and name not in _added:
        found: DesignFile = import_module(f"mbcdm_cad.layouts.{name}.design_file").DESIGN_FILE
        return found
    return _from_outside(name).design_file()


def _from_outside(name: str) -> type[Layout]:
    if name in _added:
        return _added[name]
    # Searching the installed packages takes some milliseconds, so it is done only for a name that is not found here.
    if name in _plug_ins():
        return add(_plug_ins()[name].load())
    raise MbcdmError(
        f"configuration: no such configuration (value {name}, limit one of {', '.join(names())}); "
        f"{did_you_mean(name, names()) or 'choose one of them'}"
    )


@cache
def _own() -> tuple[str, ...]:
    return tuple(sorted(path.parent.name for path in _FOLDER.glob("*/__init__.py")))


@cache
def _plug_ins() -> dict[str, EntryPoint]:
    from importlib.metadata import entry_points  # takes as long to import as half of the checks

    return {entry.name: entry for entry in entry_points(group=ENTRY_POINTS)}
