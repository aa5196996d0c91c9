"""Resolve the blocks of the design file that all drives with a drum sector share."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from typing import Any, Protocol

from mbcdm_cad.design.bought import NO_BEARING
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.rules import NamedEntry
from mbcdm_cad.design.sector_blocks import Clearances, SectorCable, SectorDrum, SteppedPulleys


class Framed(Protocol):
    """The block of the frame."""

    @property
    def material(self) -> str:
        """Name of the frame's material."""


class SectorBlocks(Protocol):
    """The blocks."""

    @property
    def clearances(self) -> Clearances:
        """Gaps between finished surfaces."""

    @property
    def drum(self) -> SectorDrum:
        """The sector."""

    @property
    def input_pulleys(self) -> SteppedPulleys:
        """The pulleys."""

    @property
    def support(self) -> Framed:
        """The frame."""


def sector_values(design: SectorBlocks, catalogue: Catalogue) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.parts.drum_sector.design.SectorDrive` but cables and bearings, and the frame."""
    drum, pulleys, support = design.drum, design.input_pulleys, design.support
    return {
        "clearances": design.clearances,
        "tensioner": catalogue.get("tensioners", drum.tensioner),
        "spring": None if drum.spring is None else catalogue.get("springs", drum.spring),
        "springs": catalogue.all("springs"),
        "drum": drum,
        "drum_material": catalogue.material(drum.material),
        "shaft_material": catalogue.material(drum.shaft_material),
        "input_pulleys": pulleys,
        "pulley_material": catalogue.material(pulleys.material),
        "support": support,
        "frame_material": catalogue.material(support.material),
    }


def terminal_angle_rad(cable: SectorCable) -> float | None:
    """Angle on the drum, rad, at which a cable is to leave its land; None if the file leaves it out."""
    return None if cable.terminal_angle_deg is None else radians(cable.terminal_angle_deg)


def sector_entries(design: SectorBlocks) -> Iterator[NamedEntry]:
    """Entries of the catalogue that these blocks name."""
    drum, pulleys = design.drum, design.input_pulleys
    yield NamedEntry(("drum", "material"), "materials", drum.material)
    yield NamedEntry(("drum", "bearing"), "bearings", drum.bearing)
    yield NamedEntry(("drum", "shaft_material"), "materials", drum.shaft_material)
    yield NamedEntry(("drum", "tensioner"), "tensioners", drum.tensioner)
    yield NamedEntry(("drum", "spring"), "springs", drum.spring)
    yield NamedEntry(("input_pulleys", "material"), "materials", pulleys.material)
    for field, name in (("lower_bearing", pulleys.lower_bearing), ("upper_bearing", pulleys.upper_bearing)):
        own = pulleys.overhung and name == NO_BEARING
        yield NamedEntry(("input_pulleys", field), "bearings", None if own else name)
    yield NamedEntry(("input_pulleys", "collar_screw"), "screws", pulleys.collar_screw)
