"""A table of turning points made ready for the model: the path from row to row, of which only the rows are compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbcdm_cad.loop.prepare.prepared import Prepared, Windows, sensor_floor_rad
from mbcdm_cad.loop.prepare.quiet import input_step_rad
from mbcdm_cad.loop.prepare.samples import Cut, held_sweeps
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.turning_points import path_of, written_step
from mbcdm_cad.routes import Floats

# Samples from one row to the next: load and inputs go straight, so the cables are simulated on few of them.
STEPS = 16
# Of a speed of 1, so that the sense of motion is sharp.
STANDSTILL = 0.05


def prepare_readings(run: Run, ratio: float) -> Prepared:
    """The path through the rows of a table. ``used`` are the rows but the first, whose friction history is unknown, and
    those that were missing; ``sweep`` numbers the half cycles."""
    path = path_of(run)
    last = path.read.size - 1
    at = np.arange(last * STEPS + 1) / STEPS

    def along(values: Floats) -> Floats:
        return np.asarray(np.interp(at, np.arange(last + 1), values))

    node = np.rint(at).astype(np.int64)
    used = (at == node) & path.read[node] & (node > 0)
    sweep = np.maximum(np.ceil(at).astype(np.int64) - 1, 0)
    output, load = along(path.output_rad), None if path.load_Nm is None else along(path.load_Nm)
    judged = np.isin(sweep, sweep[used])
    held = held_sweeps(sweep[judged], output[judged], None if load is None else load[judged])
    angle = np.stack([along(row) for row in path.input_rad])
    none, every = np.zeros(at.size, dtype=np.bool_), np.arange(at.size)
    time = along(path.time_s)
    return Prepared(
        time,
        angle,
        angle,
        angle - angle.mean(axis=0),
        output,
        load,
        path.sense[sweep],
        None,
        sweep,
        np.zeros(at.size, dtype=np.int64),
        used,
        np.isin(sweep, held),
        float(np.median(np.diff(time))),
        sensor_floor_rad(with_written_steps(run), ratio),
        input_step_rad(run),
        STANDSTILL,
        f"the rows at the end of half cycles {', '.join(str(k + 1) for k in held)}" if held.size else "none",
        False,
        run,
        Cut(every, 1, np.zeros(1, dtype=np.int64), none, none),
        Windows(0.0, 0.0, 0.0),
    )


def with_written_steps(run: Run) -> Run:
    """The run with the steps of its written figures for those of encoders that are not declared."""
    s, steps = run.sensors, [written_step(row) for row in run.input_rad]
    found = replace(
        s,
        input_resolution_rad=s.input_resolution_rad or max(steps) or None,
        output_resolution_rad=s.output_resolution_rad or written_step(run.output_rad) or None,
    )
    return replace(run, sensors=found)
