"""Rules of a miso_bevel design file, and the drive of a valid one, with catalogue entries in place of names."""

from collections.abc import Iterator, Mapping
from itertools import pairwise

from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.resolve import Catalogue, by_step, preload_N, shared_sigmas, shared_values
from mbcdm_cad.design.rules import Broken, NamedEntry, counted, encoders_needed, in_line_only, on_one_side, unique
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.layouts.miso_bevel import drive as d
from mbcdm_cad.layouts.miso_bevel.design_file.schema import BevelDesign, Transmission
from mbcdm_cad.parts.drum_sector.design import sector_entries, sector_values, terminal_angle_rad

_SIGN = {"-x": -1, "+x": 1}


def drive(design: BevelDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> d.BevelDrive:
    """The drive of a valid design; its cables are in the order of their steps."""
    drum, guide, pulleys = design.drum, design.guide, design.input_pulleys
    return d.BevelDrive(
        **shared_values(design, catalogue) | sector_values(design, catalogue),
        helix_lead_mm=design.rope.helix_lead_mm,
        dead_turns=design.rope.dead_turns,
        cables=_cables(design),
        input_sides=tuple(_SIGN[item.side] for item in design.inputs),
        centre_distance_mm=design.transmission.centre_distance_mm,
        input_setback_mm=design.transmission.input_setback_mm,
        motors_above=design.drive.motor_side == "above",
        guide_slips=guide.slip == "counted",
        radii_explicit=design.transmission.ratios is None,
        bearings=d.BevelBearings(
            drum=catalogue.bearing(drum.bearing),
            guide=catalogue.bearing(guide.bearing),
            input_lower=catalogue.bearing(pulleys.lower_bearing),
            input_upper=catalogue.bearing(pulleys.upper_bearing),
        ),
        guide_material=catalogue.material(guide.material),
        axle_material=catalogue.material(guide.axle_material),
        sigmas=_sigmas(design, catalogue, sigmas),
    )


def pitch_radii_mm(transmission: Transmission) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Guide and input pitch radii by step, from the ratios or as given.

    Radii from ratios are rounded to 1e-9 mm, so that 57.6/6 reads 9.6 in reports and not 9.600000000000001.
    """
    if transmission.ratios is None:
        return transmission.guide_radii_mm or (), transmission.input_radii_mm or ()
    ratios = transmission.ratios
    guide = tuple(round(radius / ratios.guide_to_drum, 9) for radius in transmission.drum_radii_mm)
    return guide, tuple(round(radius / ratios.input_to_guide, 9) for radius in guide)


def _cables(design: BevelDesign) -> tuple[d.BevelRun, ...]:
    guide, pulley = pitch_radii_mm(design.transmission)
    sides = {item.name: _SIGN[item.side] for item in design.inputs}
    return tuple(
        d.BevelRun(
            name=cable.name,
            input_name=cable.input,
            input_side=sides[cable.input],
            drum_side=_SIGN[cable.drum_side],
            step=cable.step,
            input_radius_mm=pulley[cable.step - 1],
            guide_radius_mm=guide[cable.step - 1],
            drum_radius_mm=design.transmission.drum_radii_mm[cable.step - 1],
            preload_N=preload_N(design, cable),
            terminal_angle_rad=terminal_angle_rad(cable),
        )
        for cable in (design.cables[k] for k in by_step(design.cables))
    )


def _sigmas(design: BevelDesign, catalogue: Catalogue, given: Mapping[FieldPath, float]) -> Sigmas:
    places = by_step(design.cables)

    def radii(name: str) -> tuple[float, ...]:
        return tuple(given.get(("transmission", name, design.cables[k].step - 1), 0.0) for k in places)

    lengths: dict[str, float | tuple[float, ...]] = {
        "input_radius_mm": radii("input_radii_mm"),
        "guide_radius_mm": radii("guide_radii_mm"),
        "drum_radius_mm": radii("drum_radii_mm"),
        "centre_distance_mm": given.get(("transmission", "centre_distance_mm"), 0.0),
    }
    return Sigmas(**shared_sigmas(design, catalogue, given, places), lengths_mm=lengths)


# With a setback above half of L the inputs would be behind the guide rather than beside it.
MOST_SETBACK = 0.5
# Two statements of one figure may differ by this share, because computed ratios are rounded.
SAME = 1e-6


def broken_rules(design: BevelDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from _transmission(design)
    yield from encoders_needed(design)
    yield from in_line_only(design)
    yield from _inputs(design)
    yield from _broken_cables(design)


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
                what = "steps do not grow"
                remedy = "order the radii from step 1, the smallest, to step 4"
                yield Broken(("transmission", name, k + 1), what, f"{outer:g} mm", f"over {inner:g} mm", remedy)


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
    yield from counted(design, "inputs", 2, "give one input on each side")
    if len(design.inputs) == 2 and design.inputs[0].side == design.inputs[1].side:
        what = "both inputs on one side"
        remedy = "give one input side: -x and the other side: +x"
        yield Broken(("inputs", 1, "side"), what, design.inputs[1].side, "one on each side", remedy)


def _broken_cables(design: BevelDesign) -> Iterator[Broken]:
    cables, inputs = design.cables, [item.name for item in design.inputs]
    yield from counted(design, "cables", 4, "give two cables for each of the two inputs")
    yield from unique("cables", "step", [cable.step for cable in cables])
    for k, name in enumerate(inputs):
        own = [cable for cable in cables if cable.input == name]
        if len(own) != 2:
            remedy = "set input: of the cables so that each input has two"
            yield Broken(("inputs", k), "an input needs two cables", f"{len(own)} cables run from {name}", "2", remedy)
            continue
        if own[0].drum_side == own[1].drum_side:
            yield on_one_side(cables.index(own[1]), own[1].drum_side, f"cables of {name}")
        steps = tuple(sorted(cable.step for cable in own))
        if steps not in ((1, 2), (3, 4)) and steps[0] != steps[1]:
            yield Broken(
                ("cables", cables.index(own[1]), "step"),
                f"the cables of {name} are not on neighbouring steps",
                f"{steps[0]} and {steps[1]}",
                "1 and 2, or 3 and 4",
                "an input pulley has two steps side by side: pair steps 1, 2 and steps 3, 4",
            )
