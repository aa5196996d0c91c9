"""Widely varied designs that pass all checks, from a seed.

Free values are drawn at random, dependent ones follow from rules of thumb with scatter, and what the checks then find
wrong is mended by the advice they give: the same way a user would go, so that the remedies are tried as well.
"""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, hypot, pi, radians, tan
from typing import Any, NamedTuple

import numpy as np
import yaml

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.design_under_test import NoFigureError
from mbcdm_cad.checks.remedies import Budget
from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.configurations.loader import load_text, reference_data
from mbcdm_cad.configurations.miso_bevel.checks import CHECKS
from mbcdm_cad.configurations.miso_bevel.checks.envelope import box_mm
from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError

Data = dict[str, Any]
ROUNDS = 40
TRIALS = 80
# A mended value goes this much further than the advice says, so that rounding does not bring it back.
OVERSHOOT = 0.003
_ADVICE = re.compile(r"(?:raise|lower) ([\w.]+) from \S+ to at (least|most) (\S+?)(?:[,;]| or |$)")
_SCALE = re.compile(r"scale ([\w. ]+?) by at (?:least|most) (\S+?)(?:[,;]| or |$)")


@dataclass(frozen=True)
class Passing:
    """A design that passes all checks: its data, loaded, and how many rounds of advice it took."""

    seed: int
    data: Data
    loaded: LoadedDesign
    rounds: int


def _source(entry: Data) -> Data:
    return {**entry, "source": "drawn at random"}


def _fitting(rng: random.Random, entries: Sequence[tuple[str, Data]]) -> tuple[str, Data]:
    return entries[min(int(abs(rng.gauss(0.0, 1.0)) * len(entries) / 2), len(entries) - 1)]


def _termination(rope: Data) -> Data:
    """What the program chooses for this rope where the file names none."""
    fitting = (
        end
        for end in package_entries("terminations").values()
        if rope["construction"] in end["constructions"]
        and end["smallest_mm"] <= rope["diameter_mm"] <= end["largest_mm"]
    )
    return max(fitting, key=lambda end: float(end["strength_share"]))


def _takes(tensioner: Data, end: Data, diameter_mm: float) -> bool:
    """Whether the sleeve is thick and long enough, with some room left."""
    thick = tensioner["swage_diameter_mm"] >= max(diameter_mm + 0.6, end["sleeve_ratio"] * diameter_mm)
    return bool(thick and tensioner["swage_length_mm"] - 0.5 >= end["grip_ratio"] * diameter_mm)


def _rope(rng: random.Random) -> tuple[str, Data]:
    ropes = [(n, e) for n, e in package_entries("ropes").items() if e["diameter_mm"] <= 1.6]
    return rng.choice(ropes)


def _bearings(low: float, high: float) -> list[tuple[str, Data]]:
    """Catalogue bearings by bore, from ``low`` to ``high`` mm."""
    found = [(n, e) for n, e in package_entries("bearings").items() if low <= e["bore_mm"] <= high]
    return sorted(found, key=lambda item: item[1]["bore_mm"])


def _drives(rng: random.Random, data: Data, lower: Data, upper: Data, drum: Data) -> float:
    """Motor, gearhead and encoders made to fit the bearings drawn; returns the gearhead's radius."""
    shelf = round(rng.uniform(2.0, 3.9), 2)
    data["support"] = {"motor_shelf_mm": shelf}
    screws = package_entries("screws")
    name = "M2x6" if lower["outer_diameter_mm"] >= 11.0 else "M1.6x6"
    screw = screws[name]
    key = screw["key_mm"] / 3**0.5 + 0.15
    bolt = lower["outer_diameter_mm"] / 2 - key - rng.uniform(0.02, 0.3)
    pilot = bolt - screw["clearance_mm"] / 2 - rng.uniform(0.55, 0.8)
    shaft = min(max(1.5, round(pilot * 2 - rng.uniform(0.6, 2.0), 1)), lower["bore_mm"] - 1.0, 4.3)
    radius = max(bolt + screw["head_diameter_mm"] / 2, rng.uniform(5.0, 10.0))
    data["catalogue"] = {
        "gearheads": {
            "drawn": _source(
                {
                    "ratio": round(rng.uniform(30.0, 150.0), 1),
                    "efficiency": 0.7,
                    "rated_torque_mNm": 400.0,
                    "max_torque_mNm": 4000.0,
                    "radial_load_N": 20.0,
                    "diameter_mm": round(2 * radius, 2),
                    "length_mm": round(rng.uniform(14.0, 26.0), 1),
                    "shaft_diameter_mm": shaft,
                    "shaft_length_mm": round(shelf + screw["head_height_mm"] + 0.9 + shaft * rng.uniform(1.0, 1.4), 2),
                    "pilot_diameter_mm": round(2 * pilot, 3),
                    "pilot_height_mm": 1.0,
                    "bolt_circle_mm": round(2 * bolt, 3),
                    "screw": name,
                    "screw_count": 2,
                    "mass_g": 18.0,
                }
            )
        },
        "motors": {
            "drawn": _source(
                {
                    "diameter_mm": round(2 * radius * rng.uniform(0.8, 1.0), 2),
                    "length_mm": round(rng.uniform(14.0, 30.0), 1),
                    "rated_torque_mNm": 40.0,
                    "rotor_inertia_g_cm2": 0.7,
                    "mass_g": 18.0,
                }
            )
        },
    }
    head = screws["M1.6x4"]["head_diameter_mm"] / 2 + 0.1
    circle = upper["outer_diameter_mm"] / 2 + head + rng.uniform(0.8, 1.5)
    ring = drum["outer_diameter_mm"] / 2 + 1.0 + rng.uniform(0.6, 1.5)
    small = {"resolution_urad": 191.7, "screw_count": 2}
    data["catalogue"]["encoders"] = {
        "drawn": _source(
            {
                **small,
                "diameter_mm": round(2 * (circle + rng.uniform(1.4, 2.5)), 2),
                "mass_g": 7.0,
                "screw": "M1.6x4",
                "length_mm": round(rng.uniform(12.0, 16.0), 1),
                "bore_mm": upper["bore_mm"],
                "bolt_circle_mm": round(2 * circle, 3),
            }
        ),
        "drawn-ring": _source(
            {
                **small,
                "diameter_mm": round(2 * (ring + rng.uniform(1.6, 2.5)), 2),
                "mass_g": 9.0,
                "screw": "M2x6",
                "length_mm": round(rng.uniform(4.5, 9.0), 1),
                "bore_mm": drum["bore_mm"],
                "bolt_circle_mm": round(2 * ring, 3),
            }
        ),
    }
    data["drive"] = {"motor": "drawn", "gearhead": "drawn", "encoder": "drawn", "drum_encoder": "drawn-ring"}
    return radius


def draw(seed: int) -> Data:
    """A design file's data; it loads, but need not pass."""
    rng = random.Random(seed)
    data = reference_data()
    data["name"] = f"random-{seed}"
    rope_name, rope = _rope(rng)
    d = rope["diameter_mm"]
    lower_name, lower = rng.choice(_bearings(4.0, 8.0))
    # A bearing that leaves a shoulder in a top plate that dowels and screws still reach through.
    flat = [b for b in _bearings(3.0, min(lower["bore_mm"], 6.0)) if b[1]["width_mm"] <= 3.1]
    upper_name, upper = rng.choice(flat)
    drum_name, drum = rng.choice(_bearings(5.0, 10.0))
    guide_name, guide = rng.choice(_bearings(3.0, 6.0))
    gear = _drives(rng, data, lower, upper, drum)

    end = _termination(rope)
    tensioners = sorted(package_entries("tensioners").items(), key=lambda item: item[1]["swage_diameter_mm"])
    tensioner_name, tensioner = _fitting(rng, [t for t in tensioners if _takes(t[1], end, d)])
    nut = tensioner["nut_across_flats_mm"] / 3**0.5

    # Radii: the pulley bends the rope and holds stop and journal, the guide lets the drum pass the drives.
    bend = rng.uniform(13.0, 32.0)
    inside = (0.5 + 2.0 * end["stop_radius_ratio"]) * d
    smallest = max(bend * d / 2, inside + lower["bore_mm"] / 2 + 1.4, inside + upper["bore_mm"] / 2 + 1.4)
    r_g = max(gear + 0.3 + d / 2, guide["outer_diameter_mm"] / 2 + 1.0 + d / 2) * rng.uniform(1.0, 1.3)
    r_g = max(r_g, smallest * rng.uniform(0.8, 1.8))
    i1, i2 = round(r_g / (smallest * rng.uniform(1.0, 1.15)), 3), round(rng.uniform(3.5, 8.5), 3)
    edge = round(rng.uniform(0.1, 0.25), 3)
    step = d / 2 + edge + rng.uniform(0.04, 0.5)
    lead = round(d * rng.uniform(1.05, 1.13), 3)
    # Two bands of +-walk must fit between the steps of an input pulley.
    room = step * i2 - d - 0.3
    reach = pi * room / (lead * i1 * i2)
    if reach < radians(8.0):
        step += (radians(8.0) - reach) * lead * i1 / pi
        reach = radians(8.0)
    half = min(reach * rng.uniform(0.6, 0.97), radians(rng.uniform(20.0, 50.0)))
    drum_radii = [round((r_g + k * step) * i2, 3) for k in range(4)]
    if rng.random() < 0.25:
        guides = [r / i2 for r in drum_radii]
        data["transmission"] = {"guide_radii_mm": guides, "input_radii_mm": [r / i1 for r in guides]}
    else:
        data["transmission"] = {"ratios": {"input_to_guide": i1, "guide_to_drum": i2}}
    outer_g, outer_m = drum_radii[3] / i2, drum_radii[3] / i2 / i1
    walk = lead * i1 * i2 * half / (2 * pi)
    fleet = rng.uniform(1.2, 2.0)
    span = walk / tan(radians(fleet)) * rng.uniform(1.02, 1.3)
    data["transmission"] |= {
        "centre_distance_mm": round(max(hypot(span, outer_g + outer_m), 2 * gear + 4.0, gear + 14.0), 3),
        "drum_radii_mm": drum_radii,
    }
    data["travel"] = {
        "half_angle_deg": round(degrees(half), 2),
        "stop_clearance_deg": round(rng.uniform(0.05, 0.45), 2),
    }
    preload = rope["breaking_load_N"] * rng.uniform(0.03, 0.12)
    data["rope"] = {
        "type": rope_name,
        "friction_coefficient": round(rng.uniform(0.08, 0.3), 3),
        "preload_N": round(preload, 1),
        "helix_lead_mm": lead,
        "dead_turns": round(rng.uniform(0.6, 2.0), 2),
    }
    gap = round(min(rng.uniform(0.08, 0.25), 0.8 * d / 2, d / 2 + edge - step + d / 2), 3)
    data["clearances"] = {
        "transfer_gap_mm": max(0.06, gap),
        "land_edge_mm": edge,
        "running_mm": round(rng.uniform(0.15, 0.4), 2),
    }
    _bodies(rng, data, _Drawn(d, nut, half, drum_radii, i2, tensioner, lower, upper, drum))
    data["guide"] = {
        "material": rng.choice(["aluminium-7075", "aluminium-6082", "brass"]),
        "bearing": guide_name,
        "axle_material": "steel",
    }
    data["input_pulleys"] = {"material": "steel", "lower_bearing": lower_name, "upper_bearing": upper_name}
    data["drum"] |= {"bearing": drum_name, "tensioner": tensioner_name}
    # What the preload carries without slack, and what stop pin and collars of the sizes drawn hold.
    shaft = data["catalogue"]["gearheads"]["drawn"]["shaft_diameter_mm"]
    held = min(4.5 * drum_radii[0] / 54.0, 0.08 * shaft * i1 * i2)
    torque = min(preload * (drum_radii[0] + drum_radii[3]) * 0.6e-3, held) * rng.uniform(0.4, 1.0)
    data["loads"] = {"test_torque_Nm": round(0.2 * torque, 4), "peak_torque_Nm": round(torque, 4)}
    bias = preload * step / i1 * 1e-3
    ratio = data["catalogue"]["gearheads"]["drawn"]["ratio"]
    motor = (0.6 * torque / (i1 * i2) + bias) * 1e3 / ratio
    data["catalogue"]["motors"]["drawn"]["rated_torque_mNm"] = round(motor * rng.uniform(1.05, 1.3), 4)
    data["limits"] |= {
        "bend_ratio_min": 12.0,
        "fleet_angle_max_deg": round(fleet + 0.1, 2),
        "frame_windup_max_mrad": 5.0,
    }
    return data


class _Drawn(NamedTuple):
    """What is drawn at random before drum and support: mm and rad, and catalogue entries of the parts chosen."""

    cable_diameter: float
    nut_radius: float
    half_travel: float
    drum_radii: list[float]
    guide_to_drum: float
    tensioner: Data
    lower_bearing: Data
    upper_bearing: Data
    drum_bearing: Data


def _bodies(rng: random.Random, data: Data, drawn: _Drawn) -> None:
    """Drum and support: thicknesses at random above what they must hold."""
    d, nut, half, drum_radii, i2, tensioner, lower, upper, drum = drawn
    outer_g = drum_radii[3] / i2
    inner_y = drum_radii[0] / i2 - d / 2 + data["clearances"]["transfer_gap_mm"]
    terminal = tensioner["stud_length_mm"] + 1.5
    running = data["clearances"]["running_mm"]
    face = outer_g + max(nut, tensioner["clearance_mm"] / 2 + 0.8) + rng.uniform(0.2, 3.0)
    web_start = inner_y + 3 * running
    web = min(rng.uniform(1.0, 3.5), face - web_start)
    bore = drum["bore_mm"]
    metals = ["aluminium-7075", "aluminium-6082"]
    data["drum"] = {
        "material": rng.choice(metals),
        "sector_half_angle_deg": round(
            min(88.0, degrees(half + terminal / drum_radii[0]) + rng.uniform(10.0, 30.0)), 2
        ),
        "rim_inner_radius_mm": round(drum_radii[0] - nut - running - 0.5 - 1.3 - rng.uniform(0.0, 4.0), 2),
        "outer_face_y_mm": round(face, 3),
        "web_thickness_mm": round(max(web, 0.9), 2),
        "hub_diameter_mm": round(bore + 10.2 + rng.uniform(0.0, 6.0), 1),
        "hub_face_y_mm": round(max(web_start + web + 6.2, inner_y + bore) + rng.uniform(0.2, 5.0), 2),
        "shaft_bore_mm": round(rng.choice([0.0, rng.uniform(0.2, 0.65) * bore]), 1),
        "shaft_material": "steel",
    }
    plate = round(rng.uniform(1.4, 4.0), 2)
    stack = data["catalogue"]["encoders"]["drawn-ring"]["length_mm"] + 1.0 + 3 * drum["width_mm"]
    deep = max(outer_g + d / 2 + running + 1.0, plate + 3.0 + lower["bore_mm"] / 2 + 5.5, stack + 2.0 - inner_y)
    data["support"] = {
        "material": rng.choice(metals),
        "back_y_mm": -round(deep + rng.uniform(0.2, 3.0), 2),
        "back_plate_mm": plate,
        "side_wall_mm": round(rng.uniform(5.4, 8.0), 2),
        "motor_shelf_mm": data["support"]["motor_shelf_mm"],
        "coupling_space_mm": round(rng.uniform(10.4, 15.0), 2),
        "bearing_shelf_mm": round(max(lower["width_mm"] + 0.8, 3.6) + rng.uniform(0.0, 2.0), 2),
        "top_plate_mm": round(min(4.0, max(upper["width_mm"] + 0.8, 2.9) + rng.uniform(0.0, 1.2)), 2),
        "rib_mm": round(rng.uniform(1.2, 4.0), 2),
    }


def load(data: Data) -> LoadedDesign:
    """The data as a design file would load; its box targets set to the box it has."""
    loaded = load_text(yaml.safe_dump(data, sort_keys=False), f"{data['name']}.yaml")
    try:
        box = box_mm(BevelUnderTest(loaded.drive))
    except NoFigureError:
        return loaded
    data["targets"] = {**data["targets"], "envelope_mm": [round(side, 3) for side in box]}
    return load_text(yaml.safe_dump(data, sort_keys=False), f"{data['name']}.yaml")


def _scaled(data: Data, what: str, factor: float) -> bool:
    """Adjustment a remedy on a list of radii into the fields that this design gives."""
    t = data["transmission"]
    ratios = t.get("ratios")
    if what == "all radii of transmission":
        names = ["drum_radii_mm"] if ratios else ["drum_radii_mm", "guide_radii_mm", "input_radii_mm"]
    elif ratios is None:
        names = [what.removeprefix("transmission.")]
    elif what == "transmission.input_radii_mm":
        ratios["input_to_guide"] /= factor
        return True
    elif what == "transmission.guide_radii_mm":
        ratios["input_to_guide"] *= factor
        ratios["guide_to_drum"] /= factor
        return True
    else:
        return False
    for name in names:
        t[name] = [r * factor for r in t[name]]
    return True


def mend(data: Data, failed: CheckResult, rng: random.Random) -> bool:
    """Follow one piece of advice, drawn at random from those the check gives. False if there is none to follow."""
    offers: list[tuple[str, str, float]] = [
        (
            "set",
            path,
            float(value) * (1 + OVERSHOOT * (1 if bound == "least" else -1) * (1 if float(value) > 0 else -1)),
        )
        for path, bound, value in _ADVICE.findall(failed.remedy)
    ]
    offers += [("scale", what, float(f) * (1 + OVERSHOOT)) for what, f in _SCALE.findall(failed.remedy)]
    rng.shuffle(offers)
    for kind, what, value in offers:
        if kind == "scale":
            if _scaled(data, what, value):
                return True
            continue
        *parents, last = what.split(".")
        block: Any = data
        for name in parents:
            block = block.get(name) or {}
        if last in block:
            block[last] = value
            return True
    return False


def failing(loaded: LoadedDesign) -> list[Check]:
    """Checks that fail, in order, without the search for remedies."""
    subject, none = BevelUnderTest(loaded.drive), Budget(0)
    with np.errstate(all="ignore"):
        return [check for check in CHECKS if run_check(check, subject, none).status == "fail"]


def advised(loaded: LoadedDesign, check: Check) -> CheckResult:
    """The check's result with what would mend it, looked for no longer than a moment."""
    with np.errstate(all="ignore"):
        return run_check(check, BevelUnderTest(loaded.drive), Budget(TRIALS))


def passing(seed: int) -> Passing | str:
    """A design that passes all checks, or the id of the check (or the input error) that could not be mended."""
    rng = random.Random(f"mend {seed}")
    data = draw(seed)
    last = ""
    for rounds in range(ROUNDS):
        try:
            loaded = load(data)
        except InputError as error:
            return f"input: {error.problems[0].message if hasattr(error.problems[0], 'message') else error}"
        failed = failing(loaded)
        if not failed:
            return Passing(seed, data, loaded, rounds)
        last = failed[0].id
        # One at a time: what mends one often mends others.
        if not any(mend(data, advised(loaded, check), rng) for check in failed):
            return failed[0].id
    return last
