"""The design file of siso_spur: its rules, the drive of a valid one, and a short file to start from."""

from collections.abc import Iterator, Mapping
from typing import Any

from mbcdm_cad.design.bought import NO_BEARING, NO_ENCODER, own_bearing, without_encoder
from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.loader import DesignFile
from mbcdm_cad.design.resolve import Catalogue, preload_N, shared_sigmas, shared_values
from mbcdm_cad.design.rules import Broken, NamedEntry, counted, on_one_side
from mbcdm_cad.design.sector_blocks import MOST_SECTOR_DEG
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.layouts.siso_spur import drive as d
from mbcdm_cad.layouts.siso_spur.first_stage import broken_first_stage, of_design
from mbcdm_cad.layouts.siso_spur.schema import REFERENCE, SpurBlocks, SpurDesign, SpurTransmission
from mbcdm_cad.parts.drum_sector.design import sector_entries, sector_values, terminal_angle_rad
from mbcdm_cad.parts.drum_sector.dims import SCREWS, WHOLE_DEG

# Places in capitals are filled in for each layout with inputs beside the drum.
_TEXT = """\
# Requirements of a cable drive; every other field follows from them by a rule ('mbcdm explain FILE' says how).
# Lengths in mm, angles in degrees. Any field of docs/design-file.md may be given too: it then stays as it is.
name: {name}
configuration: CONFIGURATION
travel:
  half_angle_deg: 35.0      # deg: travel from the centre to each side
transmission:
  input_to_drum: 5.0        # drum radius over input radius: the smaller, the longer the rope lasts; left out: what a
                            # stated motor needs, else that of the lightest drive
  drum_radius_mm: 60.0      # mm: drum pitch radius; left out: as small as the rope allows
  # cables: two_anchored    # two cables with a stop each in the input; left out: one, held there by friction
loads:
  peak_torque_Nm: TORQUE       # N m: torque to hold both ways
  # structure_share: 0.5    # turn of the payload by all other parts over that by the cables, at most; left out: that
                            # where 1 % of mass buys 1 % less turn of the payload
limits:
  losses: counted           # the torque counts what gearheads, cables and bearings lose; paper: no losses
# drive: {{motor: tmotor-u8-100kv}}  # a motor with a shaft of its own needs no gearhead
# rope: {{type: FF-081}}      # left out: the thinnest 7x7 wire rope that holds
# drum: {{material: pla}}     # left out: aluminium; so for support
"""


def starting(configuration: str, torque_Nm: float, more: str = "") -> str:
    """The text with a place for the design's ``name``, ``more`` lines behind it."""
    return _TEXT.replace("CONFIGURATION", configuration).replace("TORQUE", f"{torque_Nm:.1f}") + more


_SIGN = {"-x": -1, "+x": 1}
# Step of a side, by the value of ``transmission.cables``. The side that runs to +x has the smaller y, of two anchored
# cables the larger one: the grooves are then right-handed, as usual on a lathe.
_STEP = {"continuous": {"+x": 1, "-x": 2}, "two_anchored": {"+x": 2, "-x": 1}}


def drive(design: SpurDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> d.SpurDrive:
    """The drive of a valid design; its sides are in the order of y."""
    values = spur_values(design, catalogue, sigmas)
    first = of_design(design)
    if first is not None:
        values |= {"first_stage": first.drive, "gearhead": first.output, "motor": first.drive.motor}
        if design.drive.encoder == NO_ENCODER:
            values["encoder"] = without_encoder(first.output, first.output.ratio)
    return d.laid(d.SpurDrive(**values))


def spur_values(design: SpurBlocks, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.layouts.siso_spur.drive.SpurDrive`, still without planes of terminals.

    Sides are in the order of the inputs, then of the cables, then of y.
    """
    order, step = [item.name for item in design.inputs], _STEP[design.transmission.cables]
    sides = [(cable.input, cable.drum_side) for cable in design.cables]
    places = sorted(
        range(len(sides)), key=lambda k: (order.index(sides[k][0]), sides[:k].count(sides[k]), step[sides[k][1]])
    )
    transmission, pulleys = design.transmission, design.input_pulleys
    radius = input_radius_mm(transmission)
    shared = shared_values(design, catalogue)

    own = own_bearing(shared["gearhead"]) if pulleys.overhung else None

    def of(name: str) -> float:
        return sigmas.get(("transmission", name), 0.0)

    return (
        shared
        | sector_values(design, catalogue)
        | {
            "helix_lead_mm": design.rope.helix_lead_mm,
            # ``laid`` sets it.
            "dead_turns": 0.0,
            "cables": tuple(
                d.SpurRun(
                    name=cable.name,
                    input_name=cable.input,
                    drum_side=_SIGN[cable.drum_side],
                    step=step[cable.drum_side],
                    input_radius_mm=radius,
                    drum_radius_mm=transmission.drum_radius_mm,
                    preload_N=preload_N(design, cable),
                    terminal_angle_rad=terminal_angle_rad(cable),
                    terminal_y_mm=0.0,
                )
                for cable in (design.cables[k] for k in places)
            ),
            "centre_distance_mm": transmission.centre_distance_mm,
            "turns": transmission.turns,
            "anchored": transmission.cables == "two_anchored",
            "open_spans": transmission.spans == "open",
            "parallel": transmission.parallel,
            "radii_explicit": transmission.input_to_drum is None,
            "idlers": design.idlers,
            "bearings": d.SpurBearings(
                drum=catalogue.bearing(design.drum.bearing),
                input_lower=own if own else catalogue.bearing(pulleys.lower_bearing),
                input_upper=own if own else catalogue.bearing(pulleys.upper_bearing),
                idler=catalogue.bearing(design.idlers.bearing) if design.idlers else None,
            ),
            "sigmas": Sigmas(
                **shared_sigmas(design, catalogue, sigmas, places),
                lengths_mm={
                    "input_radius_mm": (of("input_radius_mm"),) * len(places),
                    "drum_radius_mm": (of("drum_radius_mm"),) * len(places),
                    "centre_distance_mm": of("centre_distance_mm"),
                },
            ),
        }
    )


def input_radius_mm(transmission: SpurTransmission) -> float:
    """Input pitch radius, as given or from the ratio, then rounded to 1e-9 mm."""
    if transmission.input_to_drum is None:
        return transmission.input_radius_mm or 0.0
    return round(transmission.drum_radius_mm / transmission.input_to_drum, 9)


def broken_rules(design: SpurDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from broken_radius(design.transmission)
    yield from counted(design, "inputs", 1, "give exactly one input")
    count = 2 * design.transmission.parallel
    yield from counted(design, "cables", count, "give the two sides of each cable, one for each sense of the drum")
    for k in range(1, count if len(design.cables) == count else 0, 2):
        if design.cables[k].drum_side == design.cables[k - 1].drum_side:
            yield on_one_side(k, design.cables[k].drum_side, "sides")
    yield from _broken_parallel(design)
    yield from broken_way(design)
    yield from _broken_drum(design)
    yield from _broken_spans(design)
    yield from broken_first_stage(design)


def _broken_drum(design: SpurDesign) -> Iterator[Broken]:
    """A whole drum carries one cable that runs straight to it: two anchored ones would cross on it.

    Rules take one for a long travel, so that what the file states beside it is named.
    """
    sector = f"take a sector, which rules do up to {d.MOST_SECTOR_TRAVEL_DEG:g} deg of travel each way"
    if design.drum.sector_half_angle_deg < WHOLE_DEG:
        yield from broken_sector(design.drum.sector_half_angle_deg)
    elif design.transmission.cables == "two_anchored":
        what, remedy = "two anchored cables would cross on a whole drum", f"set it to continuous, or {sector}"
        yield Broken(("transmission", "cables"), what, "two_anchored", "continuous", remedy)
    elif design.idlers is not None:
        count = len(design.idlers.places)
        yield Broken(("idlers",), "no whole drum beside idlers", f"{count}", "none", f"remove them, or {sector}")


def _broken_parallel(design: SpurDesign) -> Iterator[Broken]:
    """Parallel cables are continuous (decision 0011) and have four screws between the dowels of their hubs."""
    count, where = design.transmission.parallel, ("transmission", "parallel")
    if count > 1 and design.transmission.cables == "two_anchored":
        what = "the stops of anchored cables are milled into the input's end faces, which inner cables do not reach"
        remedy = (
            "set transmission.cables to continuous, with more transmission.turns if input_slip fails, or parallel to 1 "
            "and choose a stronger rope.type"
        )
        yield Broken(where, what, str(count), "1 beside two_anchored", remedy)
    if count > 1 and design.drum.output_screws != SCREWS:
        name = f"drum.output_screws other than {SCREWS}"
        yield Broken(where, f"not beside {name}", str(count), "1", f"set it to 1, or remove {name}")


def _broken_spans(design: SpurDesign) -> Iterator[Broken]:
    """Open spans are those of one cable that runs straight from the input, in a drive of one stage."""
    beside = {
        "two_anchored": (design.transmission.cables == "two_anchored", "the spans of two anchored cables cross"),
        "idlers": (design.idlers is not None, "idlers lead spans that cross"),
        "first_stage": (design.first_stage is not None, "behind a first stage the spans cross"),
    }
    for name, (given, why) in beside.items():
        if given and design.transmission.spans == "open":
            remedy = f"set it to crossed, or remove {name}"
            yield Broken(("transmission", "spans"), f"{why}: not beside {name}", "open", "crossed", remedy)


def broken_sector(angle_deg: float) -> Iterator[Broken]:
    """A sector leaves a gap."""
    if angle_deg > MOST_SECTOR_DEG:
        limit, remedy = f"up to {MOST_SECTOR_DEG:g}", "lower it, or state 180 in siso_spur: a whole drum"
        yield Broken(("drum", "sector_half_angle_deg"), "no gap is left", f"{angle_deg:g}", limit, remedy)


def broken_way(design: SpurBlocks) -> Iterator[Broken]:
    """What stands on the cable's way: as many idlers as stated, and a seat of the pulley that has no contradiction."""
    if design.idlers and design.idlers.pairs not in (None, len(design.idlers.places)):
        what, value = "not the number of idlers.places", f"{design.idlers.pairs}"
        yield Broken(("idlers", "pairs"), what, value, f"{len(design.idlers.places)}", "remove pairs, or remove places")
    yield from broken_seat(design)
    if design.drum.shaft_end_mm > 0.0 and design.drive.drum_encoder != NO_ENCODER:
        what, remedy = "the drum's shaft stands out where it would sit", f"write {NO_ENCODER}, or remove shaft_end_mm"
        yield Broken(("drive", "drum_encoder"), what, design.drive.drum_encoder, NO_ENCODER, remedy)


def broken_seat(design: SpurBlocks) -> Iterator[Broken]:
    """A pulley on the motor's shaft has no bearings, no encoder and no stops; one between bearings names both."""
    pulleys, carried = design.input_pulleys, "the motor's shaft carries the pulley"
    if not pulleys.overhung:
        return
    instead = "or set input_pulleys.carried_by to bearings"
    for path, name, none in (
        (("input_pulleys", "lower_bearing"), pulleys.lower_bearing, NO_BEARING),
        (("input_pulleys", "upper_bearing"), pulleys.upper_bearing, NO_BEARING),
        (("drive", "encoder"), design.drive.encoder, NO_ENCODER),
    ):
        if name != none:
            what = f"{carried} and has no place for it"
            yield Broken(path, what, name, none, f"leave it out, write {none}, {instead}")
    for block, name in ((design.idlers, "idlers"), (design.stage, "stage")):
        if block is not None:
            what = f"{carried}, whose frame has no place for it"
            yield Broken((name,), what, "", f"no {name}", f"remove it, {instead}")
    if (cables := design.transmission.cables) != "continuous":
        what = "a pulley on the motor's shaft has no end faces for the stops of anchored cables"
        yield Broken(("transmission", "cables"), what, cables, "continuous", f"leave it out, {instead}")


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
    if design.idlers:
        yield NamedEntry(("idlers", "bearing"), "bearings", design.idlers.bearing)


STARTING = starting("siso_spur", 2.0)
DESIGN_FILE = DesignFile(
    SpurDesign, REFERENCE.values, broken_rules, named_entries, drive, "mbcdm_cad.layouts.siso_spur.sizing", STARTING
)
