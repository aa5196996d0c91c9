"""Readings by hand and their vetting: tables of turning points, and creep at rest.

A table of turning points has one row where the motion or the load turns round.

The rows are those of a path that goes straight from one to the next. Two rows in one sense tell of a half cycle that
is missing between them, unless the load turns round at the first of them, or so many rows go on in one sense that they
are readings along the way. The turning point that is missing is taken where its neighbours of the same side are:
friction and play depend on the side alone.

A load that follows the sense of motion, as that of a brake, has its old size for a while after each reversal. Where it
is made smaller between two rows, no row has this extreme, and the friction of the cables remembers it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.measurement.run import Run, VettingNote, doubt, fact, refused
from mbcdm_cad.measurement.vet_signals import REVERSED_LOAD, column_findings
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# A row that differs from the one before by less than this share of the usual difference, and of its distance from the
# middle, is on the same side.
SAME_SIDE = 0.25
# Steps of less than this share of the largest one are rest.
STILL_SHARE = 1e-2
# From this share of rows that do not turn round, the table has readings along the way.
ALONG_SHARE = 1.0 / 3.0
# Digits to which the step of written figures is looked for, as a share of their range.
FINEST_SHARE = 1e-6
# Half cycles from which a cycle repeats and some can be held back.
FEWEST_HALF_CYCLES = 8
# Encoder steps within which locked inputs give way or flicker.
STILL_STEPS = 5.0


@dataclass(frozen=True, eq=False)
class TurningPath:
    """The rows of a table with those that are missing: time, inputs (n_inputs, m), output, load; ``read`` (m,) marks
    the rows of the table. ``along``: the table has readings along the way, and none counts as missing. ``by_input``:
    the inputs move, and not the load alone."""

    time_s: Floats
    input_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None
    read: NDArray[np.bool_]
    along: bool
    by_input: bool

    @property
    def sense(self) -> Floats:
        """Sense in which the output came to each row but the first, (m - 1,), as what moves it does; where it rests,
        that of the step before."""
        moved = np.diff(_mover(self.input_rad, self.load_Nm, self.by_input))
        moves = np.abs(moved) > STILL_SHARE * np.abs(moved).max()
        last = np.maximum.accumulate(np.where(moves, np.arange(moved.size), 0))
        return np.asarray(np.sign(moved[last]))

    @property
    def hides_load(self) -> bool:
        """Whether the inputs turn round under a load that turns round with them, and to a smaller size than before:
        right after such a row the load may have been larger than any row says."""
        if not self.by_input or self.load_Nm is None or self.along:
            return False
        step, sense = np.diff(self.load_Nm), self.sense
        moves = np.abs(np.diff(self.input_rad.mean(axis=0))) > STILL_SHARE * np.ptp(self.input_rad.mean(axis=0))
        turns = (sense[1:] == -sense[:-1]) & moves[1:] & moves[:-1] & (step[1:] * step[:-1] < 0.0)
        return bool(np.any(turns & (np.abs(step[1:]) < (1.0 - SAME_SIDE) * np.abs(step[:-1]))))


def inputs_move(run: Run) -> bool:
    """Whether the inputs of a table move, by more than a few steps of their encoders."""
    if not run.input_rad.size:
        return False
    return bool(np.ptp(run.input_rad.mean(axis=0)) > STILL_STEPS * (run.sensors.input_resolution_rad or 0.0))


def _mover(input_rad: Floats, load_Nm: Floats | None, by_input: bool) -> Floats:
    """What turns round from row to row, (n,): the inputs, or the load where they stand still."""
    return np.asarray(input_rad.mean(axis=0) if by_input or load_Nm is None else -load_Nm)


def path_of(run: Run) -> TurningPath:
    """The path of a table of turning points."""
    by_input = inputs_move(run)
    at = _mover(run.input_rad, run.load_Nm, by_input)
    moved, off = np.diff(at), np.abs(at - 0.5 * (at.min() + at.max()))
    least = np.minimum(np.median(np.abs(moved)), np.maximum(off[1:], off[:-1]))
    turned = np.where(np.abs(moved) < SAME_SIDE * least, 0.0, np.sign(moved))
    turns_load = np.zeros(at.size, dtype=np.bool_)
    if by_input and run.load_Nm is not None:
        step = np.diff(run.load_Nm)
        large = np.where(np.abs(step) > SAME_SIDE * np.median(np.abs(step)), np.sign(step), 0.0)
        turns_load[1:-1] = large[1:] * large[:-1] < 0.0
    missing, last = [], 0.0
    for k, sense in enumerate(turned):
        if last and sense != -last and not turns_load[k]:
            missing.append(k)
        else:
            last = sense
    along = len(missing) > ALONG_SHARE * moved.size
    columns = [run.time_s, *run.input_rad, run.output_rad, *([] if run.load_Nm is None else [run.load_Nm])]
    table = np.stack(columns)
    read = np.ones(table.shape[1], dtype=np.bool_)
    for k in [] if along else missing[::-1]:
        same_side = [j for j in (k - 1, k + 2) if 0 <= j < table.shape[1]]
        between = table[:, same_side].mean(axis=1)
        between[0] = 0.5 * (table[0, k] + table[0, k + 1])
        table, read = np.insert(table, k + 1, between, axis=1), np.insert(read, k + 1, False)
    n = run.input_rad.shape[0]
    return TurningPath(
        table[0], table[1 : 1 + n], table[1 + n], None if run.load_Nm is None else table[2 + n], read, along, by_input
    )


def written_step(values: Floats) -> float:
    """The largest step of which all figures (n,) are whole multiples, apart from one offset: that of the digits or of a
    coarse encoder; 0 where there is none."""
    found = np.unique(values)
    if found.size < 2:
        return 0.0
    least = FINEST_SHARE * float(np.ptp(found))
    step = 0.0
    for gap in np.diff(found):
        # The greatest common divisor, of figures that are only nearly whole.
        a, b = step, float(gap)
        while b > least:
            a, b = b, abs(a - round(a / b) * b)
        step = a
    return step if step > 10.0 * least else 0.0


def readings_findings(run: Run, ratio: float, travel_rad: float | None, d: DriveSI | None) -> Iterator[VettingNote]:
    """Refusals and doubts about the columns of a table by hand, and what it can show."""
    path, moves = path_of(run), inputs_move(run)
    if moves:
        yield from column_findings(run, ratio, travel_rad, d)
    elif run.load_Nm is not None and not np.corrcoef(run.output_rad, run.load_Nm)[0, 1] < 0.7:
        text = "load_torque has the wrong sign: with the inputs at rest the output moves against the load"
        yield refused("reversed_load", text, REVERSED_LOAD, "columns", "load_torque")
    half_cycles = path.read.size - 1
    what = "inputs" if moves else "load, with the inputs at rest"
    rows, ends = ("readings along the way", "") if path.along else ("turning points", f": {half_cycles} half cycles")
    yield fact("turning_points", f"a table of {run.time_s.size} {rows} of the {what}{ends}")
    if path.along and np.unique(path.sense[path.sense != 0.0]).size < 2:
        text = "all rows go one way: none is a turning point, and a gauge that drifts looks like what is to be found"
        yield refused("one_way", text, "read to both sides, or back again", "kind")
    if not path.read.all():
        rows = ", ".join(str(int(k)) for k in np.cumsum(path.read)[~path.read])
        text = (
            f"{int((~path.read).sum())} half cycle(s) missing, after row {rows}: two rows in one sense; the missing "
            "turning point is taken where its neighbours are"
        )
        yield fact("half_cycle_missing", text, "write a row for each turning point")
    if half_cycles < FEWEST_HALF_CYCLES:
        count = f"{half_cycles} {'steps' if path.along else 'half cycles'}"
        text = f"{count}: none repeats often enough to tell an effect from a misreading"
        yield doubt("few_turning_points", text, f"read {FEWEST_HALF_CYCLES} or more")
    if run.load_Nm is None:
        text = "no load: lost motion and ratio can be found; stiffness, preload and friction of the cables cannot"
        yield fact("no_load", text, "write the load under which each row was read")
    elif not np.ptp(np.abs(run.load_Nm)) > SAME_SIDE * np.abs(run.load_Nm).max():
        text = "all loads are of one size: a play and a stiffness look alike"
        yield fact("one_load", text, "read half of the cycles under half of the load")


# Steps of the load from this share of its largest size on begin a new course of creep.
LOAD_STEP_SHARE = 0.05
# Decades of time that a law of creep needs, and how far the load may wander.
FEWEST_DECADES = 2.0


def loadings(run: Run) -> list[tuple[float, float]]:
    """(time, step of the load in N m) of each change of the load at rest; the first at time 0 or the first reading, or
    where the load rises from nothing. Of a run without a load one step of 1 at its beginning."""
    begin = min(0.0, float(run.time_s[0]))
    if run.load_Nm is None or not run.load_Nm.any():
        return [(begin, 1.0)]
    least = LOAD_STEP_SHARE * float(np.abs(run.load_Nm).max())
    found, level = list[tuple[float, float]](), 0.0
    for k, load in enumerate(run.load_Nm):
        if abs(load - level) > least:
            # The level is that of the readings until the next step.
            after = run.load_Nm[k:]
            ends = np.flatnonzero(np.abs(after - load) > least)
            following = float(np.mean(after[: ends[0] if ends.size else None]))
            found.append((begin if k == 0 else float(run.time_s[k - 1]), following - level))
            level = following
    return found


def since_loading(run: Run) -> Floats:
    """Time since the last change of the load, (n,), s."""
    times = np.array([at for at, _ in loadings(run)])
    return np.asarray(run.time_s - times[np.maximum(np.searchsorted(times, run.time_s, side="left") - 1, 0)])


def creep_findings(run: Run) -> Iterator[VettingNote]:
    """What readings at rest can show."""
    steps, since = loadings(run), since_loading(run)
    loaded = run.load_Nm is not None and bool(run.load_Nm.any())
    course = np.searchsorted([at for at, _ in steps], run.time_s, side="left")
    spans = [
        (float(one.min()), float(one.max()))
        for k in np.unique(course)
        if (one := since[(course == k) & (since > 0)]).size
    ]
    first, last = max(spans, key=lambda span: span[1] / span[0])
    decades = float(np.log10(last / first))
    size = f" under {', '.join(f'{v:.3g}' for v in np.cumsum([s for _, s in steps]))} N m" if loaded else ""
    span = f"{first:.3g} s to {last:.3g} s after {'a change of the load' if loaded else 'the beginning'}"
    yield fact("creep", f"readings at rest{size}, {span}: {decades:.2g} decades")
    if decades < FEWEST_DECADES:
        text = f"{span}: {decades:.2g} of the {FEWEST_DECADES:.0f} decades of time that a law of creep needs"
        yield refused("few_decades", text, "read sooner after loading, and go on for longer", "columns", "time")
    if loaded and len(steps) < 2:
        remedy = "take the load off and go on reading: creep goes back, drift does not"
        yield fact("no_recovery", "the load stays on: a creep that ends and a warming look alike", remedy)
    if run.temperature_C is None:
        text = "no temperature: warming is found from its course over time alone"
        yield fact("no_temperature", text, "write the temperature beside each reading")
    if not loaded:
        text = "no load: a creep has no size for each newton metre, and a drift of the sensor looks like one"
        yield doubt("no_load", text, "write the load under which each row was read")
