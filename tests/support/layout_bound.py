"""Find requirements of a drive without a guide that exclude each other: necessary conditions over the whole catalogue.

As :mod:`reach_bound` for the drive with a guide. Every rope, termination, motor and gearhead of the catalogue is tried;
fields that the file leaves open take their most favourable value. If no combination meets all conditions, no design
exists.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from math import acos, degrees, inf, pi, radians, tan
from typing import Any, NamedTuple

from mbcdm_cad.design.catalogue import package_entries
from tests.support.reach_bound import TENSION_FACTOR, WIRE_BEND, ends_of, smallest_impossible

Entry = Mapping[str, Any]
# Thinnest wall of any turned metal; of a milled frame where the file names no material; gap beside what turns.
TURNED_WALL_MM, MILLED_WALL_MM, RUNNING_MM = 0.5, 0.8, 0.25
# The stop in a pulley of siso_bevel: its bend as D/d, the straight before the swage, the gap to the cable that leaves.
STOP_BEND, STOP_LEAD_MM, STOP_GAP_MM = 8.0, 0.3, 0.1
LEAST_RESERVE_DEG = 15.0
# The column of siso_bevel from its pulley down to the drum's axis: land beside the cable, gap and play over the shelf,
# room under the encoder, stop pin, head of a mounting screw with its room, wall round the drum's bearing.
LAND_MM, OVER_SHELF_MM, UNDER_ENCODER_MM, STOP_PIN_MM, MOUNT_MM, BOSS_WALL_MM = 0.8, 0.7, 1.0, 3.0, 6.5, 3.0
# Hole for the key of the screws next to the motor, round its corners; web from there to the seat of a bearing.
KEY_PLAY_MM, HOLE_WEB_MM = 0.15, 0.5
# What a requirement that is left out may be at best.
LEAST_RATIO, MOST_RADIUS_MM = 1.0, 1000.0
NAMES = ("ratio", "radius", "travel", "torque", "rope", "surface")
# Slope of the turns on a smooth input, at most.
SMOOTH_FLEET_DEG = 1.5


@dataclass(frozen=True)
class Asked:
    """What a file asks; None where it leaves a value open. mm, degrees, N m of one input."""

    ratio: float | None
    radius: float | None
    travel: float | None
    torque: float | None
    rope: str | None
    surface: str | None = None
    wall_mm: float = MILLED_WALL_MM

    def only(self, names: tuple[str, ...]) -> "Asked":
        """With all other requirements left out."""
        return Asked(**{name: getattr(self, name) if name in names else None for name in NAMES}, wall_mm=self.wall_mm)


class Face(NamedTuple):
    """What is bolted to the motor shelf: its shaft's diameter, radius of its screws' circle and of their key's hole."""

    shaft_mm: float
    bolts_mm: float
    key_mm: float


@dataclass(frozen=True)
class Trial:
    """A file with one rope, its end and one gearhead or motor face chosen."""

    asked: Asked
    rope: Entry
    end: Entry
    face: Face

    @property
    def d(self) -> float:
        """Rope diameter, mm."""
        return float(self.rope["diameter_mm"])

    @property
    def radius_mm(self) -> float:
        """Drum radius, mm."""
        return self.asked.radius or MOST_RADIUS_MM

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        return self.asked.ratio or LEAST_RATIO

    @property
    def input_mm(self) -> float:
        """Input radius of step 1, mm."""
        return self.radius_mm / self.ratio


def _bends(t: Trial) -> bool:
    fibre = t.rope["construction"] == "braid"
    return 2 * t.input_mm >= (t.rope["bend_ratio_minimum"] if fibre else WIRE_BEND) * t.d - 1e-6


def _strong(t: Trial) -> bool:
    """Both cables of an input pull at the drum's radius at most."""
    held = t.rope["breaking_load_N"] * min(t.end["strength_share"], 1.0) / TENSION_FACTOR
    return (t.asked.torque or 0.0) * 1e3 <= 2 * t.radius_mm * held


def _stop_fits(t: Trial) -> bool:
    return t.input_mm - STOP_BEND * t.d / 2 - STOP_LEAD_MM - t.end["stop_length_ratio"] * t.d > 0.0


def _under_turn(t: Trial) -> bool:
    """Ratio x full travel, the least reserve, and the angle at which the leaving cable passes the winding's end."""
    centre = t.input_mm - STOP_BEND * t.d / 2
    if centre <= 0.0:
        return False
    passing = degrees(acos(max(-1.0, 1.0 - (t.d + STOP_GAP_MM) / centre)))
    return t.ratio * 2 * (t.asked.travel or 0.0) + LEAST_RESERVE_DEG + passing <= 360.0


@cache
def _nut_corner_mm() -> float:
    return min(float(t["nut_across_flats_mm"]) for t in package_entries("tensioners").values()) / 3**0.5


def _seat_behind_drum(t: Trial) -> bool:
    """The frame ends behind the terminals' nuts, and still has a wall before the bearing next to the gearhead."""
    return t.input_mm - _nut_corner_mm() - RUNNING_MM - t.asked.wall_mm >= _least_seat_mm(t.face)


@cache
def _least_seat_mm(face: Face) -> float:
    """Seat of the smallest bearing round the shaft that lets a key pass to the screws, in its seat or beside it."""
    seats = [
        b["outer_diameter_mm"] / 2
        for b in package_entries("bearings").values()
        if b["bore_mm"] >= face.shaft_mm + 2 * TURNED_WALL_MM - 1e-9
    ]
    low, high = face.bolts_mm - face.key_mm - HOLE_WEB_MM, face.bolts_mm + face.key_mm
    return min((seat for seat in seats if seat <= low or seat >= high), default=inf)


@cache
def _least_boss_mm() -> float:
    """Boss of the smallest drum bearing that a ring encoder is made for."""
    rings = [e for name, e in package_entries("encoders").items() if "ring" in name]
    return min(
        max(b["outer_diameter_mm"] / 2 + BOSS_WALL_MM, ring["diameter_mm"] / 2 + RUNNING_MM)
        for b, ring in product(package_entries("bearings").values(), rings)
        if b["bore_mm"] == ring["bore_mm"]
    )


def least_column_mm(wall_mm: float, rope_mm: float) -> float:
    """Height of the column of siso_bevel from the drum's axis to step 1, with the smallest parts of the catalogue."""
    encoders = [e["length_mm"] for name, e in package_entries("encoders").items() if "ring" not in name]
    shelf = max(min(b["width_mm"] for b in package_entries("bearings").values()) + wall_mm, 3.0)
    above = rope_mm / 2 + LAND_MM + OVER_SHELF_MM + shelf + min(encoders) + UNDER_ENCODER_MM
    return above + STOP_PIN_MM + 2 * wall_mm + MOUNT_MM + wall_mm + _least_boss_mm()


def _column_fits(t: Trial) -> bool:
    return t.radius_mm >= least_column_mm(t.asked.wall_mm, t.d)


def _straight(t: Trial) -> bool:
    """Turns of a smooth input lie a rope apart at least, so that a thin input slopes them."""
    return t.asked.surface != "smooth" or t.d <= 2 * pi * t.input_mm * tan(radians(SMOOTH_FLEET_DEG))


COMMON: dict[str, Callable[[Trial], bool]] = {
    "the input is too thin for the bend of the rope": _bends,
    "the rope is too weak": _strong,
}
SPUR_CONDITIONS = {**COMMON, "turns on a smooth input slope too much": _straight}
CONDITIONS: dict[str, dict[str, Callable[[Trial], bool]]] = {
    "siso_spur": SPUR_CONDITIONS,
    "miso_spur": SPUR_CONDITIONS,
    "siso_bevel": {
        **COMMON,
        "the input has no room for the rope's stop": _stop_fits,
        "ratio x full travel + reserve + slot > 360 degrees": _under_turn,
        "no bearing of the input fits behind the drum": _seat_behind_drum,
        "encoder, stop pin, mounts and boss are higher than the drum's radius": _column_fits,
    },
}


def asked(data: Mapping[str, Any]) -> Asked:
    """Of the content of a file of requirements."""
    t, torque = data["transmission"], data["loads"].get("peak_torque_Nm")
    material = data.get("support", {}).get("material")
    wall = float(package_entries("materials")[material]["min_wall_mm"]) if material else MILLED_WALL_MM
    return Asked(
        t.get("input_to_drum"),
        t.get("drum_radius_mm"),
        data["travel"].get("half_angle_deg"),
        torque / max(1, len(data.get("inputs", ()))) if torque else None,
        data.get("rope", {}).get("type"),
        data.get("input_pulleys", {}).get("surface"),
        wall,
    )


def excluding(layout: str, found: Asked) -> tuple[tuple[str, ...], str]:
    """The smallest set of requirements that no combination of the catalogue meets, and why; empty where there is none.

    Why: the conditions that no combination meets, where one alone is at fault, else all of the layout's.
    """
    names = smallest_impossible(NAMES, found, lambda asked: _possible(layout, asked))
    return names, _why(layout, found.only(names)) if names else ""


def _possible(layout: str, a: Asked) -> bool:
    return any(all(holds(t) for holds in CONDITIONS[layout].values()) for t in _trials(a))


def _why(layout: str, a: Asked) -> str:
    alone = [text for text, holds in CONDITIONS[layout].items() if not any(holds(t) for t in _trials(a))]
    return "; ".join(alone) or "no combination meets all conditions at once"


def _trials(a: Asked) -> Iterator[Trial]:
    ropes = package_entries("ropes")
    for rope in [ropes[a.rope]] if a.rope else ropes.values():
        for end in ends_of(rope):
            yield from (Trial(a, rope, end, face) for face in _faces((a.torque or 0.0) / (a.ratio or 40.0)))


@cache
def _faces(input_Nm: float) -> tuple[Face, ...]:
    """Faces of gearheads, with some motor, and of motors with a shaft of their own that hold a torque at the input."""
    motors, heads = package_entries("motors").values(), package_entries("gearheads").values()
    strong = [m for m in motors if m.get("shaft_diameter_mm") and m["rated_torque_mNm"] >= input_Nm * 1e3]
    strong += [
        head
        for head in heads
        if head["max_torque_mNm"] >= input_Nm * 1e3
        and any(m["rated_torque_mNm"] * head["ratio"] >= input_Nm * 1e3 for m in motors)
    ]
    screws = package_entries("screws")
    return tuple(
        sorted(
            {
                Face(
                    e["shaft_diameter_mm"], e["bolt_circle_mm"] / 2, screws[e["screw"]]["key_mm"] / 3**0.5 + KEY_PLAY_MM
                )
                for e in strong
            }
        )
    )
