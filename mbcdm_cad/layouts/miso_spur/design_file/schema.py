"""Schema of a miso_spur design file: the blocks of siso_spur, with several inputs and a cable for each."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from mbcdm_cad.design.blocks import Input
from mbcdm_cad.design.design_file import reference_of
from mbcdm_cad.design.fields import choice
from mbcdm_cad.layouts.siso_spur.design_file.schema import SpurBlocks, SpurSide

REFERENCE = reference_of(Path(__file__).parent)


class RoundDrumSide(SpurSide):
    """One side of a cable, from its input to the drum."""

    drum_side: Literal["-x", "+x"] = choice("side of the drum, seen with its input above the drum")


class RoundDrumDesign(SpurBlocks):
    """A cable drive."""

    configuration: Literal["miso_spur"] = choice(
        "layout: miso_spur is (b) of Fig. 1, several inputs round one drum", source="Fig. 1", reference="miso_spur"
    )
    inputs: tuple[Input, ...] = choice(
        "two to four input pulleys, evenly round the drum from +Z towards +X, each further along the drum's axis",
        source="Fig. 1",
        reference=REFERENCE.inputs,
        min_length=1,
        max_length=8,
    )
    cables: tuple[RoundDrumSide, ...] = choice(
        "the two sides of each input's cable, or its two anchored cables; each may have a preload_N "
        "and a terminal_angle_deg",
        source="Fig. 1",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
