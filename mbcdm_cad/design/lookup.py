"""The catalogue of one design: the package's entries overridden by the design's own entries."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.bought import Bearing, Entry, Material, least_wall_mm
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.entries import KINDS


class Catalogue:
    """Entries by kind and name, of the package and of a design."""

    def __init__(self, design: Design) -> None:
        self._nozzle_mm = design.printing.nozzle_mm
        self._own: dict[str, dict[str, Entry]] = {kind: getattr(design.catalogue, kind) for kind in KINDS}

    def names(self, kind: str) -> list[str]:
        """All names of a kind, the package's first, in the files' order."""
        return list(dict.fromkeys((*package_entries(kind), *self._own[kind])))

    def has(self, kind: str, name: str) -> bool:
        """Whether there is an entry called ``name``."""
        return name in self._own[kind] or name in package_entries(kind)

    def get(self, kind: str, name: str, **changed: Any) -> Any:
        """The entry, an object of its class in ``KINDS``, with the values in ``changed`` replaced.

        The package's entries are not validated at every start, which would take a tenth of its time; a test validates
        them. KeyError if neither the design nor the package has the name.
        """
        own = self._own[kind].get(name)
        if own is not None:
            return replace(own, name=name, **changed)
        found = _bought(kind, name)
        return replace(found, **changed) if changed else found

    def material(self, name: str) -> Material:
        """The material called ``name``, its thinnest wall that of the design's nozzle where it is printed."""
        if name not in self._own["materials"]:
            return _material(name, self._nozzle_mm)
        return _printed_with(self.get("materials", name), self._nozzle_mm)

    def bearing(self, name: str) -> Bearing:
        """The bearing called ``name``."""
        found: Bearing = self.get("bearings", name)
        return found

    def all(self, kind: str) -> tuple[Any, ...]:
        """Every entry of a kind."""
        return tuple(self.get(kind, name) for name in self.names(kind)) if self._own[kind] else _all(kind)

    def materials(self) -> tuple[Material, ...]:
        """Every material, as :meth:`material`."""
        if self._own["materials"]:
            return tuple(self.material(name) for name in self.names("materials"))
        return _materials(self._nozzle_mm)


@cache
def _bought(kind: str, name: str) -> Any:
    """One of the package's entries; cached, since a search needs the same ones again."""
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in package_entries(kind)[name].items()
    }
    return KINDS[kind](name=name, **values)


@cache
def _all(kind: str) -> tuple[Any, ...]:
    return tuple(_bought(kind, name) for name in package_entries(kind))


@cache
def _material(name: str, nozzle_mm: float) -> Material:
    return _printed_with(_bought("materials", name), nozzle_mm)


@cache
def _materials(nozzle_mm: float) -> tuple[Material, ...]:
    return tuple(_material(name, nozzle_mm) for name in package_entries("materials"))


def _printed_with(found: Material, nozzle_mm: float) -> Material:
    return replace(found, min_wall_mm=least_wall_mm(found.process, found.min_wall_mm, nozzle_mm))
