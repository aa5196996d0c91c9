"""Faults of a run that its signals alone show: gaps in time, unusual sweep times, a saturated sensor, jumps."""

from __future__ import annotations

import math

import numpy as np

from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.measurement.run import Run, VettingNote, column_of
from mbcdm_cad.routes import Floats

# A step in time this many times the usual one is a gap.
GAP_STEPS = 5.0
# A sensor that stays at its extreme value while the drive moves by this share of the travel is saturated.
LOST_TRAVEL = 0.15
# Limits of usual sample times and half sweeps on a bench: estimates.
SLOW_STEP_S, SLOW_SWEEP_S, FAST_SWEEP_S = 1.0, 600.0, 0.1
COLDEST_C, HOTTEST_C = -60.0, 120.0
# Share of the samples in which a noisy torque may be exactly at its extreme value.
LEVEL_SHARE = 0.005

WRAPPED = "set wraps_at of this column: 360 for degrees, counts_per_turn for one turn, 65536 for 16 bits"


def signal_findings(run: Run, ratio: float) -> list[VettingNote]:
    """Doubts and refusals."""
    inputs = [(column_of(name), row) for name, row in zip(run.input_names, run.input_rad, strict=True)]
    angles = [*inputs, (("columns", "output"), run.output_rad)]
    found = [*_gaps(run), *_pace(run), *_temperature(run)]
    for field, values in angles:
        found += _jumps(str(field[1]), field, values, run)
    for field, values in inputs:
        found += _stands(str(field[1]), field, values, run.output_rad)
    found += _stands("output", ("columns", "output"), run.output_rad, run.input_rad.mean(axis=0) / ratio)
    if run.load_Nm is not None:
        found += _levels(run.load_Nm)
    return found


def _gaps(run: Run) -> list[VettingNote]:
    steps = np.diff(run.time_s)
    gaps = np.flatnonzero(steps > GAP_STEPS * run.step_s)
    if gaps.size == 0:
        return []
    longest = int(gaps[np.argmax(steps[gaps])])
    text = (
        f"{gaps.size} gap(s) in time, the longest {steps[longest]:.4g} s at {run.time_s[longest]:.6g} s "
        f"(usual step {run.step_s:.4g} s); the state of the friction after them is not known"
    )
    return [VettingNote("gaps", "doubt", text, "log without pauses", ("columns", "time"))]


def _pace(run: Run) -> list[VettingNote]:
    """A finding for sweeps too fast or too slow for a bench: time may be in another unit."""
    thin = run.output_rad[:: max(1, run.time_s.size // 1000)]
    sweeps = max(float(np.abs(np.diff(thin)).sum()) / max(float(np.ptp(thin)), 1e-300), 1.0)
    half_s = float(run.time_s[-1] - run.time_s[0]) / sweeps
    text = f"a half sweep takes some {half_s:.3g} s, a sample {run.step_s:.3g} s"
    field = ("columns", "time")
    if run.step_s >= SLOW_STEP_S or half_s > SLOW_SWEEP_S:
        return [VettingNote("pace", "doubt", text, "is the time in ms or in sample numbers but declared as s?", field)]
    if half_s < FAST_SWEEP_S:
        remedy = "is the time in s but declared as ms? If not, move slower: the model has no inertia"
        return [VettingNote("pace", "doubt", text, remedy, field)]
    return []


def _temperature(run: Run) -> list[VettingNote]:
    if run.temperature_C is None:
        return []
    low, high = float(run.temperature_C.min()), float(run.temperature_C.max())
    if low >= COLDEST_C and high <= HOTTEST_C:
        return []
    text = f"temperatures of {low:.4g} to {high:.4g} degC"
    return [
        VettingNote(
            "temperature", "doubt", text, "check its unit (K or degF declared as degC?)", ("columns", "temperature")
        )
    ]


def _jumps(name: str, field: FieldPath, values: Floats, run: Run) -> list[VettingNote]:
    """Findings for an encoder that starts again after a turn, or a counter that overflows."""
    steps = np.diff(values)
    usual = float(np.median(np.abs(steps)))
    turns = np.flatnonzero(np.abs(np.abs(steps) - 2.0 * math.pi) < 0.2)
    if turns.size and usual <= 0.2:
        text = f"{name} jumps by a full turn {turns.size} time(s), first after sample {int(turns[0]) + 1}"
        return [VettingNote("wrapped", "refused", text, WRAPPED, field)]
    size = float(np.abs(steps).max())
    # Jumps of one size, far larger than all other steps, over most of the range; a pause in logging is not a jump.
    at = np.flatnonzero((np.abs(steps) > 0.5 * size) & (np.diff(run.time_s) < GAP_STEPS * run.step_s))
    others = float(np.quantile(np.abs(steps), 1.0 - min(2.0 * at.size / steps.size, 0.5))) if at.size else size
    if at.size < 2 or size < 0.5 * float(np.ptp(values)) or others > 0.05 * size:
        return []
    if float(np.ptp(np.abs(steps[at]))) > 0.1 * size:
        return []
    text = f"{name} jumps by {size:.4g} rad {at.size} time(s), first after sample {int(at[0]) + 1}: a counter overflows"
    return [VettingNote("wrapped", "refused", text, WRAPPED, field)]


def _stands(name: str, field: FieldPath, values: Floats, other: Floats) -> list[VettingNote]:
    """Findings for an angle that stays exactly at its extreme value while the other side of the drive moves."""
    for end, word in ((float(values.max()), "highest"), (float(values.min()), "lowest")):
        at = values == end
        edges = np.flatnonzero(np.diff(np.concatenate(([0], at.view(np.int8), [0]))))
        begins, ends = edges[::2], edges[1::2]
        longest = int(np.argmax(ends - begins))
        moved = float(np.ptp(other[begins[longest] : ends[longest]]))
        if moved > LOST_TRAVEL * float(np.ptp(other)):
            text = (
                f"{name} stays at its {word} figure, {end:.6g} rad, for {int(ends[longest] - begins[longest])} samples "
                f"while the drive goes on by {moved:.4g} rad: the sensor is at its end"
            )
            return [VettingNote("saturated", "doubt", text, "cut these samples out, or set the sensor's range", field)]
    return []


def _levels(load_Nm: Floats) -> list[VettingNote]:
    """Findings for a noisy torque that is often exactly at its extreme value."""
    still = float(np.mean(np.diff(load_Nm) == 0.0))
    for end, word in ((float(load_Nm.max()), "highest"), (float(load_Nm.min()), "lowest")):
        share = float(np.mean(load_Nm == end))
        if share > LEVEL_SHARE and still < 0.5 and load_Nm.size * share > 10:
            text = f"load torque is at its {word} figure, {end:.5g} N m, in {share:.1%} of the samples: it is cut off"
            remedy = "set the sensor's range higher; load-driven effects are off where it is cut"
            return [VettingNote("saturated", "doubt", text, remedy, ("columns", "load_torque"))]
    return []
