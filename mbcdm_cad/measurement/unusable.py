"""Refuse runs that cannot be used with any design; found after conversion to SI, reported with their line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement.datafile import DataTable
from mbcdm_cad.measurement.run import Run

if TYPE_CHECKING:
    from mbcdm_cad.measurement.file import MeasurementFile

# Fewer samples than this cannot contain the sweeps that any statement needs.
FEWEST_SAMPLES = 100
# An output that turns by fewer than this many steps, or by less than this angle if the step is unknown, stands still.
FEWEST_STEPS = 20
LEAST_TRAVEL_RAD = 1e-6
# A shaft that turns by this much has moved, even if the declared step of its encoder is larger.
MOTION_RAD = 0.01
# Steps in time that run backwards, as a share of all, from which the column is hardly the time.
MOST_BACK = 0.05
# A figure that lies beyond the others by this many times their span is wrong, if at most so many rows are like it.
SPIKE_SPANS = 3.0
LONGEST_SPIKE = 5


def refuse_unusable(file: MeasurementFile, run: Run, table: DataTable, data: Path) -> None:
    """Refuse a run with too few samples, impossible figures, time that runs backwards, outliers or without motion.

    Raises InputError, with the line of the data if the problem has one.
    """
    count = run.time_s.size
    if count < FEWEST_SAMPLES:
        remedy = "record a few sweeps of the drive; check comment, skip_rows and broken_rows"
        raise InputError([Problem(str(data), 1, "", "too few samples", str(count), f"{FEWEST_SAMPLES}", remedy)])
    if not np.isfinite(table.values).all() or float(np.abs(table.values).max()) > 1e12:
        remedy = "check unit, scale and counts_per_turn of every column"
        raise InputError([file.problem(("columns",), "figures out of all bounds", limit="1e12 in SI", remedy=remedy)])
    back = np.flatnonzero(np.diff(run.time_s) <= 0.0)
    if back.size:
        row = int(back[0]) + 1
        step = float(run.time_s[row] - run.time_s[row - 1])
        what = "time runs backwards" if step < 0.0 else "time stands still"
        remedy = (
            "sort the rows, or cut the file where a new run begins"
            if step < 0.0
            else "log the time with more digits, or leave out doubled rows"
        )
        if back.size > MOST_BACK * count:
            remedy = f"so do {back.size} of {count} steps: is this column the time? Correct columns.time, or {remedy}"
        raise InputError([Problem(str(data), table.line_of(row), "", what, f"step {step:.6g} s", "over 0", remedy)])
    problems = _far_off(file, run, table, data) or _not_moved(file, run)
    if problems:
        raise InputError(problems)


def _far_off(file: MeasurementFile, run: Run, table: DataTable, data: Path) -> list[Problem]:
    """Problems for single figures far from all others, as from a short failure of a sensor or a bus."""
    signals = [
        (f"input {n}".removesuffix(" input"), row) for n, row in zip(run.input_names, run.input_rad, strict=True)
    ]
    signals += [("output", run.output_rad)] + ([] if run.load_Nm is None else [("load torque", run.load_Nm)])
    problems = []
    for name, values in signals:
        low, high = (float(v) for v in np.percentile(values, (1.0, 99.0)))
        # An angle may be far from zero; the span of a constant load is only that of its noise.
        reach = SPIKE_SPANS * (max(high - low, abs(low), abs(high)) if name == "load torque" else high - low)
        off = (values < low - reach) | (values > high + reach)
        rows = np.flatnonzero(off)
        # A drive that rests most of the time and then moves has many such figures, which is not a fault.
        lasting = np.any(np.convolve(off, np.ones(LONGEST_SPIKE + 1), "valid") > LONGEST_SPIKE)
        if high == low or rows.size == 0 or lasting:
            continue
        what = f"{rows.size} figure(s) of the {name} far from all others, the first here"
        value, limit = f"{values[rows[0]]:.6g} in SI", f"others {low:.4g} to {high:.4g}"
        remedy = "remove or correct these rows"
        problems.append(Problem(str(data), table.line_of(int(rows[0])), "", what, value, limit, remedy))
    return problems


def _not_moved(file: MeasurementFile, run: Run) -> list[Problem]:
    """Problems for shafts that stand still, or turn by few of the declared steps of their encoders."""
    given = file.content.sensors
    shafts = [
        (
            f"input {n}".removesuffix(" input"),
            "input" if n == "input" else f"input_{n}",
            row,
            run.sensors.input_resolution_rad,
            "input_resolution_rad" if given.input_resolution_rad else "",
        )
        for n, row in zip(run.input_names, run.input_rad, strict=True)
    ]
    resolution = "output_resolution_rad" if given.output_resolution_rad else ""
    shafts.append(("output", "output", run.output_rad, run.sensors.output_resolution_rad, resolution))
    problems, standing = [], 0
    for name, column, values, step, declared in shafts:
        travel, least = float(np.ptp(values)), max(FEWEST_STEPS * (step or 0.0), LEAST_TRAVEL_RAD)
        if travel >= least:
            continue
        standing += 1
        if declared and travel > MOTION_RAD:
            what = f"the {name} turns by fewer than {FEWEST_STEPS} such steps"
            remedy = "check this figure, one step of the encoder in rad, or move farther"
            problems.append(
                file.problem(("sensors", declared), what, f"{travel:.3g} rad", f"{least:.3g} rad", remedy=remedy)
            )
        else:
            remedy = "check that its encoder is driven and connected, and column, unit and scale"
            problems.append(
                file.problem(
                    ("columns", column),
                    f"no motion of the {name}",
                    f"{travel:.3g} rad",
                    f"{least:.3g} rad",
                    remedy=remedy,
                )
            )
    if standing == len(shafts) and not any(problem.field.startswith("sensors") for problem in problems):
        most = max(float(np.ptp(values)) for _, _, values, _, _ in shafts)
        remedy = "move the drive while logging; if it did move, check columns, units and scales"
        what = "no motion: the drive was never moved"
        return [file.problem(("columns",), what, f"{most:.3g} rad at most", remedy=remedy)]
    return problems
