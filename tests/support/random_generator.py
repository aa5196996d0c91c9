"""Short files with random requirements from a seed, as a user could write them."""

import random
from dataclasses import dataclass, replace
from math import exp, inf, log
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text

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
