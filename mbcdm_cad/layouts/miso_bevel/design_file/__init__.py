"""Schema of a miso_bevel design file: the blocks that are this configuration's own, each field with its source.

``source`` speaks of the reference value, the one that ``mbcdm init --reference`` writes. Reference values of the
blocks that all configurations share are in ``reference.json``.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Literal

from mbcdm_cad.design.blocks import Design, DriveTrain, Input, Length, SpanLimits, WoundRope
from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.fields import ESTIMATE, Block, EntryName, Integer, Number, choice, quantity
from mbcdm_cad.design.loader import DesignFile, reference_of
from mbcdm_cad.design.resolve import Catalogue, by_step, preload_N, shared_sigmas, shared_values
from mbcdm_cad.design.rules import Broken, NamedEntry, counted, encoders_needed, in_line_only, on_one_side, unique
from mbcdm_cad.design.sector_blocks import SectorCable, SectorDrum, TransferClearances, WoundPulleys
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.layouts.miso_bevel import drive as d
from mbcdm_cad.layouts.miso_bevel.drive import Support
from mbcdm_cad.parts.drum_sector.design import sector_entries, sector_values, terminal_angle_rad

REFERENCE = reference_of(Path(__file__).parent)

Side = Literal["-x", "+x"]


class Ratios(Block):
    """Reductions, large radius over small; every cable then satisfies Eq. (1) exactly."""

    input_to_guide: Number = quantity(
        "guide radius over input radius", "[0.2, 20]", source="Table 2: 9/6", reference=1.5
    )
    guide_to_drum: Number = quantity(
        "drum radius over guide radius", "[0.5, 50]", source="Table 2: 54/9", reference=6.0
    )


class Transmission(Block):
    """Pitch radii (to the cable's centre line), by step 1 to 4, and where the pulleys stand."""

    centre_distance_mm: Number = quantity(
        "input pulley axis to guide axis, L", "[2, 500]", uncertain=True, source="Table 2", reference=34.6
    )
    ratio: Number | None = quantity(
        "drum radius over input radius; sizing divides it between guide and inputs if ratios and radii are left "
        "out, and chooses it with the motor if it is left out too",
        "[0.5, 100]",
        source="Table 2: 54/6",
        example=9.0,
    )
    drum_radius_mm: Number | None = quantity(
        "drum pitch radius of step 1; sizing adds the steps if drum_radii_mm is left out",
        "[5, 500]",
        source="Table 2",
        example=54.0,
    )
    input_setback_mm: Number = quantity(
        "input axes behind the guide's axis, away from the drum, so that drives and collars clear the drum's terminals",
        "[0, 100]",
        default=0.0,
    )
    drum_radii_mm: tuple[Length, ...] = quantity(
        "drum pitch radii r_o of steps 1 to 4",
        uncertain=True,
        source="Table 2",
        reference=[54.0, 57.6, 61.2, 64.8],
        min_length=4,
        max_length=4,
    )
    ratios: Ratios | None = quantity(
        "reductions that give guide and input radii; leave out when the radii are explicit",
        source="Table 2",
        reference={},
    )
    guide_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit guide pitch radii r_g of steps 1 to 4, in place of ratios; Eq. (1) is then checked",
        uncertain=True,
        source="Table 2",
        example=[9.0, 9.6, 10.2, 10.8],
        min_length=4,
        max_length=4,
    )
    input_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit input pitch radii r_m of steps 1 to 4, in place of ratios",
        uncertain=True,
        source="Table 2",
        example=[6.0, 6.4, 6.8, 7.2],
        min_length=4,
        max_length=4,
    )


@dataclass(frozen=True, kw_only=True)
class BevelClearances(TransferClearances):
    """Gaps between finished surfaces."""

    transfer_gap_mm: Number = quantity(
        "gap from guide step 1 to the drum's inner face; under half a rope, so that no rope slips in", "[0.01, 5]"
    )


@dataclass(frozen=True, kw_only=True)
class Drum(SectorDrum):
    """Drum sector with web, hub and tensioners; y is along the drum axis from the guide's axis."""


class Guide(Block):
    """Guide pulley, an idler on a fixed axle."""

    material: EntryName = choice("material of the pulley", source=ESTIMATE, reference="aluminium-7075")
    bearing: EntryName = choice("both bearings inside the pulley", source=ESTIMATE, reference="618/4")
    axle_material: EntryName = choice("material of the axle", source=ESTIMATE, reference="steel")
    slip: Literal["none", "counted"] = choice(
        "whether the rope creeps on the guide's wraps too: none, as the paper reckons, the tension does not change "
        "along a wrap; or counted, in model, checks, rig and loop, from both ends of each wrap",
        default="none",
    )


class BevelDriveTrain(DriveTrain):
    """Motor, gearhead and encoders, from the catalogue."""

    motor_side: Literal["below", "above"] = choice(
        "side of the pulleys on which gearheads and motors are: below, under the motor shelf, the encoders on the top "
        "plate; or above, on the top plate, the encoders under the bearing shelf",
        default="below",
    )


@dataclass(frozen=True, kw_only=True)
class InputPulleys(WoundPulleys):
    """Input pulleys, carried by a bearing at both ends."""

    material: EntryName = choice("material of both pulleys")
    surface: Literal["smooth", "grooved"] = choice(
        "smooth lands, or a helical groove for each cable, which allows limits.fleet_angle_grooved_max_deg",
        default="smooth",
    )
    upper_bearing: EntryName = choice("bearing in the top plate")


class BevelInput(Input):
    """An input pulley with its own motor."""

    side: Side = choice("side of the guide on which it stands, at x = -L or +L", source="Fig. 2")


class BevelCable(SectorCable):
    """A cable from an input pulley over the guide to the drum."""

    step: Integer = choice("step of guide and drum it runs on, 1 the smallest", source="Table 2", ge=1, le=4)
    drum_side: Side = choice("side to which it runs on the drum from the transfer point", source="Fig. 2")


_BEHIND_DRUM = Design.ORDER.index("drum") + 1


class BevelDesign(Design):
    """A cable drive."""

    ORDER: ClassVar[tuple[str, ...]] = (*Design.ORDER[:_BEHIND_DRUM], "guide", *Design.ORDER[_BEHIND_DRUM:])

    configuration: Literal["miso_bevel"] = choice(
        "layout: miso_bevel is (d) of Fig. 1, two inputs and a bevel transfer", source="Fig. 1", reference="miso_bevel"
    )
    transmission: Transmission
    inputs: tuple[BevelInput, ...] = choice(
        "input pulleys, one on each side", source="Fig. 2", reference=REFERENCE.inputs, min_length=1, max_length=8
    )
    cables: tuple[BevelCable, ...] = choice(
        "cables: which input each runs from and which way round the drum; each may have a preload_N and a "
        "terminal_angle_deg",
        source="Table 2 and Fig. 2",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
    rope: WoundRope
    clearances: BevelClearances
    drive: BevelDriveTrain
    drum: Drum
    guide: Guide
    input_pulleys: InputPulleys
    support: Support
    limits: SpanLimits


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


DESIGN_FILE = DesignFile(
    BevelDesign,
    REFERENCE.values,
    broken_rules,
    named_entries,
    drive,
    "mbcdm_cad.layouts.miso_bevel.sizing",
    Path(__file__).with_name("starting.txt").read_text("utf-8"),
)
