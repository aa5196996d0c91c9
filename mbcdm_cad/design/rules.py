"""Rules between several fields for all configurations; a file can satisfy the schema and break such a rule.

A broken rule is bad input. Clearances, strength and travel are judged by the checks, not here.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.bought import NO_ENCODER, NO_GEARHEAD, Entry, Motor, missing_face_fields
from mbcdm_cad.design.catalogue import KINDS, entry_faults
from mbcdm_cad.design.resolve import CHANGE_VALUES, Catalogue
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.errors import did_you_mean, shortened

# Two statements of half the travel that differ by less are the same.
SAME_DEG = 1e-6


class Broken(NamedTuple):
    """A rule that does not hold: field path, what, value, limit, remedy; the others as in :class:`Problem`."""

    path: FieldPath
    what: str
    value: str
    limit: str
    remedy: str
    may_move: bool = False
    missing: bool = False


class NamedEntry(NamedTuple):
    """A field that names an entry of the catalogue: field path, kind of entry, name; no name where it is left out."""

    path: FieldPath
    kind: str
    name: str | None


def every_broken_rule(
    design: Design, catalogue: Catalogue, own: Iterable[Broken], named: Iterable[NamedEntry]
) -> Iterator[Broken]:
    """The rules that a design breaks: its configuration's ``own`` rules, the shared ones, then unknown names."""
    yield from own
    yield from broken_shared_rules(design)
    yield from broken_names(catalogue, named_by_shared_blocks(design))
    yield from _motor(design, catalogue)
    yield from broken_names(catalogue, named)


def broken_shared_rules(design: Design) -> Iterator[Broken]:
    """The rules for all configurations that the design breaks, without those on names of the catalogue."""
    for rule in (_travel, _cables, _rope, _stage, _loads, _targets):
        yield from rule(design)
    yield from unique("waivers", "check", [waiver.check for waiver in design.waivers])
    yield from _as_built(design)
    yield from _own_entries(design)


def broken_names(catalogue: Catalogue, named: Iterable[NamedEntry]) -> Iterator[Broken]:
    """The names that are not in the catalogue."""
    for path, kind, name in named:
        if name is not None and not catalogue.has(kind, name):
            yield unknown_entry(path, kind, name, catalogue.names(kind))


def unknown_entry(path: FieldPath, kind: str, name: str, known: Sequence[str]) -> Broken:
    """The broken rule for a name that is not in the catalogue."""
    remedy = f"{did_you_mean(name, known)} or add it under catalogue: {kind}:"
    return Broken(path, f"not in the catalogue of {kind}", shortened(name), "", remedy)


def named_by_shared_blocks(design: Design) -> Iterator[NamedEntry]:
    """Entries of the catalogue that the shared blocks and the design's own entries name."""
    rope, train = design.rope, design.drive
    yield NamedEntry(("rope", "type"), "ropes", rope.type)
    yield NamedEntry(("rope", "inline", "material"), "materials", rope.inline.material if rope.inline else None)
    yield NamedEntry(("rope", "termination"), "terminations", rope.termination)
    yield NamedEntry(("drive", "motor"), "motors", train.motor)
    yield NamedEntry(("drive", "gearhead"), "gearheads", None if train.gearhead == NO_GEARHEAD else train.gearhead)
    for field, name in (("encoder", train.encoder), ("drum_encoder", train.drum_encoder)):
        yield NamedEntry(("drive", field), "encoders", None if name == NO_ENCODER else name)
    for kind in KINDS:
        for name, entry in getattr(design.catalogue, kind).items():
            for field, target in (("material", "materials"), ("screw", "screws")):
                yield NamedEntry(("catalogue", kind, name, field), target, getattr(entry, field, None))


def _motor(design: Design, catalogue: Catalogue) -> Iterator[Broken]:
    """A motor without a gearhead needs a face and a shaft; a voltage has no effect without a torque constant."""
    train = design.drive
    if not catalogue.has("motors", train.motor):
        return
    motor: Motor = catalogue.get("motors", train.motor)
    if motor.servo is not None:
        yield from _servo(design, motor)
    if train.gearhead == NO_GEARHEAD:
        missing = missing_face_fields(motor)
        if missing:
            able = (catalogue.get("motors", name) for name in catalogue.names("motors"))
            names = ", ".join(each.name for each in able if not missing_face_fields(each) and each.servo is None)
            remedy = f"choose a gearhead, one of these motors, or give {', '.join(missing)} under catalogue: motors:"
            yield Broken(("drive", "gearhead"), f"{motor.name} has no face and shaft of its own", "none", names, remedy)
        elif not catalogue.has("screws", str(motor.screw)):
            yield unknown_entry(("drive", "motor"), "screws", str(motor.screw), catalogue.names("screws"))
    if train.bus_voltage_V is not None and motor.torque_constant_mNm_A is None:
        yield Broken(
            ("drive", "bus_voltage_V"),
            f"the catalogue has no torque constant of {motor.name}",
            f"{train.bus_voltage_V:g} V",
            "a motor with torque_constant_mNm_A",
            "leave it out, or choose a brushless motor of the catalogue",
        )


def _servo(design: Design, motor: Motor) -> Iterator[Broken]:
    """A servo has gears of its own, and its horn carries the pulley: that of the first stage, where there is one."""
    if design.drive.gearhead != NO_GEARHEAD:
        what = f"{motor.name} is a servo with gears of its own"
        yield Broken(("drive", "gearhead"), what, design.drive.gearhead, NO_GEARHEAD, f"write {NO_GEARHEAD}")
    here = getattr(design, "first_stage", None) is None
    if here and not getattr(getattr(design, "input_pulleys", None), "overhung", False):
        yield Broken(
            ("drive", "motor"),
            "the horn of a servo carries the input pulley, which then has no bearings",
            motor.name,
            "input_pulleys.carried_by: motor",
            "set input_pulleys.carried_by to motor, in configuration siso_spur or miso_spur",
        )


def _travel(design: Design) -> Iterator[Broken]:
    travel = design.travel
    yield from broken_ends(travel.from_deg, travel.to_deg)
    if travel.from_deg is not None and travel.to_deg is not None:
        half = (travel.to_deg - travel.from_deg) / 2
        if abs(half - travel.half_angle_deg) > SAME_DEG:
            what = "not half of the way from from_deg to to_deg"
            remedy = "leave it out, or leave from_deg and to_deg out"
            yield Broken(("travel", "half_angle_deg"), what, f"{travel.half_angle_deg:g} deg", f"{half:g} deg", remedy)


def broken_ends(from_deg: float | None, to_deg: float | None) -> Iterator[Broken]:
    """Both ends of a travel are given or none, and the upper one lies above the lower one."""
    if (from_deg is None) != (to_deg is None):
        there, missing = ("from_deg", "to_deg") if to_deg is None else ("to_deg", "from_deg")
        yield Broken(("travel", missing), f"missing beside {there}", "", "both or none", f"add it, or remove {there}")
    elif from_deg is not None and to_deg is not None and to_deg <= from_deg:
        remedy = "swap the two, or give the angle of the output at the upper end"
        yield Broken(("travel", "to_deg"), "not above from_deg", f"{to_deg:g} deg", f"over {from_deg:g} deg", remedy)


def encoders_needed(design: Design) -> Iterator[Broken]:
    """The encoders that a design leaves out, for a layout whose parts are drawn round both."""
    for field, name in (("encoder", design.drive.encoder), ("drum_encoder", design.drive.drum_encoder)):
        if name == NO_ENCODER:
            what = f"{design.configuration} is drawn with this encoder only"
            remedy = "name one, leave the line out, or choose configuration: siso_spur or miso_spur"
            yield Broken(("drive", field), what, name, "an encoder of the catalogue", remedy)


def in_line_only(design: Design) -> Iterator[Broken]:
    """A stage, for a layout whose frame carries each motor behind its own input."""
    if design.stage is not None:
        what = f"the frame of {design.configuration} carries each motor in line with its input"
        remedy = "remove the block stage, or choose configuration: siso_spur or miso_spur"
        yield Broken(("stage",), what, design.stage.kind, "siso_spur or miso_spur", remedy)


def _stage(design: Design) -> Iterator[Broken]:
    """Fields of the other kind."""
    stage = design.stage
    if stage is None:
        return
    others = {"belt": ("module_mm",), "gears": ("belt", "belt_teeth")}[stage.kind]
    for name in others:
        if getattr(stage, name) is not None:
            wanted = "gears" if stage.kind == "belt" else "belt"
            what = f"given for a stage of kind {stage.kind}"
            remedy = f"remove it, or write kind: {wanted}"
            yield Broken(("stage", name), what, shortened(getattr(stage, name)), f"kind: {wanted}", remedy)


def _cables(design: Design) -> Iterator[Broken]:
    inputs = [item.name for item in design.inputs]
    yield from unique("inputs", "name", inputs)
    # Items are named cable_NAME, whether the file writes the prefix or not.
    yield from unique("cables", "name", [cable.name.removeprefix("cable_") for cable in design.cables])
    for k, cable in enumerate(design.cables):
        if cable.input not in inputs:
            what = "no such input"
            yield Broken(
                ("cables", k, "input"), what, cable.input, ", ".join(inputs), did_you_mean(cable.input, inputs)
            )
        if cable.name in inputs:
            remedy = "rename one of them"
            yield Broken(("cables", k, "name"), "also the name of an input", cable.name, "names are used once", remedy)


def _loads(design: Design) -> Iterator[Broken]:
    """No load that lasts is larger than the peak torque, for which cables and parts are checked."""
    loads = design.loads
    limit, remedy = f"loads.peak_torque_Nm {loads.peak_torque_Nm:g}", "raise loads.peak_torque_Nm, or lower this"
    at: FieldPath = ("loads", "continuous_torque_Nm")
    if loads.continuous_torque_Nm is not None and loads.continuous_torque_Nm > loads.peak_torque_Nm:
        yield Broken(at, "more than the peak torque", f"{loads.continuous_torque_Nm:g} N m", limit, remedy)
    weight = loads.carried.weight_torque_Nm
    if weight > loads.peak_torque_Nm:
        at = ("loads", "payload", "mass_kg")
        yield Broken(at, "its weight turns the drum by more than the peak torque", f"{weight:.4g} N m", limit, remedy)
    if loads.duty is None:
        return
    if bool(loads.duty.rows) == (loads.duty.record is not None):
        what = "both rows and record are given" if loads.duty.rows else "neither rows nor record is given"
        yield Broken(("loads", "duty"), what, "", "one of the two", "give rows: [...], or record: FILE.csv")
    elif loads.duty.record is not None and loads.duty.period_s is not None:
        at = ("loads", "duty", "period_s")
        yield Broken(at, "given beside record", f"{loads.duty.period_s:g} s", "the record's own time", "leave it out")
    for k, row in enumerate(loads.duty.rows):
        if abs(row.torque_Nm) > loads.peak_torque_Nm:
            at = ("loads", "duty", "rows", k, "torque_Nm")
            yield Broken(at, "more than the peak torque", f"{row.torque_Nm:g} N m", limit, remedy)
        if row.range_deg is not None and row.range_deg > 2.0 * design.travel.half_angle_deg:
            at, whole = ("loads", "duty", "rows", k, "range_deg"), f"{2.0 * design.travel.half_angle_deg:g} deg"
            yield Broken(at, "more than the whole travel", f"{row.range_deg:g} deg", whole, "lower it")


def _targets(design: Design) -> Iterator[Broken]:
    """Hours of life need a stated duty, which says how many cycles an hour has."""
    targets = design.targets
    if targets.life_h is None:
        return
    at: FieldPath = ("targets", "life_h")
    if targets.life_cycles is not None:
        yield Broken(at, "given beside life_cycles", f"{targets.life_h:g} h", "one of the two", "leave one out")
    if design.loads.duty is None:
        remedy = "add loads.duty with the movements of a cycle, or give life_cycles in its place"
        yield Broken(at, "hours without a duty", f"{targets.life_h:g} h", "loads.duty, for cycles an hour", remedy)


def _rope(design: Design) -> Iterator[Broken]:
    rope = design.rope
    if (rope.type is None) == (rope.inline is None):
        what = "neither type nor inline is given" if rope.type is None else "both type and inline are given"
        yield Broken(("rope",), what, "", "one of the two", "give type: NAME, or all values under inline:")
    if (rope.modulus_GPa is None) != (rope.modulus_area is None):
        absent = "modulus_area" if rope.modulus_area is None else "modulus_GPa"
        remedy = "a modulus means nothing without its area: give both, or neither for the catalogue's"
        yield Broken(("rope",), f"{absent} is missing", "", "modulus_GPa and modulus_area go together", remedy)
    if rope.inline is not None and rope.modulus_GPa is not None:
        yield Broken(
            ("rope", "modulus_GPa"),
            "given beside inline",
            f"{rope.modulus_GPa:g} GPa",
            "one modulus",
            "set modulus_GPa and modulus_area under inline only",
        )


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


def _own_entries(design: Design) -> Iterator[Broken]:
    entries: dict[FieldPath, Entry] = {
        ("catalogue", kind, name): entry for kind in KINDS for name, entry in getattr(design.catalogue, kind).items()
    }
    if design.rope.inline is not None:
        entries["rope", "inline"] = design.rope.inline
    for path, entry in entries.items():
        for field, what, value, limit, remedy in entry_faults(entry):
            yield Broken((*path, field), what, value, limit, remedy)


def unique(block: str, name: str, values: Sequence[str] | Sequence[int]) -> Iterator[Broken]:
    """The rule that ``values`` of the field ``name`` in a list of blocks are unique."""
    for k, value in enumerate(values):
        if value in values[:k]:
            remedy = f"give every one of {block} its own {name}"
            yield Broken((block, k, name), "used twice", shortened(value), f"each {name} once", remedy)


def counted(design: Design, block: str, wanted: int, remedy: str) -> Iterator[Broken]:
    """The rule that a list of blocks, ``"inputs"`` or ``"cables"``, has as many entries as the configuration takes."""
    found = len(getattr(design, block))
    if found != wanted:
        what = f"wrong number of {block} for {design.configuration}"
        yield Broken((block,), what, str(found), str(wanted), remedy)


def on_one_side(index: int, side: str, who: str) -> Broken:
    """Two cables of one input, ``who`` in words, run to one side of the drum; ``index`` is that of the second."""
    remedy = "set drum_side to -x for one and to +x for the other: the input drives in one sense only otherwise"
    return Broken(("cables", index, "drum_side"), f"both {who} run to one side", side, "opposite sides", remedy)
