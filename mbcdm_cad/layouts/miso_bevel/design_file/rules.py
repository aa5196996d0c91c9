"""Rules of a miso_bevel design file: radii and steps in order, two inputs on two sides, four cables in two pairs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from mbcdm_cad.design.rules import Broken, NamedEntry, encoders_needed, unique
from mbcdm_cad.layouts.miso_bevel.design_file.schema import BevelDesign, Transmission
from mbcdm_cad.parts.drum_sector.resolve import sector_entries

# With a setback above half of L the inputs would be behind the guide rather than beside it.
MOST_SETBACK = 0.5
# Two statements of one figure may differ by this share, because computed ratios are rounded.
SAME = 1e-6


def broken_rules(design: BevelDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from _transmission(design)
    yield from encoders_needed(design)
    yield from _inputs(design)
    yield from _cables(design)


def named_entries(design: BevelDesign) -> Iterator[NamedEntry]:
    """Entries of the catalogue that the blocks of this configuration name."""
    yield from sector_entries(design)
    yield NamedEntry(("guide", "material"), "materials", design.guide.material)
    yield NamedEntry(("guide", "bearing"), "bearings", design.guide.bearing)
    yield NamedEntry(("guide", "axle_material"), "materials", design.guide.axle_material)
    yield NamedEntry(("support", "material"), "materials", design.support.material)


def _transmission(design: BevelDesign) -> Iterator[Broken]:
    block = design.transmission
    explicit = {"guide_radii_mm": block.guide_radii_mm, "input_radii_mm": block.input_radii_mm}
    given = [name for name, radii in explicit.items() if radii is not None]
    if block.ratios is not None and given:
        yield Broken(
            ("transmission", given[0]),
            "given beside ratios",
            "",
            "ratios or explicit radii",
            "remove ratios, or remove " + " and ".join(given),
        )
    elif block.ratios is None and len(given) < 2:
        absent = " and ".join(name for name in explicit if name not in given)
        yield Broken(
            ("transmission",),
            "radii of guide and input pulleys are not given",
            "",
            "ratios or explicit radii",
            f"add {absent}" + ("" if given else ", or add ratios"),
        )
    yield from _said_twice(block)
    if block.input_setback_mm > MOST_SETBACK * block.centre_distance_mm:
        yield Broken(
            ("transmission", "input_setback_mm"),
            "input axes too far behind the guide's",
            f"{block.input_setback_mm:g} mm",
            f"up to {MOST_SETBACK:g} of centre_distance_mm, {MOST_SETBACK * block.centre_distance_mm:g} mm",
            "a setback of a few mm clears drives and collars of the drum's terminals",
        )
    for name, radii in {"drum_radii_mm": block.drum_radii_mm, "guide_radii_mm": block.guide_radii_mm}.items():
        for k, (inner, outer) in enumerate(pairwise(radii or ())):
            if outer <= inner:
                yield Broken(
                    ("transmission", name, k + 1),
                    "steps do not grow",
                    f"{outer:g} mm",
                    f"over {inner:g} mm",
                    "order the radii from step 1, the smallest, to step 4",
                )


def _said_twice(block: Transmission) -> Iterator[Broken]:
    """Problems where total ratio or first radius contradict ratios and radii; sizing keeps filled values consistent."""
    if block.ratio is not None:
        if block.ratios is not None:
            found = block.ratios.input_to_guide * block.ratios.guide_to_drum
            shown = f"{block.ratios.input_to_guide:g} x {block.ratios.guide_to_drum:g} of ratios"
        elif block.input_radii_mm:
            found, shown = block.drum_radii_mm[0] / block.input_radii_mm[0], "drum over input radius of step 1"
        else:
            return
        if abs(found - block.ratio) > SAME * found:
            yield Broken(
                ("transmission", "ratio"),
                "contradicts " + ("ratios" if block.ratios is not None else "the radii"),
                f"{block.ratio:g}",
                f"{found:.6g}, {shown}",
                "leave ratio out, or what contradicts it, so that it follows",
            )
    first = block.drum_radii_mm[0] if block.drum_radii_mm else None
    if block.drum_radius_mm is not None and first is not None and abs(first - block.drum_radius_mm) > SAME * first:
        yield Broken(
            ("transmission", "drum_radius_mm"),
            "contradicts drum_radii_mm",
            f"{block.drum_radius_mm:g} mm",
            f"{first:g} mm, the radius of step 1",
            "leave one of the two out",
        )


def _inputs(design: BevelDesign) -> Iterator[Broken]:
    if len(design.inputs) != 2:
        yield Broken(
            ("inputs",),
            f"wrong number of inputs for {design.configuration}",
            str(len(design.inputs)),
            "2",
            "give one input on each side",
        )
    if len(design.inputs) == 2 and design.inputs[0].side == design.inputs[1].side:
        yield Broken(
            ("inputs", 1, "side"),
            "both inputs on one side",
            design.inputs[1].side,
            "one on each side",
            "give one input side: -x and the other side: +x",
        )


def _cables(design: BevelDesign) -> Iterator[Broken]:
    cables, inputs = design.cables, [item.name for item in design.inputs]
    if len(cables) != 4:
        yield Broken(
            ("cables",),
            f"wrong number of cables for {design.configuration}",
            str(len(cables)),
            "4",
            "give two cables for each of the two inputs",
        )
    yield from unique("cables", "step", [cable.step for cable in cables])
    for k, name in enumerate(inputs):
        own = [cable for cable in cables if cable.input == name]
        if len(own) != 2:
            yield Broken(
                ("inputs", k),
                "an input needs two cables",
                f"{len(own)} cables run from {name}",
                "2",
                "set input: of the cables so that each input has two",
            )
            continue
        if own[0].drum_side == own[1].drum_side:
            yield Broken(
                ("cables", cables.index(own[1]), "drum_side"),
                f"both cables of {name} run to one side",
                own[1].drum_side,
                "opposite sides",
                "set drum_side to -x for one and to +x for the other: the input drives in one sense only otherwise",
            )
        steps = tuple(sorted(cable.step for cable in own))
        if steps not in ((1, 2), (3, 4)) and steps[0] != steps[1]:
            yield Broken(
                ("cables", cables.index(own[1]), "step"),
                f"the cables of {name} are not on neighbouring steps",
                f"{steps[0]} and {steps[1]}",
                "1 and 2, or 3 and 4",
                "an input pulley has two steps side by side: pair steps 1, 2 and steps 3, 4",
            )
