"""Short files with random requirements from a seed, as a user could write them; and a search for passing designs.

The search is independent of ``mbcdm solve``: random starts, the best of them mutated. Every field that the file leaves
open may be drawn: parts of the whole catalogue, rope, preload, radii of guide and drum (also with unequal steps),
centre distance, setback, and every derived dimension by a factor on the value of its rule. A start draws some of them
and leaves the others to their rules. A missing requirement that no rule can fill is drawn from the same range as the
files of :mod:`benchmarks.studies.reach`.
"""

import copy
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import exp, inf, isfinite, log
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.loader import LoadedDesign, resolved
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import design_file, layout_of, load_text

Data = dict[str, Any]
PRINTED = {"drum": {"material": "pa12"}, "guide": {"material": "pa12"}, "support": {"material": "pa12"}}


@dataclass(frozen=True)
class Space:
    """What is drawn: ranges, and how often a file states what it may leave free.

    For the configurations without a guide torque is drawn for an input on a drum of 60 mm and grows with the radius
    squared; no distance. ``wind_off_deg`` is what ratio times full travel may come to at most. ``distance`` is a fixed
    centre distance in radii of the drum's first step; ``ropes`` are those that a file may name.
    """

    ratio: tuple[float, float]
    half_travel_deg: tuple[float, float]
    drum_radius_mm: tuple[float, float]
    torque_Nm: tuple[float, float]
    distance: tuple[float, float]
    ropes: tuple[str, ...]
    stated: float = 0.5
    configuration: str = "miso_bevel"
    wind_off_deg: float = inf


# Ropes that came into the catalogue after the study was drawn: a seed must stay the same file.
_LATER = {"7x7-1.5", "7x19-1.5"}
# All that is aimed at.
WHOLE = Space(
    (3.0, 20.0),
    (10.0, 60.0),
    (30.0, 190.0),
    (0.3, 50.0),
    (0.45, 1.3),
    tuple(sorted({*package_entries("ropes")} - _LATER)),
)
# Drives in usual proportions, of a size that is drawn in seconds.
USUAL = Space(
    (4.0, 12.0), (12.0, 40.0), (55.0, 110.0), (0.4, 4.0), (0.7, 1.1), ("7x7-1.0", "7x19-0.81", "uhmwpe-0.8"), 0.3
)


# The plain capstan drive, out to what one motor of the catalogue holds.
SPUR = Space(
    (3.0, 12.0),
    (10.0, 90.0),
    (25.0, 120.0),
    (0.2, 1.6),
    (0.0, 0.0),
    ("7x7-0.61", "FF-081", "7x7-1.0", "7x19-0.81", "uhmwpe-0.8", "uhmwpe-1.5", "uhmwpe-2", "vectran-1"),
    0.4,
    "siso_spur",
)
# Two to four such inputs round one drum; half the travel is at most this over their number, deg.
ROUND_TRAVEL_DEG = 140.0
ROUND = replace(SPUR, configuration="miso_spur")
# The input winds under a turn: 18 degrees of reserve and 25 for the end of the winding besides.
BEVEL = replace(SPUR, ratio=(1.5, 7.0), torque_Nm=(0.1, 0.7), configuration="siso_bevel", wind_off_deg=317.0)
LAYOUTS = {space.configuration: space for space in (WHOLE, SPUR, ROUND, BEVEL)}


def _without_guide(seed: int, space: Space) -> Data:
    """A file of requirements for a configuration whose inputs drive the drum straight."""
    rng = random.Random(seed)
    torque = exp(rng.uniform(*map(log, space.torque_Nm)))
    radius = round(exp(rng.uniform(*map(log, space.drum_radius_mm))), 1)
    data: Data = {
        "name": f"random-{seed}",
        "configuration": space.configuration,
        "travel": {"half_angle_deg": round(rng.uniform(*space.half_travel_deg), 1)},
        "transmission": {"input_to_drum": round(rng.uniform(*space.ratio), 2), "drum_radius_mm": radius},
        "loads": {"peak_torque_Nm": float(f"{torque * (radius / 60.0) ** 2:.2g}")},
    }
    if rng.random() < space.stated:
        data["rope"] = {"type": rng.choice(space.ropes)}
    if space.configuration == "siso_bevel":
        ratio, half = data["transmission"]["input_to_drum"], data["travel"]["half_angle_deg"]
        data["travel"]["half_angle_deg"] = round(min(half, space.wind_off_deg / (2 * ratio)) - 0.05, 1)
    elif rng.random() < space.stated:
        data["input_pulleys"] = {"surface": rng.choice(("smooth", "grooved"))}
    if rng.random() < space.stated:
        metal = rng.choice(("pla", "pa12"))
        data |= {"drum": {"material": metal}, "support": {"material": metal}}
    if space.configuration == "miso_spur":
        names = "abcd"[: rng.randint(2, 4)]
        data["inputs"] = [{"name": name} for name in names]
        # Further the terminals of one sector come round to the next input.
        data["travel"]["half_angle_deg"] = min(data["travel"]["half_angle_deg"], ROUND_TRAVEL_DEG / len(names))
        data["loads"]["peak_torque_Nm"] = round(data["loads"]["peak_torque_Nm"] * len(names), 4)
    return data


def requirements(seed: int, space: Space = USUAL) -> Data:
    """One file of requirements: ratio, radius and torque spread evenly over their decades, travel over its degrees."""
    if space.configuration != "miso_bevel":
        return _without_guide(seed, space)
    rng = random.Random(seed)

    def decades(low: float, high: float) -> float:
        return float(f"{exp(rng.uniform(log(low), log(high))):.3g}")

    data: Data = {
        "name": f"random-{seed}",
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": round(rng.uniform(*space.half_travel_deg), 1)},
        "transmission": {"ratio": decades(*space.ratio), "drum_radius_mm": decades(*space.drum_radius_mm)},
        "loads": {"peak_torque_Nm": decades(*space.torque_Nm)},
    }
    if rng.random() < space.stated:
        data["rope"] = {"type": rng.choice(space.ropes)}
    if rng.random() < space.stated:
        distance = rng.uniform(*space.distance) * data["transmission"]["drum_radius_mm"]
        data["transmission"]["centre_distance_mm"] = round(distance, 1)
    if rng.random() < space.stated:
        data |= {block: dict(fields) for block, fields in PRINTED.items()}
    return data


@dataclass(frozen=True)
class Passing:
    """A design that passes all checks: its requirements, and the design that follows from them."""

    seed: int
    data: Data
    loaded: LoadedDesign


def load(data: Data) -> LoadedDesign:
    """The data as a design file would load."""
    return load_text(yaml.safe_dump(data, sort_keys=False), f"{data['name']}.yaml")


def failing(loaded: LoadedDesign) -> tuple[tuple[str, str], ...]:
    """(id, message) of the checks that fail, in order, without the search for remedies."""
    subject = layout_of(loaded.drive)
    with np.errstate(all="ignore"):
        found = [run_check(check, subject, Budget(0)) for check in checks_of(loaded.drive)]
    return tuple((check.id, check.message) for check in found if check.status == "fail")


def passing(seed: int, space: Space = USUAL) -> Passing | str:
    """The design of a seed if it passes all checks, else the first that fails or the message that refuses it."""
    data = requirements(seed, space)
    try:
        loaded = load(data)
    except InputError as error:
        return str(error.problems[0])
    failed = failing(loaded)
    return failed[0][0] if failed else Passing(seed, data, loaded)


# Random starts of a search, how many of them are followed, and by how many mutations each.
STARTS, FOLLOWED, MUTATIONS = 200, 8, 12
# Shares of the open fields that a start draws.
DRAWN = (0.08, 0.25, 0.6)
# Checks that take as long as all others together: asked where the others hold.
SLOW = ("cables_apart", "spans_clear", "terminals_apart", "no_slack")
NO_DRIVE = 1e3


@dataclass
class Draw:
    """Values drawn for fields of the file, and factors on what rules find."""

    values: dict[str, Any] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)


def search(data: Data, seed: int = 0, starts: int = STARTS) -> Data | None:
    """Values (by field) with which the file passes every check, empty where it does as it is; None if none is found."""
    rng = random.Random(f"{data['name']} {seed}")
    found: list[tuple[float, int, Draw]] = []
    for k in range(starts):
        draw = Draw() if k == 0 and not _missing(data) else _drawn(data, rng)
        # Once it misses by more than all that are followed, by how much no longer matters.
        least = sorted(miss for miss, _, _ in found)[:FOLLOWED]
        miss = missed(data, draw, least[-1] if len(least) == FOLLOWED else inf)
        if miss == 0.0:
            return {**draw.values, **draw.factors}
        found.append((miss, k, draw))
    for miss, _, best in sorted(found, key=lambda item: item[:2])[:FOLLOWED]:
        for _ in range(MUTATIONS):
            other = _mutated(data, best, rng)
            now = missed(data, other, miss)
            if now == 0.0:
                return {**other.values, **other.factors}
            if now <= miss:
                miss, best = now, other
    return None


def missed(data: Data, draw: Draw, most: float = inf) -> float:
    """Nought where every check holds, else how many fail and by how much; beyond ``most`` no further check is asked."""
    whole = copy.deepcopy(data)
    for name, value in draw.values.items():
        _put(whole, name, value)
    moved = {name: partial(_scaled, factor) for name, factor in draw.factors.items()}
    with np.errstate(all="ignore"):
        try:
            drive = resolved(Tree(whole, {}), Path("drawn.yaml"), _FILE, moved).drive
        except InputError:
            return NO_DRIVE
        subject = layout_of(drive)
        asked = [check for check in checks_of(drive) if check.severity == "fail"]
        miss = 0.0
        for check in sorted(asked, key=lambda check: check.id in SLOW):
            if miss > most or (miss and check.id in SLOW):
                break
            miss += _miss(check.measure, subject)
        return miss


def _miss(measure: Callable[[Any], Any], subject: Any) -> float:
    try:
        found = measure(subject)
    except NoFigureError:
        return 3.0
    if found.holds:
        return 0.0
    over = abs(found.margin) / (abs(found.limit) + 1e-3)
    return 1.0 + min(over, 2.0) if isfinite(over) else 3.0


def _scaled(factor: float, value: Any) -> Any:
    return round(value * factor, 3) if isinstance(value, int | float) and not isinstance(value, bool) else value


def _put(data: Data, name: str, value: Any) -> None:
    *blocks, last = name.split(".")
    for block in blocks:
        data = data.setdefault(block, {})
    data[last] = value


def _has(data: Mapping[str, Any], name: str) -> bool:
    at: Any = data
    for part in name.split("."):
        at = at.get(part) if isinstance(at, dict) else None
    return at is not None


def _decades(rng: random.Random, low: float, high: float) -> float:
    return float(f"{exp(rng.uniform(log(low), log(high))):.4g}")


# Requirements that no rule fills, with their range in the space of the files.
_SPACE = {
    "transmission.ratio": WHOLE.ratio,
    "transmission.drum_radius_mm": WHOLE.drum_radius_mm,
    "travel.half_angle_deg": WHOLE.half_travel_deg,
    "loads.peak_torque_Nm": WHOLE.torque_Nm,
}
_PARTS = {
    "rope.type": "ropes",
    "drive.motor": "motors",
    "drive.gearhead": "gearheads",
    "drive.encoder": "encoders",
    "drive.drum_encoder": "encoders",
    "drum.tensioner": "tensioners",
    "drum.bearing": "bearings",
    "guide.bearing": "bearings",
    "input_pulleys.lower_bearing": "bearings",
    "input_pulleys.upper_bearing": "bearings",
}
_WORDS = {
    "input_pulleys.surface": ("smooth", "grooved"),
    "input_pulleys.collar_screw": ("M1.6x6", "M2x8", "M2.5x10", "M3x12", "M4x16", "M5x20", "M6x25"),
    "drum.material": ("aluminium-7075", "steel"),
    "support.material": ("aluminium-7075", "steel"),
}
_NUMBERS = (
    "rope.preload_N",
    "transmission.ratios.guide_to_drum",
    "transmission.drum_radii_mm",
    "transmission.centre_distance_mm",
    "transmission.input_setback_mm",
)
_FILE = design_file("miso_bevel")
_DERIVED = tuple(name for name in _FILE.derived() if name not in _NUMBERS)


def _missing(data: Data) -> list[str]:
    return [name for name in _SPACE if not _has(data, name)]


def _open(data: Data) -> list[str]:
    return [name for name in (*_PARTS, *_WORDS, *_NUMBERS, *_DERIVED) if not _has(data, name)]


def _drawn(data: Data, rng: random.Random) -> Draw:
    draw, share = Draw(), rng.choice(DRAWN)
    for name in _missing(data):
        draw.values[name] = _decades(rng, *_SPACE[name])
    for name in _open(data):
        # Derived dimensions are many: each is drawn less often.
        if rng.random() < (0.3 * share if name in _DERIVED else share):
            _draw(data, draw, name, rng)
    return draw


def _mutated(data: Data, of: Draw, rng: random.Random) -> Draw:
    """One to three fields drawn anew, or left to their rules again."""
    draw = Draw(dict(of.values), dict(of.factors))
    for name in rng.sample([*_missing(data), *_open(data)], rng.randint(1, 3)):
        if name in _SPACE:
            draw.values[name] = _decades(rng, *_SPACE[name])
        elif (name in draw.values or name in draw.factors) and rng.random() < 0.4:
            draw.values.pop(name, None)
            draw.factors.pop(name, None)
        else:
            _draw(data, draw, name, rng)
    return draw


def _draw(data: Data, draw: Draw, name: str, rng: random.Random) -> None:
    if name in _DERIVED:
        draw.factors[name] = _decades(rng, 0.6, 1.7)
        return
    if name in _PARTS:
        draw.values[name] = rng.choice(sorted(package_entries(_PARTS[name])))
    elif name in _WORDS:
        draw.values[name] = rng.choice(_WORDS[name])
    else:
        draw.values[name] = _number(data, draw, name, rng)


def _number(data: Data, draw: Draw, name: str, rng: random.Random) -> Any:
    def asked(field_name: str) -> float:
        block, last = field_name.split(".")
        return float(draw.values.get(field_name) or data[block][last])

    first, ratio = asked("transmission.drum_radius_mm"), asked("transmission.ratio")
    pulley = first / ratio
    guide = first / draw.values.get("transmission.ratios.guide_to_drum", max(ratio / 1.5, 2.0))
    distance = data["transmission"].get("centre_distance_mm")
    distance = float(draw.values.get("transmission.centre_distance_mm") or distance or 1.5 * (guide + pulley))
    if name == "rope.preload_N":
        share = asked("loads.peak_torque_Nm") * 1e3 / (4.4 * first)
        return _decades(rng, 0.6 * share, 4.0 * share)
    if name == "transmission.ratios.guide_to_drum":
        return round(first / _decades(rng, max(3.0, 0.4 * pulley), max(0.4 * first, pulley)), 3)
    if name == "transmission.centre_distance_mm":
        return round((guide + pulley) * rng.uniform(1.05, 3.0), 1)
    if name == "transmission.input_setback_mm":
        return round(rng.uniform(0.0, 0.5) * distance, 2)
    steps = [_decades(rng, 1.5, max(4.0, 0.35 * first)) for _ in range(3)]
    if rng.random() < 0.5:
        steps = [steps[0]] * 3
    radii = [first]
    for step in steps:
        radii.append(round(radii[-1] + step, 3))
    return radii
