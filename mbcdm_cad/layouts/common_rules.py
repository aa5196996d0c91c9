"""Rules and required fields of every configuration, and what ``mbcdm solve`` may change besides derived dimensions."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from mbcdm_cad.checks.design_variables import ROPE_DIAMETER
from mbcdm_cad.checks.drum_sector import STOP_WINDOW_DEG
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken, broken_ends
from mbcdm_cad.design.sized import Freedom, to_a_size
from mbcdm_cad.sizing import Found, KnownFields, RopeKnown, constant, rule, significant

# Least D/d in the rope makers' tables of wire rope; they state no life below it.
LEAST_WIRE_RATIO = 10.0
# The same on a whole drum: where the data of a 7x7 rope's life begin (docs/life.md), since a cable of many turns is
# bent on all its length, and that of a first stage behind the second one is not seen to wear.
LEAST_LONG_RATIO = 14.2
# Constructions of ropes that rules choose: the most flexible wire rope of the catalogue in all sizes, and one with
# thinner wires, which lasts longer, with one of its entries.
CONSTRUCTION, FINER, FINER_ROPE = "7x7", "7x19", "7x19-1.0"
# Screws of the clamp collars, by size.
COLLAR_SCREWS = ("M1.6x6", "M2x8", "M2.5x10", "M3x12", "M4x16", "M5x20", "M6x25")
# Usual diameters of stop pins, from that of small drives upwards, mm.
STOP_PINS_MM = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
# Share of the peak torque at which backlash is stated, if the file has no test torque.
TEST_SHARE = 0.3


def _is_braid(given: RopeKnown) -> bool:
    known = given.has(at.rope.type) or given.has(at.rope.inline)
    return known and given.rope["construction"] == "braid"


def wants_life(given: KnownFields) -> bool:
    """Whether the file asks for a life of the cables."""
    return given.get(at.targets.life_cycles) is not None or given.get(at.targets.life_h) is not None


def stated_end(given: KnownFields) -> Mapping[str, Any] | None:
    """The entry of the ends that the file asks for by name; None where it leaves them out."""
    name = given.get(at.rope.termination)
    return None if name is None else given.entries("terminations").get(name)


def end_share(given: KnownFields, usual: float) -> float:
    """Strength of the ends over the rope's, before the rope is chosen: ``usual``, or that of weaker ends by name."""
    end = stated_end(given)
    return usual if end is None else min(usual, float(end["strength_share"]))


def ropes_to_choose(given: RopeKnown) -> list[tuple[float, str, float]]:
    """(diameter in mm, name, breaking load in N) of the ropes that rules may choose, the thinnest first.

    They are of the usual construction, the one with thinner wires where the file asks for a life; ends by name that are
    not made on it, or not on every diameter, are followed.
    """
    kind, end = FINER if wants_life(given) else CONSTRUCTION, stated_end(given)
    if end is not None and kind not in end["constructions"]:
        kind = end["constructions"][0]
    ropes = sorted(
        (entry["diameter_mm"], name, entry["breaking_load_N"])
        for name, entry in given.entries("ropes").items()
        if entry["construction"] == kind
    )
    ropes = [rope for rope in ropes if rope[0] >= given.least_rope_mm] or ropes
    if end is None:
        return ropes
    return [rope for rope in ropes if end["smallest_mm"] <= rope[0] <= end["largest_mm"]] or ropes


def least_bend_ratio(given: RopeKnown) -> float:
    """Least D/d of a rope: a fibre rope's minimum; what the maker recommends where the file asks for a life.

    Else that of makers' tables, on a whole drum that at which a life can be told.
    """
    if _is_braid(given):
        return float(given.rope["bend_ratio_minimum"])
    if not wants_life(given):
        return LEAST_LONG_RATIO if given.whole_drum else LEAST_WIRE_RATIO
    known = given.has(at.rope.type) or given.has(at.rope.inline)
    rope = given.rope if known else given.entries("ropes")[FINER_ROPE]
    return float(rope["bend_ratio_desired"])


@rule(
    at.limits.bend_ratio_min,
    "least D/d of makers' tables; a fibre rope's own minimum; what the maker recommends where targets ask for a life",
    "life",
)
def bend_ratio(given: RopeKnown) -> Found:
    least = least_bend_ratio(given)
    if least == LEAST_LONG_RATIO:
        return Found(least, "the data of life begin there; for a sector, rope makers' tables at 10")
    if least != LEAST_WIRE_RATIO:
        return Found(least, "the rope's own minimum" if _is_braid(given) else "life")
    return Found(least, "rope makers' tables of wire rope begin at 10")


@rule(at.rope.friction_coefficient, "usual value of dry wire rope, or of smooth fibre, on metal", "rope")
def friction(given: RopeKnown) -> float:
    return 0.1 if _is_braid(given) else 0.15


@rule(at.loads.test_torque_Nm, "0.3 of the peak torque", "loads")
def test_torque(given: KnownFields) -> float:
    return significant(TEST_SHARE * given[at.loads.peak_torque_Nm], 2)


def needed(field: str, remedy: str) -> Broken:
    """The error for a missing requirement."""
    what = "missing; it is a requirement, so no sizing rule gives it"
    return Broken(tuple(field.split(".")), what, "", "", remedy, missing=True)


def missing_travel(given: KnownFields, meaning: str) -> Iterator[Broken]:
    """What the file lacks, or contradicts, of the travel: half of it, or both ends."""
    ends = given.peek(at.travel.from_deg), given.peek(at.travel.to_deg)
    yield from broken_ends(*ends)
    if ends == (None, None) and not given.has(at.travel.half_angle_deg):
        yield needed(at.travel.half_angle_deg, f"add half_angle_deg: 35.0 ({meaning}, deg), or from_deg and to_deg")


@rule(
    at.travel.half_angle_deg, "half of the way from from_deg to to_deg; the drum is centred in its middle", "the file"
)
def half_travel(given: KnownFields) -> float:
    return float(given[at.travel.to_deg] - given[at.travel.from_deg]) / 2


SCHEMA_VERSION = constant("schema_version", 1, "the version of the file's layout", "the program")
STOP_CLEARANCE = constant(
    at.travel.stop_clearance_deg,
    STOP_WINDOW_DEG / 2,
    "middle of the range beyond the travel in which the stops must engage",
    "stop_within_half_degree",
)
TENSION_SAFETY = constant(at.limits.tension_safety_factor, 5.0, "usual factor; rope makers state 5 to 10", "tension")
PRELOAD_SHARE = constant(at.limits.preload_share_max, 0.5, "rope makers' limit: less than half", "preload_share")
MESH_TOLERANCE = constant("export.mesh_tolerance_mm", 0.01, "finer than the tolerances of usual workshops", "export")
RUNNING = constant(
    at.clearances.running_mm, 0.25, "gap for the tolerances and the run-out of moving parts", "frame_front"
)
DRUM_MATERIAL = constant(at.drum.material, "aluminium-7075", "light and strong; the part is milled", "process")
SHAFT_MATERIAL = constant(at.drum.shaft_material, "steel", "made from ground bar", "process")
SUPPORT_MATERIAL = constant(at.support.material, "aluminium-7075", "light and stiff; the part is milled", "process")


DRIVE: tuple[Freedom, ...] = (
    Freedom(at.rope.type, kind="ropes", order="diameter_mm", mends=((ROPE_DIAMETER, 1),)),
    Freedom(at.rope.preload_N, 0.5, 2.0),
    Freedom(at.drive.motor, kind="motors", order="rated_torque_mNm"),
    Freedom(at.drive.gearhead, kind="gearheads", order="max_torque_mNm"),
    Freedom(at.drum.tensioner, kind="tensioners", order="stud_length_mm"),
    Freedom(at.drum.bearing, kind="bearings", order="bore_mm"),
    Freedom(at.drum.stop_pin_mm, 0.5, 2.0, partial(to_a_size, STOP_PINS_MM)),
)
INPUTS: tuple[Freedom, ...] = (
    Freedom(at.input_pulleys.lower_bearing, kind="bearings", order="bore_mm"),
    Freedom(at.input_pulleys.upper_bearing, kind="bearings", order="bore_mm"),
    Freedom(at.input_pulleys.collar_screw, words=COLLAR_SCREWS),
)
SURFACE = Freedom(at.input_pulleys.surface, words=("smooth", "grooved"))
ENCODERS: tuple[Freedom, ...] = (
    Freedom(at.drive.encoder, kind="encoders", order="bore_mm"),
    Freedom(at.drive.drum_encoder, kind="encoders", order="bore_mm"),
)
# A metal frame or drum that the file leaves to its rule is of aluminium; steel is three times as stiff, and as heavy.
METALS: tuple[Freedom, ...] = tuple(
    Freedom(f"{part}.material", words=("aluminium-7075", "steel"), only_named=True) for part in ("drum", "support")
)
PARTS = (*DRIVE, *INPUTS, *ENCODERS, *METALS)


def first_radius(data: Mapping[str, Any]) -> dict[str, Any]:
    """Of a file with all radii of the drum, the field that gives the first alone; empty if it has none."""
    radii = data["transmission"].get("drum_radii_mm")
    return {at.transmission.drum_radius_mm: radii[0]} if radii else {}
