"""Draft a measurement file for a logger's data: guess each column from names, units, ranges and the design.

Every guess is marked, with its reason, so that a person can check it. The output is found first; an input's unit, sign
and place (at the pulley or on the motor, before the gearhead) follow from its angle for a given angle of the output.
The reference page of all fields is written here too.
"""

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from mbcdm_cad.design.describe import flow, limit_text
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement import logformat, roles
from mbcdm_cad.measurement.binarylog import opened
from mbcdm_cad.measurement.datafile import MOST_BROKEN, Channel, clock_s, read_channels, read_table
from mbcdm_cad.measurement.file import file_of
from mbcdm_cad.measurement.kinds import FEWEST_SAMPLES, FEWEST_STEPS
from mbcdm_cad.measurement.logformat import Format, Unit, figure_of, find_format, title_lines, wrong
from mbcdm_cad.measurement.reading import FULL_SENSE, read_run
from mbcdm_cad.measurement.schema import FREQUENCY_RESPONSE, json_schema
from mbcdm_cad.measurement.vet_signals import robust_slope
from mbcdm_cad.report.table import rendered
from mbcdm_cad.routes import Floats

# Rows that are tested for figures, and the share of them that must have one.
TRIED_ROWS, LEAST_FIGURES = 300, 0.9
# Share of empty cells from which a table holds one channel a row.
LEAST_EMPTY = 0.2
# Filled cells of a channel among the rows that are tried, and the most channels of a table with one a row.
FEWEST_FILLED, MOST_CHANNELS = 5, 40
# Where clocks begin again: each second, minute, hour or day in its unit, or as a counter of so many bits.
CLOCKS = sorted({*roles.SECONDS, 60.0, 3600.0, 86_400.0, 86_400e3, 3600e3, 60e3} | {2.0**k for k in range(8, 33)})
# In place of a figure that only its owner knows.
UNKNOWN = "'?'"
_NO_TIME = f"sample_rate_Hz: {UNKNOWN}    # no column looks like the time: put the samples a second in place of ?"
_NO_LOAD = (
    "# load: no torque is logged; say load: none if there was none, or of a weight on an arm\n"
    "#   load: {pendulum: {mass_kg: ?, arm_mm: ?, vertical_deg: ?}}"
)


@dataclass(frozen=True)
class _Table:
    """How the file is laid out: lines before the names, the indices of the columns to read, and that of dates."""

    layout: Format
    skip_rows: int
    chosen: tuple[int, ...]
    clock: int | None
    own_times: bool = False
    named_by: str | int | None = None


def draft_text(data: Path, expected: roles.Expected) -> str:
    """The measurement file's text for ``data``. Raises InputError if the data are not a table or nothing turned."""
    table, columns = _columns(data)
    if (found := roles.response_columns(columns)) is not None:
        return _response_text(data, table, columns, found, expected)
    for column in columns:
        _begun_again(column)
    scale, why = roles.assign(columns, expected)
    if scale is None and columns[0].values.size < FEWEST_SAMPLES:
        # Of a few rows by hand the inputs may be held; a person finds the rest.
        for column in [c for c in columns if not c.role and float(np.ptp(c.values)) > 0.0][:1]:
            column.role, scale = "output", roles.output_scale(column, (), expected)
            column.fields |= scale.fields
            column.reasons += ["the only column that moves", scale.reason]
    by_role = {column.role: column for column in columns if column.role}
    if scale is None:
        raise InputError([_no_pair(data, table, columns, why)])
    _lengths(by_role["output"], [c for c in columns if c.role.startswith("input")], expected)
    for role, units, unit in (
        ("load_torque", {**logformat.TORQUE, **logformat.FORCE}, "N*m"),
        ("temperature", logformat.TEMPERATURE, "degC"),
    ):
        if role in by_role:
            _plain(by_role[role], units, unit)
    return _read_back(data, _written(data, table, columns, expected))


def _response_text(
    data: Path, table: _Table, columns: list[roles.Guess], found: dict[str, roles.Guess], expected: roles.Expected
) -> str:
    """The measurement file of an analyser's table; what its gain is over by its size at the lowest frequencies."""
    gain, phase = found["gain"], found["phase"]
    dB = gain.unit == logformat.DECIBEL or "db" in str(gain.name).lower() or float(gain.values.min()) <= 0.0
    deg = roles.stated_unit(phase, logformat.ANGLE)[0] or (
        "deg" if float(np.ptp(phase.values)) > 2.0 * math.pi else "rad"
    )
    f_unit = roles.stated_unit(found["frequency"], logformat.FREQUENCY)[0] or "Hz"
    low = float(np.median(gain.values[np.argsort(found["frequency"].values)[:5]]))
    low = 10.0 ** (low / 20.0) if dB else low
    ratio, motors = expected.ratio, expected.ratio * (expected.gearhead_ratio or 1.0)
    turns = min((ratio, 1.0, motors), key=lambda n: abs(math.log(low * n)))
    over, why = "inputs", f"a gain of {low:.4g} at the lowest frequencies is one over {turns:.6g} turns"
    if gain.unit in logformat.GIVE or abs(math.log(low * turns)) > math.log(1.5):
        over, why = "torque", f"a gain of {low:.4g} at the lowest frequencies is no ratio of this drive"
    of_gain = gain.unit if gain.unit in logformat.GIVE else "'-'" if over == "inputs" else "rad/(N*m)"
    percent = "coherence" in found and float(found["coherence"].values.max()) > 1.5
    units = {"frequency": f_unit, "gain": logformat.DECIBEL if dB else of_gain, "phase": deg}
    units["coherence"] = "'%'" if percent else "'-'"
    block = f"{{over: {over}" + (f", turns: {turns:.6g}" if over == "inputs" and turns != ratio else "") + "}"
    level = "amplitude_Nm" if over == "torque" else "amplitude_rad"
    lines = [
        *_head(data, table, expected),
        f"kind: {FREQUENCY_RESPONSE}    # guessed: a table of gain and phase over frequency",
        "columns:",
        *(f"  {key}: {{column: {_quoted(one.name)}, unit: {units[key]}}}    # guessed" for key, one in found.items()),
        f"response: {block}    # guessed: {why}",
        f"  # add {level}: the amplitude at which it was measured",
    ]
    if expected.travel_rad is not None:
        lines += ["parts: {structure: true}    # output_at: payload, if its encoder is there"]
        lines += ["# inertia_plate: {inertia_kg_m2: ...}, of what the output turned besides the design's payload"]
    return "\n".join([*lines, *_unused(columns, found.values()), ""])


def _columns(data: Path) -> tuple[_Table, list[roles.Guess]]:
    """The columns that contain figures, with their header."""
    try:
        log = opened(data)
        if log is not None:
            return _Table(log.layout, 0, (), None), [
                roles.Guess(one.name, one.unit, one.values) for one in log.drafted()
            ]
        # Whole numbers are figures with either decimal sign: the right one gives more columns of figures.
        found_table = max((_table(data, decimal) for decimal in ("point", "comma")), key=lambda t: len(t.chosen))
        layout = found_table.layout
        rows = _tried_rows(data, layout)
        figures = found_table.chosen
        found_table = _without_whole_seconds(found_table, rows)
        chosen = found_table.chosen
        if len(chosen) < 3 and len(chosen) > 0:
            named = _named_by(rows, layout, figures)
            if named is not None:
                return _one_channel_a_row(data, found_table, rows, named)
            if np.mean([not cell for row in rows for cell in row] or [False]) > LEAST_EMPTY:
                found_table = _with_empty_cells(found_table, rows)
                chosen = found_table.chosen
        if len(chosen) < 2:
            remedy = "give the logger's CSV, a header and rows of figures, or a log of JSON, an object a line"
            raise wrong(data, 1, "fewer than two columns of figures", remedy)
        if found_table.own_times:
            channels = [Channel(str(k), k) for k in chosen[1:]]
            table = read_channels(data, layout, chosen[0], channels, None, found_table.clock is not None)
        else:
            table = read_table(data, layout, list(chosen), True, found_table.clock)
    except OSError as error:
        raise wrong(data, 1, f"cannot be read: {error.strerror or error}", "check the path") from None
    found = []
    for index, values in zip(chosen, table.values, strict=True):
        name, told = layout.told(index)
        unit = logformat.ISO_CLOCK if index == found_table.clock else told
        found.append(roles.Guess(name or index + 1, unit, values))
    return found_table, found


def _with_empty_cells(table: _Table, rows: list[list[str]]) -> _Table:
    """The table whose time, its only full column, is that of channels with empty cells."""
    full = [[row for row in rows if k < len(row) and row[k]] for k in range(table.layout.fields)]
    figures = [
        k
        for k, mine in enumerate(full)
        if k not in table.chosen
        and len(mine) >= FEWEST_FILLED
        and _share(mine, k, table.layout, float) >= LEAST_FIGURES
    ]
    return replace(table, chosen=(table.chosen[0], *figures), own_times=True)


def _named_by(rows: list[list[str]], layout: Format, chosen: Sequence[int]) -> int | None:
    """The column of words, few and each often, that names the channel of a row; None where there is none."""
    for k in set(range(layout.fields)) - set(chosen):
        words = Counter(row[k] for row in rows if k < len(row))
        if 2 <= len(words) <= MOST_CHANNELS and min(words.values()) >= FEWEST_FILLED and "" not in words:
            return k
    return None


def _one_channel_a_row(
    data: Path, table: _Table, rows: list[list[str]], named_by: int
) -> tuple[_Table, list[roles.Guess]]:
    """The channels of a table with a name in each row, and its time, the first of its columns of figures."""
    layout, time, value = table.layout, table.chosen[0], table.chosen[-1]
    names = sorted({row[named_by] for row in rows if named_by < len(row)})
    channels = [Channel(name, value, name) for name in names]
    at = [] if table.clock is not None else [row[time] for row in rows if time < len(row)]
    begins_again = _begins_again(np.array([float(cell) for cell in at if _is_read([cell], 0, layout, float)]))
    found = read_channels(data, layout, time, channels, named_by, table.clock is not None, begins_again)

    def called(index: int) -> str | int:
        return layout.names[index] if index < len(layout.names) else index + 1

    guesses = [roles.Guess(called(time), logformat.ISO_CLOCK if table.clock == time else "", found.values[0])]
    for name, row in zip(names, found.values[1:], strict=True):
        guesses.append(roles.Guess(name, "", row))
        guesses[-1].fields |= {"_column": called(value), "channel": name}
    if begins_again:
        guesses[0].fields["wraps_at"] = begins_again
        guesses[0].reasons.append(f"begins again after {begins_again:g}")
    return replace(table, named_by=called(named_by)), guesses


def _without_whole_seconds(table: _Table, rows: list[list[str]]) -> _Table:
    """The table without a column of whole seconds beside which another has what is over them, as ROS's sec, nanosec."""
    read = [k for k in table.chosen if k != table.clock]
    whole = [row for row in rows if all(_is_read(row, k, table.layout, float) for k in read)]
    figures = {k: np.array([float(row[k].replace(",", ".")) for row in whole]) for k in read}
    for sec in read:
        steps = np.diff(figures[sec])
        if not steps.any() or not np.all((steps == 0.0) | (steps == 1.0)):
            continue
        for over in read:
            if _begins_again(figures[over]) and np.array_equal(np.diff(figures[over]) < 0.0, steps == 1.0):
                return replace(table, chosen=tuple(k for k in table.chosen if k != sec))
    return table


def _begins_again(values: Floats) -> float | None:
    """Where a clock begins again after a second, an hour or its bits; None for any other column."""
    steps = np.diff(values)
    if not (steps < 0.0).any() or not (steps > 0.0).any() or values.min() < 0.0:
        return None
    usual, most = 5.0 * float(np.quantile(steps, 0.95)), float(values.max())
    ranges = [r for r in CLOCKS if most < r <= most + usual]
    counted = [np.diff(np.unwrap(values, period=r)) for r in ranges]
    return next((r for r, step in zip(ranges, counted, strict=True) if step.min() >= 0.0 and step.max() < usual), None)


def _table(data: Path, decimal: str) -> _Table:
    skipped = title_lines(data, decimal, "#")
    layout = find_format(data, "auto", decimal, "#", skipped, "auto")
    rows = _tried_rows(data, layout)
    figures = [k for k in range(layout.fields) if _share(rows, k, layout, figure_of) >= LEAST_FIGURES]
    dates = (k for k in range(layout.fields) if k not in figures and _share(rows, k, layout, clock_s) >= LEAST_FIGURES)
    clock = next(dates, None)
    return _Table(layout, skipped, tuple(figures if clock is None else sorted([*figures, clock])), clock)


def _tried_rows(data: Path, layout: Format) -> list[list[str]]:
    with open(data, encoding="utf-8", errors="replace") as file:
        lines = islice(file, layout.begin_line - 1, None)
        rows = (layout.cells(line) for line in lines if line.strip() and not line.startswith("#"))
        return list(islice(rows, TRIED_ROWS))


def _share(rows: list[list[str]], k: int, layout: Format, reads: Callable[[str], float]) -> float:
    """Share of the rows whose cell ``k`` is read as a finite figure."""
    return float(np.mean([_is_read(row, k, layout, reads) for row in rows])) if rows else 0.0


def _is_read(row: list[str], k: int, layout: Format, reads: Callable[[str], float]) -> bool:
    try:
        return math.isfinite(reads(row[k].replace(",", ".") if layout.decimal_comma else row[k]))
    except (ValueError, IndexError):
        return False


def _lengths(output: roles.Guess, inputs: Sequence[roles.Guess], expected: roles.Expected) -> None:
    """Draft the radius of an angle that was measured as a length: that with which the ratio is met."""
    for column in (output, *inputs):
        ending = next((u for u in ("mm", "um") if u in column.words[-1:]), "")
        unit = column.unit if column.unit in logformat.LENGTH else ending
        if not unit:
            continue
        other = inputs[0] if column is output and inputs else output
        rad, _ = roles.stated_unit(other, logformat.ANGLE)
        slope, _ = robust_slope(other.values, column.values)
        turns = 1.0 / expected.ratio if column is output else expected.ratio
        column.fields = {"unit": unit, "radius_mm": UNKNOWN}
        column.reasons = ["a length: put the radius at which it is measured in place of ?"]
        if slope and rad:
            radius = 1e3 * logformat.LENGTH[unit].factor * abs(slope) / (logformat.ANGLE[rad].factor * turns)
            column.fields["radius_mm"] = float(f"{radius:.4g}")
            column.reasons = ["a length: with this radius the ratio is met; put the measured radius in its place"]
        if slope < 0.0 and column is not output:
            column.fields["scale"] = -1


def _begun_again(column: roles.Guess) -> None:
    """Count on where a column begins again after a whole range of its encoder or clock, and draft ``wraps_at``."""
    steps, covered = np.diff(column.values), float(np.ptp(column.values))
    begins_again = None
    if column.unit in logformat.TIME or column.says(roles.TIME_WORDS):
        begins_again = _begins_again(column.values)
    elif covered:
        ranges = roles.COUNTS_SOLD if column.whole else roles.TURNS.values()
        r = min((r for r in ranges if r >= covered), default=np.inf)
        # A step of more than this share of the range may be one back as well as one forward.
        if bool(np.any(np.abs(steps) > 0.5 * r)) and covered >= (1.0 - roles.MET) * r:
            told = np.quantile(np.abs(np.diff(np.unwrap(column.values, period=r))), 0.999) <= FULL_SENSE * r
            begins_again = r if told else None
    if begins_again is not None:
        counted_on = np.unwrap(column.values, period=begins_again)
        times = int(np.count_nonzero(np.abs(np.diff(counted_on) - steps) > 0.5 * begins_again))
        column.values = counted_on
        column.fields["wraps_at"] = float(begins_again)
        column.reasons.append(f"begins again {times} time(s), after {begins_again:g}")


def _no_pair(data: Path, table: _Table, columns: Sequence[roles.Guess], why: Sequence[str]) -> Problem:
    """The problem of a log in which no two angles follow each other: what moves, by how much, and what is missing."""
    line = table.layout.begin_line
    moving = [c for c in columns if not c.role and float(np.ptp(c.values)) > 0.0]
    angles = [c for c in moving if f"{c.name} moves" in why]
    names = ", ".join(str(column.name) for column in columns)
    if not moving:
        what, remedy = "no column looks like the output: none but the time moves", "move the drive while logging"
        return Problem(str(data), line, "", what, names, remedy=remedy)
    spans = []
    for column in (angles or moving)[:4]:
        span = float(np.ptp(column.values))
        counts = np.all(column.values == np.round(column.values)) and span < 1024.0
        told = f" ({360.0 * span / 4096.0:.3g} deg where 4096 are a turn)" if counts else ""
        spans.append(f"{column.name} by {span:.6g} of its figures{told}")
    rest = [f"{c.name} rests" for c in columns if not c.role and float(np.ptp(c.values)) == 0.0]
    what = "one angle moves" if len(angles) == 1 else "no two columns follow each other as the angles of a drive do"
    facts = [*(one for one in why if not one.endswith(" moves")), *rest]
    remedy = (
        "a drive needs the angles of its input and of its output: log both, or join the file that holds the other to "
        "this one by its time; of a drive whose inputs are held the range is its play by hand: write the turning "
        "points and the load, kind: turning_points"
    )
    return Problem(str(data), line, "", f"{what}; {'; '.join(facts)}".rstrip("; "), "; ".join(spans), remedy=remedy)


def _read_back(data: Path, text: str) -> str:
    """The draft as it is read: with rows left out that are none, or with what its own reading says of it."""
    begin, _, rest = text.partition("columns:")
    told = ""
    for more in ("", "broken_rows: skip    # guessed: some lines are no rows\n"):
        tried = f"{begin}{more}columns:{rest}"
        try:
            read_run(file_of(data.with_suffix(".yaml"), tried.replace(UNKNOWN, "1")))
        except InputError as error:
            told = told or f"# As drafted it is not read: {error.problems[0]}\n"
        else:
            return tried
    return told + text


def _plain(column: roles.Guess, units: Mapping[str, Unit], otherwise: str) -> None:
    unit, reason = roles.stated_unit(column, units)
    column.fields["unit"] = unit or otherwise
    column.reasons.append(reason if unit else f"{otherwise} is assumed")
    if unit in logformat.FORCE:
        column.fields["lever_arm_mm"] = UNKNOWN
        column.reasons.append("a force: put the arm of the load cell in mm in place of ?")


def _quoted(name: object) -> str:
    return str(name) if isinstance(name, int) else f'"{name}"'


def _unused(columns: Sequence[roles.Guess], used: Collection[roles.Guess]) -> list[str]:
    names = [str(c.name) for c in columns if all(c is not one for one in used)]
    return [f"# not used: {', '.join(names)}"] if names else []


def _head(data: Path, table: _Table, expected: roles.Expected) -> list[str]:
    """The first lines of a measurement file."""
    return [
        f"# Drafted from {data.name} and {expected.known_from}. Check every line marked 'guessed'.",
        f"data: {data.name}",
        *([f"ratio: {expected.ratio:g}"] if expected.travel_rad is None else []),
        *(["decimal: comma    # guessed"] if table.layout.decimal_comma else []),
        *([f"skip_rows: {table.skip_rows}    # guessed: what stands above the table"] if table.skip_rows else []),
    ]


def _written(data: Path, table: _Table, columns: list[roles.Guess], expected: roles.Expected) -> str:
    lines = [
        *_head(data, table, expected),
        *(["rows: own_times    # guessed: empty cells"] if table.own_times else []),
        *([f"channel_column: {_quoted(table.named_by)}    # guessed: few words"] if table.named_by is not None else []),
        *([] if any(c.role == "time" for c in columns) else [_NO_TIME]),
        "columns:",
    ]
    order = ("time", "input", "output", "load_torque", "temperature")
    known = [c for c in columns if c.role]
    known.sort(key=lambda c: (order.index(c.role.split("_")[0] if c.role.startswith("input") else c.role), c.role))
    for column in known:
        name = _quoted(column.fields.get("_column", column.name))
        fields = {"column": name, **{k: v for k, v in column.fields.items() if not k.startswith("_")}}
        body = ", ".join(
            f"{k}: {v:.12g}" if isinstance(v, float) else f"{k}: {_quoted(v) if k == 'channel' else v}"
            for k, v in fields.items()
        )
        lines.append(f"  {column.role}: {{{body}}}    # guessed: {'; '.join(column.reasons)}")
    wanted, inputs = len(expected.input_names), sum(c.role.startswith("input") for c in columns)
    if inputs < wanted:
        lines.append(f"  # {inputs} of the {wanted} inputs found: {', '.join(expected.input_names)}")
    lines += _unused(columns, known)
    if all(c.role != "load_torque" for c in columns):
        lines.append(_NO_LOAD)
    lines += ["# sensors: the steps of the encoders and the noise of the torque, from the data sheets"]
    return "\n".join([*lines, ""])


def measurement_page() -> str:
    """The reference page of the measurement file in Markdown, from its schema and the table of units."""

    def cell(text: object) -> str:
        return " ".join(str(text).split()).replace("|", "\\|")

    schema = json_schema()
    blocks = schema["properties"]
    return rendered(
        "reference.md.j2",
        "mbcdm_cad.measurement",
        filters={"flow": flow, "cell": cell, "said": lambda node: node["description"].capitalize()},
        blocks=blocks,
        plain={name: node for name, node in blocks.items() if "properties" not in node and name != "published"},
        required=schema.get("required", []),
        limits=lambda node: cell(limit_text(node)),
        known_units=logformat.known_units,
        MOST_BROKEN=MOST_BROKEN,
        FEWEST_SAMPLES=FEWEST_SAMPLES,
        FEWEST_STEPS=FEWEST_STEPS,
    )
