"""Resolve the blocks of the design file that all drives with a drum sector share."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from typing import Any, Protocol

from mbcdm_cad.design.lookup import Catalogue, copied
from mbcdm_cad.design.rules import NamedEntry
from mbcdm_cad.design.sector_blocks import SectorCable, SectorDrum, SteppedPulleys
from mbcdm_cad.parts.drum_sector.design import DrumSpec, InputPulleySpec


class SectorBlocks(Protocol):
    """The blocks."""

    @property
    def drum(self) -> SectorDrum:
        """The sector."""

    @property
    def input_pulleys(self) -> SteppedPulleys:
        """The pulleys."""


def sector_values(design: SectorBlocks, catalogue: Catalogue) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.parts.drum_sector.design.SectorDrive` but cables, bearings and clearances."""
    drum = design.drum
    return {
        "tensioner": catalogue.get("tensioners", drum.tensioner),
        "drum": copied(
            DrumSpec,
            drum,
            material=catalogue.material(drum.material),
            shaft_material=catalogue.material(drum.shaft_material),
        ),
        "input_pulleys": InputPulleySpec(
            material=catalogue.material(design.input_pulleys.material), collar_screw=design.input_pulleys.collar_screw
        ),
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
    yield NamedEntry(("input_pulleys", "material"), "materials", pulleys.material)
    yield NamedEntry(("input_pulleys", "lower_bearing"), "bearings", pulleys.lower_bearing)
    yield NamedEntry(("input_pulleys", "upper_bearing"), "bearings", pulleys.upper_bearing)
    yield NamedEntry(("input_pulleys", "collar_screw"), "screws", pulleys.collar_screw)
