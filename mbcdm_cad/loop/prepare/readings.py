"""Readings by hand made ready for the model: of a table of turning points the path from row to row, of which only the
rows are compared; of creep at rest the course of time."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.prepared import Prepared, Windows, sensor_floor_rad
from mbcdm_cad.loop.prepare.samples import Cut, held_sweeps, input_step_rad
from mbcdm_cad.measurement.by_hand import loadings, path_of, since_loading, written_step
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.routes import Floats

# Samples from one row to the next: load and inputs go straight, so the cables are simulated on few of them.
STEPS = 16
# Readings at rest are means over so many parts of a decade of time; this share of the decades is held back.
PER_DECADE, HELD_SHARE = 12, 1.0 / 3.0
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
    ends = "steps" if path.along else "half cycles"
    words = f"the rows at the end of {ends} {', '.join(str(k + 1) for k in held)}" if held.size else "none"
    angle = np.stack([along(row) for row in path.input_rad])
    signals = {"time_s": along(path.time_s), "angle_rad": angle, "output_rad": output, "load_Nm": load}
    more = {"temperature_C": None, "speed_rad_s": path.sense[sweep], "held_words": words}
    return _prepared(run, ratio, sweep, used, np.isin(sweep, held), **signals, **more)


def prepare_creep(run: Run, ratio: float) -> Prepared:
    """Readings at rest, of a logger's the means over equal parts of the logarithm of time. A sample without a load is
    set before them. Held back is the last third of each course, in the logarithm of time."""
    times = np.array([at for at, _ in loadings(run)])
    since, course = since_loading(run), np.searchsorted(times, run.time_s, side="left")
    early = float(since[since > 0.0].min())
    decade = np.log10(np.maximum(since, early) / early)
    part = np.where(since > 0.0, np.floor(decade * PER_DECADE).astype(np.int64), -1)
    number = np.cumsum(np.diff(part, prepend=part[0]) + 1000 * np.diff(course, prepend=course[0]) != 0)
    count = np.bincount(number)

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(number, values) / count)

    def led(values: Floats, first: float) -> Floats:
        return np.concatenate([[first], values])

    begin = min(0.0, float(run.time_s[0])) - 1e-6 * early
    time = led(mean(run.time_s), begin)
    at = mean(decade)
    held, used = np.zeros(at.size, dtype=np.bool_), mean(part.astype(float)) >= 0.0
    for one in np.unique(course):
        mine = used & (mean(course.astype(float)) == one)
        if mine.sum() > 1:
            low, high = float(at[mine].min()), float(at[mine].max())
            held |= mine & (at > low + (high - low) * (1.0 - HELD_SHARE))
    words = (
        f"the last third of the logarithm of time, from {float(time[1:][held].min()) if held.any() else 0.0:.3g} s on"
    )
    load = None if run.load_Nm is None else led(mean(run.load_Nm), 0.0)
    warm = None if run.temperature_C is None else led(mean(run.temperature_C), float(run.temperature_C[0]))
    angle = np.stack([led(mean(row), float(row[0])) for row in run.input_rad])
    output = led(mean(run.output_rad), float(run.output_rad[0]))
    sweep = led(np.floor(3.0 * at), 0.0).astype(np.int64)
    used, held = np.append(False, used), np.append(False, held)
    signals = {"time_s": time, "angle_rad": angle, "output_rad": output, "load_Nm": load}
    more = {"temperature_C": warm, "speed_rad_s": np.zeros(time.size), "held_words": words}
    return _prepared(run, ratio, sweep, used, held, **signals, **more)


def under_load(p: Prepared, law: Callable[[Floats], Floats]) -> Floats:
    """Turn of the output by a law of creep for 1 N m, rad (n,): the sum over the steps of the load."""
    turned = np.zeros_like(p.time_s)
    for at, step in loadings(p.run):
        turned -= step * law(np.maximum(p.time_s - at, 0.0))
    return turned


def _prepared(
    run: Run, ratio: float, sweep: NDArray[np.int64], used: NDArray[np.bool_], held: NDArray[np.bool_], **signals: Any
) -> Prepared:
    """Signals that need no smoothing as the fits take them; ``speed_rad_s``: sense of motion, -1 to 1."""
    angle, time = signals["angle_rad"], signals["time_s"]
    none, every = np.zeros(time.size, dtype=np.bool_), np.arange(time.size)
    return Prepared(
        **signals,
        shaft_rad=angle,
        apart_rad=angle - angle.mean(axis=0),
        sweep=sweep,
        sector=np.zeros(time.size, dtype=np.int64),
        used=used,
        held=held & used,
        step_s=float(np.median(np.diff(time))),
        floor_rad=sensor_floor_rad(with_written_steps(run), ratio),
        input_step_rad=input_step_rad(run),
        standstill_rad_s=STANDSTILL,
        few=False,
        run=run,
        cut=Cut(every, 1, np.zeros(1, dtype=np.int64), none, none),
        windows=Windows(0.0, 0.0, 0.0),
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
