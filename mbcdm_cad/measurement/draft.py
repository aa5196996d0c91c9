"""Draft a measurement file for a logger's data: guess each column from names, units, ranges and the design.

Every guess is marked, with its reason, so that a person can check it. The output is found first; an input's unit, sign
and place (at the pulley or on the motor, before the gearhead) follow from its angle for a given angle of the output.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement.datafile import clock_s, read_table
from mbcdm_cad.measurement.logformat import Format, find_format, split, title_lines
from mbcdm_cad.measurement.reading import FULL_SENSE
from mbcdm_cad.measurement.units import ANGLE, FORCE, ISO_CLOCK, TEMPERATURE, TIME, TORQUE
from mbcdm_cad.measurement.vet_columns import robust_slope
from mbcdm_cad.routes import Floats

WORDS = {
    "time": r"^(t|time|timestamp|sec(onds)?|clock|zeit)\b|^(t|time)_",
    "temperature": r"temp|°c|degc",
    "load_torque": r"tau|torq|load|force|cell|moment|kraft|^f\b",
    "output": r"out|drum|joint|link|abtrieb",
    "input": r"^in|input|mot|left|right|enc|q_|pos|antrieb",
}
# Quantities that their unit alone tells, where the name does not.
ROLE_OF_UNIT = {"load_torque": {*TORQUE, *FORCE}, "temperature": {*TEMPERATURE}}
# Rows that are tested for figures, and the share of them that must have one.
TRIED_ROWS, LEAST_FIGURES = 300, 0.9
# A column that turns by less than this share of the design's travel is hardly the drum.
LEAST_TRAVEL = 0.02
NEAR = 0.03
# Lines or counts a turn that encoders are sold with, times 1 or 4 for edges.
LINES = (100, 125, 128, 200, 250, 256, 300, 360, 400, 500, 512, 600, 720, 900, 1000, 1024, 1250, 2000, 2048, 2500, 3600)
COUNTS = sorted({n * edges for n in LINES for edges in (1, 4)} | {2**k for k in range(8, 27)})


@dataclass
class _Column:
    name: str | int
    unit: str
    values: Floats
    role: str = ""
    fields: dict[str, object] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Table:
    """How the file is laid out: lines before the names, the indices of the columns to read, and that of dates."""

    layout: Format
    skip_rows: int
    chosen: tuple[int, ...]
    clock: int | None


def draft_text(data: Path, drive: Drive) -> str:
    """The measurement file's text for ``data``. Raises InputError if the data are not a table or nothing turned."""
    table, columns = _columns(data)
    _roles(columns, drive)
    by_role = {column.role: column for column in columns if column.role}
    missing = [role for role in ("time", "output") if role not in by_role]
    if missing:
        names = ", ".join(str(column.name) for column in columns)
        what = f"no column looks like the {' or the '.join(missing)}"
        remedy = "write the measurement file by hand; docs/measurement-file.md shows how"
        raise InputError([Problem(str(data), table.layout.header_line or 1, "", what, names, remedy=remedy)])
    _time(by_role["time"])
    for column in columns:
        if column.role == "output" or column.role.startswith("input"):
            _wrapped(column)
    _output(by_role["output"], drive)
    out_rad = by_role["output"].values * float(by_role["output"].fields.pop("_factor"))  # type: ignore[arg-type]
    inputs = [column for column in columns if column.role.startswith("input")]
    for column in inputs:
        _input(column, out_rad, drive)
    for role, units, unit in (("load_torque", {**TORQUE, **FORCE}, "N*m"), ("temperature", TEMPERATURE, "degC")):
        if role in by_role:
            _plain(by_role[role], units, unit)
    return _written(data, table, columns, len(inputs), drive)


def _columns(data: Path) -> tuple[_Table, list[_Column]]:
    """The columns that contain figures, with their header."""
    try:
        # Whole numbers are figures with either decimal sign: the right one gives more columns of figures.
        found_table = max((_table(data, decimal) for decimal in ("point", "comma")), key=lambda t: len(t.chosen))
        layout, chosen = found_table.layout, found_table.chosen
        if len(chosen) < 2:
            remedy = "give the logger's CSV: a header and rows of figures"
            raise InputError([Problem(str(data), 1, "", "fewer than two columns of figures", remedy=remedy)])
        table = read_table(data, layout, list(chosen), True, found_table.clock)
    except OSError as error:
        problem = Problem(str(data), 1, "", f"cannot be read: {error.strerror or error}", remedy="check the path")
        raise InputError([problem]) from None
    found = []
    for index, values in zip(chosen, table.values, strict=True):
        name = layout.names[index] if index < len(layout.names) else ""
        unit = layout.units[index] if index < len(layout.units) else ""
        inside = re.search(r"[\[(]\s*([^\[\]()]+?)\s*[\])]\s*$", name)
        unit = ISO_CLOCK if index == found_table.clock else unit.strip("[]() ") or (inside.group(1) if inside else "")
        found.append(_Column(name or index + 1, unit, values))
    return found_table, found


def _table(data: Path, decimal: str) -> _Table:
    skipped = title_lines(data, decimal, "#")
    layout = find_format(data, "auto", decimal, "#", skipped, "auto")
    rows = _tried_rows(data, layout)
    figures = [k for k in range(layout.fields) if _share(rows, k, layout, float) >= LEAST_FIGURES]
    dates = (k for k in range(layout.fields) if k not in figures and _share(rows, k, layout, clock_s) >= LEAST_FIGURES)
    clock = next(dates, None)
    return _Table(layout, skipped, tuple(figures if clock is None else sorted([*figures, clock])), clock)


def _tried_rows(data: Path, layout: Format) -> list[list[str]]:
    rows = []
    with open(data, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            if number >= layout.begin_line and line.strip() and not line.startswith("#"):
                rows.append(split(line, layout.sign))
            if len(rows) >= TRIED_ROWS:
                break
    return rows


def _share(rows: list[list[str]], k: int, layout: Format, reads: Callable[[str], float]) -> float:
    """Share of the rows whose cell ``k`` is read as a finite figure."""
    return float(np.mean([_is_read(row, k, layout, reads) for row in rows])) if rows else 0.0


def _is_read(row: list[str], k: int, layout: Format, reads: Callable[[str], float]) -> bool:
    try:
        return math.isfinite(reads(row[k].replace(",", ".") if layout.decimal_comma else row[k]))
    except (ValueError, IndexError):
        return False


def _roles(columns: list[_Column], drive: Drive) -> None:
    """The quantity of each column: by the names in the design, then by usual words; each quantity once."""
    names = list(drive.input_names)
    one = len(names) == 1
    for column in columns:
        word = str(column.name).lower()
        own = next((name for name in names if name.lower() in word), None)
        role = next((r for r, pattern in WORDS.items() if re.search(pattern, word)), "")
        of_unit = next((r for r, units in ROLE_OF_UNIT.items() if column.unit in units), "")
        if own and not re.search(WORDS["output"], word):
            column.role = "input" if one else f"input_{own}"
            column.reasons.append(f"its name contains that of the input {own}")
        elif role and role != "input" and all(other.role != role for other in columns):
            column.role = role
            column.reasons.append("by its name")
        elif not role and of_unit and all(other.role != of_unit for other in columns):
            column.role = of_unit
            column.reasons.append("by the unit in its header")
    taken = {column.role for column in columns}
    if "time" not in taken:
        rising = [c for c in columns if not c.role and bool(np.all(np.diff(c.values) > 0.0))]
        if rising:
            rising[0].role = "time"
            rising[0].reasons.append("it rises in every row")
    free = [name for name in names if f"input_{name}" not in taken and "input" not in taken]
    named = [c for c in columns if not c.role and re.search(WORDS["input"], str(c.name).lower())]
    for name, column in zip(free, named, strict=False):
        column.role = "input" if one else f"input_{name}"
        column.reasons.append("by its name, in the order of the design's inputs: check which is which")


def _time(column: _Column) -> None:
    unit = _said(column, TIME)
    if not unit:
        step = float(np.median(np.diff(column.values)))
        unit = "s" if step < 0.5 else "ms" if step < 100.0 else "us"
        column.reasons.append(f"steps of {step:.4g}: {unit}?")
    column.fields["unit"] = unit


def _output(column: _Column, drive: Drive) -> None:
    """Unit of the output's angle: as the header says, else one in which it stays within the design's travel."""
    span = float(np.ptp(column.values))
    most = 2.1 * math.radians(drive.half_travel_deg + drive.stop_clearance_deg)
    unit = _said(column, ANGLE)
    if _whole(column) and unit not in ANGLE:
        per_turn = _sold(2.0 * math.pi / (drive.drum_encoder.resolution_urad * 1e-6))
        column.fields |= {"unit": "counts", "counts_per_turn": per_turn, "_factor": 2.0 * math.pi / per_turn}
        column.reasons.append(f"whole numbers; {per_turn:g} a turn is the drum encoder of the design")
        return
    if not unit:
        fits = [u for u in ("rad", "deg", "mrad", "turn") if LEAST_TRAVEL * most < span * ANGLE[u].factor <= most]
        unit = fits[0] if fits else "rad"
        column.reasons.append(f"spans {span:.4g}, the design {most / 1.05:.3g} rad between its stops: {unit}?")
    column.fields |= {"unit": unit, "_factor": ANGLE[unit].factor}


def _input(column: _Column, out_rad: Floats, drive: Drive) -> None:
    """Unit, sign and side of an input from its slope against the output."""
    slope, _ = robust_slope(out_rad, column.values)
    if slope == 0.0:
        column.fields["unit"] = _said(column, ANGLE) or "rad"
        column.reasons.append("does not follow the output: is it the right column?")
        return
    ratio = float(np.mean([run.drum_radius_mm / run.input_radius_mm for run in drive.cables]))
    ways = (("drive", ratio), ("motor", ratio * drive.gearhead.ratio))
    unit = _said(column, ANGLE)
    found: list[tuple[float, str, dict[str, object]]] = []
    for side, turns in ways:
        for word in [unit] if unit else [] if _whole(column) else ["rad", "deg", "turn", "mrad"]:
            found.append((abs(math.log(abs(slope) * ANGLE[word].factor / turns)), side, {"unit": word}))
        if not unit and _whole(column):
            per_turn = _sold(abs(slope) * 2.0 * math.pi / turns)
            # Few lines a turn are more usual on a motor, many on a shaft, as in encoder catalogues.
            miss = abs(math.log(abs(slope) * 2.0 * math.pi / turns / per_turn))
            known = 0.0 if per_turn in COUNTS else NEAR
            found.append((miss + known, side, {"unit": "counts", "counts_per_turn": per_turn}))
    best = min(found, key=lambda one: one[0])
    miss, side, fields = best
    column.fields |= fields
    if side == "motor":
        column.fields["side"] = "motor"
    if slope < 0.0:
        column.fields["scale"] = -1
    words = "after the gearhead" if side == "drive" else f"before the gearhead of {drive.gearhead.ratio:g}"
    column.reasons.append(f"turns {abs(slope):.6g} a rad of the output: {words}")
    if miss > NEAR:
        column.reasons.append("no unit gives the design's ratio to a few percent: check")


def _wrapped(column: _Column) -> None:
    """Count the turns of an angle that covers and jumps by a whole range of its encoder, and draft ``wraps_at``."""
    covered = float(np.ptp(column.values))
    ranges = COUNTS if _whole(column) else [ANGLE["turn"].factor / ANGLE[u].factor for u in ("deg", "rad", "turn")]
    begins_again = min((r for r in ranges if r >= covered), default=0.0)
    jumps = int(np.count_nonzero(np.abs(np.diff(column.values)) > 0.5 * begins_again))
    counted = np.unwrap(column.values, period=begins_again) if begins_again else column.values
    if not jumps or covered < (1.0 - NEAR) * begins_again:
        return
    if float(np.quantile(np.abs(np.diff(counted)), 0.999)) > FULL_SENSE * begins_again:
        return
    column.values = counted
    column.fields["wraps_at"] = float(begins_again)
    column.reasons.append(f"begins again {jumps} time(s), after {begins_again:g}")


def _whole(column: _Column) -> bool:
    """Whether its figures are whole numbers, as of a counter."""
    return bool(np.all(column.values == np.round(column.values))) and float(np.ptp(column.values)) > 50.0


def _sold(counts: float) -> float:
    """The nearest number of counts a turn that encoders are sold with; the figure itself where none is near."""
    near = min(COUNTS, key=lambda n: abs(math.log(counts / n)))
    return float(near) if abs(math.log(counts / near)) < NEAR else float(max(round(counts), 1))


def _plain(column: _Column, units: Mapping[str, object], otherwise: str) -> None:
    unit = _said(column, units)
    column.fields["unit"] = unit or otherwise
    if not unit:
        column.reasons.append(f"{otherwise} is assumed")
    if unit in FORCE:
        column.fields["lever_arm_mm"] = "?"
        column.reasons.append("a force: put the arm of the load cell in mm in place of ?")


def _said(column: _Column, units: Mapping[str, object]) -> str:
    """The unit that the header or the end of the name states."""
    if column.unit in units:
        column.reasons.append("unit as its header says")
        return column.unit
    ending = str(column.name).rsplit("_", 1)[-1]
    # As it is written first: N is a newton, n is none.
    unit = next((word for word in (ending, ending.lower()) if word in units), "")
    if unit and "_" in str(column.name):
        column.reasons.append("unit by the end of its name")
        return unit
    return ""


def _written(data: Path, table: _Table, columns: list[_Column], inputs: int, drive: Drive) -> str:
    lines = [
        f"# Drafted from {data.name} and the design {drive.name}. Check every line marked 'guessed'.",
        f"data: {data.name}",
        *(["decimal: comma    # guessed"] if table.layout.decimal_comma else []),
        *([f"skip_rows: {table.skip_rows}    # guessed: shorter than the table"] if table.skip_rows else []),
        "columns:",
    ]
    order = ("time", "input", "output", "load_torque", "temperature")
    known = [c for c in columns if c.role]
    known.sort(key=lambda c: (order.index(c.role.split("_")[0] if c.role.startswith("input") else c.role), c.role))
    for column in known:
        name = column.name if isinstance(column.name, int) else f'"{column.name}"'
        fields = {"column": name, **{k: v for k, v in column.fields.items() if not k.startswith("_")}}
        body = ", ".join(f"{k}: {v:g}" if isinstance(v, float) else f"{k}: {v}" for k, v in fields.items())
        lines.append(f"  {column.role}: {{{body}}}    # guessed: {'; '.join(column.reasons)}")
    wanted = len(drive.input_names)
    if inputs < wanted:
        lines.append(f"  # {inputs} of the {wanted} inputs of the design found: {', '.join(drive.input_names)}")
    unused = [str(c.name) for c in columns if not c.role]
    if unused:
        lines.append(f"# not used: {', '.join(unused)}")
    lines += ["# sensors: the steps of the encoders and the noise of the torque, from the data sheets"]
    return "\n".join([*lines, ""])
