"""Rules between fields: what makes a file that satisfies the schema still no design.

A broken rule is bad input. Whether the design is any good (clearances, strength, travel) is for the checks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from mbcdm_cad.design.as_built import CHANGE_VALUES
from mbcdm_cad.design.loaded import FieldPath
from mbcdm_cad.design.resolve import KINDS, Catalogue
from mbcdm_cad.errors import did_you_mean, shortened

if TYPE_CHECKING:
    from mbcdm_cad.design.entries import Entry
    from mbcdm_cad.design.schema import Design


class Broken(NamedTuple):
    """A rule that does not hold: field path, what, value, limit, remedy."""

    path: FieldPath
    what: str
    value: str
    limit: str
    remedy: str


def broken_rules(design: Design) -> list[Broken]:
    """All rules that the design breaks, in the order of the file's blocks."""
    rules: tuple[Callable[[Design], Iterator[Broken]], ...] = (
        _transmission,
        _inputs,
        _cables,
        _rope,
        _waivers,
        _as_built,
        _references,
        _own_entries,
    )
    return [broken for rule in rules for broken in rule(design)]


def _transmission(design: Design) -> Iterator[Broken]:
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


def _inputs(design: Design) -> Iterator[Broken]:
    if len(design.inputs) != 2:
        yield Broken(
            ("inputs",),
            f"wrong number of inputs for {design.configuration}",
            str(len(design.inputs)),
            "2",
            "give one input on each side",
        )
    yield from _unique("inputs", "name", [item.name for item in design.inputs])
    if len(design.inputs) == 2 and design.inputs[0].side == design.inputs[1].side:
        yield Broken(
            ("inputs", 1, "side"),
            "both inputs on one side",
            design.inputs[1].side,
            "one on each side",
            "give one input side: -x and the other side: +x",
        )


def _cables(design: Design) -> Iterator[Broken]:
    cables, inputs = design.cables, [item.name for item in design.inputs]
    if len(cables) != 4:
        yield Broken(
            ("cables",),
            f"wrong number of cables for {design.configuration}",
            str(len(cables)),
            "4",
            "give two cables for each of the two inputs",
        )
    # Items are named cable_NAME, whether the file writes the prefix or not.
    yield from _unique("cables", "name", [cable.name.removeprefix("cable_") for cable in cables])
    yield from _unique("cables", "step", [cable.step for cable in cables])
    for k, cable in enumerate(cables):
        if cable.input not in inputs:
            yield Broken(
                ("cables", k, "input"),
                "no such input",
                cable.input,
                ", ".join(inputs),
                did_you_mean(cable.input, inputs),
            )
        if cable.name in inputs:
            yield Broken(
                ("cables", k, "name"),
                "also the name of an input",
                cable.name,
                "names are used once",
                "rename one of them",
            )
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
                "let one run to -x and one to +x, or the input pulls one way only",
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


def _rope(design: Design) -> Iterator[Broken]:
    rope = design.rope
    if (rope.type is None) == (rope.inline is None):
        what = "neither type nor inline is given" if rope.type is None else "both type and inline are given"
        yield Broken(("rope",), what, "", "one of the two", "give type: NAME, or all values under inline:")
    if (rope.modulus_GPa is None) != (rope.modulus_area is None):
        absent = "modulus_area" if rope.modulus_area is None else "modulus_GPa"
        yield Broken(
            ("rope",),
            f"{absent} is missing",
            "",
            "modulus_GPa and modulus_area go together",
            "a modulus means nothing without its area: give both, or neither for the catalogue's",
        )
    if rope.inline is not None and rope.modulus_GPa is not None:
        yield Broken(
            ("rope", "modulus_GPa"),
            "given beside inline",
            f"{rope.modulus_GPa:g} GPa",
            "one modulus",
            "set modulus_GPa and modulus_area under inline only",
        )


def _waivers(design: Design) -> Iterator[Broken]:
    yield from _unique("waivers", "check", [waiver.check for waiver in design.waivers])


def _as_built(design: Design) -> Iterator[Broken]:
    cables = [cable.name for cable in design.cables]
    for k, entry in enumerate(design.as_built):
        for i, name in enumerate(entry.cables):
            if name not in cables:
                limit = ", ".join(cables)
                yield Broken(
                    ("as_built", k, "cables", i), "no such cable", shortened(name), limit, did_you_mean(name, cables)
                )
        if entry.name in CHANGE_VALUES and entry.form in CHANGE_VALUES[entry.name]:
            share = next((i for i, value in enumerate(entry.values) if value.name == "share"), None)
            if share is None:
                yield Broken(
                    ("as_built", k, "values"), "no share", "", "a value named share", "add {name: share, value: ...}"
                )
            elif entry.values[share].value <= -1.0:
                path: FieldPath = ("as_built", k, "values", share, "value")
                value = f"{entry.values[share].value:g}"
                yield Broken(
                    path, "nothing would be left", value, "over -1", "give the change as a share, 0.1 for 10 % more"
                )


def _unique(block: str, name: str, values: list[str] | list[int]) -> Iterator[Broken]:
    counts = Counter(values)
    for k, value in enumerate(values):
        if counts[value] > 1 and value in values[:k]:
            yield Broken(
                (block, k, name),
                "used twice",
                shortened(value),
                f"each {name} once",
                f"give every one of {block} its own {name}",
            )


def _references(design: Design) -> Iterator[Broken]:
    catalogue = Catalogue(design)
    drum, pulleys, train = design.drum, design.input_pulleys, design.drive
    wanted: list[tuple[FieldPath, str, str | None]] = [
        (("rope", "type"), "ropes", design.rope.type),
        (("rope", "inline", "material"), "materials", design.rope.inline.material if design.rope.inline else None),
        (("drive", "motor"), "motors", train.motor),
        (("drive", "gearhead"), "gearheads", train.gearhead),
        (("drive", "encoder"), "encoders", train.encoder),
        (("drive", "drum_encoder"), "encoders", train.drum_encoder),
        (("drum", "material"), "materials", drum.material),
        (("drum", "bearing"), "bearings", drum.bearing),
        (("drum", "shaft_material"), "materials", drum.shaft_material),
        (("drum", "tensioner"), "tensioners", drum.tensioner),
        (("guide", "material"), "materials", design.guide.material),
        (("guide", "bearing"), "bearings", design.guide.bearing),
        (("guide", "axle_material"), "materials", design.guide.axle_material),
        (("input_pulleys", "material"), "materials", pulleys.material),
        (("input_pulleys", "lower_bearing"), "bearings", pulleys.lower_bearing),
        (("input_pulleys", "upper_bearing"), "bearings", pulleys.upper_bearing),
        (("support", "material"), "materials", design.support.material),
    ]
    for kind in KINDS:
        for name, entry in getattr(design.catalogue, kind).items():
            for field, target in (("material", "materials"), ("screw", "screws")):
                wanted.append((("catalogue", kind, name, field), target, getattr(entry, field, None)))
    for path, kind, reference in wanted:
        known = catalogue.names(kind)
        if reference is not None and reference not in known:
            yield Broken(
                path,
                f"not in the catalogue of {kind}",
                shortened(reference),
                "",
                f"{did_you_mean(reference, known)} or add it under catalogue: {kind}:",
            )


def _own_entries(design: Design) -> Iterator[Broken]:
    for kind in KINDS:
        for name, entry in getattr(design.catalogue, kind).items():
            yield from _entry(("catalogue", kind, name), entry)
    if design.rope.inline is not None:
        yield from _entry(("rope", "inline"), design.rope.inline)


def _entry(path: FieldPath, entry: Entry) -> Iterator[Broken]:
    from mbcdm_cad.design.entries import RopeEntry

    for names in entry_orders(entry):
        for small, large in pairwise(names):
            low, high = getattr(entry, small), getattr(entry, large)
            if low > high:
                yield Broken(
                    (*path, small), f"larger than {large}", f"{low:g}", f"up to {high:g}", f"check {small} and {large}"
                )
    if isinstance(entry, RopeEntry):
        nominal = 0.7854 * entry.diameter_mm**2
        if entry.metallic_area_mm2 > nominal:
            yield Broken(
                (*path, "metallic_area_mm2"),
                "larger than the rope's own circle",
                f"{entry.metallic_area_mm2:g} mm2",
                f"up to {nominal:.4g} mm2",
                "a 7x7 rope has about 0.475 d^2",
            )


def entry_orders(entry: Entry) -> tuple[tuple[str, ...], ...]:
    """Fields of a catalogue entry that must not decrease in this order."""
    from mbcdm_cad.design import entries as e

    orders: dict[type[Entry], tuple[tuple[str, ...], ...]] = {
        e.RopeEntry: (("bend_ratio_minimum", "bend_ratio_desired"),),
        e.GearheadEntry: (
            ("rated_torque_mNm", "max_torque_mNm"),
            ("shaft_diameter_mm", "pilot_diameter_mm", "bolt_circle_mm", "diameter_mm"),
        ),
        e.EncoderEntry: (("bore_mm", "bolt_circle_mm", "diameter_mm"),),
        e.BearingEntry: (("bore_mm", "inner_shoulder_mm", "outer_shoulder_mm", "outer_diameter_mm"),),
        e.ScrewEntry: (("tap_drill_mm", "thread_mm", "clearance_mm"),),
        e.TensionerEntry: (("thread_mm", "clearance_mm", "nut_across_flats_mm"),),
    }
    return orders.get(type(entry), ())
