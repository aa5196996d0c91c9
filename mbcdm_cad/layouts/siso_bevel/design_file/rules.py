"""Rules of a siso_bevel design file: radii in order, one input, two cables on two steps and two sides."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.design.rules import Broken, NamedEntry, encoders_needed, unique
from mbcdm_cad.layouts.siso_bevel.design_file.schema import DirectDesign
from mbcdm_cad.parts.drum_sector.resolve import sector_entries


def broken_rules(design: DirectDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from _transmission(design)
    yield from encoders_needed(design)
    for block, found, wanted, remedy in (
        ("inputs", len(design.inputs), 1, "give exactly one input; miso_bevel has two"),
        ("cables", len(design.cables), 2, "give one cable for each sense of the drum"),
    ):
        if found != wanted:
            what = f"wrong number of {block} for {design.configuration}"
            yield Broken((block,), what, str(found), str(wanted), remedy)
    yield from unique("cables", "step", [cable.step for cable in design.cables])
    if len(design.cables) == 2 and design.cables[0].drum_side == design.cables[1].drum_side:
        yield Broken(
            ("cables", 1, "drum_side"),
            "both cables run to one side",
            design.cables[1].drum_side,
            "opposite sides",
            "set drum_side to -x for one and to +x for the other: the input drives in one sense only otherwise",
        )


def named_entries(design: DirectDesign) -> Iterator[NamedEntry]:
    """Entries of the catalogue that the blocks of this configuration name."""
    yield from sector_entries(design)
    yield NamedEntry(("support", "material"), "materials", design.support.material)


def _transmission(design: DirectDesign) -> Iterator[Broken]:
    block = design.transmission
    if block.input_to_drum is not None and block.input_radii_mm is not None:
        where, remedy = ("transmission", "input_radii_mm"), "remove input_to_drum, or remove input_radii_mm"
        yield Broken(where, "given beside input_to_drum", "", "input_to_drum or explicit radii", remedy)
    elif block.input_to_drum is None and block.input_radii_mm is None:
        what, remedy = "radii of the input pulley are not given", "add input_to_drum, or input_radii_mm"
        yield Broken(("transmission",), what, "", "input_to_drum or explicit radii", remedy)
    small, large = block.drum_radii_mm
    if block.drum_radius_mm is not None and block.drum_radius_mm != small:
        yield Broken(
            ("transmission", "drum_radius_mm"),
            "contradicts drum_radii_mm",
            f"{block.drum_radius_mm:g} mm",
            f"{small:g} mm, the first of drum_radii_mm",
            "leave one of the two out, so that it follows",
        )
    if large <= small:
        remedy = "order the radii from step 1, the smaller, to step 2"
        step = ("transmission", "drum_radii_mm", 1)
        yield Broken(step, "steps do not grow", f"{large:g} mm", f"over {small:g} mm", remedy)
