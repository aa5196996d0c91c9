"""Finds configurations: the folders beside this file, those of plug-ins, and those added by a program.

A plug-in announces its module as an entry point of the group ``mbcdm_cad.layouts``.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.interface import Configuration

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

ENTRY_POINTS = "mbcdm_cad.layouts"
# Configuration of new design files by default.
DEFAULT = "miso_bevel"
_FOLDER = Path(__file__).parent
_added: dict[str, Configuration] = {}


def add(module: ModuleType) -> Configuration:
    """Add the ``CONFIGURATION`` of a module from outside the package; a second one of the same name replaces it."""
    found: Configuration = module.CONFIGURATION
    _added[found.name] = found
    return found


def names() -> tuple[str, ...]:
    """Names of all configurations: those of the package first, in alphabetical order."""
    return tuple(dict.fromkeys([*_own(), *sorted(_added), *sorted(_plug_ins())]))


def configuration(name: str) -> Configuration:
    """The configuration called ``name``. Raises ``MbcdmError`` if there is none."""
    if name in _added:
        return _added[name]
    if name in _own():
        found: Configuration = import_module(f"mbcdm_cad.layouts.{name}").CONFIGURATION
        return found
    # Searching the installed packages takes some milliseconds, so it is done only for a name that is not found here.
    if name in _plug_ins():
        return add(import_module(_plug_ins()[name]))
    raise MbcdmError(
        f"configuration: no such configuration (value {name}, limit one of {', '.join(names())}); "
        f"{did_you_mean(name, names()) or 'choose one of them'}"
    )


def configuration_of(drive: Drive) -> Configuration:
    """The configuration that ``drive`` belongs to."""
    return configuration(drive.configuration)


@cache
def _own() -> tuple[str, ...]:
    return tuple(sorted(path.parent.name for path in _FOLDER.glob("*/__init__.py")))


@cache
def _plug_ins() -> dict[str, str]:
    from importlib.metadata import entry_points  # takes as long to import as half of the checks

    return {entry.name: entry.value for entry in entry_points(group=ENTRY_POINTS)}
