"""The kinds of runs: what the rows of each are, when they cannot be used, and what their vetting finds.

A kind is one object. Reading and vetting ask :func:`kind_of` for it and nothing else about the kind.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement.by_hand import creep_findings, inputs_move, readings_findings
from mbcdm_cad.measurement.datafile import MOST_BROKEN, DataTable
from mbcdm_cad.measurement.file import Broken, MeasurementFile
from mbcdm_cad.measurement.response import FEWEST_AVERAGES, response_findings, table_findings
from mbcdm_cad.measurement.run import Run, VettingNote, column_of, fact, refused
from mbcdm_cad.measurement.schema import CREEP, FREQUENCY_RESPONSE, MOTION, TURNING_POINTS
from mbcdm_cad.measurement.vet_signals import column_findings, reach_findings, robust_slope, signal_findings
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# Fewer samples than this cannot contain the sweeps that any statement needs.
FEWEST_SAMPLES = 100
# Fewest rows of a table by hand, and the share of its rows in which a figure may be missing.
FEWEST_ROWS, MOST_MISSING = 6, 0.34
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
# Largest share of the rows that a device which was not ready yet may fill.
LONGEST_STARTUP = 0.2
# Samples that the comparison of columns needs; longer runs are thinned.
MOST_SAMPLES = 20_000
# Relative deviation from the gearhead's ratio up to which a factor counts as this ratio.
MOTOR_WIDTH = 0.03


@dataclass(frozen=True)
class Declared:
    """The known data of the drive: ``d`` and ``travel_rad`` (full) are None if only the ratio is known."""

    ratio: float
    d: DriveSI | None
    travel_rad: float | None
    gearhead_ratio: float | None = None


@dataclass(frozen=True, eq=False)
class Rows:
    """A run as it was read from the ``table`` of ``data``."""

    file: MeasurementFile
    run: Run
    table: DataTable
    data: Path

    def angles(self) -> list[tuple[str, Floats]]:
        """Name and angle of each shaft that an encoder reads."""
        names = [f"input {name}".removesuffix(" input") for name in self.run.input_names]
        return [*zip(names, self.run.input_rad, strict=True), ("output", self.run.output_rad)]


class RunKind:
    """One kind of run. The defaults are those of a log over time.

    ``by_hand``: a person may have written the few rows: broken ones are left out. ``moves``: it has half sweeps, and
    several short runs repeat each other. ``fewest`` rows; ``most_broken``: share of them that may be left out.
    """

    by_hand, moves = False, False
    fewest, most_broken = FEWEST_SAMPLES, MOST_BROKEN

    def refuse_unusable(self, rows: Rows) -> None:
        """Raise InputError, with the line of the data if the problem has one, for a run that cannot be used."""
        for problems in self.faults(rows):
            if found := list(problems):
                raise InputError(found)

    def faults(self, rows: Rows) -> Iterator[Iterable[Problem]]:
        """Problems in groups, of which the first that has any is told: too few samples, impossible figures, time that
        runs backwards, and what the kind itself asks for."""
        yield self._too_few(rows)
        yield _out_of_bounds(rows)
        yield _backwards(rows)
        yield rows.file.problems(self.lacks(rows.run))

    def lacks(self, run: Run) -> Iterator[Broken]:
        """What rows without motion must show: more than one figure of the output."""
        if not np.ptp(run.output_rad):
            yield ("columns", "output"), "one figure in all rows", "read it to more digits, or check column and unit"

    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        """Refusals, doubts and facts of the vetting, in any order."""
        raise NotImplementedError

    def _too_few(self, rows: Rows) -> Iterator[Problem]:
        count = rows.run.time_s.size
        remedy = "record a few sweeps of the drive; check comment, skip_rows and broken_rows"
        if self.by_hand:
            remedy = "go on measuring; check comment and skip_rows"
        elif count >= FEWEST_ROWS:
            remedy += f"; of a table by hand, a row for each turning point, say kind: {TURNING_POINTS}"
            remedy += f", of readings at rest kind: {CREEP}"
        if count < self.fewest:
            yield Problem(str(rows.data), 1, "", "too few samples", str(count), f"{self.fewest}", remedy)


class _Motion(RunKind):
    moves = True

    def faults(self, rows: Rows) -> Iterator[Iterable[Problem]]:
        yield from (self._too_few(rows), _out_of_bounds(rows), _backwards(rows))
        yield from (_startup(rows), _far_off(rows), _not_moved(rows))

    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        rows = {name: getattr(run, name) for name in ("time_s", "input_rad", "output_rad", "load_Nm", "temperature_C")}
        every = max(1, run.time_s.size // MOST_SAMPLES)
        thin = replace(run, **{name: row[..., ::every] for name, row in rows.items() if row is not None})
        found = list(signal_findings(run, known.ratio))
        # An angle that jumps has no meaningful slope.
        if not any(note.level == "refused" for note in found):
            notes = column_findings(thin, known.ratio, known.travel_rad, known.d)
            found += [_on_the_motor(note, thin, known) for note in notes]
        yield from found
        yield from _zeros(run)
        if not any(note.level == "refused" for note in found):
            yield from reach_findings(thin, known.ratio, known.d)


class _ByHand(RunKind):
    by_hand = True
    fewest, most_broken = FEWEST_ROWS, MOST_MISSING


class _TurningPoints(_ByHand):
    def lacks(self, run: Run) -> Iterator[Broken]:
        yield from super().lacks(run)
        if inputs_move(run):
            return
        if run.load_Nm is None:
            remedy = "give the inputs' angles, or the load under which each row was read"
            yield ("columns",), "neither an input nor a load that changes", remedy
        elif not np.ptp(run.load_Nm):
            remedy = "read the output under other loads, or at other angles of the inputs"
            yield ("columns", "load_torque"), "one figure in all rows", remedy

    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        return readings_findings(run, known.ratio, known.travel_rad, known.d)


class _Creep(_ByHand):
    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        return creep_findings(run)


class _ResponseLog(RunKind):
    def lacks(self, run: Run) -> Iterator[Broken]:
        yield from super().lacks(run)
        if not np.ptp(run.input_rad, axis=1).any():
            remedy = "let the drive's own motors excite it, and log the angle of each input"
            yield ("columns",), "no input moves", remedy

    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        return response_findings(run, known.ratio)


class _AnalyserTable(RunKind):
    def faults(self, rows: Rows) -> Iterator[Iterable[Problem]]:
        yield [*self._too_few(rows), *rows.file.problems(self.lacks(rows.run))]

    def _too_few(self, rows: Rows) -> Iterator[Problem]:
        assert rows.run.table is not None
        if (count := np.unique(rows.run.table.frequency_Hz).size) < FEWEST_AVERAGES:
            remedy = "measure at more frequencies, most of them around the first mode"
            what = "too few rows of different frequencies"
            yield Problem(str(rows.data), 1, "", what, str(count), f"{FEWEST_AVERAGES}", remedy)

    def lacks(self, run: Run) -> Iterator[Broken]:
        """Impossible figures."""
        table = run.table
        assert table is not None
        if not np.all(np.isfinite(table.value)) or not np.all(np.abs(table.value) > 0.0):
            remedy = "set unit: dB if the figures are decibels, and leave rows without a figure out"
            yield ("columns", "gain"), "no gain: zero, below zero or out of all bounds", remedy
        if not np.all(table.frequency_Hz > 0.0):
            yield ("columns", "frequency"), "not above zero", "leave that row out"
        if table.coherence is not None and not np.all((table.coherence >= 0.0) & (table.coherence <= 1.001)):
            remedy = "set unit: '%' if the figures are percent, or leave it out"
            yield ("columns", "coherence"), "not between 0 and 1", remedy
        if table.amplitude is not None and not np.all(table.amplitude > 0.0):
            yield ("columns", "amplitude"), "not above zero", "check column and unit"

    def findings(self, run: Run, known: Declared) -> Iterator[VettingNote]:
        assert run.table is not None
        return table_findings(run.table, known.ratio, known.gearhead_ratio)


KINDS: dict[str, RunKind] = {
    MOTION: _Motion(),
    TURNING_POINTS: _TurningPoints(),
    CREEP: _Creep(),
    FREQUENCY_RESPONSE: _ResponseLog(),
}
_TABLE = _AnalyserTable()


def kind_of(run: Run) -> RunKind:
    """The kind of a run; an analyser's table is a kind of its own."""
    return KINDS[run.kind] if run.table is None else _TABLE


def _out_of_bounds(rows: Rows) -> Iterator[Problem]:
    """A figure that no sensor shows."""
    if not np.isfinite(rows.table.values).all() or float(np.abs(rows.table.values).max()) > 1e12:
        remedy = "check unit, scale and counts_per_turn of every column"
        yield rows.file.problem(("columns",), "figures out of all bounds", limit="1e12 in SI", remedy=remedy)


def _backwards(rows: Rows) -> Iterator[Problem]:
    """Time that runs backwards or stands still."""
    time_s = rows.run.time_s
    back = np.flatnonzero(np.diff(time_s) <= 0.0)
    if not back.size:
        return
    row = int(back[0]) + 1
    step = float(time_s[row] - time_s[row - 1])
    seconds = np.diff(time_s)[back]
    every_second = back.size > 1 and bool(np.all(np.abs(seconds + 1.0) < 0.5))
    remedy = (
        "it begins again every second: set wraps_at on columns.time, 1000000 for microseconds; another column has "
        "the seconds"
        if every_second
        else "sort the rows, or cut the file where a new run begins"
        if step < 0.0
        else "log the time with more digits, or set broken_rows: skip, which leaves out rows that repeat the time"
    )
    if back.size > MOST_BACK * time_s.size and not every_second:
        asked = f"so do {back.size} of {time_s.size} steps: is this column the time?"
        remedy = f"{asked} Correct columns.time, or {remedy}"
    what = "time runs backwards" if step < 0.0 else "time stands still"
    yield Problem(str(rows.data), rows.table.line_of(row), "", what, f"step {step:.6g} s", "over 0", remedy)


def _startup(rows: Rows) -> Iterator[Problem]:
    """A block of one figure at the start that is far from all others: a device that was not ready."""
    for name, values in rows.angles():
        changed = np.flatnonzero(values != values[0])
        count = int(changed[0]) if changed.size else values.size
        rest = values[count:]
        if count == values.size or count > LONGEST_STARTUP * values.size:
            continue
        # A drive that rests first leaves its place step by step; this one jumps.
        if abs(float(rest[0] - values[0])) <= SPIKE_SPANS * float(np.ptp(rest)):
            continue
        first, last = rows.table.line_of(0), rows.table.line_of(count - 1)
        what = f"lines {first} to {last} hold one figure of the {name}, far from all others"
        figure, limit = f"{values[0]:.6g} in SI", f"others {rest.min():.4g} to {rest.max():.4g}"
        remedy = "remove these lines: the device was not ready yet"
        yield Problem(str(rows.data), first, "", what, figure, limit, remedy)


def _far_off(rows: Rows) -> Iterator[Problem]:
    """Single figures far from all others, as from a short failure of a sensor or a bus."""
    load = rows.run.load_Nm
    for name, values in rows.angles() + ([] if load is None else [("load torque", load)]):
        low, high = (float(v) for v in np.percentile(values, (1.0, 99.0)))
        # An angle may be far from zero; the span of a constant load is only that of its noise.
        reach = SPIKE_SPANS * (max(high - low, abs(low), abs(high)) if name == "load torque" else high - low)
        off = (values < low - reach) | (values > high + reach)
        at = np.flatnonzero(off)
        # A drive that rests most of the time and then moves has many such figures, which is not a fault.
        lasting = np.any(np.convolve(off, np.ones(LONGEST_SPIKE + 1), "valid") > LONGEST_SPIKE)
        if high == low or at.size == 0 or lasting:
            continue
        what = f"{at.size} figure(s) of the {name} far from all others, the first here"
        value, limit = f"{values[at[0]]:.6g} in SI", f"others {low:.4g} to {high:.4g}"
        line = rows.table.line_of(int(at[0]))
        yield Problem(str(rows.data), line, "", what, value, limit, "remove or correct these rows")


def _not_moved(rows: Rows) -> list[Problem]:
    """Shafts that stand still, or turn by few of the declared steps of their encoders."""
    problems, shafts, travels = [], rows.angles(), list[float]()
    for name, values in shafts:
        resolution = f"{name.split()[0]}_resolution_rad"
        least = max(FEWEST_STEPS * (getattr(rows.run.sensors, resolution) or 0.0), LEAST_TRAVEL_RAD)
        if (travel := float(np.ptp(values))) >= least:
            continue
        travels.append(travel)
        where: FieldPath = ("columns", name.replace(" ", "_", 1))
        what = f"no motion of the {name}"
        remedy = "check that its encoder is driven and connected, and column, unit and scale"
        if getattr(rows.file.content.sensors, resolution) and travel > MOTION_RAD:
            where, what = ("sensors", resolution), f"the {name} turns by fewer than {FEWEST_STEPS} such steps"
            remedy = "check this figure, one step of the encoder in rad, or move farther"
        problems.append(rows.file.problem(where, what, f"{travel:.3g} rad", f"{least:.3g} rad", remedy=remedy))
    if len(travels) == len(shafts) and not any(problem.field.startswith("sensors") for problem in problems):
        remedy = "move the drive while logging; if it did move, check columns, units and scales"
        what = "no motion: the drive was never moved"
        return [rows.file.problem(("columns",), what, f"{max(travels):.3g} rad at most", remedy=remedy)]
    return problems


def _zeros(run: Run) -> Iterator[VettingNote]:
    """Facts about zeros that were taken from the data."""
    zeros, remedy = run.zeros, "where the true zeros are known, give them as zero"
    if zeros is not None and zeros.apart_rad:
        text = (
            f"the inputs' zeros are {zeros.apart_rad:.3g} rad apart, which the cables could not bear: they are taken "
            "from the run, as if the inputs agreed on average"
        )
        yield fact("zeros_apart", text, remedy)
    if zeros is not None and zeros.centre_rad:
        far = f"the inputs are {zeros.centre_rad:.3g} rad from zero, beyond the travel"
        yield fact("zeros_centre", f"{far}: zero is the middle of their range", remedy)


def _on_the_motor(note: VettingNote, run: Run, known: Declared) -> VettingNote:
    """The same note, or that the encoders sit on the motors, where an input turns too far by the gearhead's ratio."""
    named = len(note.field) == 2 and str(note.field[1]).startswith("input")
    if known.gearhead_ratio is None or note.kind not in ("ratio", "unit") or not named:
        return note
    index = [column_of(name) for name in run.input_names].index(note.field)
    slope = robust_slope(run.output_rad, run.input_rad[index])[0] / known.ratio
    if abs(abs(slope) / known.gearhead_ratio - 1.0) > MOTOR_WIDTH:
        return note
    text = (
        f"{note.field[1]} turns {abs(slope):.4g} times as far as the input pulley does, which is the gearhead's "
        f"{known.gearhead_ratio:g}: its encoder sits on the motor"
    )
    return refused("unit", text, "set side: motor on the columns of the inputs", *note.field, "side")
