"""Rules of a siso_spur design file: one input, and the two sides of its cable."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.design.rules import Broken, NamedEntry
from mbcdm_cad.layouts.siso_spur.design_file.schema import SpurBlocks, SpurDesign, SpurTransmission
from mbcdm_cad.parts.drum_sector.resolve import sector_entries


def broken_rules(design: SpurDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from broken_radius(design.transmission)
    for name, found, wanted, remedy in (
        ("inputs", len(design.inputs), 1, "give exactly one input"),
        ("cables", len(design.cables), 2, "give the two sides of the cable, one for each sense of the drum"),
    ):
        if found != wanted:
            yield Broken((name,), f"wrong number of {name} for {design.configuration}", str(found), str(wanted), remedy)
    if len(design.cables) == 2 and design.cables[0].drum_side == design.cables[1].drum_side:
        yield Broken(
            ("cables", 1, "drum_side"),
            "both sides run to one side",
            design.cables[1].drum_side,
            "opposite sides",
            "set drum_side to -x for one and to +x for the other: the input drives in one sense only otherwise",
        )


def broken_radius(block: SpurTransmission) -> Iterator[Broken]:
    """The input's radius is given once, explicitly or by the ratio."""
    if block.input_to_drum is not None and block.input_radius_mm is not None:
        where, remedy = ("transmission", "input_radius_mm"), "remove input_to_drum, or remove input_radius_mm"
        yield Broken(where, "given beside input_to_drum", "", "input_to_drum or an explicit radius", remedy)
    elif block.input_to_drum is None and block.input_radius_mm is None:
        what, remedy = "radius of the input pulley is not given", "add input_to_drum, or input_radius_mm"
        yield Broken(("transmission",), what, "", "input_to_drum or an explicit radius", remedy)


def named_entries(design: SpurBlocks) -> Iterator[NamedEntry]:
    """Entries of the catalogue that the blocks of this configuration name."""
    yield from sector_entries(design)
    yield NamedEntry(("support", "material"), "materials", design.support.material)
