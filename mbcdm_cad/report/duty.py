"""Duty of a drive, warmth of its motors and life of its cables, as text and as plain data for JSON and the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.life import Life, life_of
from mbcdm_cad.model.duty import Duty, MotorDay
from mbcdm_cad.model.heat import STANDSTILL_SHARE
from mbcdm_cad.report.table import ReportTable, chart, filled

if TYPE_CHECKING:
    from mbcdm_cad.model.losses import Train
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


@dataclass(frozen=True)
class DutyReport:
    """Duty and motors of one design. ``most_mNm``: largest torque at an input's gearhead for a short time, or of it."""

    duty: Duty
    motors: Sequence[MotorDay]
    train: Train
    most_motor_Nm: float
    most_output_Nm: float

    @cached_property
    def held_Nm(self) -> tuple[tuple[float, ...], ...]:
        """Torque that the drum moves for a share of each period of the duty, at rest for the others, by ambient."""
        heat = self.motors[0].heat
        found = []
        for ambient in AMBIENTS_C:
            motor = [heat.allowed_Nm(share, self.duty.period_s, ambient) for share in TIME_SHARES]
            limited = np.minimum(motor, self.most_motor_Nm)
            output = np.minimum(self.train.output_Nm(limited), self.most_output_Nm)
            ways = [self.train.raised_Nm(output, way).min(axis=0) for way in (1, -1)]
            found.append(tuple(np.minimum(*ways).tolist()))
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; a temperature or a time without an end is null."""
        d = self.duty
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
            "motors": [_motor(m) for m in self.motors],
            "held": {"time_share": list(TIME_SHARES), "ambient_C": list(AMBIENTS_C), "torque_Nm": list(self.held_Nm)},
        }

    def table(self) -> ReportTable:
        """Torque and temperatures of each motor."""
        heads = ("motor", "RMS mN m", "rated mN m", "winding C", "limit C", "case C", "peak cold", "peak warm")
        rows = tuple(
            (
                m.name,
                f"{m.rms_Nm * 1e3:.4g}",
                f"{m.heat.continuous_at_Nm(self.duty.ambient_C) * 1e3:.4g}",
                _warm(m.winding_C, m.sigma_K[0]),
                f"{m.heat.limit_C:g}",
                _warm(m.housing_C, m.sigma_K[1]),
                time_words(m.peak_from_cold_s),
                time_words(m.peak_from_warm_s),
            )
            for m in self.motors
        )
        return ReportTable(heads, rows)

    def text(self, width: int | None) -> list[str]:
        """Table and sentences for a terminal."""
        told = (line for text in self.lines() for line in filled(f"  {text}", width))
        return ["Motors over the duty:", *self.table().text(width, "  "), *told]

    def lines(self) -> Iterator[str]:
        """Sentences beside the table."""
        d = self.duty
        what = "of loads.duty" if d.stated else "assumed, because the file has no loads.duty"
        yield (
            f"duty {what}: {d.rms_torque_Nm:.4g} N m RMS, {d.peak_torque_Nm:.4g} N m at most, moving "
            f"{d.moving_share:.0%} of {d.period_s:.4g} s, {d.cycles_per_h:.4g} times there and back an hour, "
            f"ambient {d.ambient_C:g} C"
        )
        if d.assumed:
            yield f"not in the file and assumed: {'; '.join(d.assumed)}"
        for m in self.motors:
            if isfinite(m.duty_from_cold_s):
                yield f"the {m.name} motor is too hot {time_words(m.duty_from_cold_s)} after a cold start"
        estimated = self.motors[0].heat.estimated
        words = f"estimates: {', '.join(_WORDS[x] for x in estimated)}; " if estimated else ""
        still = (
            f"a brushless motor at rest counts as {1.0 / STANDSTILL_SHARE:.2g} times the torque; "
            if self.motors[0].heat.brushless
            else ""
        )
        yield (
            f"peak cold, warm: how long the peak load is held from the air's temperature and from the hottest moment "
            f"of the duty; {still}{words}docs/heat.md"
        )


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


def duty_report(layout: Layout) -> DutyReport:
    """The figures of the duty. Raises ``ModelError`` where the routes have no free span."""
    drive = layout.drive
    most, head = drive.motor.peak_torque_mNm * 1e-3, drive.reduction.max_torque_mNm * 1e-3
    return DutyReport(layout.duty, layout.motor_days, layout.losses, most, head)


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
_QUANTILES = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class LifeReport:
    """Life of all cables of one design."""

    life: Life

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; cycles of the output, places in mm from the middle or stop on the input."""
        life, first = self.life, self.life.first
        return {
            "duty": life.duty,
            "cycles_per_h": life.cycles_per_h,
            "generic": life.generic,
            "first": None if first is None else first.name,
            "first_on": None if first is None else first.pulleys[0].body,
            "replace_at_cycles": None if first is None else first.reached(0.1),
            "replace_at_h": None
            if first is None or life.cycles_per_h is None
            else first.reached(0.1) / life.cycles_per_h,
            "refused": life.refused,
            "governs_instead": list(life.governs),
            "bend_ratio": life.layout.smallest_bend_ratio,
            "bend_ratio_minimum": life.layout.drive.cable.bend_ratio_minimum,
            "ropes": [_rope(rope) for rope in life.ropes],
            "helps": [asdict(each) for each in life.helps],
        }

    def table(self) -> ReportTable:
        """Bendings at each pulley of the weakest point of each cable, and its life."""
        rows: list[tuple[str, ...]] = []
        for rope in self.life.ropes:
            for k, p in enumerate(rope.pulleys):
                cycles = ("", "", "") if k or rope.refused else tuple(_cycles(rope.reached(q)) for q in _QUANTILES)
                share = "" if isnan(p.damage_share) else f"{p.damage_share:.0%}"
                tension = f"{p.tension_N[0]:.1f} to {p.tension_N[1]:.1f}"
                name = rope.name if k == 0 else ""
                rows.append((name, p.body, f"{p.bend_ratio:.1f}", f"{p.bendings:.3g}", tension, share, *cycles))
        heads = ("cable", "on", "D/d", "bendings", "tension N", "damage", "N10", "N50", "N90")
        return ReportTable(heads, tuple(rows))

    def lines(self) -> Iterator[str]:
        """Sentences below the table."""
        life, first = self.life, self.life.first
        least = life.layout.drive.cable.bend_ratio_minimum
        if life.layout.smallest_bend_ratio < least:
            yield f"the cables bend over D/d {life.layout.smallest_bend_ratio:.3g}; the maker's least is {least:g}"
        for reason in dict.fromkeys(rope.refused for rope in life.ropes if rope.refused):
            names = ", ".join(rope.name for rope in life.ropes if rope.refused == reason)
            yield f"no figure for {names}: {reason}"
        yield from (f"what governs instead: {text}" for text in life.governs)
        if first is None:
            return
        early = first.reached(0.1)
        hours = "" if life.cycles_per_h is None else f" ({early / life.cycles_per_h:.2g} h)"
        yield (
            f"{first.name} breaks first, on the {first.pulleys[0].body}: {life.told}; inspect it from "
            f"{_cycles(early / 2.0)} cycles on and replace it at {_cycles(early)}{hours}: its core breaks unseen"
        )
        helps = [f"{h.change} x{h.factor:.2g}{f' ({h.note})' if h.note else ''}" for h in life.helps]
        if helps:
            yield f"what helps, as a factor of its life: {', '.join(helps)}"


def _cycles(value: float) -> str:
    """Two digits are more than these figures are worth."""
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
            life = [_cycles(rope[key]) if rope[key] is not None else "none" for key in ("n10", "n50", "n90")]
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
        "median": next((_cycles(rope["n50"]) for rope in ropes if rope["name"] == found["first"]), None),
        "early": None if found["replace_at_cycles"] is None else _cycles(found["replace_at_cycles"]),
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


def life_report(layout: Layout) -> tuple[LifeReport | None, str]:
    """The figures of the cables' life; None, with the reason, where the cables have no tensions or places."""
    try:
        return LifeReport(life_of(layout)), ""
    except NoFigureError as missing:
        return None, str(missing)
