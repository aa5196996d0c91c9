"""The kinds of the catalogue with the class of each, for the package's data files and a design's own entries."""

from __future__ import annotations

from pydantic import Field

from mbcdm_cad.design.bought import (
    Bearing,
    CableSpec,
    Encoder,
    Entry,
    Gearhead,
    InsertSpec,
    Material,
    Motor,
    Screw,
    SpringSpec,
    TensionerSpec,
    TerminationSpec,
)
from mbcdm_cad.design.fields import Block, EntryName

KINDS: dict[str, type[Entry]] = {
    "ropes": CableSpec,
    "terminations": TerminationSpec,
    "motors": Motor,
    "gearheads": Gearhead,
    "encoders": Encoder,
    "bearings": Bearing,
    "screws": Screw,
    "inserts": InsertSpec,
    "tensioners": TensionerSpec,
    "springs": SpringSpec,
    "materials": Material,
}


class OwnEntries(Block):
    """Entries of the design's own, by kind and name; a name of the package's catalogue is overridden."""

    ropes: dict[EntryName, CableSpec] = Field(default={}, max_length=64, description="ropes by name")
    terminations: dict[EntryName, TerminationSpec] = Field(
        default={}, max_length=64, description="ways of ending a rope by name"
    )
    motors: dict[EntryName, Motor] = Field(default={}, max_length=64, description="motors by name")
    gearheads: dict[EntryName, Gearhead] = Field(default={}, max_length=64, description="gearheads by name")
    encoders: dict[EntryName, Encoder] = Field(default={}, max_length=64, description="encoders by name")
    bearings: dict[EntryName, Bearing] = Field(default={}, max_length=64, description="bearings by name")
    screws: dict[EntryName, Screw] = Field(default={}, max_length=64, description="screws by name")
    inserts: dict[EntryName, InsertSpec] = Field(default={}, max_length=64, description="heat-set inserts by name")
    tensioners: dict[EntryName, TensionerSpec] = Field(default={}, max_length=64, description="tensioners by name")
    springs: dict[EntryName, SpringSpec] = Field(default={}, max_length=64, description="springs of terminals by name")
    materials: dict[EntryName, Material] = Field(default={}, max_length=64, description="materials by name")
