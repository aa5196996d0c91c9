"""The design file of miso_spur: the blocks of siso_spur with several inputs and cables, its rules, its drive."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

from mbcdm_cad.design.blocks import Input
from mbcdm_cad.design.fields import choice
from mbcdm_cad.design.loader import DesignFile, reference_of
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.layouts.siso_spur import design_file as of_one
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.schema import SpurBlocks, SpurSide
from mbcdm_cad.parts.drum_sector.dims import SCREWS

REFERENCE = reference_of(Path(__file__).parent)
FEWEST, MOST = 2, 4


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


def drive(design: RoundDrumDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> SpurDrive:
    """The drive of a valid design."""
    return laid(SpurDrive(**of_one.spur_values(design, catalogue, sigmas)))


def broken_rules(design: RoundDrumDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from of_one.broken_radius(design.transmission)
    if design.drum.output_screws != SCREWS:
        yield Broken(
            ("drum", "output_screws"),
            "the dowels between the hubs stand between four screws",
            str(design.drum.output_screws),
            str(SCREWS),
            "leave it out, or choose configuration: siso_spur",
        )
    count = len(design.inputs)
    if not FEWEST <= count <= MOST:
        remedy = "take configuration siso_spur for one input" if count < FEWEST else "leave out some"
        what = f"wrong number of inputs for {design.configuration}"
        yield Broken(("inputs",), what, str(count), f"{FEWEST} to {MOST}", remedy)
    for item in design.inputs:
        sides = sorted(cable.drum_side for cable in design.cables if cable.input == item.name)
        if sides != ["+x", "-x"]:
            yield Broken(
                ("cables",),
                f"the cable of input {item.name} has not two sides that run apart",
                ", ".join(sides) or "none",
                "one to -x and one to +x",
                "give both sides of its cable, one for each sense of the drum",
            )
    yield from of_one.broken_way(design)
    yield from of_one.broken_sector(design.drum.sector_half_angle_deg)
    if design.transmission.parallel > 1:
        remedy = "set it to 1, or take configuration siso_spur"
        value = str(design.transmission.parallel)
        yield Broken(("transmission", "parallel"), "each input has one cable", value, "1", remedy)
    if design.transmission.spans == "open":
        remedy = "set it to crossed, or take configuration siso_spur"
        yield Broken(("transmission", "spans"), "the inputs turn against the drum", "open", "crossed", remedy)


STARTING = of_one.starting(
    "miso_spur", 4.0, "# inputs: [{{name: a}}, {{name: b}}, {{name: c}}]  # left out: two inputs\n"
)
DESIGN_FILE = DesignFile(
    RoundDrumDesign,
    REFERENCE.values,
    broken_rules,
    of_one.named_entries,
    drive,
    "mbcdm_cad.layouts.miso_spur.sizing",
    STARTING,
)
