"""Find requirements that exclude each other for any other choice: necessary conditions over the whole catalogue.

Nothing here sizes or checks a design. Every rope, gearhead and motor of the catalogue is compared with conditions that
each design must meet, written from the descriptions of the checks; fields that the file leaves open take their most
favourable value. If no combination meets all conditions, no design exists. The converse does not follow: the conditions
are only a small part of the checks.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import hypot, inf, pi, radians, tan
from typing import Any, Protocol, Self, TypeVar

from mbcdm_cad.checks.input_pulley import SHOULDER_MM
from mbcdm_cad.checks.ratios import ANCHOR_RATIO
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.parts.input_pulley.dims import STOP_WALL_MM

# Of the design files in question, which name no limits of their own: least D/d of wire and of fibre, factor on the
# breaking load, largest fleet angle of all surfaces.
WIRE_BEND, FIBRE_BEND, TENSION_FACTOR, FLEET_DEG = 10.0, 8.0, 5.0, 2.0
# Outermost land over the first, at most: the one bound on a value that no check bounds by itself.
MOST_OUTER = 2.0
# Between the pocket of a stop and the neck under it; between guide and input pulley.
NECK_GAP_MM, PULLEY_GAP_MM, BAND_GAP_MM = 0.1, 0.25, 0.2
# Thinnest wall of any turned metal.
WALL_MM = 0.5
# What a requirement that is left out may be at best.
LEAST_RATIO, MOST_RATIO, MOST_RADIUS_MM = 1.0, 40.0, 1000.0
NAMES = ("ratio", "radius", "travel", "torque", "rope", "distance")


class Requirements(Protocol):
    """What a file asks, with the fields that it leaves open None."""

    def only(self, names: tuple[str, ...]) -> Self:
        """With all other requirements left out."""
        ...


T = TypeVar("T", bound=Requirements)


@dataclass(frozen=True)
class Asked:
    """What a file asks; None where it leaves a value open. mm, degrees, N m."""

    ratio: float | None
    radius: float | None
    travel: float | None
    torque: float | None
    rope: str | None
    distance: float | None

    def only(self, names: tuple[str, ...]) -> "Asked":
        """With all other requirements left out."""
        return Asked(**{name: getattr(self, name) if name in names else None for name in NAMES})


def asked(data: Mapping[str, Any]) -> Asked:
    """Of the content of a file of requirements."""
    t = data["transmission"]
    return Asked(
        t.get("ratio"),
        t.get("drum_radius_mm"),
        data["travel"].get("half_angle_deg"),
        data["loads"].get("peak_torque_Nm"),
        data.get("rope", {}).get("type"),
        t.get("centre_distance_mm"),
    )


def excluding(found: Asked) -> tuple[str, ...]:
    """The smallest set of requirements that no combination of the catalogue meets; empty where there is none."""
    return smallest_impossible(NAMES, found, _possible)


def smallest_impossible(names: Sequence[str], found: T, possible: Callable[[T], bool]) -> tuple[str, ...]:
    """The smallest of the sets of stated fields ``names`` that are not ``possible`` alone; empty where all are."""
    if possible(found):
        return ()
    given = [name for name in names if getattr(found, name) is not None]
    sets = (some for count in range(1, len(given) + 1) for some in combinations(given, count))
    return next(some for some in sets if not possible(found.only(some)))


def _possible(a: Asked) -> bool:
    ratios = [a.ratio] if a.ratio is not None else [LEAST_RATIO * 1.05**k for k in range(76)]
    ropes = package_entries("ropes")
    return any(
        _pulleys(a, ratio, rope, end, head) and _strong(a, rope, end) and _placed(a, ratio, rope)
        for rope in ([ropes[a.rope]] if a.rope else ropes.values())
        for end in ends_of(rope)
        for ratio in ratios
        for head in _heads(a, ratio)
    )


def ends_of(rope: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Terminations that are made on this rope."""
    for end in package_entries("terminations").values():
        if (
            rope["construction"] in end["constructions"]
            and end["smallest_mm"] <= rope["diameter_mm"] <= end["largest_mm"]
        ):
            yield end


def _heads(a: Asked, ratio: float) -> Iterator[Mapping[str, Any]]:
    """Gearheads that hold half the torque over the ratio, with some motor."""
    needed = 0.0 if a.torque is None else a.torque * 1e3 / (2 * ratio)
    strongest = max(motor["rated_torque_mNm"] for motor in package_entries("motors").values())
    for head in package_entries("gearheads").values():
        if head["max_torque_mNm"] >= needed and strongest * head["ratio"] >= needed:
            yield head


def _pulleys(a: Asked, ratio: float, rope: Mapping[str, Any], end: Mapping[str, Any], head: Mapping[str, Any]) -> bool:
    """The smaller step of an input pulley bends the rope, holds its stop, and has a journal round the drive's shaft."""
    if a.radius is None:
        return True
    d, r = rope["diameter_mm"], a.radius / ratio
    least = FIBRE_BEND if rope["construction"] == "braid" else WIRE_BEND
    stop = end["stop_radius_ratio"] * d
    bend = r - d / 2 - stop - STOP_WALL_MM
    journal = head["shaft_diameter_mm"] / 2 + WALL_MM
    smallest = min(b["bore_mm"] for b in package_entries("bearings").values() if b["bore_mm"] / 2 >= journal - 1e-9)
    return (
        2 * r >= least * d and 2 * bend >= ANCHOR_RATIO * d and bend - stop - NECK_GAP_MM >= smallest / 2 + SHOULDER_MM
    )


def _strong(a: Asked, rope: Mapping[str, Any], end: Mapping[str, Any]) -> bool:
    """Steps 1 and 4 pull one way alone: T <= (r_1 + r_4) T_max."""
    if a.torque is None or a.radius is None:
        return True
    held = rope["breaking_load_N"] * min(end["strength_share"], 1.0) / TENSION_FACTOR
    return a.torque * 1e3 <= (1.0 + MOST_OUTER) * a.radius * held


def _placed(a: Asked, ratio: float, rope: Mapping[str, Any]) -> bool:
    """Guide and input pulley fit beside each other, with a free span long enough for the fleet angle."""
    if a.distance is None or a.radius is None:
        return True
    d = rope["diameter_mm"]
    walk = d * ratio * radians(a.travel or 0.0) / (2 * pi)
    outer = a.radius + 2 * (2 * walk + d + BAND_GAP_MM)
    least = min((b["outer_diameter_mm"] for b in package_entries("bearings").values()), default=inf) / 2
    guide = (least + WALL_MM + d / 2) * outer / a.radius
    reach = guide + outer / ratio
    return a.distance >= max(hypot(reach, walk / tan(radians(FLEET_DEG))), reach + d + PULLEY_GAP_MM)
