"""Rules by which all layouts choose bought parts: the lightest with which the checks pass."""

from collections.abc import Callable
from math import inf
from typing import Any

from mbcdm_cad.checks.geometry import HOLE_WEB_MM
from mbcdm_cad.design.bought import NO_BEARING, NO_ENCODER
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.sized import NOT_USED
from mbcdm_cad.layouts.common_rules import COLLAR_SCREWS
from mbcdm_cad.layouts.head_dims import UNUSED
from mbcdm_cad.layouts.trial_sizing import TrialKnown
from mbcdm_cad.sizing import Found, rule

_RING = "ring"
# Thinnest journal that carries a wheel (estimate).
JOURNAL_MM = 4.0


def by_mass(
    given: TrialKnown, kind: str, wanted: Callable[[str, dict[str, Any]], bool] = lambda name, entry: True
) -> list[str]:
    """Names of the entries that are ``wanted``, the lightest first."""
    entries = given.entries(kind)
    return sorted((n for n, e in entries.items() if wanted(n, e)), key=lambda n: (entries[n]["mass_g"], n))


def _beside(given: TrialKnown, bearing: dict[str, Any], kind: str = _RING) -> list[str]:
    """Encoders of a bearing's bore, whose screws are beside its seat; the lightest first."""

    def fits(name: str, one: dict[str, Any]) -> bool:
        if kind not in name or one["bore_mm"] != bearing["bore_mm"]:
            return False
        web = (one["bolt_circle_mm"] - given.screw(one["screw"]).thread_mm - bearing["outer_diameter_mm"]) / 2
        return bool(web >= HOLE_WEB_MM)

    names = by_mass(given, "encoders", fits)
    return [name for name in names if given.get(at.drive.drum_encoder) in (None, name)]


@rule(
    at.drum.bearing,
    "the lightest with a ring encoder that carries the drum and has a strong enough shaft",
    "drum_bearings",
)
def drum_bearing(given: TrialKnown) -> Found:
    any_will_do = given.get(at.drive.drum_encoder) == NO_ENCODER
    field, refused, before = at.drum.bearing, given.drives.refused, given.guesses.get(at.drum.bearing)
    # A lighter bearing is narrower and so nearer to the other one: tried at the distance of a wider pair it seems to
    # carry the drum, and would be chosen and refused in turn.
    if (
        given.drives.passes
        and before is not None
        and -inf < given.margins(field, before, ("drum_bearings",))["drum_bearings"][0] < 0.0
    ):
        entries = given.entries("bearings")
        weak = entries[before]
        refused |= {
            name
            for name, entry in entries.items()
            if entry["static_rating_N"] <= weak["static_rating_N"] and entry["width_mm"] <= weak["width_mm"]
        }

    def allowed(kind: str) -> list[str]:
        names = by_mass(given, "bearings", lambda _, entry: any_will_do or bool(_beside(given, entry, kind)))
        return [name for name in names if name not in refused]

    # A ring leaves the shaft open behind; where no bearing with one will do, an encoder on the shaft's end.
    names = allowed(_RING) or allowed("") or by_mass(given, "bearings", lambda _, entry: bool(_beside(given, entry)))
    # A bore that the file states is a hollow centre, round which the shaft needs a wall.
    hollow = ("shaft_wall",) if given.get(at.drum.shaft_bore_mm) is not None else ()
    checks = (*hollow, "drum_bearings", "shaft_stress", "shaft_twist", "set_screw_tips")
    found = given.first(field, names, checks)
    if not names or given.margins(field, found.value, ("drum_bearings",))["drum_bearings"][0] >= 0.0:
        return found
    # With small bearings the next pass would put them so near to each other that none carries the drum.
    entries = given.entries("bearings")
    strongest = max(names, key=lambda name: entries[name]["static_rating_N"])
    return Found(strongest, "drum_bearings", "no candidate does yet: the strongest")


@rule(
    at.input_pulleys.lower_bearing,
    "the lightest that fits journal and shaft, carries the cables' load and leaves access to the screws",
    "input_bearings",
)
def lower(given: TrialKnown) -> Found:
    if given.overhung:
        return Found(NO_BEARING, UNUSED)
    wall, wheel = given.wall_mm("input_pulleys"), given.has("stage.kind")
    least = JOURNAL_MM if wheel else given.gearhead.shaft_diameter_mm + 2 * wall
    names = by_mass(given, "bearings", lambda _, entry: entry["bore_mm"] >= least)
    # A journal that carries a wheel has no bore.
    own = ("stage_journal",) if wheel else ("bore_wall", "key_access")
    return given.first(at.input_pulleys.lower_bearing, names, (*own, "input_bearings"))


@rule(
    at.input_pulleys.upper_bearing, "the lightest that carries the cables' load and fits an encoder", "input_bearings"
)
def upper(given: TrialKnown) -> Found:
    if given.overhung:
        return Found(NO_BEARING, UNUSED)
    # Bores of the encoders that sit on the end of a shaft; of the stated one.
    stated, entries = given.get(at.drive.encoder), given.entries("encoders")
    bores = {entries[n]["bore_mm"] for n in ([stated] if stated in entries else entries) if _RING not in n}
    names = by_mass(given, "bearings", lambda _, entry: stated == NO_ENCODER or entry["bore_mm"] in bores)
    return given.first(at.input_pulleys.upper_bearing, names, ("input_bearings",))


@rule(at.drive.encoder, "the lightest that fits the journal", "encoder_fit")
def encoder(given: TrialKnown) -> Found:
    if given.overhung:
        return Found(NO_ENCODER, UNUSED)
    bore = given.entry("bearings", at.input_pulleys.upper_bearing)["bore_mm"]
    names = by_mass(given, "encoders", lambda name, entry: _RING not in name and entry["bore_mm"] == bore)
    return given.first(at.drive.encoder, names, given.encoder_checks)


@rule(at.drive.drum_encoder, "the lightest ring that fits the drum's shaft", "encoder_fit")
def drum_encoder(given: TrialKnown) -> Found:
    bearing = given.entry("bearings", at.drum.bearing)
    # For a bearing that the file states there may be none beside its seat: the checks then state what is missing.
    names = (
        _beside(given, bearing)
        or _beside(given, bearing, "")
        or by_mass(given, "encoders", lambda name, entry: _RING in name and entry["bore_mm"] == bearing["bore_mm"])
    )
    return given.first(at.drive.drum_encoder, names, ("boss",))


@rule(at.drum.tensioner, "the shortest whose sleeve fits the rope and whose stud is strong and long enough", "take_up")
def tensioner(given: TrialKnown) -> Found:
    entries = given.entries("tensioners")
    names = sorted(entries, key=lambda name: entries[name]["stud_length_mm"])
    led = ("spring_fits",) if given.has(at.drum.spring) else ()
    # No width of the rim makes the lugs of a whole drum wider.
    lug = ("lug_stress",) if given.whole_drum else ()
    return given.first(at.drum.tensioner, names, ("sleeve_fits", "stud_stress", "take_up", *led, *lug))


@rule(at.input_pulleys.collar_screw, "the smallest whose clamp holds the input's torque", "collar_grip")
def collar_screw(given: TrialKnown) -> Found:
    if given.overhung:
        return Found(COLLAR_SCREWS[0], NOT_USED + "set screws hold the pulley")
    # The shaft of a first stage is thick, and the collar round it wide for the screw that holds it.
    wide = ("engagement",) if given.has("first_stage") else ()
    return given.first(at.input_pulleys.collar_screw, COLLAR_SCREWS, ("collar_grip", *wide))


PARTS = (drum_bearing, lower, upper, collar_screw, encoder, drum_encoder, tensioner)
