"""Rules of the idlers, for a design whose file has that block."""

from __future__ import annotations

from math import hypot
from typing import Any

from mbcdm_cad.layouts.siso_spur.idlers import flange_radius_mm
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.sizing.rule import Found, Rule, largest, rounded_up

# Radius of an idler over that of the input, since the cable is bent back behind it (rope makers: a quarter larger).
REVERSE = 1.25
# Wall between the outer ring of a bearing and the land of its idler, mm (estimate).
WALL_MM = 1.5
# Radius that terminals reach beyond the cable on the drum, over the thread of their stud (estimate; a check measures).
REACH = 2.0
# Bearings of a radius that is tried first, before their loads are known.
_BEARING = "624"


def _has_idlers(given: SpurKnown) -> bool:
    return given.peek("idlers") is not None


def idler_guesses(given: SpurKnown, drum_mm: float) -> dict[str, Any]:
    """Values of idlers that the first pass does not know yet; none for a design without idlers."""
    if not _has_idlers(given):
        return {}
    return {
        "idlers.bearing": _BEARING,
        "idlers.radius_mm": 12.0,
        "idlers.width_mm": 20.0,
        "idlers.places": [{"x_mm": 14.0, "z_mm": 1.05 * drum_mm + 20.0}],
    }


def _guessed(given: SpurKnown) -> str:
    """Bearing of the pass before."""
    return str(given.guesses["idlers.bearing"])


def _radius(given: SpurKnown) -> Found:
    """The limit of the bend ratio, a quarter more than the input, and room for the bearing."""
    stated = given.has("idlers.bearing")
    bearing = given.entry("bearings", "idlers.bearing") if stated else given.entries("bearings")[_guessed(given)]
    needs = {
        "bend_ratio": given["limits.bend_ratio_min"] * given.d_mm / 2,
        "life": REVERSE * given.input_mm,
        "idler_bearings": bearing["outer_diameter_mm"] / 2 + WALL_MM + given.d_mm / 2,
    }
    return largest(needs, 0.5)


def _places(given: SpurKnown) -> Found:
    """One pair before the drum: the cables pass between the two, whose flanges leave a gap, and go on to the drum."""
    running, flange = given["clearances.running_mm"], flange_radius_mm(given["idlers.radius_mm"], given.d_mm)
    across = rounded_up(flange + running, 0.1)
    tensioner = given.entries("tensioners")[given.get("drum.tensioner", given.guesses["drum.tensioner"])]
    corner = REACH * tensioner["thread_mm"]
    reach = hypot(given.drum_mm + corner, tensioner["stud_length_mm"])
    apart = reach + flange + running
    return Found([{"x_mm": across, "z_mm": rounded_up((apart**2 - across**2) ** 0.5, 0.5)}], "idler_room", "up to 0.5")


def _bearing(given: SpurKnown) -> Found:
    entries = given.entries("bearings")
    names = sorted(entries, key=lambda name: (entries[name]["mass_g"], name))
    return given.first("idlers.bearing", names, ("idler_bearings", "idler_axles"))


def _width(given: SpurKnown) -> Found:
    bearing = given.entry("bearings", "idlers.bearing")
    return given.moved("idlers.width_mm", 2.0 * bearing["width_mm"] + 1.0, 0.1, ("idler_walk",))


IDLERS = (
    Rule(
        "idlers.radius_mm",
        "the limit of the bend ratio, a quarter more than the input's radius, or room for the bearing",
        "bend_ratio",
        _radius,
        applies=_has_idlers,
    ),
    Rule(
        "idlers.places",
        "one pair as near to the drum as its terminals allow, side by side; the cables pass between the two",
        "idler_room",
        _places,
        applies=_has_idlers,
    ),
)
WIDTH = (
    Rule(
        "idlers.bearing",
        "the lightest that carries the pull of both spans and whose axle is strong enough",
        "idler_bearings",
        _bearing,
        applies=_has_idlers,
    ),
    Rule(
        "idlers.width_mm",
        "least land for the walk of the cable and its rise, and for two bearings",
        "idler_walk",
        _width,
        applies=_has_idlers,
    ),
)
