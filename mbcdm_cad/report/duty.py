"""Duty of a drive, warmth of its motors and life of its cables: plain data, and what the page shows of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.model.duty import MotorDay
from mbcdm_cad.model.heat import MotorHeat
from mbcdm_cad.report.table import chart

if TYPE_CHECKING:
    from mbcdm_cad.model.rope_zones import RopeLife


# Shares of the time and temperatures of the air in the picture of the torque that may be held.
TIME_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0)
AMBIENTS_C = (20.0, 40.0, 60.0)
# What an estimate stands for, in words.
_WORDS = {
    "winding_K_W": "resistance from winding to housing",
    "housing_K_W": "resistance from housing to air",
    "winding_J_K": "heat capacity of the winding",
    "housing_J_K": "heat capacity of the housing",
    "limit_C": "limit of the winding",
}


def duty_data(layout: Layout) -> dict[str, Any]:
    """Duty and motors of a design; a temperature or a time without an end is null.

    ``held``: torque that the drum moves for a share of each period, at rest for the others, by ambient. Raises
    ``ModelError`` where the routes have no free span.
    """
    d, drive, motors = layout.duty, layout.drive, layout.motor_days
    held = []
    for ambient in AMBIENTS_C:
        motor = [motors[0].heat.allowed_Nm(share, d.period_s, ambient) for share in TIME_SHARES]
        limited = np.minimum(motor, drive.motor.peak_torque_mNm * 1e-3)
        output = np.minimum(layout.losses.output_Nm(limited), drive.reduction.max_torque_mNm * 1e-3)
        ways = [layout.losses.raised_Nm(output, way).min(axis=0) for way in (1, -1)]
        held.append(np.minimum(*ways).tolist())
    return {
        "stated": d.stated,
        "assumed": list(d.assumed),
        "period_s": d.period_s,
        "ambient_C": d.ambient_C,
        "peak_torque_Nm": d.peak_torque_Nm,
        "rms_torque_Nm": d.rms_torque_Nm,
        "moving_share": d.moving_share,
        "largest_speed_deg_s": d.largest_speed_deg_s,
        "cycles_per_h": d.cycles_per_h,
        "strokes": [{"range_deg": s.range_deg, "torque_Nm": s.torque_Nm, "per_h": s.per_h} for s in d.strokes],
        "motors": [_motor(m) for m in motors],
        "held": {"time_share": list(TIME_SHARES), "ambient_C": list(AMBIENTS_C), "torque_Nm": held},
    }


def estimated(heat: MotorHeat) -> str:
    """The figures of a motor's heat that are estimates, in words."""
    return ", ".join(_WORDS[name] for name in heat.estimated)


def time_words(seconds: float) -> str:
    """A time as text; without an end: no limit."""
    if not isfinite(seconds):
        return "no limit"
    if seconds < 120.0:
        return f"{seconds:.3g} s"
    return f"{seconds / 60.0:.3g} min" if seconds < 7200.0 else f"{seconds / 3600.0:.3g} h"


def _warm(temperature_C: float, sigma_K: float) -> str:
    if not isfinite(temperature_C):
        return "burns"
    return f"{temperature_C:.0f} +- {sigma_K:.0f}" if isfinite(sigma_K) else f"{temperature_C:.0f}"


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def _endless(value: float | None) -> float:
    """A figure of the JSON, in which null stands for one without an end."""
    return inf if value is None else value


def _motor(m: MotorDay) -> dict[str, Any]:
    return {
        "name": m.name,
        "rms_mNm": m.rms_Nm * 1e3,
        "continuous_mNm": m.heat.continuous_at_Nm(m.duty.ambient_C) * 1e3,
        "winding_C": _finite(m.winding_C),
        "winding_sigma_K": _finite(m.sigma_K[0]),
        "winding_limit_C": m.heat.limit_C,
        "housing_C": _finite(m.housing_C),
        "housing_sigma_K": _finite(m.sigma_K[1]),
        "peak_from_cold_s": _finite(m.peak_from_cold_s),
        "peak_from_warm_s": _finite(m.peak_from_warm_s),
        "duty_from_cold_s": _finite(m.duty_from_cold_s),
        "winding_K_W": m.heat.winding_K_W,
        "housing_K_W": m.heat.housing_K_W,
        "winding_J_K": m.heat.winding_J_K,
        "housing_J_K": m.heat.housing_J_K,
        "estimated": list(m.heat.estimated),
    }


def duty_shown(found: Mapping[str, Any]) -> dict[str, Any]:
    """What page and report show of the block ``duty``."""
    held = found["held"]
    lines = [
        {"label": f"air at {ambient:g} C", "x": [100.0 * share for share in held["time_share"]], "y": torque}
        for ambient, torque in zip(held["ambient_C"], held["torque_Nm"], strict=True)
    ]
    motors = [
        {
            **m,
            "winding": _warm(_endless(m["winding_C"]), _endless(m["winding_sigma_K"])),
            "housing": _warm(_endless(m["housing_C"]), _endless(m["housing_sigma_K"])),
            "cold": time_words(_endless(m["peak_from_cold_s"])),
            "warm": time_words(_endless(m["peak_from_warm_s"])),
        }
        for m in found["motors"]
    ]
    title = f"Torque moved for a share of each {found['period_s']:.4g} s, by the windings' heat"
    shown = chart(title, ("share of the time", "%"), ("torque at the drum", "N m"), lines)
    return {**found, "motors": motors, "chart": shown}


# Points of a line in the picture of one rope.
_SHOWN_POINTS = 160


def life_data(layout: Layout) -> dict[str, Any]:
    """Life of all cables; cycles of the output, places in mm from the middle or stop on the input.

    Raises ``NoFigureError`` where the cables have no tensions or places.
    """
    life = life_of(layout)
    first = life.first
    early = None if first is None else first.reached(0.1)
    return {
        "duty": life.duty,
        "cycles_per_h": life.cycles_per_h,
        "generic": life.generic,
        "first": None if first is None else first.name,
        "first_on": None if first is None else first.pulleys[0].body,
        "replace_at_cycles": early,
        "replace_at_h": None if early is None or life.cycles_per_h is None else early / life.cycles_per_h,
        "refused": life.refused,
        "governs_instead": list(life.governs),
        "bend_ratio": layout.smallest_bend_ratio,
        "bend_ratio_minimum": layout.drive.cable.bend_ratio_minimum,
        "ropes": [_rope(rope) for rope in life.ropes],
        "helps": [asdict(each) for each in life.helps],
    }


def two_digits(value: float) -> str:
    """Two digits are more than figures of cycles are worth."""
    return f"{float(f'{value:.2g}'):.0f}"


def _rope(rope: RopeLife) -> dict[str, Any]:
    known = not rope.refused
    damaged = rope.place_m.size > 0 and not isnan(float(rope.damage[0]))
    step = max(1, rope.place_m.size // _SHOWN_POINTS)
    return {
        "name": rope.name,
        "refused": rope.refused,
        "order_of_magnitude_only": rope.rough,
        "n10": rope.reached(0.1) if known else None,
        "n50": rope.cycles if known else None,
        "n90": rope.reached(0.9) if known else None,
        "sigma_ln": rope.sigma if known else None,
        "sigma_ln_by_cause": rope.sigmas if known else {},
        "weakest_point": [
            asdict(p) | {"damage_share": None if isnan(p.damage_share) else p.damage_share} for p in rope.pulleys
        ],
        "zones": [{"from_mm": 1e3 * z.start_m, "to_mm": 1e3 * z.end_m, "bendings": z.bendings} for z in rope.zones],
        "place_mm": (1e3 * rope.place_m[::step]).tolist() if damaged else [],
        "damage_per_cycle": rope.damage[::step].tolist() if damaged else [],
    }


def life_shown(found: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """What page and report show of the block ``life``: a row for each cable and pulley, pictures along the cables."""
    if found is None:
        return None
    ropes, rows = found["ropes"], []
    for rope in ropes:
        for k, pulley in enumerate(rope["weakest_point"]):
            life = [two_digits(rope[key]) if rope[key] is not None else "none" for key in ("n10", "n50", "n90")]
            rows.append({"cable": rope["name"] if k == 0 else "", "life": life if k == 0 else [""] * 3, **pulley})
    bent = [{"label": rope["name"], **_steps(rope["zones"])} for rope in ropes]
    used = [
        {"label": rope["name"], "x": rope["place_mm"], "y": [1e5 * d for d in rope["damage_per_cycle"]]}
        for rope in ropes
        if rope["n50"] is not None
    ]
    along = "along the cable, from its middle or stop on the input", "mm"
    charts = [("bent", "Bendings of each zone in a cycle of the output", "bendings", "", bent)]
    if used:
        charts.append(("used", "Life that 1000 cycles take", "of the median life", "%", used))
    return dict(found) | {
        "rows": rows,
        "too_small": found["bend_ratio"] < found["bend_ratio_minimum"],
        "median": next((two_digits(rope["n50"]) for rope in ropes if rope["name"] == found["first"]), None),
        "early": None if found["replace_at_cycles"] is None else two_digits(found["replace_at_cycles"]),
        "charts": {name: chart(title, along, (label, unit), lines) for name, title, label, unit, lines in charts},
    }


def _steps(zones: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """Bendings over the place as a line with steps; 0 where nothing bends."""
    x, y, last = list[float](), list[float](), None
    for zone in zones:
        if last is not None and zone["from_mm"] > last:
            x += [last, zone["from_mm"]]
            y += [0.0, 0.0]
        x += [zone["from_mm"], zone["to_mm"]]
        y += [sum(zone["bendings"].values())] * 2
        last = zone["to_mm"]
    return {"x": x, "y": y}
