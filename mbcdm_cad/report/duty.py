"""The duty of a drive and how warm its motors get, as text for a terminal and as plain data for JSON and the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.model.duty.cycle import Duty
from mbcdm_cad.model.duty.heat import STANDSTILL_SHARE
from mbcdm_cad.model.duty.motors import MotorDay
from mbcdm_cad.report.table import ReportTable, filled

if TYPE_CHECKING:
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.model.losses.train import Train

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
    return {
        **found,
        "motors": motors,
        "chart": {
            "title": f"Torque moved for a share of each {found['period_s']:.4g} s, by the windings' heat",
            "x": {"label": "share of the time", "unit": "%"},
            "y": {"label": "torque at the drum", "unit": "N m"},
            "lines": lines,
        },
    }
