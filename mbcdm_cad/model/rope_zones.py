"""Which zones of a rope bend where, how often in a cycle of the output, and the damage of each by Miner's rule.

A point of the rope that passes the tangent point of a pulley bends on or off it: half a bending, at the tension that
the rope has there at that moment. All tangent points of a rope move along it together, by the drum's radius times its
angle. What a pulley never gives up does not bend.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from statistics import NormalDist

import numpy as np

from mbcdm_cad.model.rope_bendings import (
    MOST_BENDINGS,
    Crossing,
    RopeKind,
    at_border,
    bendings,
    is_rough,
    sigmas,
    too_hard,
)
from mbcdm_cad.routes import Floats

# A bend the other way round next counts for this many (1 to 4: estimate).
REVERSE_WEIGHT, SIGMA_REVERSE = 2.5, 0.5
# Miner's sum over several loads: a factor of 2.
SIGMA_MINER = float(np.log(2.0))
# Points of a rope at which the damage is summed, between two borders of zones.
_POINTS = 17
_EDGE = 1e-9
# Tensions that differ by less, as a share, count as one load.
_SAME_LOAD = 0.05


@dataclass(frozen=True, eq=False)
class Tangent:
    """A tangent point: where along the rope with the drum centred, m, and how far it moves for a rad of the drum, m.

    ``cable``: index of the cable (side of a rope that passes through) whose tension the rope has there. ``normal``
    points from the rope to the pulley's axis. ``spans_to``: index of the tangent point at the other end of the span.
    ``fleet_per_rad``: fleet angle, deg, for a rad of the drum from its centre.
    """

    cable: int
    body: str
    radius_m: float
    place_m: float
    moves_m: float
    normal: tuple[float, float, float]
    spans_to: int
    groove: float | None = None
    fleet_deg_per_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class Level:
    """Cycles of the drum between two angles, to and fro, ``count`` of them in one cycle of the output.

    ``there_N`` and ``back_N``: tensions of the cables (n_cables, n) at ``angle_rad`` (n,), rising, with the drum on its
    way up and on its way down.
    """

    angle_rad: Floats
    there_N: Floats
    back_N: Floats
    count: float = 1.0


@dataclass(frozen=True, eq=False)
class RopeInUse:
    """A rope on its way over the pulleys. ``bend_stiffness_N_m2``: a move shorter than sqrt(EI/T) bends it less."""

    name: str
    rope: RopeKind
    breaking_N: float
    bend_stiffness_N_m2: float
    tangents: tuple[Tangent, ...]


@dataclass(frozen=True)
class AtPulley:
    """What the weakest point of a rope goes through at one pulley in a cycle of the output."""

    body: str
    bend_ratio: float
    bendings: float
    tension_N: tuple[float, float]
    damage_share: float
    fleet_deg: float
    groove: float | None


@dataclass(frozen=True)
class BentZone:
    """A stretch of a rope, m from the middle or the stop on its input, and its bendings a cycle at each pulley."""

    start_m: float
    end_m: float
    bendings: dict[str, float]


@dataclass(frozen=True, eq=False)
class RopeLife:
    """Life of one rope in cycles of the output. ``refused``: why there are no figures; they are then nan.

    ``longer``: they are refused because the rope outlives what the data show.
    ``place_m`` (n,), ``damage`` (n,): share of the life that a cycle takes, along the rope.
    """

    name: str
    cycles: float
    sigmas: dict[str, float]
    refused: str
    rough: bool
    pulleys: tuple[AtPulley, ...]
    zones: tuple[BentZone, ...]
    place_m: Floats
    damage: Floats
    longer: bool = False

    @cached_property
    def sigma(self) -> float:
        """Standard deviation of ln of the cycles."""
        return float(np.sqrt(sum(value**2 for value in self.sigmas.values())))

    def reached(self, share: float) -> float:
        """Cycles at which ``share`` of all such ropes have broken, with all that is not known counted as scatter."""
        return float(self.cycles * np.exp(NormalDist().inv_cdf(share) * self.sigma))


@dataclass(frozen=True, eq=False)
class _Pass:
    """A tangent point in one sense of one level: how often it bends each point of the rope a cycle, and how hard."""

    tangent: Tangent
    bendings: Floats
    weight: Floats
    tension_N: Floats
    at: Crossing


def rope_life(rope: RopeInUse, levels: Sequence[Level]) -> RopeLife:
    """Damage along a rope, its weakest point and the cycles until it breaks there. A rope that never bends: refused."""
    borders = np.sort([end for tangent in rope.tangents for level in levels for end in _ends(tangent, level)])
    if len(borders):
        borders = borders[np.concatenate([[True], np.diff(borders) > 10.0 * _EDGE])]
    inner = np.linspace(0.0, 1.0, _POINTS)
    inner[0], inner[-1] = _EDGE, 1.0 - _EDGE
    pieces = [a + (b - a) * inner for a, b in pairwise(borders)]
    place = np.concatenate(pieces) if pieces else np.zeros(0)
    passes = [one for level in levels for one in _passes(rope, level, place)]
    zones = _zones(passes, borders)
    if not any(np.any(one.bendings > 0.0) for one in passes):
        return RopeLife(rope.name, np.nan, {}, "no part of it bends in this duty", False, (), zones, place, 0.0 * place)
    if rope.rope.why_unknown:
        hardest = int(np.argmax(sum(one.bendings for one in passes)))
        met = [one for one in passes if one.bendings[hardest] > 0.0]
        pulleys = _pulleys(met, hardest, np.full(len(met), np.nan))
        return RopeLife(rope.name, np.nan, {}, rope.rope.why_unknown, False, pulleys, zones, place, np.nan * place)
    each = [np.where(one.bendings > 0.0, one.bendings / bendings(rope.rope, one.at), 0.0) for one in passes]
    damage = np.asarray(sum(each))
    worst = int(np.argmax(damage))
    met = [one for one in passes if one.bendings[worst] > 0.0]
    share = np.array([own[worst] for one, own in zip(passes, each, strict=True) if one.bendings[worst] > 0.0])
    share = share / damage[worst]
    hard = Crossing(*(np.array([getattr(one.at, f.name)[worst] for one in met]) for f in fields(Crossing)))
    reason = too_hard(rope.rope, hard)
    bent = sum(float(one.bendings[worst]) for one in met)
    easy = ""
    if not reason and float(share[at_border(rope.rope, hard)].sum()) > 0.5:
        easy = "its bends are so easy that the data end before them: it lives longer than they show"
    elif not reason and rope.rope.anchor is None and bent > MOST_BENDINGS * float(damage[worst]):
        easy = f"more than {MOST_BENDINGS:.0f} bendings, where the data end: it lives longer than they show"
    reason = reason or easy
    return RopeLife(
        rope.name,
        np.nan if reason else 1.0 / float(damage[worst]),
        sigmas(rope.rope, hard, share) | _summing(met, share, worst),
        reason,
        is_rough(rope.rope, hard, share),
        _pulleys(met, worst, share),
        zones,
        place,
        damage,
        bool(easy),
    )


def _ends(tangent: Tangent, level: Level) -> tuple[float, float]:
    """Where along the rope a tangent point moves to and fro."""
    one, two = (tangent.place_m + tangent.moves_m * float(a) for a in (level.angle_rad[0], level.angle_rad[-1]))
    return min(one, two), max(one, two)


def _passes(rope: RopeInUse, level: Level, place: Floats) -> list[_Pass]:
    found = []
    inside = [(place > low) & (place < high) for low, high in (_ends(t, level) for t in rope.tangents)]
    for k, tangent in enumerate(rope.tangents):
        angle = (place - tangent.place_m) / tangent.moves_m
        other = rope.tangents[tangent.spans_to]
        against = max(-float(np.dot(tangent.normal, other.normal)), 0.0)
        weight = np.where(inside[tangent.spans_to], 1.0 + (REVERSE_WEIGHT - 1.0) * against, 1.0)
        bent = np.where(inside[k], 0.5 * level.count * weight, 0.0)
        move = abs(tangent.moves_m) * float(level.angle_rad[-1] - level.angle_rad[0])
        fleet = tangent.fleet_deg_per_rad * np.abs(angle)
        groove = np.full(len(place), np.nan if tangent.groove is None else tangent.groove)
        for tension in (level.there_N, level.back_N):
            there = np.maximum(np.interp(angle, level.angle_rad, tension[tangent.cable]), 0.0)
            with np.errstate(divide="ignore", over="ignore"):
                length = np.sqrt(rope.bend_stiffness_N_m2 / there)
                softer = 1.0 - np.exp(-move / length) if rope.bend_stiffness_N_m2 > 0.0 else np.ones(len(place))
                ratio = 2e3 * tangent.radius_m / rope.rope.diameter_mm / np.maximum(softer, _EDGE)
            at = Crossing(ratio, there / rope.breaking_N, groove, fleet)
            found.append(_Pass(tangent, bent, weight, there, at))
    return found


def _zones(passes: Sequence[_Pass], borders: Floats) -> tuple[BentZone, ...]:
    """Stretches between two borders that bend, with their bendings (a reverse one with its weight)."""
    zones = []
    for k, (start, end) in enumerate(pairwise(borders)):
        middle, counted = k * _POINTS + _POINTS // 2, dict[str, float]()
        for one in passes:
            if one.bendings[middle] > 0.0:
                body = one.tangent.body
                counted[body] = counted.get(body, 0.0) + float(one.bendings[middle])
        if counted:
            zones.append(BentZone(float(start), float(end), counted))
    return tuple(zones)


def _pulleys(met: Sequence[_Pass], worst: int, share: Floats) -> tuple[AtPulley, ...]:
    found = []
    for body in dict.fromkeys(one.tangent.body for one in met):
        own = [(one, float(part)) for one, part in zip(met, share, strict=True) if one.tangent.body == body]
        tension = [float(one.tension_N[worst]) for one, _ in own]
        first = own[0][0]
        found.append(
            AtPulley(
                body=body,
                bend_ratio=min(float(one.at.bend_ratio[worst]) for one, _ in own),
                bendings=sum(float(one.bendings[worst]) for one, _ in own),
                tension_N=(min(tension), max(tension)),
                damage_share=sum(part for _, part in own),
                fleet_deg=max(float(one.at.fleet_deg[worst]) for one, _ in own),
                groove=first.tangent.groove,
            )
        )
    return tuple(sorted(found, key=lambda pulley: -pulley.damage_share))


def _summing(met: Sequence[_Pass], share: Floats, worst: int) -> dict[str, float]:
    """What Miner's rule and bends of opposite sense add: nothing where one load and one sense do all the damage."""
    tension = np.array([one.tension_N[worst] for one in met])
    main = np.abs(np.log(np.maximum(tension, _EDGE) / max(float(tension[np.argmax(share)]), _EDGE))) < _SAME_LOAD
    reverse = np.array([one.weight[worst] > 1.0 + _EDGE for one in met])
    return {
        "sum over several loads": SIGMA_MINER * float(share[~main].sum()),
        "bends of opposite sense": SIGMA_REVERSE * float(share[reverse].sum()),
    }
