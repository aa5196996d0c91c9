"""Schema of a siso_bevel design file: the blocks that are this configuration's own, each field with its source.

Reference values of shared blocks are in ``reference.json``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from mbcdm_cad.design.blocks import Design, Input, Length
from mbcdm_cad.design.design_file import reference_of
from mbcdm_cad.design.fields import ESTIMATE, Block, Integer, Number, choice, quantity
from mbcdm_cad.design.sector_blocks import SectorCable, SectorDrum, SteppedPulleys, TransferClearances
from mbcdm_cad.layouts.siso_bevel.drive import ColumnSupport

REFERENCE = reference_of(Path(__file__).parent)


class DirectTransmission(Block):
    """Pitch radii (to the cable's centre line) of steps 1 and 2, and the wrap that stays on the input."""

    drum_radius_mm: Number | None = quantity(
        "drum pitch radius of step 1; sizing adds step 2 if drum_radii_mm is left out",
        source="the paper's Table 2",
        default=None,
        ge=5.0,
        le=500.0,
    )
    drum_radii_mm: tuple[Length, ...] = quantity(
        "drum pitch radii r_o of steps 1 and 2",
        uncertain=True,
        source="their mean is that of the paper's Table 2",
        reference=[58.05, 60.75],
        min_length=2,
        max_length=2,
    )
    input_to_drum: Number | None = quantity(
        "drum radius over input radius, the same for both steps; leave it out if the input radii are explicit",
        source="highest ratio with which travel, reserve and stop slot fit on one turn of the input",
        reference=4.5,
        default=None,
        ge=0.5,
        le=60.0,
    )
    input_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit input pitch radii r_m of steps 1 and 2, in place of input_to_drum",
        uncertain=True,
        example=[12.9, 13.5],
        default=None,
        min_length=2,
        max_length=2,
    )
    reserve_deg: Number = quantity(
        "wrap that stays on the input at the unwound end of the travel, before the stop's bend",
        source=ESTIMATE,
        reference=18.0,
        ge=0.0,
        le=360.0,
    )


class DirectCable(SectorCable):
    """A cable from the input pulley to the drum."""

    step: Integer = choice("step of input and drum, 1 the smaller", ge=1, le=2)
    drum_side: Literal["-x", "+x"] = choice("side of the drum, from the transfer point")


class DirectDesign(Design):
    """A cable drive."""

    configuration: Literal["siso_bevel"] = choice(
        "layout: siso_bevel is (c) of Fig. 1, one input straight onto the drum", source="Fig. 1", reference="siso_bevel"
    )
    transmission: DirectTransmission
    inputs: tuple[Input, ...] = choice(
        "the input pulley", source="Fig. 1", reference=REFERENCE.inputs, min_length=1, max_length=8
    )
    cables: tuple[DirectCable, ...] = choice(
        "cables, each with its step and its side of the drum; each may have a preload_N and a terminal_angle_deg",
        source="Fig. 1",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
    clearances: TransferClearances
    drum: SectorDrum
    input_pulleys: SteppedPulleys
    support: ColumnSupport
